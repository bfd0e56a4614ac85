"""Flores, Machado, Silva and Martins (2011): Hunt-Crossley damping valid over the range of
restitution.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from pydantic import Field

from valvetrain.contact import kernels
from valvetrain.contact.law import (
    SLOWEST_IMPACT,
    Array,
    require_exponent,
    require_positive,
    require_restitution,
    row,
)
from valvetrain.contact.power import DampedPower
from valvetrain.contact.spec import ContactSpec
from valvetrain.parameters.schema_contact import RESTITUTION, ContactTable
from valvetrain.parameters.schema_types import Ratio


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


SPEC = ContactSpec(Flores, FloresTable)
