"""The verdict on a measured lift: peak, duration, acceleration, noise, and stations that do not fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from valvetrain.lift.figures import UNIT_TEXTS, LiftFigure, LobeResult, figure_factor
from valvetrain.report.text import number

#: Standard deviations from which a station is off the law.
OFF = 4.0
#: Figures between which the acceleration lies: over the nose, on the flanks.
PEAKS = ("nose_acceleration", "largest_acceleration")


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
    peaks = [found for name in PEAKS for found in one.figures if found.name == name]
    if len(peaks) == len(PEAKS):
        parts.append(f"acceleration {_value(peaks[0])} to {_shown(peaks[1])}")
    lift = one.smoothed
    noise = f"noise {1e6 * lift.noise:.2g} µm"
    off = int(np.count_nonzero(np.abs(lift.residuals) > OFF * lift.noise))
    verb = "is" if off == 1 else "are"
    stations = f"{off} of {len(lift.residuals)} stations {verb} off the law"
    return ", ".join([*parts, noise, stations if off else "every station fits"])


def _shown(figure: LiftFigure) -> str:
    unit = "cam degrees" if figure.unit == "deg" else UNIT_TEXTS.get(figure.unit, figure.unit)
    return f"{_value(figure)} {unit}"


def _value(figure: LiftFigure) -> str:
    return number(figure.value / figure_factor(figure.unit), 4)
