"""Hertz point contact: F = K d**1.5, elastic."""

from __future__ import annotations

from dataclasses import dataclass, field

from valvetrain.contact import kernels
from valvetrain.contact.law import Array, require_positive, row
from valvetrain.contact.power import DampedPower
from valvetrain.contact.spec import ContactSpec
from valvetrain.parameters.schema_contact import ContactTable


@dataclass(frozen=True, slots=True)
class HertzPoint(DampedPower):
    """F = K d**1.5; ``contact_stiffness`` K in N/m**1.5 of a sphere of radius R: 4/3 E* sqrt(R)
    (Johnson 1985, chapter 4).

    1/E* is the sum of (1 - nu**2)/E of the two bodies, 1/R of their curvatures. No loss: a drop
    rebounds fully.
    """

    contact_stiffness: float
    exponent: float = field(default=1.5, init=False)
    name: str = "hertz-point"

    def __post_init__(self) -> None:
        require_positive(self.name, contact_stiffness=self.contact_stiffness)

    @property
    def code(self) -> int:
        return kernels.POWER

    def parameters(self) -> Array:
        return row(self.contact_stiffness, self.exponent)


class HertzPointTable(ContactTable):
    """``contact_stiffness`` in N/m**1.5."""


SPEC = ContactSpec(HertzPoint, HertzPointTable)
