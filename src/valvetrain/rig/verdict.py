"""The verdict on a recording: cycles that were retained, the largest value of its channels, and where
its mark is.
"""

from __future__ import annotations

import numpy as np

from valvetrain.report.text import number
from valvetrain.rig.page import peaks_of, shown_unit
from valvetrain.rig.result import RigResult
from valvetrain.solution.definition import label_of

#: Channels of which the largest value is reported.
MAX_CHANNELS = 2


def rig_verdict(result: RigResult) -> str:
    """The sentence; cycles that were left out come first."""
    retained, every = len(result.retained), result.grid.cycles
    lead = "Synthetic recording: " if result.synthetic else ""
    counted = (
        f"{every} cycle{'s' * (every != 1)}"
        if retained == every
        else f"{retained} of {every} cycles retained"
    )
    rpm = float(result.grid.cam_speeds[list(result.retained)].mean()) * 30 / np.pi
    parts = []
    for channel in result.channels[:MAX_CHANNELS]:
        peak = peaks_of(channel)[0]
        unit, _ = shown_unit(peak.quantity, peak.unit)
        said = f"{label_of(peak.quantity)} at most {peak.shown(peak.mean, 4)} {unit}".strip()
        if peak.scatter > 0:
            said += f" (± {peak.shown(2 * peak.scatter, 2)} from cycle to cycle)"
        parts.append(said)
    more = len(result.channels) - MAX_CHANNELS
    if more > 0:
        parts.append(f"{more} more channel{'s' * (more > 1)}")
    mark = ""
    if result.alignment is not None:
        mark = f"; its mark is at {np.degrees(result.offset):.2f} cam degrees of the case"
    return f"{lead}{counted} at {number(rpm, 4)} rpm of the cam: {', '.join(parts)}{mark}."
