"""Hunt and Crossley (1975): damping that grows with the elastic force."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from pydantic import Field

from valvetrain.arrays import Array
from valvetrain.contact import kernels
from valvetrain.contact.elastic import DampedPower
from valvetrain.contact.law import (
    SLOWEST_IMPACT,
    ContactSpec,
    require_exponent,
    require_not_negative,
    require_positive,
    require_restitution,
    row,
)
from valvetrain.errors import InputError
from valvetrain.parameters.schema_contact import RESTITUTION, ContactTable
from valvetrain.parameters.schema_types import Ratio


@dataclass(frozen=True, slots=True)
class HuntCrossley(DampedPower):
    """F = K d**n (1 + q d'), never adhesive; ``contact_stiffness`` K in N/m**n, ``damping`` q in
    s/m.

    A free drop at speed v rebounds with e from q v (1 + e) = ln((1 + q v) / (1 - e q v)), whatever
    K, n and the mass
    (``contact.restitution``); e = 1 - 2 q v / 3 for small q v.
    """

    contact_stiffness: float
    damping: float
    exponent: float = 1.5
    name: str = "hunt-crossley"

    def __post_init__(self) -> None:
        require_positive(self.name, contact_stiffness=self.contact_stiffness)
        require_not_negative(self.name, damping=self.damping)
        require_exponent(self.name, self.exponent)

    @property
    def code(self) -> int:
        return kernels.HUNT_CROSSLEY

    def parameters(self) -> Array:
        return row(self.contact_stiffness, self.exponent, self.damping)

    def damping_factor(self, impact_rate: float) -> float:
        """Factor (s/m) of the rate in F = K d**n (1 + factor d')."""
        return self.damping


class HuntCrossleyTable(ContactTable):
    """``contact_stiffness`` in N/m**n, ``damping`` in s/m."""

    exponent: Ratio = Field(default=1.5, description="n of K d^n")


HUNT_CROSSLEY_SPEC = ContactSpec(HuntCrossley, HuntCrossleyTable, "s/m")


@dataclass(frozen=True, slots=True)
class LankaraniNikravesh(DampedPower):
    """F = K d**n (1 + 3 (1 - e**2) d' / (4 v)) with v the approach velocity (m/s) of this impact.

    ``contact_stiffness`` K in N/m**n, ``restitution`` e. Derived for e near 1; the rebound it gives
    below that is
    larger than e (``contact.restitution.rebound`` gives it).
    """

    contact_stiffness: float
    restitution: float
    exponent: float = 1.5
    name: str = "lankarani-nikravesh"
    states: ClassVar[int] = 2

    def __post_init__(self) -> None:
        require_positive(self.name, contact_stiffness=self.contact_stiffness)
        require_restitution(self.name, self.restitution)
        require_exponent(self.name, self.exponent)

    @property
    def code(self) -> int:
        return kernels.LANKARANI_NIKRAVESH

    def parameters(self) -> Array:
        return row(self.contact_stiffness, self.exponent, restitution=self.restitution)

    def damping_factor(self, impact_rate: float) -> float:
        """Factor (s/m) of the rate in F = K d**n (1 + factor d')."""
        return 0.75 * (1 - self.restitution**2) / max(impact_rate, SLOWEST_IMPACT)


class LankaraniNikraveshTable(ContactTable):
    """``contact_stiffness`` in N/m**n and ``restitution``."""

    restitution: Ratio = Field(
        default=RESTITUTION,
        description="velocity of rebound over that of approach (steel on steel)",
    )
    exponent: Ratio = Field(default=1.5, description="n of K d^n")


LANKARANI_NIKRAVESH_SPEC = ContactSpec(LankaraniNikravesh, LankaraniNikraveshTable)


@dataclass(frozen=True, slots=True)
class Flores(DampedPower):
    """F = K d**n (1 + 8 (1 - e) d' / (5 e v)) with v the approach velocity (m/s) of this impact.

    ``contact_stiffness`` K in N/m**n, ``restitution`` e in (0, 1].
    """

    contact_stiffness: float
    restitution: float
    exponent: float = 1.5
    name: str = "flores"
    states: ClassVar[int] = 2

    def __post_init__(self) -> None:
        require_positive(self.name, contact_stiffness=self.contact_stiffness)
        require_restitution(self.name, self.restitution, lowest_open=True)
        require_exponent(self.name, self.exponent)

    @property
    def code(self) -> int:
        return kernels.FLORES

    def parameters(self) -> Array:
        return row(self.contact_stiffness, self.exponent, restitution=self.restitution)

    def damping_factor(self, impact_rate: float) -> float:
        """Factor (s/m) of the rate in F = K d**n (1 + factor d')."""
        return 1.6 * (1 - self.restitution) / (self.restitution * max(impact_rate, SLOWEST_IMPACT))


class FloresTable(ContactTable):
    """``contact_stiffness`` in N/m**n and ``restitution``."""

    restitution: Ratio = Field(
        default=RESTITUTION,
        description="velocity of rebound over that of approach (steel on steel)",
    )
    exponent: Ratio = Field(default=1.5, description="n of K d^n")


FLORES_SPEC = ContactSpec(Flores, FloresTable)


def rebound(damping_number: float) -> float:
    """Restitution e for the damping number q v (dimensionless, >= 0) by bisection to 1e-14.

    Raises :class:`InputError` for a negative number.
    """
    if not damping_number >= 0:
        raise InputError(f"damping number is {damping_number}; give zero or a positive number")
    if damping_number == 0:
        return 1.0
    low, high = 0.0, min(1.0, 1.0 / damping_number)
    while high - low > 1e-14:
        middle = (low + high) / 2
        # log1p keeps the tiny difference of the small-damping limit.
        excess = (
            math.log1p(damping_number)
            - math.log1p(-middle * damping_number)
            - damping_number * (1 + middle)
        )
        low, high = (middle, high) if excess < 0 else (low, middle)
    return (low + high) / 2


def damping_number(restitution: float) -> float:
    """Damping number q v that gives ``restitution`` (0 < e <= 1): the inverse of :func:`rebound`."""
    if not 0 < restitution <= 1:
        raise InputError(f"restitution is {restitution}; it must be above 0 and at most 1")
    low, high = 0.0, 1.0 / restitution
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if rebound(middle) > restitution else (low, middle)
    return (low + high) / 2
