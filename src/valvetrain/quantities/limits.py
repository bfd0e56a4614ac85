"""Limits of results, in one table that terminal, JSON, page and workbench read. A passed limit is marked,
the run stays.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from valvetrain.solution.definition import NESTED, label_of, shown

#: What stands behind a number that passes its limit, and what :func:`passed_limits` explains.
MARK = "\u00a0!"


@dataclass(frozen=True, slots=True)
class Limit:
    """``quantity`` that lies at or below ``value`` (SI), or below the quantity ``against``; at or
    above it where ``least``. ``reason`` with its source.
    """

    quantity: str
    reason: str
    value: float = 0.0
    against: str = ""
    least: bool = False


_SHEAR = "the permitted shear stress of this wire, 0.56 of its least tensile strength (EN 13906-1; strengths: docs/limits.md)"
LIMITS: tuple[Limit, ...] = (
    Limit("nominal_peak_shear_stress", _SHEAR, against="permitted_shear_stress"),
    Limit("peak_shear_stress", _SHEAR, against="permitted_shear_stress"),
    Limit("seating_velocity", "published as smooth seating, 1.33 m/s as too fast (doi:10.1177/14727978241299543)", 0.52),
    Limit("coil_bind_clearance", "the coils are solid before the largest lift", 0.0, least=True),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class PassedLimit:
    """A ``quantity`` whose ``value`` passes ``limit`` (SI), above it or, where ``least``, below."""

    quantity: str
    value: float
    limit: float
    least: bool
    reason: str

    @property
    def comparison(self) -> str:
        """Value and limit in words, in the units shown."""
        value, unit = shown(self.quantity, self.value)
        limit, _ = shown(self.quantity, self.limit)
        side = "below" if self.least else "above"
        return f"{label_of(self.quantity)} {value:.4g} {unit}, {side} {limit:.4g} {unit}"


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
            if name not in values or (limit.against and against not in values):
                continue
            value, bound = values[name], values[against] if limit.against else limit.value
            if value < bound if limit.least else value > bound:
                found[name] = PassedLimit(name, value, bound, limit.least, limit.reason)
    return found
