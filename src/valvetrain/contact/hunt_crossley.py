"""Hunt and Crossley (1975): damping that grows with the elastic force."""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from valvetrain.contact import kernels
from valvetrain.contact.law import SLOWEST_IMPACT, Array, require_exponent, require_not_negative, require_positive, row
from valvetrain.contact.power import damped_power_force, damped_power_loss, damped_power_tangent


@dataclass(frozen=True, slots=True)
class HuntCrossley:
    """F = K d**n (1 + q d'), never adhesive; ``contact_stiffness`` K in N/m**n, ``damping`` q in s/m.

    A free drop at speed v rebounds with e from q v (1 + e) = ln((1 + q v) / (1 - e q v)), whatever K, n and the mass
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

    def force(self, penetration: ArrayLike, penetration_rate: ArrayLike, impact_rate: float = SLOWEST_IMPACT) -> Array:
        factor = self.damping_factor(impact_rate)
        return damped_power_force(self.contact_stiffness, self.exponent, factor, penetration, penetration_rate)

    def tangent(self, penetration: ArrayLike, penetration_rate: ArrayLike, impact_rate: float = SLOWEST_IMPACT) -> Array:
        factor = self.damping_factor(impact_rate)
        return damped_power_tangent(self.contact_stiffness, self.exponent, factor, penetration, penetration_rate)

    def dissipated_power(self, penetration: ArrayLike, penetration_rate: ArrayLike, impact_rate: float = SLOWEST_IMPACT) -> Array:
        factor = self.damping_factor(impact_rate)
        return damped_power_loss(self.contact_stiffness, self.exponent, factor, penetration, penetration_rate)

    def stiffness(self, penetration: float) -> float:
        return float(damped_power_tangent(self.contact_stiffness, self.exponent, 0.0, penetration, 0.0))
