"""Linear unilateral contact (Kelvin-Voigt that never pulls)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from valvetrain.contact import kernels
from valvetrain.contact.law import (
    SLOWEST_IMPACT,
    Array,
    overlap,
    require_not_negative,
    require_positive,
    row,
)
from valvetrain.contact.spec import ContactSpec
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


SPEC = ContactSpec(LinearContact, LinearTable, "N s/m")
