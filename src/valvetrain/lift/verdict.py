"""The verdict on a measured lift: peak, duration, acceleration, noise, and stations that do not fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from valvetrain.lift.band import CarriedSpread, LiftBandStudy
from valvetrain.lift.figures import LiftFigure, LobeResult, figure_rows
from valvetrain.measured.lift_smoothing import BAND
from valvetrain.report.text import number, speed_text, unit_text
from valvetrain.solution.definition import definition_of, label_of, shown

#: Standard deviations from which a station is off the law.
OFF = 4.0
#: Figures that bound the acceleration: over the nose, on the flanks.
PEAKS = ("nose_acceleration", "largest_acceleration")
#: What is reported of a case that has the lift, as many as there are up to a number.
IN_CASE = (
    "float_engine_speed", "minimum_open_cam_contact_force", "peak_cam_contact_force", "peak_spring_force",
)  # fmt: skip
MAX_NAMED = 2


def lift_verdict(
    lobes: Sequence[LobeResult],
    pair: Sequence[LiftFigure] = (),
    carried: LiftBandStudy | None = None,
) -> str:
    """One sentence on one lobe; on two with what they have together; of a case with what its forces and
    speeds are.
    """
    said = "; ".join(_lobe(one, len(lobes) > 1) for one in lobes)
    lap = [one for one in pair if one.name.startswith("overlap_at")][:1]
    both = ", ".join(f"{one.label} {_shown(one)}" for one in (*pair[:1], *lap))
    more = f"{f'; {both}' if both else ''}{'' if carried is None else _in_case(carried)}"
    return f"{said[:1].upper()}{said[1:]}{more}."


def _in_case(carried: LiftBandStudy) -> str:
    """``; in the case float speed 7094 ± 20 rpm``: the speeds and forces of :data:`IN_CASE` that it has."""
    known = [
        one for name in IN_CASE for one in carried.spreads if one.quantity == name and one.value > 0
    ]
    first = {one.quantity: one for one in reversed(known)}
    rows = [carried_text(first[name]) for name in IN_CASE if name in first][:MAX_NAMED]
    parts = [
        f"{label} {value} {spread.replace('±', '± ')} {unit}{f' ({run})' if run else ''}"
        for label, run, value, spread, unit in rows
    ]
    return f"; in the case {', '.join(parts)}" if parts else ""


def carried_text(one: CarriedSpread) -> tuple[str, str, str, str, str]:
    """Quantity, run, value, 95 % interval and unit of a carried spread as people read them."""
    unit = unit_text(definition_of(one.quantity).unit_word)
    value, spread = (
        float(shown(one.quantity, number_)[0]) for number_ in (one.value, BAND * one.spread)
    )
    run = one.label + (
        ""
        if one.engine_speed is None
        else f"{', ' if one.label else ''}{speed_text(one.engine_speed)}"
    )
    return label_of(one.quantity), run, number(value, 4), f"±{number(spread, 2)}", unit


def _lobe(one: LobeResult, named: bool) -> str:
    name = f"{one.measured.name} {one.measured.lift_of}" if named else one.measured.lift_of
    parts = []
    for figure in one.figures:
        if figure.name == "peak_lift":
            parts.append(f"{name} lift {_shown(figure)}")
        elif figure.name.startswith("duration_at"):
            parts.append(figure.label.replace("duration", f"duration {_shown(figure)}"))
            break
    peaks = [found for name in PEAKS for found in one.figures if found.name == name]
    if len(peaks) == len(PEAKS) and not named:
        parts.append(f"acceleration {_shown(peaks[0], False)} to {_shown(peaks[1])}")
    lift = one.smoothed
    noise = [] if named else [f"noise {1e6 * lift.noise:.2g} µm"]
    off = int(np.count_nonzero(np.abs(lift.residuals) > OFF * lift.noise))
    verb = "is" if off == 1 else "are"
    stations = f"{off} of {len(lift.residuals)} stations {verb} off the law"
    fits = [] if named else ["every station fits"]
    return ", ".join([*parts, *noise, *([stations] if off else fits)])


def _shown(figure: LiftFigure, with_unit: bool = True) -> str:
    """Value and half of its 95 % interval with the digits of the table, and the unit."""
    _, value, band, unit = figure_rows((figure,))[0]
    said = f"{value} {band.replace('±', '± ')}".replace("-", "−") if figure.spread > 0 else value
    return f"{said} {unit.replace(' deg', ' degrees')}" if with_unit else said
