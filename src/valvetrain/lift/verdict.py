"""The verdict on a measured lift: peak, duration, acceleration, noise, and stations that do not fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from valvetrain.lift.figures import LiftFigure, LobeResult, figure_rows

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
        parts.append(f"acceleration {_shown(peaks[0], False)} to {_shown(peaks[1])}")
    lift = one.smoothed
    noise = f"noise {1e6 * lift.noise:.2g} µm"
    off = int(np.count_nonzero(np.abs(lift.residuals) > OFF * lift.noise))
    verb = "is" if off == 1 else "are"
    stations = f"{off} of {len(lift.residuals)} stations {verb} off the law"
    return ", ".join([*parts, noise, stations if off else "every station fits"])


def _shown(figure: LiftFigure, with_unit: bool = True) -> str:
    """Value and half of its 95 % interval with the digits of the table, and the unit."""
    _, value, band, unit = figure_rows((figure,))[0]
    said = f"{value} {band.replace('±', '± ')}".replace("-", "−") if figure.spread > 0 else value
    return f"{said} {'cam degrees' if unit == 'cam deg' else unit}" if with_unit else said
