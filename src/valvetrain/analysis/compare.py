"""Computed beside published: one row per published value, with an honest verdict."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from valvetrain.analysis.quantity import Quantity, unit_of
from valvetrain.solution.comparison import Comparison

if TYPE_CHECKING:
    from valvetrain.parameters.case import PublishedValue

#: What produced a published value -> the spring model of ours that stands for the same thing.
COUNTERPARTS = {"solid finite elements": "finite-element", "engine head test": "finite-element", "analytical modal": "modal"}
#: Angles of one kind that are counted through a cycle: an extra one early on would shift the count of all that follow.
_COUNTED = re.compile(r"(clash|stage_1_peak)_\d+_cam_angle")


def compare(
    published: Iterable[PublishedValue], quantities: Mapping[Quantity, float], counterparts: Mapping[str, str] = COUNTERPARTS
) -> tuple[Comparison, ...]:
    """One row per published value, in their order.

    A published value meets the computed one of the same name and engine speed by the counterpart of its model; where
    there is none the row says so. Counted angles (collisions, peaks of Stage I) meet the nearest computed one of their kind.
    """
    rows = []
    for value in published:
        model = "" if value.engine_speed is None else counterparts.get(value.model, "")
        computed = _find(value, model, quantities)
        difference = None if computed is None else _difference(value, computed)
        rows.append(
            Comparison(
                quantity=value.quantity, engine_speed=value.engine_speed, model=model, origin=value.model, unit=value.unit,
                published=value.value, computed=computed, difference=difference, role=value.role, tolerance=value.tolerance,
                verdict=verdict(value, difference), source=value.source,
            )
        )  # fmt: skip
    return tuple(rows)


def _find(value: PublishedValue, model: str, quantities: Mapping[Quantity, float]) -> float | None:
    speed = value.engine_speed
    mine = {key.name: number for key, number in quantities.items() if key.model == model and same_speed(key.engine_speed, speed)}
    counted = _COUNTED.fullmatch(value.quantity)
    if counted:
        kin = ((_COUNTED.fullmatch(name), number) for name, number in mine.items())
        angles = [number for match, number in kin if match and match[1] == counted[1]]
        return min(angles, key=lambda angle: abs(_turn_difference(angle - value.value)), default=None)
    return mine.get(value.quantity)


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
