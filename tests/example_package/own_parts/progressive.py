"""A massless spring whose rate grows with the lift."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field

from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.schema_types import PositiveLength, Ratio
from valvetrain.parameters.spring_options import SpringOptions
from valvetrain.solution.static import SpringAtRest
from valvetrain.springs.contract import Array, EndForces, Kernel, SpringEnergy, SpringOutputs
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.springs.spec import SpringModelSpec


@njit
def advance(parameters, integers, state, retainer_displacement, retainer_velocity, time_step):  # type: ignore[no-untyped-def]
    """``parameters``: preload (N), rate (N/m), cubic rate (N/m3)."""
    x = retainer_displacement
    force = parameters[0] + parameters[1] * x + parameters[2] * x * x * x
    return force, force


@dataclass(frozen=True)
class ProgressiveSpring:
    """Force = preload + rate x + cubic_rate x**3 (N, N/m, N/m3) at the retainer displacement x; a
    third of ``mass`` (kg) moves with it.
    """

    preload: float
    rate: float
    cubic_rate: float
    mass: float = 0.0
    name: str = "progressive"

    @property
    def unknowns(self) -> int:
        return 0

    @property
    def kernel(self) -> Kernel:
        found: Kernel = advance
        return found

    def parameters(self) -> Array:
        return np.array([self.preload, self.rate, self.cubic_rate])

    def integers(self) -> NDArray[np.int64]:
        return np.zeros(1, dtype=np.int64)

    def with_time_step(self, time_step: float) -> ProgressiveSpring:
        return self

    def initial_state(self, retainer_displacement: float) -> Array:
        return np.zeros(1)

    def stable_time_step(self) -> float:
        return float("inf")

    def energy(
        self,
        state: Array,
        retainer_displacement: float,
        retainer_velocity: float = 0.0,
        time_step: float = 0.0,
    ) -> SpringEnergy:
        x = retainer_displacement
        return SpringEnergy(
            0.0, self.preload * x + self.rate * x**2 / 2 + self.cubic_rate * x**4 / 4, 0.0
        )

    def force(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> EndForces:
        x = retainer_displacement
        force = self.preload + self.rate * x + self.cubic_rate * x**3
        return EndForces(force, force)

    def tangent(self, state: Array, retainer_displacement: float) -> float:
        return self.rate + 3 * self.cubic_rate * retainer_displacement**2

    def outputs(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> SpringOutputs:
        return SpringOutputs(*self.force(state, retainer_displacement))

    def retainer_mass(self) -> float:
        return self.mass / 3


class ProgressiveOptions(SpringOptions):
    """Options of the progressive spring."""

    rise: Ratio = Field(
        default=0.2,
        description="share by which the force above the preload exceeds the straight one at the reach",
    )
    reach: PositiveLength = Field(default=0.01, description="lift at which the rise is told")


def _make(
    spring: InstalledSpring, options: ProgressiveOptions, rest: SpringAtRest | None
) -> ProgressiveSpring:
    plain = EquivalentSpring.from_installed(spring)
    return ProgressiveSpring(
        plain.preload, plain.rate, plain.rate * options.rise / options.reach**2, plain.active_mass
    )


SPEC = SpringModelSpec(
    "progressive",
    "progressive spring",
    "#8c6d31",
    ProgressiveOptions,
    _make,
    knows="a rate that grows with the lift",
    leaves_out="surge, clash",
    processor_time=0.05,
)
