"""A contact whose stiffness grows with its depth, by a compiled kernel of its own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import ArrayLike
from pydantic import Field

from valvetrain.contact.kernels import OWN_LAW
from valvetrain.contact.law import (
    SLOWEST_IMPACT,
    Array,
    ContactSpec,
    LawKernel,
    overlap,
    require_not_negative,
    require_positive,
    row,
)
from valvetrain.parameters.schema_contact import ContactDamping, ContactTable
from valvetrain.parameters.schema_types import PositiveLength


@njit
def hardening(parameters, memory, penetration, previous_penetration, penetration_rate, time_step):  # type: ignore[no-untyped-def]
    """Force that needs no rate, and the damping of what does."""
    if penetration <= 0.0:
        return 0.0, 0.0
    return parameters[0] * penetration * (1.0 + (penetration / parameters[4]) ** 2), parameters[2]


@dataclass(frozen=True, slots=True)
class Hardening:
    """F = K d (1 + (d / hardening_depth)**2) + c d', never pulling; K in N/m, c in N s/m, depth in
    m.
    """

    contact_stiffness: float
    damping: float = 0.0
    hardening_depth: float = 1e-4
    name: str = "hardening"
    states: ClassVar[int] = 0
    code: ClassVar[int] = OWN_LAW

    def __post_init__(self) -> None:
        require_positive(
            self.name,
            contact_stiffness=self.contact_stiffness,
            hardening_depth=self.hardening_depth,
        )
        require_not_negative(self.name, damping=self.damping)

    @property
    def kernel(self) -> LawKernel:
        found: LawKernel = hardening
        return found

    def parameters(self) -> Array:
        return row(self.contact_stiffness, damping=self.damping, depth=self.hardening_depth)

    def _elastic(self, penetration: ArrayLike) -> Array:
        depth = overlap(penetration)
        return self.contact_stiffness * depth * (1 + (depth / self.hardening_depth) ** 2)

    def force(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        touching = np.asarray(penetration, dtype=float) > 0
        return np.where(
            touching,
            np.maximum(
                self._elastic(penetration) + self.damping * np.asarray(penetration_rate), 0.0
            ),
            0.0,
        )

    def tangent(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        slope = self.contact_stiffness * (
            1 + 3 * (overlap(penetration) / self.hardening_depth) ** 2
        )
        return np.where(self.force(penetration, penetration_rate) > 0, slope, 0.0)

    def dissipated_power(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        found: Array = (
            self.force(penetration, penetration_rate) - self._elastic(penetration)
        ) * np.asarray(penetration_rate)
        return found

    def stiffness(self, penetration: float) -> float:
        return self.contact_stiffness * (
            1 + 3 * (max(penetration, 0.0) / self.hardening_depth) ** 2
        )


class HardeningTable(ContactTable):
    """``contact_stiffness`` in N/m, ``damping`` in N s/m."""

    damping: ContactDamping = Field(default=0.0, description="c of c d' (N s/m)")
    hardening_depth: PositiveLength = Field(
        default=1e-4, description="penetration at which the force is twice the straight one"
    )


SPEC = ContactSpec(Hardening, HardeningTable, "N s/m")
