"""The wire as a body of bricks, as a model of a spring alone under prescribed motion."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NoReturn, Self

import numpy as np

from valvetrain.arrays import Array, Ints
from valvetrain.continuum.statics import SolidEquilibrium, SolidStatics
from valvetrain.continuum.transient import SAFETY, SolidDynamics, stable_time_step
from valvetrain.continuum.wire import SolidContactLaw, SolidMeshSize, SolidWire
from valvetrain.errors import InputError
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.springs.chain_statics import first_period_of
from valvetrain.springs.contract import EndForces, Kernel, SpringEnergy, SpringOutputs

#: Why a solid has no place in the steps of a train.
ALONE = (
    "solid finite elements follow the motion of a train by run and sweep, one way, and take no part in its steps; "
    "use finite-element here"
)


@dataclass(frozen=True, eq=False)
class SolidModel:
    """Bricks of ``definition`` installed at ``precompression`` (m from the free state), its inactive
    turns bonded to seat and retainer.

    ``size`` of the mesh, law of ``contact``, ``dynamics``: damping and mass scaling, ``seats``:
    planes that press, or clamps. A train's step is a thousand of its own: it
    follows a train's motion one way.

    >>> import valvetrain as vt
    >>> wire = vt.parameters.SpringDefinition("4 mm", "24 mm", total_coils=6, free_length="44 mm", material="OTEVA 90 SC")
    >>> round(SolidModel(wire, 3e-3, SolidMeshSize(12)).installed.retainer_force)
    140
    """

    definition: SpringDefinition
    precompression: float
    size: SolidMeshSize = SolidMeshSize()
    contact: SolidContactLaw = SolidContactLaw()
    dynamics: SolidDynamics = SolidDynamics()
    seats: str = "planes"
    time_step: float | None = None
    name: str = "solid"
    pulls: bool = True

    def __post_init__(self) -> None:
        if not self.precompression >= 0:
            raise InputError(
                f"precompression of spring '{self.name}' is {self.precompression} m; give zero or a positive length"
            )
        if self.contact.stiffness > 0:
            self.definition.refuse_solid(self.precompression)

    @cached_property
    def first_period(self) -> float:
        """First natural period (s) as installed, both ends fixed."""
        return first_period_of(self.definition, self.precompression)

    @cached_property
    def statics(self) -> SolidStatics:
        """Residual, tangent and Newton solver of the mesh."""
        planes = self.seats == "planes"
        return SolidStatics(SolidWire(self.definition, self.size, self.contact, planes))

    @property
    def wire(self) -> SolidWire:
        """Mesh, contact points and seat planes."""
        return self.statics.wire

    @cached_property
    def installed(self) -> SolidEquilibrium:
        """Static equilibrium at the precompression. Raises :class:`InputError` where there is none."""
        return self.statics.compress([self.precompression])[0]

    def equilibrium(self, retainer_displacement: float) -> SolidEquilibrium:
        """The equilibrium at a displacement (m) from the installed state, reached from there."""
        if retainer_displacement == 0.0:
            return self.installed
        goal = self.precompression + retainer_displacement
        return self.statics.compress([goal], self.installed)[0]

    def prepare(self) -> None:
        """Solve the installed state and the stable step, once for all threads."""
        _ = self.installed, self._stable

    @cached_property
    def _stable(self) -> float:
        return SAFETY * stable_time_step(self.statics, self.dynamics, self.installed)

    def stable_time_step(self) -> float:
        return self._stable

    @property
    def unknowns(self) -> int:
        """Displacement components of the free nodes."""
        return len(self.statics.free)

    def with_time_step(self, time_step: float) -> Self:
        """The solid for another step; what is solved is reused."""
        model = replace(self, time_step=time_step)
        for name in ("statics", "installed", "_stable"):
            if name in self.__dict__:
                model.__dict__[name] = self.__dict__[name]
        return model

    def initial_state(self, retainer_displacement: float) -> Array:
        return self.equilibrium(retainer_displacement).position.ravel().copy()

    def energy(
        self,
        state: Array,
        retainer_displacement: float,
        retainer_velocity: float = 0.0,
        time_step: float = 0.0,
    ) -> SpringEnergy:
        """Elastic energy (J) of the bricks at rest."""
        position = state.reshape(self.wire.free_position.shape)
        return SpringEnergy(0.0, self.wire.bricks.energy(position), 0.0)

    def force(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> EndForces:
        position = state.reshape(self.wire.free_position.shape)
        goal = self.precompression + retainer_displacement
        _, retainer, seat = self.statics.forces(position, goal, self.installed.points.copy())
        return EndForces(retainer, seat)

    def tangent(self, state: Array, retainer_displacement: float) -> float:
        position = state.reshape(self.wire.free_position.shape)
        goal = self.precompression + retainer_displacement
        matrix = self.statics.tangent(position, goal, self.installed.points.copy())
        lifted = np.zeros(position.shape)
        lifted[:, 2, self.wire.ends[1] :] = 1.0
        return float(lifted.ravel() @ (matrix @ lifted.ravel()))

    def outputs(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> SpringOutputs:
        forces = self.force(state, retainer_displacement)
        centre = self.wire.centres(state.reshape(self.wire.free_position.shape))
        height = centre[2] - self.wire.centres(self.installed.position)[2]
        return SpringOutputs(forces.retainer, forces.seat, self.wire.coil, height)

    def retainer_mass(self) -> float:
        """Mass (kg) of the inactive wire at the retainer and of the bricks' nodes on it."""
        wire, (_, last) = self.definition, self.definition.free_coils
        bonded = wire.integrate_along_wire(wire.wire_diameter, 2, (last, wire.total_coils))
        nodes = self.wire.bricks.mass[:, self.wire.ends[1] :].sum()
        return float(wire.material.density * np.pi / 4 * bonded + nodes)

    @property
    def kernel(self) -> Kernel:
        """None: a solid steps alone. Raises :class:`InputError`."""
        self._refuse_train()

    def parameters(self) -> Array:
        self._refuse_train()

    def integers(self) -> Ints:
        self._refuse_train()

    def _refuse_train(self) -> NoReturn:
        raise InputError(ALONE)
