"""The IMPACT law of the common multibody tools, and the form one source prints."""

from __future__ import annotations

from dataclasses import dataclass
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
    require_exponent,
    require_not_negative,
    require_positive,
    row,
)
from valvetrain.parameters.schema_contact import ContactTable
from valvetrain.parameters.schema_types import Ratio

#: The rate (m/s) that the printed sum of force and damping means in millimetres, newtons and
#: seconds.
PRINTED_RATE = 1e-3


def cubic_step(share: ArrayLike) -> Array:
    """Step s**2 (3 - 2 s) from 0 at share 0 to 1 at share 1, flat beyond."""
    inside = np.clip(np.asarray(share, dtype=float), 0.0, 1.0)
    found: Array = inside**2 * (3.0 - 2.0 * inside)
    return found


def _cubic_step_slope(share: Array) -> Array:
    inside = np.clip(share, 0.0, 1.0)
    return 6.0 * inside * (1.0 - inside)


@dataclass(frozen=True, slots=True)
class ImpactContact:
    """F = max(0, K d**n + c(d) d'), c rising as a cubic step from 0 at d = 0 to ``damping`` at
    ``full_damping_depth``.

    ``contact_stiffness`` K in N/m**n (a tool's N/mm**1.5 is 1000**1.5 N/m**1.5), ``damping`` in N
    s/m, depth in m.
    """

    contact_stiffness: float
    damping: float
    full_damping_depth: float
    exponent: float = 1.5
    name: str = "impact"
    states: ClassVar[int] = 0

    def __post_init__(self) -> None:
        require_positive(
            self.name,
            contact_stiffness=self.contact_stiffness,
            full_damping_depth=self.full_damping_depth,
        )
        require_not_negative(self.name, damping=self.damping)
        require_exponent(self.name, self.exponent)

    @property
    def code(self) -> int:
        return kernels.IMPACT

    def parameters(self) -> Array:
        return row(
            self.contact_stiffness, self.exponent, self.damping, depth=self.full_damping_depth
        )

    def _elastic(self, penetration: ArrayLike) -> Array:
        return self.contact_stiffness * overlap(penetration) ** self.exponent

    def _damping(self, penetration: ArrayLike) -> Array:
        return self.damping * cubic_step(overlap(penetration) / self.full_damping_depth)

    def force(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        rate = np.asarray(penetration_rate, dtype=float)
        found: Array = np.maximum(
            self._elastic(penetration) + self._damping(penetration) * rate, 0.0
        )
        return found

    def tangent(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        depth, rate = overlap(penetration), np.asarray(penetration_rate, dtype=float)
        elastic = self.contact_stiffness * self.exponent * depth ** (self.exponent - 1.0)
        slope = (
            self.damping
            / self.full_damping_depth
            * _cubic_step_slope(depth / self.full_damping_depth)
        )
        pressing = (depth > 0) & (self.force(depth, rate) > 0)
        return np.where(pressing, elastic + slope * rate, 0.0)

    def dissipated_power(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        rate = np.asarray(penetration_rate, dtype=float)
        found: Array = (self.force(penetration, rate) - self._elastic(penetration)) * rate
        return found

    def stiffness(self, penetration: float) -> float:
        return float(
            self.contact_stiffness * self.exponent * max(penetration, 0.0) ** (self.exponent - 1.0)
        )


@dataclass(frozen=True, slots=True)
class ImpactAsPrinted:
    """The IMPACT law as the pushrod study prints it: K d**n + c(d), the damping term WITHOUT the
    penetration rate.

    Provided to reproduce the print only: N s/m added to N has no physical meaning, and the force no
    longer depends on the rate, so nothing
    is dissipated. The number enters in the study's own system, as if the rate were 1 mm/s. Use
    :class:`ImpactContact`.
    """

    contact_stiffness: float
    damping: float
    full_damping_depth: float
    exponent: float = 1.5
    name: str = "impact-as-printed"
    states: ClassVar[int] = 0

    def __post_init__(self) -> None:
        self.physical()

    def physical(self) -> ImpactContact:
        """The law that was meant (also checks the values)."""
        return ImpactContact(
            self.contact_stiffness, self.damping, self.full_damping_depth, self.exponent
        )

    @property
    def code(self) -> int:
        return kernels.IMPACT_AS_PRINTED

    def parameters(self) -> Array:
        return row(
            self.contact_stiffness,
            self.exponent,
            self.damping * PRINTED_RATE,
            depth=self.full_damping_depth,
        )

    def force(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        return self.physical().force(
            penetration, np.full_like(np.asarray(penetration_rate, dtype=float), PRINTED_RATE)
        )

    def tangent(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        return self.physical().tangent(
            penetration, np.full_like(np.asarray(penetration_rate, dtype=float), PRINTED_RATE)
        )

    def dissipated_power(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        return np.zeros(np.broadcast(np.asarray(penetration), np.asarray(penetration_rate)).shape)

    def stiffness(self, penetration: float) -> float:
        return float(self.tangent(penetration, 0.0))


class ImpactTable(ContactTable):
    """``contact_stiffness`` in N/m**n, ``damping`` in N s/m, ``full_damping_depth``."""

    exponent: Ratio = Field(default=1.5, description="n of K d^n")


SPEC = ContactSpec(ImpactContact, ImpactTable, "N s/m")
AS_PRINTED = ContactSpec(ImpactAsPrinted, ImpactTable, "N s/m")
