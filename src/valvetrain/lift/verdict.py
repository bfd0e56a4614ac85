"""The verdict on a measured lift: peak, duration, noise, and stations that do not fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from valvetrain.lift.figures import LiftFigure, LobeResult
from valvetrain.report.text import number
from valvetrain.units import unit_factor

#: Standard deviations from which a station is off the law.
OFF = 4.0


def lift_verdict(lobes: Sequence[LobeResult]) -> str:
    """One sentence on one or two lobes."""
    return f"{'; '.join(_lobe(one, len(lobes) > 1) for one in lobes)}."


def _lobe(one: LobeResult, named: bool) -> str:
    name = f"{one.measured.name} {one.measured.lift_of}" if named else one.measured.lift_of
    parts = []
    for figure in one.figures:
        if figure.name == "peak_lift":
            parts.append(f"{name} lift {_shown(figure)}".capitalize())
        elif figure.name.startswith("duration_at"):
            parts.append(figure.label.replace("duration", f"duration {_shown(figure)}"))
            break
    lift = one.smoothed
    noise = f"noise {1e6 * lift.noise:.2g} µm"
    off = int(np.count_nonzero(np.abs(lift.residuals) > OFF * lift.noise))
    verb = "is" if off == 1 else "are"
    stations = f"{off} of {len(lift.residuals)} stations {verb} off the law"
    return ", ".join([*parts, noise, stations if off else "every station fits"])


def _shown(figure: LiftFigure) -> str:
    unit = "cam degrees" if figure.unit == "deg" else figure.unit
    return f"{number(figure.value / unit_factor(figure.unit), 4)} {unit}"
