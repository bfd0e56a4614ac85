"""The finite-element rod behind the contract of spring models: its mesh, states, forces and
contacts.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from valvetrain.arrays import Array, Ints
from valvetrain.coil_contact.law import contact_response, law_address
from valvetrain.cosserat.buffer import RodDynamics, fill_buffer, stable_time_step, stepping_numbers
from valvetrain.cosserat.end_coils import EndCoils
from valvetrain.cosserat.guide import walls
from valvetrain.cosserat.layout import ROW, STRIDE, row
from valvetrain.cosserat.mesh import RodMesh, mesh_spring
from valvetrain.cosserat.state import RodState, free_state
from valvetrain.cosserat.static import Equilibrium, RodStatics, compress
from valvetrain.cosserat.time_stepping import LAW
from valvetrain.cosserat.turning import TurningStatics
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import ROTATIONS, Guide
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.springs import finite_element_kernel as stepping
from valvetrain.springs.chain_statics import first_period_of
from valvetrain.springs.contract import (
    WATCH_SHARE,
    ContactWatch,
    EndForces,
    SpringEnergy,
    SpringOutputs,
)
from valvetrain.units import keep_si

_SCRATCH = threading.local()
#: Wire points and coil pairs are reported at every eighth of a turn.
POINTS_PER_COIL = 8


@dataclass(frozen=True, eq=False)
class RodModel:
    """Rod model of ``definition`` installed at ``precompression`` (m from the free state).

    ``time_step`` (s) is set by :meth:`with_time_step`; None means the stable step. Where it does
    not pull (``pulls``) its end forces in a train stop at zero; its inactive coils stay on their
    seats, unless it is ``lifting``: then its end coils lift off seat and retainer and come down on
    them, each a rigid body on the axis. ``guide``: bore or rod that the wire
    may lean on.
    ``retainer_rotation``: ``fixed``, or ``free`` about the axis at rest; in motion the retainer
    keeps the angle at which it is installed.
    """

    definition: SpringDefinition
    precompression: float
    elements_per_coil: int = 24
    dynamics: RodDynamics = field(default_factory=RodDynamics)
    curvature_correction: bool = True
    seats: str = "planes"
    time_step: float | None = None
    name: str = "finite-element"
    pulls: bool = True
    guide: Guide | None = None
    retainer_rotation: str = "fixed"
    lifting: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.definition, SpringDefinition):
            raise InputError(
                f"a rod is made of the definition of a wire, not of a {type(self.definition).__name__}; give its wire"
            )
        keep_si(self, f"spring '{self.name}'", precompression="compression", time_step="time")
        if not self.precompression >= 0:
            raise InputError(
                f"precompression of spring '{self.name}' is {self.precompression} m; give zero or a positive length"
            )
        if self.lifting and not self.pulls and self.dynamics.ends is None:
            ends = EndCoils(*zip(*map(self._inactive, (0, 1)), strict=True))
            object.__setattr__(self, "dynamics", replace(self.dynamics, ends=ends))
        if self.seats not in ("planes", "clamps"):
            raise InputError(
                f"seats '{self.seats}' of spring '{self.definition.name}' is unknown; use planes or clamps"
            )
        if self.dynamics.contact_stiffness > 0:
            self.definition.refuse_solid(self.precompression)
        if self.guide is not None:
            self.guide.check_fit(self.definition)
        if self.retainer_rotation not in ROTATIONS:
            raise InputError(
                f"retainer_rotation '{self.retainer_rotation}' of spring '{self.definition.name}' is unknown; use fixed or free"
            )

    def _inactive(self, end: int) -> tuple[float, float]:
        """Mass (kg) and length (m) of the inactive wire at the seat (0) or the retainer (1)."""
        wire, free = self.definition, self.definition.free_coils
        between = (0.0, free[0]) if end == 0 else (free[1], wire.total_coils)
        volume = np.pi / 4 * wire.integrate_along_wire(wire.wire_diameter, 2, between)
        return wire.material.density * volume, wire.integrate_along_wire(between=between)

    @cached_property
    def mesh(self) -> RodMesh:
        """The stress-free rod."""
        touching = self.dynamics.contact_stiffness > 0
        mesh = mesh_spring(
            self.definition,
            self.elements_per_coil,
            curvature_correction=self.curvature_correction,
            contact=touching,
        )
        if self.seats == "clamps":
            nothing = np.full(mesh.vertices, np.inf)
            mesh = replace(mesh, lower_seat_limit=-nothing, upper_seat_limit=nothing)
        if self.guide is not None:
            mesh = replace(
                mesh,
                guide=walls(
                    mesh.wire_diameter, self.guide.bore, self.guide.rod, self.guide.stiffness
                ),
            )
        return mesh

    @cached_property
    def statics(self) -> RodStatics:
        """Residual, tangent and Newton solver of the mesh."""
        kind = TurningStatics if self.retainer_rotation == "free" else RodStatics
        return kind(
            self.mesh, self.dynamics.contact_stiffness, contact_law=self.dynamics.contact_law
        )

    @cached_property
    def _turned(self) -> RodStatics:
        """As ``statics``, the retainer at the angle that it has."""
        if not self.statics.turns:
            return self.statics
        return RodStatics(
            self.mesh, self.dynamics.contact_stiffness, contact_law=self.dynamics.contact_law
        )

    @cached_property
    def installed(self) -> Equilibrium:
        """Static equilibrium at the precompression. Raises :class:`InputError` when the spring
        cannot be compressed so far.
        """
        return self._equilibrium(0.0)

    def _equilibrium(self, retainer_displacement: float) -> Equilibrium:
        compression = self.precompression + retainer_displacement
        if self.dynamics.ends is not None:  # lifting, above its free length it is free
            compression = max(compression, 0.0)
        if compression == 0.0:
            return self.statics.solve(free_state(self.mesh), 0.0)
        # Every other state is reached from the installed one, so that the answer does not depend on
        # what was computed before.
        away = retainer_displacement != 0.0
        start, statics = (self.installed.state, self._turned) if away else (None, self.statics)
        result = compress(statics, [compression], start)[-1]
        if not result.converged:
            raise InputError(
                f"spring '{self.definition.name}' finds no equilibrium at {compression * 1e3:.3g} mm compression "
                f"(it is solid at {self.definition.solid_compression * 1e3:.3g} mm); compress it less"
            )
        return result

    @property
    def unknowns(self) -> int:
        """Entries of the position rows of the flat buffer (vertex positions and edge frames, pads
        included).
        """
        return 7 * STRIDE

    @property
    def kernel(self) -> Any:
        return stepping.advance_rod

    @cached_property
    def _step(self) -> float:
        return self.time_step or self.stable_time_step()

    @cached_property
    def _numbers(self) -> tuple[Array, Ints]:
        integers, numbers, places = stepping_numbers(self.mesh, self.dynamics, self._step)
        return np.concatenate(
            ([self.precompression, float(self.pulls)], numbers, places.ravel())
        ), integers

    def parameters(self) -> Array:
        return self._numbers[0].copy()

    def integers(self) -> Ints:
        integers = self._numbers[1].copy()
        integers[LAW] = law_address(self.dynamics.contact_law)  # of this process
        return integers

    def with_time_step(self, time_step: float) -> Self:
        """The rod for another step; the solved installed state is reused."""
        model = replace(self, time_step=time_step)
        for name in ("mesh", "statics", "installed"):
            if name in self.__dict__:
                model.__dict__[name] = self.__dict__[name]
        return model

    def initial_state(self, retainer_displacement: float) -> Array:
        equilibrium = (
            self.installed
            if retainer_displacement == 0.0
            else self._equilibrium(retainer_displacement)
        )
        return self._filled(equilibrium, retainer_displacement)

    def static_forces(self, retainer_displacements: Array) -> Array:
        """Retainer force (N) at rest at each displacement (m), each from its neighbour's
        equilibrium: a third of the Newton steps.
        """
        found, start = np.zeros(len(retainer_displacements)), self.installed.state
        for place, displacement in enumerate(retainer_displacements.tolist()):
            result = compress(self._turned, [self.precompression + displacement], start)[-1]
            if not result.converged:
                result = self._equilibrium(displacement)
            start = result.state
            found[place] = self.force(self._filled(result, displacement), displacement).retainer
        return found

    def _filled(self, equilibrium: Equilibrium, retainer_displacement: float) -> Array:
        state = np.zeros(stepping.STATE_SIZE)
        state[: stepping.TRAVEL] = fill_buffer(
            self.mesh, equilibrium.state, self.dynamics, self._step
        )
        state[stepping.TRAVEL] = self.precompression + retainer_displacement
        return state

    @cached_property
    def _stable(self) -> float:
        return stable_time_step(self.mesh, self.dynamics)

    def stable_time_step(self) -> float:
        return self._stable

    def prepare(self) -> None:
        """Solve the installed state and the stable step."""
        _ = self.installed, self._stable

    def place_retainer(
        self, state: Array, retainer_displacement: float, travel_since: float
    ) -> None:
        state[stepping.TRAVEL] = self.precompression + retainer_displacement - travel_since

    def rod_state(self, state: Array, retainer_displacement: float) -> RodState:
        """Positions and frames in a flat ``state``, the retainer moved to ``retainer_displacement``
        (m).
        """
        count, compression = self.mesh.vertices, self.precompression + retainer_displacement
        position = np.stack([row(state, name, count) for name in "XYZ"], axis=1)
        if self.dynamics.ends is None:
            position[self.mesh.last :, 2] -= compression - state[stepping.TRAVEL]
        frame = np.stack([row(state, f"Q{n}", count + 1) for n in range(4)], axis=1)
        return RodState(position, frame / np.linalg.norm(frame, axis=1)[:, None], compression)

    def energy(
        self,
        state: Array,
        retainer_displacement: float,
        retainer_velocity: float = 0.0,
        time_step: float = 0.0,
    ) -> SpringEnergy:
        """Energies (J); contact energy is counted with the elastic one."""
        later = state
        if time_step > 0:
            later = state.copy()
            self.kernel(
                self.parameters(),
                self.integers(),
                later,
                retainer_displacement,
                retainer_velocity,
                time_step,
            )
        masses, inertia = (
            self.mesh.node_mass[self.mesh.first + 1 : self.mesh.last],
            self.mesh.edge_inertia,
        )
        kinetic = 0.0
        if self.dynamics.ends is not None:
            places = [self.mesh.first, self.mesh.last]
            speeds = (
                row(state, "VZ", self.mesh.vertices) + row(later, "VZ", self.mesh.vertices)
            ) / 2
            kinetic = 0.5 * float(self.dynamics.ends.masses(self.mesh) @ speeds[places] ** 2)
        for name in ("VX", "VY", "VZ"):
            mean = (row(state, name, self.mesh.last) + row(later, name, self.mesh.last)) / 2
            kinetic += 0.5 * float(masses @ mean[self.mesh.first + 1 :] ** 2)
        for axis, name in enumerate(("W1", "W2", "W3")):
            mean = (row(state, name, len(inertia)) + row(later, name, len(inertia))) / 2
            kinetic += 0.5 * float(inertia[:, axis] @ mean**2)
        elastic, *_ = self.statics.assemble(
            self.rod_state(state, retainer_displacement), with_tangent=False
        )
        return SpringEnergy(
            kinetic, float(elastic), 0.0, float(state[stepping.LOST] + self._contact_loss(state))
        )

    def _contact_loss(self, state: Array) -> float:
        return float(sum(row(state, name, self.mesh.vertices).sum() for name in ("LOSS", "LOSSb")))

    def force(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> EndForces:
        # the state is over a megabyte: a fresh copy per call costs more in page faults than the
        # forces do
        work: Array | None = getattr(_SCRATCH, "state", None)
        if work is None:
            work = _SCRATCH.state = np.empty(stepping.STATE_SIZE)
        np.copyto(work, state)
        parameters, integers = self._numbers[0], self.integers()
        return EndForces(
            *self.kernel(parameters, integers, work, retainer_displacement, retainer_velocity, 0.0)
        )

    def tangent(self, state: Array, retainer_displacement: float) -> float:
        if self.dynamics.ends is not None:
            stiffness = self.dynamics.ends.stiffnesses(self.mesh, self.dynamics.contact_stiffness)
            return float(stiffness[1]) if self.force(state, retainer_displacement)[0] > 0 else 0.0
        matrix = self.statics.tangent(self.rod_state(state, retainer_displacement))
        held = np.zeros(matrix.shape[0])
        held[6 * self.mesh.last + 2 :: 6] = 1.0
        rod = self.rod_state(state, retainer_displacement)
        seat = self.statics.retainer_contact(rod).tangent
        return float(held @ (matrix @ held)) + self.dynamics.contact_stiffness * float(
            self.mesh.node_length @ seat
        )

    def outputs(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> SpringOutputs:
        rod, count = self.rod_state(state, retainer_displacement), self.mesh.vertices
        forces = self.force(state, retainer_displacement, retainer_velocity)
        gaps = self.statics.gaps(rod.position)
        points, line = self.mesh.contact.points, self.mesh.contact.length
        pairs = np.any(points, axis=0)
        found = contact_response(self.dynamics.contact_law, -np.where(points, gaps, 0.0))
        pressed = self.dynamics.contact_stiffness * np.sum(line * found.elastic, axis=0)
        return SpringOutputs(
            *forces,
            coil_number=self.mesh.coil_number,
            axial_displacement=rod.position[:, 2] - self.installed.state.position[:, 2],
            axial_velocity=row(state, "VZ", count).copy(),
            upper_coil=self.mesh.coil_number[pairs],
            coil_gap=np.min(gaps[:, pairs], axis=0),
            coil_contact_force=pressed[pairs],
        )

    @cached_property
    def coil_pairs(self) -> tuple[Array, Ints]:
        """Upper coil numbers of the pairs in which contacts are reported, at every eighth of a turn,
        and the pair of each vertex (-1: none).
        """
        points, pair_of = (
            np.any(self.mesh.contact.points, axis=0),
            np.full(self.mesh.vertices, -1, dtype=np.int64),
        )
        bins = np.round(self.mesh.coil_number[points] * POINTS_PER_COIL).astype(np.int64)
        used = np.unique(bins)
        pair_of[points] = np.searchsorted(used, bins)
        return used / POINTS_PER_COIL, pair_of

    def contact_watch(self) -> ContactWatch | None:
        """Impulse since the start and stored energy of every contact point; forces are means over
        the record's spacing,
        which is wider than that of others: a rod has many points."""
        upper_coil, pair_of = self.coil_pairs
        vertices = np.flatnonzero(pair_of >= 0)
        if not len(vertices):
            return None
        first, count = vertices[0], vertices[-1] + 1 - vertices[0]
        groups = ("", "b")[: self.mesh.contact.groups]
        rows = [
            int(ROW[name + group]) + first for name in ("IMPULSE", "STORED") for group in groups
        ]

        def read(
            record: Array, spacing: float, time_step: float
        ) -> tuple[Ints, Array, Array, Array]:
            impulses = len(groups) * count
            met = np.flatnonzero(record[-1, :impulses] > record[0, :impulses])
            pair = pair_of[first + met % count]
            touched = np.unique(pair)
            force, energy = (
                np.zeros((len(touched), len(record))),
                np.zeros((len(touched), len(record))),
            )
            for entry, row_of in zip(
                met.tolist(), np.searchsorted(touched, pair).tolist(), strict=True
            ):
                force[row_of] += record[:, entry]
                energy[row_of] += record[:, impulses + entry]
            force[:, 1:] = np.diff(force, axis=1) / spacing
            force[:, 0] = force[
                :, min(1, len(record) - 1)
            ]  # a coil that rests at the start shall not seem to come down
            return touched, upper_coil[touched], force, energy

        stretches = np.array([[place, count] for place in rows], dtype=np.int64)
        period = self.first_period
        return ContactWatch(stretches, period, 2 * WATCH_SHARE * period, read)

    @cached_property
    def first_period(self) -> float:
        """First natural period (s) as installed, both ends fixed."""
        return first_period_of(self.definition, self.precompression)

    def retainer_mass(self) -> float:
        """Inactive wire on the retainer and half the last element (kg); none where they lift: then
        the force on the retainer contains their inertia.
        """
        return self.end_mass if self.dynamics.ends is None else 0.0

    @property
    def end_mass(self) -> float:
        """Inactive wire at the retainer and half the last element (kg)."""
        return self._inactive(1)[0] + float(self.mesh.node_mass[self.mesh.last])
