"""Hertz line contact of finite length: F = K d**(10/9), elastic (Palmgren)."""

from __future__ import annotations

from dataclasses import dataclass, field

from valvetrain.contact import kernels
from valvetrain.contact.law import Array, require_positive, row
from valvetrain.contact.power import DampedPower
from valvetrain.contact.spec import ContactSpec
from valvetrain.parameters.schema_contact import ContactTable


@dataclass(frozen=True, slots=True)
class HertzLine(DampedPower):
    """F = K d**(10/9); ``contact_stiffness`` K in N/m**(10/9) of bodies of length L: E* L**(8/9) /
    1.36**(10/9) (Palmgren 1959).

    1/E* is the sum of (1 - nu**2)/E of the two bodies. No loss: a drop rebounds fully.
    """

    contact_stiffness: float
    exponent: float = field(default=10 / 9, init=False)
    name: str = "hertz-line"

    def __post_init__(self) -> None:
        require_positive(self.name, contact_stiffness=self.contact_stiffness)

    @property
    def code(self) -> int:
        return kernels.POWER

    def parameters(self) -> Array:
        return row(self.contact_stiffness, self.exponent)


class HertzLineTable(ContactTable):
    """``contact_stiffness`` in N/m**(10/9)."""


SPEC = ContactSpec(HertzLine, HertzLineTable)
