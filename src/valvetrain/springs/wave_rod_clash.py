"""Equivalent rod whose turns meet: the wave equation plus unilateral contact of neighbouring turns
from the installed gaps.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from valvetrain.arrays import Array, Ints
from valvetrain.coil_contact.law import LINEAR, law_of
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.solution.static import SpringAtRest
from valvetrain.springs.chain_layout import NO_CONTACTS, ChainLayout, CoilContacts, uniform_chain
from valvetrain.springs.contract import ContactWatch, EndForces, Kernel, SpringEnergy, SpringOutputs
from valvetrain.springs.equivalent import EquivalentSpring, InstalledGaps, installed_gaps
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.spec import NoOptions, SpringModelSpec
from valvetrain.springs.wave_rod import cells_for_step, wave_friction
from valvetrain.units import Given, keep_si, si

#: Courant number that leaves a margin for the contacts, their stiffness over a cell's, and their
#: damping time over the step.
COURANT, CONTACT_SHARE, DAMPING_SHARE = 0.9, 0.2, 0.4


@dataclass(frozen=True, eq=False)
class WaveRodWithClash:
    """Rod of ``cells`` cells with the installed ``gaps`` between neighbouring turns.

    A contact may be no stiffer than the explicit step resolves (``CONTACT_SHARE`` of a cell), so a
    clash is softer than steel.
    ``friction`` mu (1/s). ``pulls``: whether the ends are held. The state counts from a linear free
    state at ``preload / rate``.

    >>> import valvetrain as vt
    >>> problem = vt.system.build.build("uniform-spring")
    >>> rod = problem.model_of("wave-rod-clash", problem.springs[0])
    >>> isinstance(rod, WaveRodWithClash)
    True
    """

    spring: EquivalentSpring
    gaps: InstalledGaps
    cells: int = 200
    friction: float = 0.0
    name: str = "wave-rod-clash"
    pulls: bool = True

    def __post_init__(self) -> None:
        keep_si(self, f"the rod of spring '{self.spring.name}'", friction="damping rate")
        if self.cells < 3:
            raise InputError(
                f"the rod of spring '{self.spring.name}' has {self.cells} cells; give at least 3 (200 is typical)"
            )

    @classmethod
    def from_definition(
        cls, spring: SpringDefinition, precompression: Given, **options: Any
    ) -> WaveRodWithClash:
        """Rate, mass and installed gaps of the wire at ``precompression`` (m, text with a unit or a
        pint quantity).
        """
        precompression = si(
            precompression, "compression", f"precompression of spring '{spring.name}'"
        )
        return cls(
            EquivalentSpring.from_definition(spring, precompression),
            installed_gaps(spring, precompression),
            **options,
        )

    @cached_property
    def chain(self) -> MultiMassSpring:
        """The same rod as a uniform chain with contacts, stepped by the chain's kernel."""
        bare = uniform_chain(
            self.spring.rate, self.spring.active_mass, self.cells, self.spring.inactive_mass
        )
        coil = np.interp(bare.coil_number, self.gaps.flow, self.gaps.turns)
        layout = ChainLayout(
            bare.stiffness,
            bare.masses,
            coil,
            bare.seat_mass,
            bare.retainer_mass,
            self._contacts(coil),
        )
        step = COURANT / (self.spring.wave_speed * self.cells)
        return MultiMassSpring(
            layout,
            self.spring.preload / self.spring.rate,
            mass_damping=2 * self.friction,
            contact_damping_time=DAMPING_SHARE * step,
            name=self.name,
            pulls=self.pulls,
        )

    def _contacts(self, coil: Array) -> CoilContacts:
        """One contact per node of free wire, and as dense a row where carried turns come down on
        free ones.
        """
        gaps = self.gaps
        if not len(gaps.gap):
            return NO_CONTACTS
        carried = coil[-1] + np.diff(coil)[-1] * np.arange(
            0, int((gaps.upper_coil[-1] - coil[-1]) / np.diff(coil)[-1]) + 1
        )
        places = np.concatenate((coil[1:-1], carried))
        places = places[(places >= gaps.upper_coil[0]) & (places <= gaps.upper_coil[-1])]
        upper = np.minimum(np.searchsorted(coil, places - 1e-9), self.cells)
        below = gaps.position(places - 1.0) * self.cells
        lower = np.minimum(np.floor(below + 1e-9).astype(np.int64), self.cells - 1)
        fraction = np.clip(below - lower, 0.0, 1.0)
        # The chain counts from its free state, the gaps from the installed one.
        closed = self.spring.preload / self.spring.rate * (upper - below) / self.cells
        gap = np.interp(places, gaps.upper_coil, gaps.gap) + closed
        order = np.argsort((lower < 1) | (upper == self.cells), kind="stable")
        stiffness = np.full(len(places), CONTACT_SHARE * self.spring.rate * self.cells)
        return CoilContacts(
            upper[order].astype(np.int64),
            lower[order],
            fraction[order],
            gap[order],
            stiffness,
            places[order],
        )

    @property
    def unknowns(self) -> int:
        return self.cells - 1

    @property
    def kernel(self) -> Kernel:
        kernel: Kernel = self.chain.kernel
        return kernel

    def parameters(self) -> Array:
        return self.chain.parameters()

    def integers(self) -> Ints:
        return self.chain.integers()

    def with_time_step(self, time_step: float) -> WaveRodWithClash:
        """The finest grid that this step (s) carries with closed contacts."""
        return replace(self, cells=cells_for_step(self.spring.wave_speed, time_step, COURANT))

    def initial_state(self, retainer_displacement: float) -> Array:
        return self.chain.initial_state(retainer_displacement)

    def stable_time_step(self) -> float:
        return COURANT / (self.spring.wave_speed * self.cells)

    def energy(
        self,
        state: Array,
        retainer_displacement: float,
        retainer_velocity: float = 0.0,
        time_step: float = 0.0,
    ) -> SpringEnergy:
        return self.chain.energy(state, retainer_displacement, retainer_velocity, time_step)

    def force(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> EndForces:
        return self.chain.force(state, retainer_displacement, retainer_velocity)

    def tangent(self, state: Array, retainer_displacement: float) -> float:
        return self.chain.tangent(state, retainer_displacement)

    def outputs(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> SpringOutputs:
        return self.chain.outputs(state, retainer_displacement, retainer_velocity)

    def outputs_at(
        self, states: Array, displacements: Array, velocities: Array
    ) -> list[SpringOutputs]:
        """Those of the chain."""
        return self.chain.outputs_at(states, displacements, velocities)

    def contact_watch(self) -> ContactWatch | None:
        """That of the chain."""
        return self.chain.contact_watch()

    def retainer_mass(self) -> float:
        """Half a cell plus the coils resting on the retainer (kg)."""
        return self.chain.retainer_mass()


def _make(
    spring: InstalledSpring, options: NoOptions, rest: SpringAtRest | None
) -> WaveRodWithClash:
    assert spring.wire is not None
    if law_of(spring.contact) != LINEAR:
        raise InputError(
            f"a rod with clash presses its coils apart by a linear penalty of its own, so the law '{spring.contact.law}' of "
            f"spring '{spring.name}' has no effect; use multi-mass or finite-element"
        )
    equivalent = EquivalentSpring.from_installed(spring)
    gaps = installed_gaps(spring.wire, spring.precompression)
    return WaveRodWithClash(
        equivalent, gaps, friction=wave_friction(spring, equivalent), pulls=spring.pulls
    )


SPEC = SpringModelSpec(
    "wave-rod-clash",
    "equivalent rod with clash",
    "#3c7d3f",
    NoOptions,
    _make,
    shows=("sections", "clash"),
    processor_time=1.0,
    beside=("multi-mass",),
    knows="the wave equation with contact of neighbouring turns from the installed gaps",
    leaves_out="change of rate while surging",
    wire_only="a rod with clash needs the coil gaps of its wire, so use wave-rod",
    citation="vasilyev2016",
)
