"""Files of a recording: cycles of every channel, their means, what was found."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from valvetrain.measurements.cycles_file import write_cycles
from valvetrain.measurements.rig_result import RigResult
from valvetrain.solution.atomic import write_text

#: Values of a channel beyond which its cycles are not written as text besides.
MOST_IN_TEXT = 2_000_000


def write_rig(result: RigResult, folder: Path) -> list[Path]:
    """``cycles.nc`` with every channel, ``<quantity>.csv`` with the cycles of each, ``means.csv`` with means, scatter and bands."""
    files = [write_cycles(folder / "cycles.nc", result.cycles)]
    files += [write_cycles(folder / f"{one.quantity}.csv", [one]) for one in result.cycles if one.values.size <= MOST_IN_TEXT]
    heads, columns = ["cam angle [deg]"], [np.degrees(result.grid.cam_angle)]
    for channel in result.channels:
        one = channel.cycles
        scatter = one.values.std(axis=0, ddof=1) if len(one.values) > 1 else np.zeros(one.values.shape[1])
        heads += [
            f"{one.quantity} [{one.unit}]",
            f"standard deviation of {one.quantity} [{one.unit}]",
            f"95 % of the mean within [{one.unit}]",
        ]
        columns += [one.mean, scatter, channel.spread]
    lines = ["# synthetic: computed, not measured"] if result.synthetic else []
    lines += [",".join(heads), *(",".join(f"{value:.9g}" for value in row) for row in np.column_stack(columns))]
    files.append(write_text(folder / "means.csv", "\n".join(lines) + "\n"))
    return files
