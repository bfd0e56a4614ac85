"""Springs without inner motion: linear, and a force table k(x) taken from a static curve.

Their inertia is a stated share of the wire's mass that moves with the retainer: one third in the
static shape (Rayleigh).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, Self

import numpy as np
from pydantic import Field

from valvetrain.arrays import Array, Ints
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring, Share
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.spring_options import SpringOptions
from valvetrain.solution.static import SpringAtRest
from valvetrain.springs import massless_kernels
from valvetrain.springs.chain_layout import RAYLEIGH_FRACTION, check_masses
from valvetrain.springs.chain_statics import reduction_chain, static_curve
from valvetrain.springs.contract import EndForces, SpringEnergy, SpringOutputs
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.springs.spec import SpringModelSpec
from valvetrain.units import keep_si, si_each


class Massless:
    """What springs without inner motion share: no state, any time step, and the mass that moves with the retainer."""

    active_mass: float
    effective_mass_fraction: float
    inactive_mass: float

    @property
    def unknowns(self) -> int:
        return 0

    def with_time_step(self, time_step: float) -> Self:
        return self

    def initial_state(self, retainer_displacement: float) -> Array:
        return np.zeros(1)

    def stable_time_step(self) -> float:
        return float("inf")

    def retainer_mass(self) -> float:
        """``effective_mass_fraction`` of the active mass plus the inactive end coils (kg)."""
        return self.effective_mass_fraction * self.active_mass + self.inactive_mass


@dataclass(frozen=True)
class MasslessSpring(Massless):
    """Force = preload + rate * displacement (N, N/m); ``effective_mass_fraction`` of
    ``active_mass`` moves with the retainer.

    ``inactive_mass`` (kg): end coils bonded to the retainer. ``pulls``: ends fixed, else the spring
    is loose where it would pull.
    Raises :class:`InputError` for impossible values.

    >>> spring = MasslessSpring(30e3, 250.0)
    >>> round(spring.force(spring.initial_state(10e-3), 10e-3, 0.0).retainer)
    550
    """

    rate: float
    preload: float
    active_mass: float = 0.0
    effective_mass_fraction: float = RAYLEIGH_FRACTION
    inactive_mass: float = 0.0
    name: str = "massless"
    pulls: bool = True

    def __post_init__(self) -> None:
        keep_si(
            self,
            f"spring '{self.name}'",
            rate="spring_rate",
            preload="force",
            active_mass="mass",
            inactive_mass="mass",
        )
        if not self.rate > 0:
            raise InputError(
                f"rate of spring '{self.name}' is {self.rate} N/m; give a positive rate"
            )
        check_masses(
            self.name,
            self.preload,
            self.active_mass,
            self.effective_mass_fraction,
            self.inactive_mass,
        )

    @property
    def kernel(self) -> Any:
        return massless_kernels.advance_linear

    def parameters(self) -> Array:
        return np.array([self.preload, self.rate, self._free])

    @property
    def _free(self) -> float:
        """Displacement (m) at which a spring that cannot pull is loose; below all others for one
        that can.
        """
        return -np.inf if self.pulls else -self.preload / self.rate

    def integers(self) -> Ints:
        return np.zeros(1, dtype=np.int64)

    def energy(
        self,
        state: Array,
        retainer_displacement: float,
        retainer_velocity: float = 0.0,
        time_step: float = 0.0,
    ) -> SpringEnergy:
        """Elastic energy counted from the installed position."""
        x = max(retainer_displacement, self._free)
        return SpringEnergy(0.0, self.preload * x + self.rate * x**2 / 2, 0.0)

    def force(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> EndForces:
        force = self.preload + self.rate * max(retainer_displacement, self._free)
        return EndForces(force, force)

    def tangent(self, state: Array, retainer_displacement: float) -> float:
        return self.rate if retainer_displacement >= self._free else 0.0

    def outputs(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> SpringOutputs:
        return SpringOutputs(*self.force(state, retainer_displacement))


@dataclass(frozen=True)
class MasslessTable(Massless):
    """Static curve as a spring: force (N) over displacement from the installed position (m), joined
    by straight lines.

    Straight lines keep the force continuous and the energy exact; beyond the table the last slopes
    continue, down to no force unless the
    spring ``pulls``.

    >>> spring = MasslessTable((0.0, 5e-3, 10e-3), (250.0, 400.0, 600.0))
    >>> round(spring.force(spring.initial_state(10e-3), 10e-3, 0.0).retainer)
    600
    """

    displacements: tuple[float, ...]
    forces: tuple[float, ...]
    active_mass: float = 0.0
    effective_mass_fraction: float = RAYLEIGH_FRACTION
    inactive_mass: float = 0.0
    name: str = "massless"
    pulls: bool = True

    def __post_init__(self) -> None:
        where = f"static curve of spring '{self.name}'"
        object.__setattr__(self, "displacements", si_each(self.displacements, "compression", where))
        object.__setattr__(self, "forces", si_each(self.forces, "force", where))
        keep_si(self, f"spring '{self.name}'", active_mass="mass", inactive_mass="mass")
        if len(self.displacements) != len(self.forces) or len(self.forces) < 2:
            raise InputError(
                f"static curve of spring '{self.name}' needs at least two points, each with displacement and force"
            )
        if np.any(np.diff(self.displacements) <= 0) or np.any(np.diff(self.forces) <= 0):
            raise InputError(
                f"static curve of spring '{self.name}' must rise in displacement and force; sort it and remove repeats"
            )
        preload = float(np.interp(0.0, self.displacements, self.forces))
        check_masses(
            self.name, preload, self.active_mass, self.effective_mass_fraction, self.inactive_mass
        )

    @property
    def kernel(self) -> Any:
        return massless_kernels.advance_table

    def parameters(self) -> Array:
        return np.concatenate((self.displacements, self.forces)).astype(np.float64)

    def integers(self) -> Ints:
        return np.array([len(self.forces), int(self.pulls)], dtype=np.int64)

    @cached_property
    def _free(self) -> float:
        """Displacement (m) at which a spring that cannot pull is loose; below all others for one
        that can.
        """
        if self.pulls:
            return -np.inf
        index, slope = self._segment(float(np.interp(0.0, self.forces, self.displacements)))
        return self.displacements[index] - self.forces[index] / slope

    def _segment(self, displacement: float) -> tuple[int, float]:
        index = int(
            np.clip(
                np.searchsorted(self.displacements, displacement, side="right") - 1,
                0,
                len(self.forces) - 2,
            )
        )
        rise = self.forces[index + 1] - self.forces[index]
        return index, rise / (self.displacements[index + 1] - self.displacements[index])

    def _work(self, displacement: float) -> float:
        x, f = np.asarray(self.displacements), np.asarray(self.forces)
        areas = np.concatenate(([0.0], np.cumsum(np.diff(x) * (f[1:] + f[:-1]) / 2)))
        index, slope = self._segment(displacement)
        step = displacement - x[index]
        return float(areas[index] + f[index] * step + slope * step**2 / 2)

    def energy(
        self,
        state: Array,
        retainer_displacement: float,
        retainer_velocity: float = 0.0,
        time_step: float = 0.0,
    ) -> SpringEnergy:
        """Elastic energy counted from the installed position: the area under the curve."""
        return SpringEnergy(
            0.0, self._work(max(retainer_displacement, self._free)) - self._work(0.0), 0.0
        )

    def force(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> EndForces:
        index, slope = self._segment(retainer_displacement)
        force = self.forces[index] + slope * (retainer_displacement - self.displacements[index])
        force = force if self.pulls else max(force, 0.0)
        return EndForces(force, force)

    def tangent(self, state: Array, retainer_displacement: float) -> float:
        return (
            self._segment(retainer_displacement)[1] if retainer_displacement >= self._free else 0.0
        )

    def outputs(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> SpringOutputs:
        return SpringOutputs(*self.force(state, retainer_displacement))


@lru_cache(maxsize=64)
def massless_table(
    spring: SpringDefinition,
    precompression: float,
    maximum_lift: float,
    points: int = 41,
    effective_mass_fraction: float = RAYLEIGH_FRACTION,
    pulls: bool = True,
) -> MasslessTable:
    """Massless spring with the static curve of the wire, coils closing, from ``-precompression`` to
    ``maximum_lift`` (m from installed).

    ``effective_mass_fraction`` of the vibrating mass moves with the retainer, with the inactive
    coils.
    """
    if not (maximum_lift > 0 and points >= 3):
        raise InputError(
            f"static curve of spring '{spring.name}' needs a positive lift and 3 points or more; it got {maximum_lift} m, {points}"
        )
    compressions = np.unique(
        np.append(np.linspace(0.0, precompression + maximum_lift, points), precompression)
    )
    forces, _ = static_curve(reduction_chain(spring), compressions)
    whole = EquivalentSpring.from_definition(spring, precompression)
    displacements = tuple((compressions - precompression).tolist())
    masses = whole.active_mass, effective_mass_fraction, whole.inactive_mass
    return MasslessTable(displacements, tuple(forces.tolist()), *masses, pulls=pulls)


class MasslessOptions(SpringOptions):
    """Options of the massless spring."""

    effective_mass_fraction: Share = Field(
        default=RAYLEIGH_FRACTION,
        description="share of the spring's mass that moves with the retainer",
    )


def _make(
    spring: InstalledSpring, options: MasslessOptions, rest: SpringAtRest | None
) -> MasslessSpring | MasslessTable:
    if spring.card is not None:
        card = spring.card
        return MasslessSpring(
            card.rate,
            card.preload,
            card.mass or 0.0,
            options.effective_mass_fraction,
            pulls=spring.pulls,
        )
    assert spring.wire is not None and spring.room is not None
    return massless_table(
        spring.wire,
        spring.precompression,
        0.98 * spring.room,
        97,
        options.effective_mass_fraction,
        spring.pulls,
    )


SPEC = SpringModelSpec(
    "massless",
    "massless spring",
    "#7b8794",
    MasslessOptions,
    _make,
    needs_mass=False,
    processor_time=0.05,
    beside=("wave-rod",),
    damped=False,
    knows="rate or static curve k(x), share of its mass on the valve",
    leaves_out="surge, clash",
)
