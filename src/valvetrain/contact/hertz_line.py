"""Hertz line contact of finite length: F = K d**(10/9), elastic (Palmgren)."""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from valvetrain.contact import kernels
from valvetrain.contact.law import SLOWEST_IMPACT, Array, require_positive, row
from valvetrain.contact.power import damped_power_force, damped_power_loss, damped_power_tangent


@dataclass(frozen=True, slots=True)
class HertzLine:
    """F = K d**(10/9); ``contact_stiffness`` K in N/m**(10/9) (``contact.hertz.line_stiffness``). No loss: a drop rebounds fully."""

    contact_stiffness: float
    name: str = "hertz-line"

    def __post_init__(self) -> None:
        require_positive(self.name, contact_stiffness=self.contact_stiffness)

    @property
    def code(self) -> int:
        return kernels.POWER

    def parameters(self) -> Array:
        return row(self.contact_stiffness, 10 / 9)

    def damping_factor(self, impact_rate: float) -> float:
        """Factor (s/m) of the rate in F = K d**n (1 + factor d')."""
        return 0.0

    def force(self, penetration: ArrayLike, penetration_rate: ArrayLike, impact_rate: float = SLOWEST_IMPACT) -> Array:
        factor = self.damping_factor(impact_rate)
        return damped_power_force(self.contact_stiffness, 10 / 9, factor, penetration, penetration_rate)

    def tangent(self, penetration: ArrayLike, penetration_rate: ArrayLike, impact_rate: float = SLOWEST_IMPACT) -> Array:
        factor = self.damping_factor(impact_rate)
        return damped_power_tangent(self.contact_stiffness, 10 / 9, factor, penetration, penetration_rate)

    def dissipated_power(self, penetration: ArrayLike, penetration_rate: ArrayLike, impact_rate: float = SLOWEST_IMPACT) -> Array:
        factor = self.damping_factor(impact_rate)
        return damped_power_loss(self.contact_stiffness, 10 / 9, factor, penetration, penetration_rate)

    def stiffness(self, penetration: float) -> float:
        return float(damped_power_tangent(self.contact_stiffness, 10 / 9, 0.0, penetration, 0.0))
