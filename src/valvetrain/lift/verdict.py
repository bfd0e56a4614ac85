"""The verdict on a measured lift: peak, duration, noise, and stations that do not fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from valvetrain.lift.page import LobeResult, figure_rows

#: Standard deviations from which a station is off the law.
OFF = 4.0


def lift_verdict(lobes: Sequence[LobeResult]) -> str:
    """One sentence on one or two lobes."""
    return f"{'; '.join(_lobe(one, len(lobes) > 1) for one in lobes)}."


def _lobe(one: LobeResult, named: bool) -> str:
    values = {
        figure.name: (text, unit)
        for figure, (_, text, _, unit) in zip(one.figures, figure_rows(one.figures), strict=True)
    }
    name = f"{one.measured.name} {one.measured.lift_of}" if named else one.measured.lift_of
    parts = [f"{name} lift {_text(values['peak_lift'])}".capitalize()]
    duration = next((key for key in values if key.startswith("duration_at")), None)
    if duration is not None:
        figure = next(row for row in one.figures if row.name == duration)
        parts.append(f"{figure.label} {_text(values[duration])} of the cam")
    lift = one.smoothed
    noise = f"noise {1e6 * lift.noise:.2g} µm"
    off = int(np.count_nonzero(np.abs(lift.residuals) > OFF * lift.noise))
    verb = "lies" if off == 1 else "lie"
    parts.append(
        f"{noise}, {off} of {len(lift.residuals)} stations {verb} off the law"
        if off
        else f"{noise}, every station fits"
    )
    return ", ".join(parts)


def _text(pair: tuple[str, str]) -> str:
    value, unit = pair
    return f"{value} {'degrees' if unit == 'deg' else unit}"
