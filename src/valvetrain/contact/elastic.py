"""Linear unilateral contact (Kelvin-Voigt that never pulls)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from valvetrain.arrays import Array
from valvetrain.contact import kernels
from valvetrain.contact.law import (
    SLOWEST_IMPACT,
    ContactSpec,
    overlap,
    require_not_negative,
    require_positive,
    row,
)
from valvetrain.parameters.schema_contact import ContactDamping, ContactTable


@dataclass(frozen=True, slots=True)
class LinearContact:
    """F = max(0, k d + c d') for d > 0; ``contact_stiffness`` k in N/m, ``damping`` c in N s/m."""

    contact_stiffness: float
    damping: float = 0.0
    name: str = "linear"
    states: ClassVar[int] = 0

    def __post_init__(self) -> None:
        require_positive(self.name, contact_stiffness=self.contact_stiffness)
        require_not_negative(self.name, damping=self.damping)

    @property
    def code(self) -> int:
        return kernels.LINEAR

    def parameters(self) -> Array:
        return row(self.contact_stiffness, damping=self.damping)

    def force(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        depth, rate = overlap(penetration), np.asarray(penetration_rate, dtype=float)
        return np.where(
            depth > 0, np.maximum(self.contact_stiffness * depth + self.damping * rate, 0.0), 0.0
        )

    def tangent(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        return np.where(self.force(penetration, penetration_rate) > 0, self.contact_stiffness, 0.0)

    def dissipated_power(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        extra = self.force(penetration, penetration_rate) - self.contact_stiffness * overlap(
            penetration
        )
        found: Array = extra * np.asarray(penetration_rate, dtype=float)
        return found

    def stiffness(self, penetration: float) -> float:
        return self.contact_stiffness


class LinearTable(ContactTable):
    """``contact_stiffness`` in N/m, ``damping`` in N s/m."""

    damping: ContactDamping = Field(default=0.0, description="c of c d' (N s/m)")


LINEAR_SPEC = ContactSpec(LinearContact, LinearTable, "N s/m")


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


HERTZ_LINE_SPEC = ContactSpec(HertzLine, HertzLineTable)


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


HERTZ_POINT_SPEC = ContactSpec(HertzPoint, HertzPointTable)
