"""Computed beside published: one row per published value, with an honest verdict."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from valvetrain.solution.comparison import Comparison
from valvetrain.solution.quantity import Quantity, unit_of

if TYPE_CHECKING:
    from valvetrain.parameters.case import PublishedValue

#: What produced a published value -> the spring model of ours that stands for the same thing.
COUNTERPARTS = {"solid finite elements": "finite-element", "engine head test": "finite-element", "analytical modal": "modal-varied"}
#: A whole turn (rad).
TURN = 2 * np.pi
#: Angles of one kind that are counted through a cycle: an extra one early on would shift the count of all that follow.
_COUNTED = re.compile(r"(clash|stage_1_peak)_\d+_cam_angle")


def compare(
    published: Iterable[PublishedValue], quantities: Mapping[Quantity, float], counterparts: Mapping[str, str] = COUNTERPARTS
) -> tuple[Comparison, ...]:
    """One row per published value, in their order.

    A published value meets the computed one of the same name and engine speed by the counterpart of its model; where
    there is none the row says so. Counted angles (collisions, peaks of Stage I) meet the computed ones of their kind one to one.
    """
    rows, listed = [], tuple(published)
    counted = _counted(listed, quantities, counterparts)
    for value in listed:
        model = _model(value, counterparts)
        computed = counted[id(value)] if _COUNTED.fullmatch(value.quantity) else _find(value, model, quantities)
        difference = None if computed is None else _difference(value, computed)
        rows.append(
            Comparison(
                quantity=value.quantity, engine_speed=value.engine_speed, model=model, origin=value.model, unit=value.unit,
                published=value.value, computed=computed, difference=difference, role=value.role, tolerance=value.tolerance,
                verdict=verdict(value, difference), source=value.source,
            )
        )  # fmt: skip
    return tuple(rows)


def _model(value: PublishedValue, counterparts: Mapping[str, str]) -> str:
    return "" if value.engine_speed is None else counterparts.get(value.model, "")


def _of_run(value: PublishedValue, model: str, quantities: Mapping[Quantity, float]) -> dict[str, float]:
    speed = value.engine_speed
    return {key.name: number for key, number in quantities.items() if key.label == model and same_speed(key.engine_speed, speed)}


def _find(value: PublishedValue, model: str, quantities: Mapping[Quantity, float]) -> float | None:
    return _of_run(value, model, quantities).get(value.quantity)


def _counted(
    published: tuple[PublishedValue, ...], quantities: Mapping[Quantity, float], counterparts: Mapping[str, str]
) -> dict[int, float | None]:
    """Computed partner of every counted published angle, by ``id``: one to one within an origin, engine speed and kind."""
    series: dict[tuple[str, float | None, str], list[PublishedValue]] = {}
    for value in published:
        match = _COUNTED.fullmatch(value.quantity)
        if match:
            series.setdefault((value.model, value.engine_speed, match[1]), []).append(value)
    partners: dict[int, float | None] = {}
    for (_, _, kind), values in series.items():
        values.sort(key=lambda value: value.value)
        mine = _of_run(values[0], _model(values[0], counterparts), quantities)
        computed = [number for name, number in mine.items() if (match := _COUNTED.fullmatch(name)) and match[1] == kind]
        found = pair_angles([value.value for value in values], computed)
        partners |= {id(value): partner for value, partner in zip(values, found, strict=True)}
    return partners


def pair_angles(published: Sequence[float], computed: Sequence[float]) -> list[float | None]:
    """For each of the ascending ``published`` angles (rad) a ``computed`` one, in order round the circle, each at most once, or None.

    Least sum of distances, where a published angle without a partner counts as much as the median step between published
    ones: a collision that did not come must not shift all that follow. A single published angle meets the nearest.
    """
    alone = float(np.median(np.diff(published))) if len(published) > 1 else TURN
    ordered = sorted(computed)
    turned = (ordered[start:] + ordered[:start] for start in range(max(1, len(ordered))))
    return min((_pair_in_order(published, angles, alone) for angles in turned), key=lambda found: found[0])[1]


def _pair_in_order(published: Sequence[float], computed: Sequence[float], alone: float) -> tuple[float, list[float | None]]:
    """Least cost and the partners, both lists taken in their order."""
    # best[j]: cost and partners of the published angles so far with the first j computed ones.
    best: list[tuple[float, list[float | None]]] = [(0.0, [])] * (len(computed) + 1)
    for angle in published:
        row: list[tuple[float, list[float | None]]] = []
        for count, (cost, partners) in enumerate(best):
            choices = [(cost + alone, [*partners, None])]
            if count:
                before, other = best[count - 1], computed[count - 1]
                choices += [row[-1], (before[0] + abs(_turn_difference(other - angle)), [*before[1], other])]
            row.append(min(choices, key=lambda choice: choice[0]))
        best = row
    return best[-1]


def same_speed(one: float | None, other: float | None) -> bool:
    """True for two engine speeds (rad/s) that agree to 0.01 %, or that are both absent."""
    if one is None or other is None:
        return one is other
    return abs(one - other) <= 1e-4 * max(abs(one), abs(other))


def _difference(value: PublishedValue, computed: float) -> float:
    difference = computed - value.value
    wraps = value.quantity.endswith("_cam_angle") and "interval" not in value.quantity
    return _turn_difference(difference) if wraps else difference


def _turn_difference(difference: float) -> float:
    return float((difference + np.pi) % (2 * np.pi) - np.pi)


def verdict(value: PublishedValue, difference: float | None) -> str:
    """Words for one row: within or outside a stated tolerance, else just how far apart.

    A bound ("spikes up to 620 N") is no tolerance: staying below it is not agreement, so the distance is given there too.
    """
    if difference is None:
        return "not computed"
    if value.relation in ("at-most", "at-least"):
        beyond = difference if value.relation == "at-most" else -difference
        limit = value.relation.replace("-", " ")
        return f"stated as {limit}: " + (f"beyond by {_size(value, beyond)}" if beyond > 0 else _size(value, difference, signed=True))
    if value.tolerance is None:
        return f"differs by {_size(value, difference, signed=True)}"
    if abs(difference) <= value.tolerance * (1 + 1e-12):
        return "within tolerance"
    return f"misses by {_size(value, difference, signed=True)}, tolerance {_size(value, value.tolerance)}"


def _size(value: PublishedValue, difference: float, signed: bool = False) -> str:
    from valvetrain.units import unit_factor

    sign = "+" if signed else ""
    if unit_of(value.quantity) == "rad":
        degrees = round(float(np.degrees(difference)), 1) + 0.0  # no minus nought
        return f"{degrees:{sign}.1f} deg"
    if value.value == 0:
        return f"{difference / unit_factor(value.unit):{sign}.3g} {value.unit}"
    return f"{100 * difference / abs(value.value):{sign}.1f} %"
