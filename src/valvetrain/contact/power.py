"""Shared arithmetic of the laws F = K d**n (1 + factor * d') that never pull."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.contact.law import SLOWEST_IMPACT, Array, overlap


class DampedPower:
    """What these laws answer alike; each adds its ``damping_factor`` (s/m), which need not be
    constant.

    ``contact_stiffness`` K in N/m**n, ``exponent`` n.
    """

    __slots__ = ()

    #: Numbers that the law remembers from step to step.
    states: ClassVar[int] = 0

    contact_stiffness: float
    exponent: float

    def damping_factor(self, impact_rate: float) -> float:
        """Factor (s/m) of the rate in F = K d**n (1 + factor d'); zero for an elastic law."""
        return 0.0

    def force(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        return self._elastic(penetration) * self._growth(penetration_rate, impact_rate)

    def tangent(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        return self._elastic_slope(penetration) * self._growth(penetration_rate, impact_rate)

    def dissipated_power(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        growth = self._growth(penetration_rate, impact_rate)
        found: Array = (
            self._elastic(penetration) * (growth - 1.0) * np.asarray(penetration_rate, dtype=float)
        )
        return found

    def stiffness(self, penetration: float) -> float:
        return float(self._elastic_slope(penetration))

    def _elastic(self, penetration: ArrayLike) -> Array:
        return self.contact_stiffness * overlap(penetration) ** self.exponent

    def _elastic_slope(self, penetration: ArrayLike) -> Array:
        depth = overlap(penetration)
        return np.where(
            depth > 0, self.contact_stiffness * self.exponent * depth ** (self.exponent - 1.0), 0.0
        )

    def _growth(self, penetration_rate: ArrayLike, impact_rate: float) -> Array:
        return np.maximum(
            1.0 + self.damping_factor(impact_rate) * np.asarray(penetration_rate, dtype=float), 0.0
        )
