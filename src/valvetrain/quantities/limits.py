"""Limits of results, in one table that terminal, JSON, page and workbench read. A passed limit is marked, the run stays;
a run that presses a spring solid ends there.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase

import numpy as np

from valvetrain.cam.contract import TURN, LiftLaw
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.forces import bind_clearances, force_quantities
from valvetrain.solution.definition import NESTED
from valvetrain.solution.result import Solution
from valvetrain.solution.static import SpringAtRest
from valvetrain.solution.status import Status


@dataclass(frozen=True, slots=True)
class Limit:
    """``quantity`` that is at or below the quantity ``against`` or, where a run has none, below
    ``value`` (SI; None for no limit); at or above it where ``least``. ``reason`` with its source;
    a value that the case gives is a limit of its own.
    """

    quantity: str
    reason: str
    value: float | None = None
    against: str = ""
    least: bool = False


_SHEAR = (
    "what EN 13906-1 permits this wire, uncorrected and at rest, 0.56 of its least tensile strength; no limit of fatigue "
    "(docs/limits.md)"
)
_SEATING = (
    "called smooth of one hydraulic valve train up to 4500 rpm, 1.33 m/s too fast (doi:10.1177/14727978241299543); "
    "permitted_seating_velocity of [train.valve] sets a limit of your own"
)
#: The reason of a limit that the case gives.
OF_CASE = "the limit that the case sets"
LIMITS: tuple[Limit, ...] = (
    Limit("open_uncorrected_shear_stress", _SHEAR, against="permitted_shear_stress"),
    Limit("coil_bind_clearance", "the coils are solid before the largest lift", 0.0, least=True),
    Limit("seating_velocity", _SEATING, 0.52, against="permitted_seating_velocity"),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class PassedLimit:
    """A ``quantity`` whose ``value`` passes ``limit`` (SI), above it or, where ``least``, below."""

    quantity: str
    value: float
    limit: float
    least: bool
    reason: str


def passed_limits(values: Mapping[str, float]) -> dict[str, PassedLimit]:
    """Quantity -> its passed limit, of the quantities of a run (SI); where a limit is unknown, none is
    passed.

    >>> passed_limits({"seating_velocity": 12.5})["seating_velocity"].limit
    0.52
    """
    found = {}
    for limit in LIMITS:
        for prefix in ("", *(f"{spring}_" for spring in NESTED)):
            name, against = prefix + limit.quantity, prefix + limit.against
            own = values.get(against) if limit.against else None
            bound = limit.value if own is None else own
            if name not in values or bound is None:
                continue
            value = values[name]
            if value < bound if limit.least else value > bound:
                of_case = own is not None and limit.value is not None
                reason = OF_CASE if of_case else limit.reason
                found[name] = PassedLimit(name, value, bound, limit.least, reason)
    return found


#: Codes of runs that gave all of their samples.
ENDED = ("completed", "not-converged")
#: First words of numbers that the integrator found on every step of the whole revolution.
OF_EVERY_STEP = ("peak_", "minimum_")


def bound(solution: Solution, springs: tuple[InstalledSpring, ...]) -> Solution:
    """The run up to where the retainer passes the lift at which the first of ``springs`` is solid,
    with the status ``coil-bind``.

    Only models with coil contact represent it, so later values are invalid: of channels, events and
    numbers those remain that come before. A spring without installed and solid height is not
    judged; nor is a run that diverged.
    """
    known = [(spring.room, spring) for spring in springs if spring.room is not None]
    if not known or solution.status.code not in ENDED or not solution.has("valve_lift"):
        return solution
    travel, spring = min(known, key=lambda pair: pair[0])
    past = solution.channel("valve_lift") >= travel
    if not np.any(past):
        return solution
    index = int(np.argmax(past))
    angle = float(np.degrees(solution.cam_angle[index]) % 360)
    message = (
        f"spring '{spring.name}' is solid at {travel * 1e3:.4g} mm of lift, which the retainer passes at {angle:.1f} cam degrees, "
        "where the run ends"
    )
    remedy = (
        "run slower, or fit a spring that holds the valve and has more travel to its solid height"
    )
    status = Status("coil-bind", message, float(solution.time[index]), spring.name, remedy)
    return replace(_until(solution, index, travel, springs), status=status)


def _until(
    solution: Solution, index: int, travel: float, springs: tuple[InstalledSpring, ...]
) -> Solution:
    """The run before sample ``index``, at which the lift passes ``travel`` (m)."""
    end = float(solution.time[index])
    statistics = {
        name: value
        for name, value in solution.statistics.items()
        if not any(word in name for word in OF_EVERY_STEP)
    }
    channels = solution.arrays.at({"sample": range(index)})
    cut = replace(solution, channels=channels, statistics=statistics)
    found = {"peak_valve_lift": travel, **bind_clearances(springs, travel)}
    if index > 2:
        forces = force_quantities(reported_cycle(cut))
        found |= {name: force for name, force in forces.items() if not name.startswith("below_")}
    if cut.has("rigid_valve_lift"):
        above = travel - float(solution.channel("rigid_valve_lift")[index])
        found["float_excess_lift"] = max(above, 0.0)
    events = (event for event in solution.events if event.time <= end)
    return cut.with_found(events, {k: v for k, v in found.items() if k in solution.quantities})


@dataclass(frozen=True, slots=True)
class PlausibleRange:
    """Range ``low`` to ``high`` (SI) of the quantities of these ``names``, separated by blanks, ``*`` for any text;
    ``unit`` and ``scale`` for display, and the ``reason`` for the bounds.
    """

    label: str
    names: str
    low: float
    high: float
    unit: str
    scale: float
    reason: str

    def holds(self, name: str) -> bool:
        """Whether the range applies to the quantity or channel ``name``."""
        return any(fnmatchcase(name, pattern) for pattern in self.names.split())

    def why_not(self, value: float) -> str:
        """Why a value is implausible, as a sentence without a remedy; empty for a plausible one."""
        if self.low <= value <= self.high:
            return ""
        bound = self.high if not value < self.low else self.low
        side = "above" if bound == self.high else "below"
        found = f"{value / self.scale:.4g} {self.unit}".strip()
        limit = f"{bound / self.scale:g} {self.unit}".strip()
        return f"{self.label} is {found}, {side} {limit}: {self.reason}"


#: Of the motion that is requested, by lift law and engine speed.
MIN_LIFT = PlausibleRange(
    "the minimum lift",
    "least_lift",
    -50e-6,
    math.inf,
    "mm",
    1e-3,
    "no cam is ground below its base circle by more than run-out",
)
MAX_LIFT = PlausibleRange(
    "the largest lift",
    "largest_lift",
    0.0,
    0.1,
    "mm",
    1e-3,
    "valves that a cam drives open by less, in ship engines too",
)
SPEED = PlausibleRange(
    "the lift speed",
    "lift_speed",
    0.0,
    50.0,
    "m/s",
    1.0,
    "racing engines at 20 000 rpm reach about 15 m/s",
)
ACCELERATION = PlausibleRange(
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
GUIDE_FRICTION = PlausibleRange(
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
    PlausibleRange("the friction coefficient", "friction_coefficient", 0.0, 2.0, "", 1.0,
        "dry steel reaches 1, oiled valvetrains about 0.1"),
    PlausibleRange("the thinnest wire", "wire_diameter", 0.4e-3, math.inf, "mm", 1e-3,
        "wires of valve springs have 1 to 10 mm, those of models 0.5 mm"),
    PlausibleRange("the spring index (coil over wire diameter)", "spring_index", 0.0, 25.0, "", 1.0,
        "valve springs have about 4 to 12"),
)  # fmt: skip
#: Of runs: quantities and channels by name.
FOUND = (
    PlausibleRange("a speed of the motion", "retainer_velocity valve_velocity axial_velocity *_axial_velocity",
        -100.0, 100.0, "m/s", 1.0,
        "wire struck at v bears a shear stress of v √(2 G ρ), 3.5 GPa at 100 m/s"),
    PlausibleRange("a spring force", "raw_peak_spring_force raw_peak_retainer_force", -1e5, 1e5, "N", 1.0,
        "the largest valve springs carry some 10 kN"),
    PlausibleRange("a contact force", "peak_*_contact_force", -1e6, 1e6, "N", 1.0, "more than any cam, tappet or seat can carry"),
    PlausibleRange("the force on a guide", "guide_force", -1e5, 1e5, "N", 1.0,
        "a spring cannot press on its guide with more than it can carry"),
    PlausibleRange("a shear stress", "peak_shear_stress open_nominal_shear_stress open_uncorrected_shear_stress",
        -1e10, 1e10, "GPa", 1e9,
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


def plausible_rest(rest: SpringAtRest) -> SpringAtRest:
    """A spring at rest, its curve marked ``diverged`` where a number of it is implausible; all
    numbers stay.
    """
    if rest.curve is None or not (found := _implausible_rest(rest)):
        return rest
    label, compression = found
    status = Status("diverged", label, where=f"{compression * 1e3:.4g} mm", remedy=REMEDY)
    return replace(rest, curve=replace(rest.curve, status=status))


def _implausible_rest(rest: SpringAtRest) -> tuple[str, float] | None:
    """The first implausible number of a spring at rest as a sentence, and its compression (m)."""
    assert rest.curve is not None
    curve, nominal = rest.curve, rest.stress_per_force
    rows = [("raw_peak_spring_force", curve.compression, curve.force)]
    if nominal is not None:
        rows.append(("open_nominal_shear_stress", curve.compression, nominal * curve.force))
    if rest.stress is not None and rest.stress.shear.size:
        rows.append(
            ("peak_shear_stress", rest.stress.compression, np.max(rest.stress.shear, axis=1))
        )
    if curve.leaning is not None:
        rows.append(("guide_force", curve.compression[-1:], np.array([curve.leaning.force])))
    rows += [
        ("raw_peak_spring_force", np.array([point.compression]), np.array([point.force]))
        for point in rest.points
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
