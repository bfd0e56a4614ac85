"""Regularised Coulomb friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array
from valvetrain.contact.law import require_not_negative, require_positive


@dataclass(frozen=True, slots=True)
class CoulombFriction:
    """Friction -mu N tanh(v / v0); ``coefficient`` mu, ``slip_rate`` v0 in m/s (99.9 % of mu N at 4
    v0).

    Below v0 it creeps as a viscous film of mu N / v0 (N s/m) instead of sticking; ``damping`` is
    that figure, for the step estimate.
    """

    coefficient: float
    slip_rate: float = 1e-2
    name: str = "coulomb"

    def __post_init__(self) -> None:
        require_not_negative(self.name, coefficient=self.coefficient)
        require_positive(self.name, slip_rate=self.slip_rate)

    def force(self, normal_force: ArrayLike, sliding_velocity: ArrayLike) -> Array:
        """Friction force (N) on the body that slides with ``sliding_velocity`` (m/s)."""
        return (
            -self.coefficient
            * np.asarray(normal_force)
            * np.tanh(np.asarray(sliding_velocity) / self.slip_rate)
        )

    def dissipated_power(self, normal_force: ArrayLike, sliding_velocity: ArrayLike) -> Array:
        """Power (W) turned to heat, never negative."""
        found: Array = -self.force(normal_force, sliding_velocity) * np.asarray(sliding_velocity)
        return found

    def damping(self, normal_force: float) -> float:
        """Largest slope (N s/m) of the force over the velocity."""
        return self.coefficient * normal_force / self.slip_rate
