"""Hunt and Crossley (1975): damping that grows with the elastic force."""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import Field

from valvetrain.contact import kernels
from valvetrain.contact.law import (
    Array,
    require_exponent,
    require_not_negative,
    require_positive,
    row,
)
from valvetrain.contact.power import DampedPower
from valvetrain.contact.spec import ContactSpec
from valvetrain.parameters.schema_contact import ContactTable
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


SPEC = ContactSpec(HuntCrossley, HuntCrossleyTable, "s/m")
