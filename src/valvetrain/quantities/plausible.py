"""Plausible ranges of requested motion, parts and results; beyond them a request is refused or a
run has diverged.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from valvetrain.cam.contract import TURN, LiftLaw
from valvetrain.errors import InputError
from valvetrain.quantities.limits import ENDED
from valvetrain.solution.result import Solution
from valvetrain.solution.static import SpringAtRest
from valvetrain.solution.status import Status


@dataclass(frozen=True, slots=True)
class PlausibleRange:
    """Range ``low`` to ``high`` (SI) of the quantities whose names begin and end as a pair of
    ``names``; ``unit`` and ``scale`` for display, and the ``reason`` for the bounds.
    """

    label: str
    names: tuple[tuple[str, str], ...]
    low: float
    high: float
    unit: str
    scale: float
    reason: str

    def holds(self, name: str) -> bool:
        """Whether the range applies to the quantity or channel ``name``."""
        return any(name.startswith(head) and name.endswith(tail) for head, tail in self.names)

    def why_not(self, value: float) -> str:
        """Why a value is implausible, as a sentence without a remedy; empty for a plausible one."""
        if self.low <= value <= self.high:
            return ""
        bound = self.high if not value < self.low else self.low
        side = "above" if bound == self.high else "below"
        found = f"{value / self.scale:.4g} {self.unit}".strip()
        limit = f"{bound / self.scale:g} {self.unit}".strip()
        return f"{self.label} is {found}, {side} {limit}: {self.reason}"


def _range(
    label: str, names: str, low: float, high: float, unit: str, scale: float, reason: str
) -> PlausibleRange:
    """A range from ``names`` separated by blanks, ``*`` for any text between head and tail."""
    parts = (
        (head, tail if star else "")
        for head, star, tail in (name.partition("*") for name in names.split())
    )
    exact = tuple((head, tail or head) for head, tail in parts)
    return PlausibleRange(label, exact, low, high, unit, scale, reason)


#: Of the motion that is requested, by lift law and engine speed.
MIN_LIFT = _range(
    "the minimum lift",
    "least_lift",
    -50e-6,
    math.inf,
    "mm",
    1e-3,
    "no cam is ground below its base circle by more than run-out",
)
MAX_LIFT = _range(
    "the largest lift",
    "largest_lift",
    0.0,
    0.1,
    "mm",
    1e-3,
    "valves that a cam drives open by less, in ship engines too",
)
SPEED = _range(
    "the lift speed",
    "lift_speed",
    0.0,
    50.0,
    "m/s",
    1.0,
    "racing engines at 20 000 rpm reach about 15 m/s",
)
ACCELERATION = _range(
    "the lift acceleration",
    "lift_acceleration",
    0.0,
    2e6,
    "m/s²",
    1.0,
    "racing valves reach about 1e5 m/s²; no contact of a valvetrain survives much more",
)
MOTION = (MIN_LIFT, MAX_LIFT, SPEED, ACCELERATION)
#: Of parts: a force that holds a part in its guide, what rubs, and wires.
GUIDE_FRICTION = _range(
    "the friction in a guide",
    "friction",
    0.0,
    1e4,
    "N",
    1.0,
    "guides of valves and tappets take some 10 N",
)
PARTS = (
    GUIDE_FRICTION,
    _range("the friction coefficient", "friction_coefficient", 0.0, 2.0, "", 1.0, "dry steel reaches 1, oiled valvetrains about 0.1"),
    _range("the thinnest wire", "wire_diameter", 0.4e-3, math.inf, "mm", 1e-3, "wires of valve springs have 1 to 10 mm, those of models 0.5 mm"),
    _range("the spring index (coil over wire diameter)", "spring_index", 0.0, 25.0, "", 1.0, "valve springs have about 4 to 12"),
)  # fmt: skip
#: Of runs: quantities and channels by name.
FOUND = (
    _range("a speed of the motion", "retainer_velocity valve_velocity axial_velocity *_axial_velocity", -100.0, 100.0, "m/s", 1.0,
           "wire struck at v bears a shear stress of v √(2 G ρ), 3.5 GPa at 100 m/s"),
    _range("a spring force", "raw_peak_spring_force raw_peak_retainer_force", -1e5, 1e5, "N", 1.0, "the largest valve springs carry some 10 kN"),
    _range("a contact force", "peak_*_contact_force", -1e6, 1e6, "N", 1.0, "more than any cam, tappet or seat can carry"),
    _range("the force on a guide", "guide_force", -1e5, 1e5, "N", 1.0, "a spring cannot press on its guide with more than it can carry"),
    _range("a shear stress", "peak_shear_stress open_nominal_shear_stress open_uncorrected_shear_stress", -1e10, 1e10, "GPa", 1e9,
           "the ideal strength of a steel crystal is G / 8"),
)  # fmt: skip
#: Channels of velocities, each of which counts by its largest value.
MOVING = (
    "retainer_velocity", "valve_velocity", "axial_velocity", "outer_axial_velocity", "inner_axial_velocity",
)  # fmt: skip
TABLES: Mapping[str, tuple[PlausibleRange, ...]] = {
    "requested": MOTION,
    "of parts": PARTS,
    "of a run": FOUND,
}
REMEDY = "check the numbers and their units, or let implausible values pass (--implausible, implausible=True)"


def lift_extremes(law: LiftLaw) -> tuple[float, float, float, float]:
    """Least and largest lift (m), largest first and second derivative by size (m/rad, m/rad2) of a
    law, between its joints too.
    """
    joints = (
        np.unique(np.mod(np.asarray(law.joints, dtype=float), TURN))
        if len(law.joints)
        else np.zeros(0)
    )
    ends = np.unique(np.concatenate([joints, np.linspace(0.0, TURN, 721)]))
    inner = np.linspace(0.0, 1.0, 8, endpoint=False)
    angles = (ends[:-1, None] + np.diff(ends)[:, None] * inner).ravel()
    lift, rate, bend = (
        np.asarray(law.lift(angles, derivative), dtype=float) for derivative in (0, 1, 2)
    )
    return (
        float(np.min(lift)),
        float(np.max(lift)),
        float(np.max(np.abs(rate))),
        float(np.max(np.abs(bend))),
    )


def refuse_implausible_motion(law: LiftLaw, cam_speeds: Iterable[float]) -> None:
    """Raise :class:`InputError` where the lift of ``law`` at the highest of ``cam_speeds`` (rad/s)
    is outside :data:`MOTION`.
    """
    least, largest, rate, bend = lift_extremes(law)
    speed = max(cam_speeds, default=0.0)
    for limit, value in zip(MOTION, (least, largest, rate * speed, bend * speed**2), strict=True):
        if sentence := limit.why_not(value):
            raise InputError(f"{sentence}; {REMEDY}")


def refuse_implausible_parts(values: Mapping[str, float]) -> None:
    """Raise :class:`InputError` for the first of ``values`` (SI, by key path) outside its range of
    :data:`PARTS`.
    """
    for place, value in values.items():
        for limit in PARTS:
            if limit.holds(place.rpartition(".")[2]) and (sentence := limit.why_not(value)):
                raise InputError(f"{sentence}; {REMEDY}", place)


def plausible_run(solution: Solution) -> Solution:
    """An evaluated run, as ``diverged`` where one of its numbers is implausible; all numbers stay."""
    numbers = dict(solution.quantities)
    for name in MOVING:
        if solution.has(name) and solution.channel(name).size:
            values = solution.channel(name)
            numbers[name] = float(values.flat[int(np.argmax(np.abs(values)))])
    limits = ((limit, name) for name in numbers for limit in FOUND if limit.holds(name))
    reasons = (limit.why_not(numbers[name]) for limit, name in limits)
    message = next(filter(None, reasons), "")
    if not message or solution.status.code not in ENDED:
        return solution
    status = Status("diverged", message, float(solution.time[-1]), remedy=REMEDY)
    return replace(solution, status=status)


def plausible_rest(one: SpringAtRest) -> SpringAtRest:
    """A spring at rest, its curve marked ``diverged`` where a number of it is implausible; all
    numbers stay.
    """
    if one.curve is None or not (found := _implausible_rest(one)):
        return one
    label, compression = found
    status = Status("diverged", label, where=f"{compression * 1e3:.4g} mm", remedy=REMEDY)
    return replace(one, curve=replace(one.curve, status=status))


def _implausible_rest(one: SpringAtRest) -> tuple[str, float] | None:
    """The first implausible number of a spring at rest as a sentence, and its compression (m)."""
    assert one.curve is not None
    curve, nominal = one.curve, one.stress_per_force
    rows = [("raw_peak_spring_force", curve.compression, curve.force)]
    if nominal is not None:
        rows.append(("open_nominal_shear_stress", curve.compression, nominal * curve.force))
    if one.stress is not None and one.stress.shear.size:
        rows.append(("peak_shear_stress", one.stress.compression, np.max(one.stress.shear, axis=1)))
    if curve.leaning is not None:
        rows.append(("guide_force", curve.compression[-1:], np.array([curve.leaning.force])))
    rows += [
        ("raw_peak_spring_force", np.array([point.compression]), np.array([point.force]))
        for point in one.points
    ]
    for name, places, values in rows:
        for limit in FOUND:
            wrong = [
                place
                for place, value in enumerate(values.tolist())
                if limit.holds(name) and limit.why_not(value)
            ]
            if wrong:
                return limit.why_not(float(values[wrong[0]])), float(places[wrong[0]])
    return None
