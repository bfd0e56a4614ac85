"""Limits of results, in one table that terminal, JSON, page and workbench read. A passed limit is marked,
the run stays.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from valvetrain.solution.definition import NESTED


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
