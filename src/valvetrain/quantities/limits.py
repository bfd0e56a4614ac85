"""Limits of results, in one table that terminal, JSON, page and workbench read. A passed limit is marked, the run stays;
a run that presses a spring solid ends there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.forces import bind_clearances, force_quantities
from valvetrain.solution.definition import NESTED
from valvetrain.solution.result import Solution
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
