"""What a change from one saved run to another made better and worse: headline quantities at their worst,
against their error bars.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from valvetrain.runs.differences import answer_numbers
from valvetrain.solution.critical import BOUNCE_HEIGHT, FLOAT_LIFT, KINDS, RPM
from valvetrain.solution.definition import definition_of

#: What the valve lost of its motion and how fast it may run: named first where they changed.
DURATION_LOST = "valve_50_thou_lost_crank_angle_range"
FIRST = (
    "lift_loss_displacement",
    DURATION_LOST,
    *KINDS.values(),
    "rigid_contact_loss_engine_speed",
)
#: Quantities that answer whether a change is better, most important first.
HEADLINES = (
    *KINDS.values(), "rigid_contact_loss_engine_speed", "minimum_cam_contact_force", "float_excess_lift", "loft_gap",
    "lift_loss_displacement", DURATION_LOST, "seating_velocity", "bounce_height", "surge_amplitude_force", "clash_energy",
    "coil_bind_clearance", "outer_coil_bind_clearance", "inner_coil_bind_clearance", "largest_amplitude_shear_stress",
    "open_nominal_shear_stress", "peak_spring_force", "minimum_spring_force", "mean_cam_power",
)  # fmt: skip
#: Values (SI) below which a quantity is none.
NOTHING = {
    "float_excess_lift": FLOAT_LIFT, "bounce_height": BOUNCE_HEIGHT, "loft_gap": 1e-6, "lift_loss_displacement": 1e-6,
    DURATION_LOST: math.radians(0.1), "clash_energy": 1e-5, "surge_amplitude_force": 1.0,
}  # fmt: skip
#: Share of a value from which a change is one.
LEAST = 0.005


@dataclass(frozen=True, slots=True)
class HeadlineChange:
    """A ``quantity`` at its worst over the runs that ``a`` and ``b`` (as its unit in ``run.json``) share,
    with the error ``bar`` of both together; infinite for a speed that is never reached.
    """

    quantity: str
    a: float
    b: float
    bar: float = 0.0

    @property
    def share(self) -> float:
        """Size of the change over the larger value; infinite where one of both is never reached."""
        if math.isinf(self.a) or math.isinf(self.b):
            return 0.0 if self.a == self.b else math.inf
        largest = max(abs(self.a), abs(self.b))
        return abs(self.b - self.a) / largest if largest else 0.0

    @property
    def counts(self) -> bool:
        """Whether the change is above its error bar and :data:`LEAST`, of what is not nothing."""
        if max(abs(self.a), abs(self.b)) <= NOTHING.get(self.quantity, 0.0):
            return False
        return self.share > LEAST and not abs(self.b - self.a) <= self.bar

    @property
    def better(self) -> bool:
        """Whether B is the better one, by the sense of the quantity."""
        return (self.b > self.a) == (definition_of(self.quantity).sense == "larger is better")


def headline_changes(a: Mapping[str, Any], b: Mapping[str, Any]) -> tuple[HeadlineChange, ...]:
    """Headline quantities of the answers (``run.json``) of two runs, each at its worst over the labels and
    engine speeds that both have; those of :data:`FIRST`, then the largest change first.

    >>> def answer(force):
    ...     run = {"label": "massless", "engine_speed": {"value": 6000.0}}
    ...     return {"runs": [run | {"quantities": {"minimum_cam_contact_force": {"value": force, "unit": "N"}}}]}
    >>> (change,) = headline_changes(answer(200.0), answer(150.0))
    >>> change.better, change.share
    (False, 0.25)
    """
    first, second = _values(a), _values(b)
    bars = [_bars(answer) for answer in (a, b)]
    found = []
    for name in HEADLINES:
        least = definition_of(name).sense == "larger is better"
        common = [run for quantity, run in first if quantity == name and (name, run) in second]
        if not common:
            continue
        (one, where), (other, there) = (
            (min if least else max)((values[name, run], run) for run in common)
            for values in (first, second)
        )
        bar = bars[0].get((name, where), 0.0) + bars[1].get((name, there), 0.0)
        found.append(HeadlineChange(name, one, other, bar))
    places = {name: place for place, name in enumerate(FIRST)}
    return tuple(
        sorted(found, key=lambda change: (places.get(change.quantity, len(FIRST)), -change.share))
    )


def _values(answer: Mapping[str, Any]) -> dict[tuple[str, str], float]:
    """(quantity, run) -> value; a critical speed that was searched and not found is infinite."""
    known = {key: value for key, (value, _) in answer_numbers(answer) if key[0] in HEADLINES}
    for row in _rows(answer, "critical_speeds"):
        name, label = KINDS.get(str(row.get("kind")), ""), str(row.get("label", ""))
        known.setdefault((name, label), math.inf)
    return known


def _bars(answer: Mapping[str, Any]) -> dict[tuple[str, str], float]:
    """(quantity, run) -> numerical error bar, of those that are known."""
    bars = {}
    for row in _rows(answer, "uncertainties"):
        speed, bar = (_value(row.get(key)) for key in ("engine_speed", "numerical_uncertainty"))
        run = f"{row.get('label')} at {speed:g} rpm"
        if math.isfinite(bar):
            bars[str(row.get("quantity")), run] = bar
    for row in _rows(answer, "critical_speeds"):
        ends, speed = row.get("numerical"), _value(row.get("engine_speed"))
        if isinstance(ends, Mapping):
            sizes = [abs(_value(ends.get(end)) - speed) for end in ("lower", "upper")]
            known = [size for size in sizes if math.isfinite(size)]
            name = KINDS.get(str(row.get("kind")), "")
            bars[name, str(row.get("label", ""))] = RPM * max(known, default=0.0)
    return bars


def _rows(answer: Mapping[str, Any], key: str) -> Iterator[Mapping[str, Any]]:
    found = answer.get(key)
    yield from (row for row in found if isinstance(row, Mapping)) if isinstance(found, list) else ()


def _value(item: Any) -> float:
    value = item.get("value") if isinstance(item, Mapping) else None
    return float(value) if isinstance(value, (int, float)) else math.nan
