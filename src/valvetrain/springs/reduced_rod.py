"""Spring reduced from its finite-element rod: the wire in some forty coordinates that are carried
over lift, with clash in all contact points of the rod.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from pydantic import Field

from valvetrain.arrays import Array, Ints
from valvetrain.cosserat.contact_points import ContactPoints
from valvetrain.cosserat.static import Equilibrium, RodStatics
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring_options import SpringOptions
from valvetrain.solution.static import SpringAtRest
from valvetrain.springs import reduced_rod_kernel as kernels
from valvetrain.springs.contract import (
    WATCH_SHARE,
    ContactWatch,
    EndForces,
    ShownSeries,
    SpringEnergy,
    SpringOutputs,
)
from valvetrain.springs.finite_element import SPEC as ROD
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.finite_element_channels import interpolation, wire_points
from valvetrain.springs.reduced_rod_cache import tables_of
from valvetrain.springs.reduced_rod_samples import (
    SampleForces,
    Samples,
    sample_energies,
    sample_forces,
    samples_of,
)
from valvetrain.springs.reduced_rod_sections import section_loads
from valvetrain.springs.reduced_rod_tables import (
    PARTS,
    SPACING,
    ReducedTables,
    path_of_equilibria,
    reduce_rod,
)
from valvetrain.springs.spec import SpringModelSpec

#: Travel (m) of the tables below the installed state; share of a lift and length (m) beyond it to
#: which they reach; share of the travel left to solid that they never pass.
BELOW, BEYOND, MORE, NEARLY_SOLID = 0.6e-3, 0.05, 0.5e-3, 0.97
#: The step given as stable over the largest with every contact closed: a quarter of them close at a time, with
#: which it may be 1.25 (beehive up to 12000 rpm), and of what is given integrators take 0.8
#: (``STEP_FRACTION``), which holds with all closed; steps of Newton's method for a state at rest.
STEP_SAFETY, NEWTON_STEPS = 1.2, 60


class _AtLift(NamedTuple):
    """The tables at one retainer displacement, and their slopes by it."""

    place: float
    rest: Array
    load: Array
    overlap: Array
    stiffness: Array
    gradient: Array
    rest_slope: Array
    load_slope: Array
    overlap_slope: Array
    stiffness_slope: Array
    gradient_slope: Array


@dataclass(frozen=True, eq=False)
class ReducedRod:
    """Spring reduced from ``rod``, with tables up to a ``largest_lift`` (m) of the retainer and a
    little more, to nearly solid without one; they are made on first use.

    The rod itself answers static questions (statics, modes, stress). Raises
    :class:`InputError` for a rod with a contact law of its own, or whose ends lift. A guide's walls
    hold where the wire leans on them at rest; those that it meets in motion alone are not felt.

    >>> import valvetrain as vt
    >>> wire = vt.parameters.SpringDefinition("4 mm", "24 mm", total_coils=5, free_length="40 mm", material="OTEVA 90 SC")
    >>> spring = ReducedRod(vt.springs.FiniteElementRod(wire, "7 mm", elements_per_coil=12), 2e-3)
    >>> state = spring.initial_state(2e-3)
    >>> round(spring.force(state, 2e-3).retainer), round(spring.rod.static_point("9 mm").force)
    (556, 556)
    """

    rod: FiniteElementRod
    largest_lift: float | None = None
    name: str = "reduced-rod"

    def __post_init__(self) -> None:
        if reason := _why_not(self.rod):
            raise InputError(reason)

    @property
    def pulls(self) -> bool:
        """Whether seat and retainer can pull at the spring; where not, end forces stop at zero."""
        return self.rod.pulls

    def reaching(self, largest_lift: float) -> ReducedRod:
        """The spring with tables up to a lift (m) and a little more."""
        return (
            self if self.largest_lift == largest_lift else replace(self, largest_lift=largest_lift)
        )

    @cached_property
    def statics(self) -> RodStatics:
        """Statics of the rod, its retainer at the angle that it has as installed."""
        rod = self.rod
        if not rod.statics.turns:
            return rod.statics
        return RodStatics(rod.mesh, rod.dynamics.contact_stiffness)

    @cached_property
    def tables(self) -> ReducedTables:
        """The tables, made on first use or read. Raises :class:`InputError` where the rod has no
        equilibria.
        """
        rod, contact = self.rod, self.rod.dynamics.contact_stiffness
        numbers = (rod.precompression, rod.retainer_rotation, contact, self.largest_lift)
        return tables_of(rod.mesh, numbers, self._made)

    def make_tables(self) -> None:
        """Make or read the tables. Raises :class:`InputError` for a rod without equilibria."""
        _ = self.tables

    def refuse_unreached(self) -> None:
        """Raise :class:`InputError` where the rod has no equilibria over the lift; no tables are made."""
        self._path(1)

    def _made(self) -> ReducedTables:
        path, start, spacing = self._path(PARTS)
        return reduce_rod(self.statics, path, start, spacing, self.rod.definition.total_coils)

    def _path(self, parts: int) -> tuple[list[Equilibrium], float, float]:
        """Equilibria over the lift, ``parts`` from one coarse lift to the next: they, the displacement (m) of the first,
        and their spacing (m). Raises :class:`InputError` where they end below the largest lift or within a coarse one.
        """
        rod = self.rod
        top = NEARLY_SOLID * (rod.definition.solid_compression - rod.precompression)
        if self.largest_lift is not None:
            top = min(top, (1 + BEYOND) * self.largest_lift + MORE)
        coarse = max(2, int(np.ceil((top + BELOW) / SPACING)))
        spacing = (top + BELOW) / (coarse * parts)
        below = int(min(rod.precompression, BELOW) / spacing)
        path = path_of_equilibria(
            self.statics, rod.installed, below, coarse * parts - below, spacing
        )
        start = path[0].state.compression - rod.installed.state.compression
        reach = start + (len(path) - 1) * spacing
        if self.largest_lift is not None and reach < min(top, self.largest_lift) - parts * spacing:
            raise InputError(
                f"the rod of spring '{rod.definition.name}' has no equilibria beyond {reach * 1e3:.3g} mm of lift and cannot be reduced; "
                "use multi-mass"
            )
        if len(path) <= parts:
            raise InputError(
                "the rod has too few equilibria about the installed state to be reduced; compress the spring less"
            )
        return path, start, spacing

    @property
    def unknowns(self) -> int:
        return self.tables.coordinates

    @property
    def kernel(self) -> Any:
        return kernels.advance_reduced

    @cached_property
    def _parameters(self) -> Array:
        t, d = self.tables, self.rod.dynamics
        head = np.array(
            [t.start, t.spacing, d.mass_damping, d.stiffness_damping, d.contact_damping_time]
        )
        reach = np.sqrt(np.max(np.sum(t.gradient**2, axis=2), axis=0))

        def rows(table: Array, axes: int = 1) -> Array:
            more = [kernels.row_size(size) - size for size in table.shape[-axes:]]
            return np.pad(table, [(0, 0)] * (table.ndim - axes) + [(0, size) for size in more])

        tables = (
            *(head, t.contact_stiffness, reach, t.rest, t.rest_load, t.overlap, t.wire_force),
            *(t.gradient, t.momentum),
        )
        every = [rows(table) for table in tables]
        every.insert(7, rows(t.stiffness, 2))
        return kernels.aligned(np.concatenate([table.ravel() for table in every]))

    def parameters(self) -> Array:
        return kernels.aligned(self._parameters)

    @cached_property
    def _pairs(self) -> tuple[Array, Ints]:
        """Coil numbers of the coil pairs, and the pair of each contact point (-1: a seat); pairs that
        lie between the coils of one end are left out, as their points are.
        """
        upper_coil, pair_of = self.rod.coil_pairs
        found = np.full(self.tables.points, -1, dtype=np.int64)
        vertices = ContactPoints.of(self.rod.mesh).vertex
        moving, found[: len(vertices)] = np.unique(pair_of[vertices], return_inverse=True)
        return upper_coil[moving], found

    @cached_property
    def _integers(self) -> Ints:
        t, (upper_coil, pair_of) = self.tables, self._pairs
        sizes = [t.coordinates, t.points, len(t.rest), len(t.stiffness), t.parts, int(self.pulls)]
        return np.array([*sizes, len(upper_coil), *pair_of.tolist()], dtype=np.int64)

    def integers(self) -> Ints:
        return self._integers.copy()

    def with_time_step(self, time_step: float) -> ReducedRod:
        return self

    def _at(self, retainer_displacement: float) -> _AtLift:
        t = self.tables
        place = (retainer_displacement - t.start) / t.spacing
        fine = min(max(int(np.floor(place)), 0), len(t.rest) - 2)
        coarse = fine // t.parts
        values: list[Array] = []
        slopes: list[Array] = []
        for tables, at, part in (
            ((t.rest, t.rest_load, t.overlap), fine, 1),
            ((t.stiffness, t.gradient), coarse, t.parts),
        ):
            for table in tables:
                step = table[at + 1] - table[at]
                values.append(table[at] + (place / part - at) * step)
                slopes.append(step / (part * t.spacing))
        return _AtLift(place, *values, *slopes)

    def _apart(self, state: Array, here: _AtLift) -> tuple[Array, Array]:
        """Coordinates from rest on, and overlaps of all points."""
        apart = state[: self.unknowns] - here.rest
        return apart, here.overlap + here.gradient @ apart

    def initial_state(self, retainer_displacement: float) -> Array:
        t, here = self.tables, self._at(retainer_displacement)
        apart = np.zeros(t.coordinates)
        for _ in range(NEWTON_STEPS):
            depth = here.overlap + here.gradient @ apart
            closed = t.contact_stiffness * (depth > 0)
            residual = here.stiffness @ apart + here.load + (closed * depth) @ here.gradient
            tangent = here.stiffness + (here.gradient.T * closed) @ here.gradient
            step = np.linalg.solve(tangent, residual)
            apart = apart - step
            if np.max(np.abs(step)) <= 1e-14 * max(1e-3, np.max(np.abs(here.rest))):
                break
        state = np.zeros(kernels.state_size(t.coordinates, t.points, len(self._pairs[0])))
        state[: t.coordinates] = here.rest + apart
        return state

    def frequencies(self, retainer_displacement: float, count: int = 6) -> Array:
        """First ``count`` natural frequencies (Hz), both ends fixed, about rest at a displacement
        (m); touching coils stay closed.
        """
        here = self._at(retainer_displacement)
        _, depth = self._apart(self.initial_state(retainer_displacement), here)
        closed = self.tables.contact_stiffness * (depth > 0)
        matrix = here.stiffness + (here.gradient.T * closed) @ here.gradient
        squares = np.linalg.eigvalsh(matrix)[:count]
        return np.asarray(np.sign(squares) * np.sqrt(np.abs(squares)) / (2 * np.pi))

    @cached_property
    def _stable(self) -> float:
        """:data:`STEP_SAFETY` times the largest step h of a wire damped by velocities of half a step ago, 4 > 2 h C
        + h^2 K, every contact closed; damped contacts carry longer ones.
        """
        t, d, step = self.tables, self.rod.dynamics, np.inf
        for stiffness, gradient in ((t.stiffness[k], t.gradient[k]) for k in (0, -1)):
            closed = (gradient.T * t.contact_stiffness) @ gradient
            damped = d.stiffness_damping * stiffness + d.contact_damping_time * closed
            # with h = 1 / x a quadratic eigenvalue problem, x^2 = C x / 2 + K / 4
            zero, one = np.zeros_like(closed), np.eye(len(closed))
            form = np.block([[zero, one], [(stiffness + closed) / 4, damped / 2]])
            step = min(step, 1 / float(np.max(np.linalg.eigvals(form).real)))
        return STEP_SAFETY * float(step)

    def stable_time_step(self) -> float:
        return self._stable

    def force(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> EndForces:
        at = np.array([retainer_displacement]), np.array([retainer_velocity])
        samples = samples_of(self.tables, state[None, : self.unknowns], at[0])
        return EndForces(*self._forces(state[None], samples, *at).ends[0].tolist())

    def _forces(
        self, states: Array, samples: Samples, displacements: Array, velocities: Array
    ) -> SampleForces:
        arrays, overlaps = (self._parameters, self._integers), samples.overlap
        return sample_forces(arrays, states, overlaps, displacements, velocities, self.unknowns)

    def energy(
        self,
        state: Array,
        retainer_displacement: float,
        retainer_velocity: float = 0.0,
        time_step: float = 0.0,
    ) -> SpringEnergy:
        """Elastic energy counted from the lowest table on; the end masses belong to the valve."""
        at = np.array([retainer_displacement]), np.array([retainer_velocity])
        energy = self.shown_at(state[None], *at, time_step).energy
        assert energy is not None
        return SpringEnergy(*energy[0].tolist())

    @property
    def sampled_entries(self) -> int:
        """Coordinates, their rates and the dissipated energy."""
        return 2 * self.unknowns + 1

    def shown_at(
        self, states: Array, displacements: Array, velocities: Array, time_step: float = 0.0
    ) -> ShownSeries:
        """See :class:`valvetrain.springs.contract.ShownTogether`."""
        t, count = self.tables, self.unknowns
        samples = samples_of(t, states[:, :count], displacements)
        rates = states[:, count : 2 * count]
        now = rates
        if time_step > 0:
            pull = self._forces(states, samples, displacements, velocities).pull
            now = rates + time_step / 2 * (pull - self.rod.dynamics.mass_damping * rates)
        coil, installed = self._installed
        loads = samples.at_rest_and_beyond(
            t.section_load.reshape(len(t.rest), -1),
            t.section_shape.reshape(len(t.stiffness), -1, count),
        )
        return ShownSeries(
            coil,
            samples.at_rest_and_beyond(t.height, t.axial_shape) - installed,
            samples.rates(t, velocities, rates),
            *self._coil_pairs(samples.overlap),
            section_loads(loads.reshape(-1, 6, len(coil)).swapaxes(0, 1)),
            sample_energies(t, samples, now, states[:, 2 * count]),
        )

    def _coil_pairs(self, overlap: Array) -> tuple[Array, Array, Array]:
        """Coil numbers of the pairs, their gaps and elastic contact forces, from overlaps (n, p)."""
        upper_coil, pair_of = self._pairs
        if not len(upper_coil):
            return upper_coil, *np.zeros((2, len(overlap), 0))
        order = np.argsort(pair_of, kind="stable")[np.sum(pair_of < 0) :]
        first = np.searchsorted(pair_of[order], np.arange(len(upper_coil)))
        depth = overlap[:, order]
        pressed = self.tables.contact_stiffness[order] * np.maximum(depth, 0.0)
        return (
            upper_coil,
            -np.maximum.reduceat(depth, first, axis=1),
            np.add.reduceat(pressed, first, axis=1),
        )

    def stiffness(self, retainer_displacement: float) -> Array:
        """Stiffness (N/m) of the coordinates, of unit mass each, and of the retainer, which is last,
        about rest at a displacement (m); touching coils stay closed.
        """
        here, state = self._at(retainer_displacement), self.initial_state(retainer_displacement)
        apart, depth = self._apart(state, here)
        closed = self.tables.contact_stiffness * (depth > 0)
        slope, turns = here.rest_slope, here.gradient_slope
        by_travel = here.overlap_slope + turns @ apart - here.gradient @ slope
        inner = here.stiffness + (here.gradient.T * closed) @ here.gradient
        coupled = here.load_slope + here.stiffness_slope @ apart - here.stiffness @ slope
        coupled += (closed * by_travel) @ here.gradient + (closed * depth) @ turns
        tangent = self.tangent(state, retainer_displacement)
        return np.block([[inner, coupled[:, None]], [coupled[None], np.array([[tangent]])]])

    def surge_frequency(self, retainer_displacement: float) -> float:
        """Frequency (Hz) of the mode, both ends fixed, that takes most mass along with the retainer."""
        stiffness = self.stiffness(retainer_displacement)
        squares, modes = np.linalg.eigh(stiffness[:-1, :-1])
        carried = (stiffness[-1, :-1] @ modes / squares) ** 2
        return float(np.sqrt(squares[np.argmax(carried)]) / (2 * np.pi))

    def tangent(self, state: Array, retainer_displacement: float) -> float:
        if not self.pulls and self.force(state, retainer_displacement).retainer <= 0.0:
            return 0.0
        t, here = self.tables, self._at(retainer_displacement)
        apart, depth = self._apart(state, here)
        fine = min(max(int(np.floor(here.place)), 0), len(t.rest) - 2)
        slope, turns = here.rest_slope, here.gradient_slope
        by_travel = here.overlap_slope + turns @ apart - here.gradient @ slope
        stiffness = t.contact_stiffness * (depth > 0)
        grows = here.load_slope + here.stiffness_slope @ apart
        return float(
            (t.wire_force[fine + 1] - t.wire_force[fine]) / t.spacing
            - 2 * slope @ grows
            + slope @ here.stiffness @ slope
            + stiffness @ by_travel**2
            - 2 * (stiffness * depth) @ (turns @ slope)
        )

    def outputs(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> SpringOutputs:
        at = np.array([retainer_displacement]), np.array([retainer_velocity])
        return self.outputs_at(state[None], *at)[0]

    def outputs_at(
        self, states: Array, displacements: Array, velocities: Array
    ) -> list[SpringOutputs]:
        """See :class:`valvetrain.springs.contract.OutputsTogether`."""
        samples = samples_of(self.tables, states[:, : self.unknowns], displacements)
        forces = self._forces(states, samples, displacements, velocities).ends
        shown = self.shown_at(states, displacements, velocities)
        return [
            SpringOutputs(
                *(forces[n, 0], forces[n, 1], shown.coil_number, shown.axial_displacement[n]),
                *(shown.axial_velocity[n], shown.upper_coil, shown.coil_gap[n]),
                shown.coil_contact_force[n],
                {name: values[n] for name, values in shown.section_loads.items()},
            )
            for n in range(len(states))
        ]

    @cached_property
    def _installed(self) -> tuple[Array, Array]:
        """Coil numbers of the wire points, and their heights (m) as installed."""
        coil = wire_points(self.rod.definition.total_coils)
        return coil, interpolation(
            self.rod.mesh.coil_number, coil
        ) @ self.rod.installed.state.position[:, 2]

    def contact_watch(self) -> ContactWatch | None:
        """Force and stored energy of every coil pair, which the kernel leaves behind its scratch."""
        upper_coil = self._pairs[0]
        count = len(upper_coil)
        if not count:
            return None

        def read(
            record: Array, spacing: float, time_step: float
        ) -> tuple[Ints, Array, Array, Array]:
            touched = np.flatnonzero(np.max(record[:, :count], axis=0) > 0)
            force, energy = (
                np.ascontiguousarray(record[:, first + touched].T) for first in (0, count)
            )
            return touched, upper_coil[touched], force, energy

        first = kernels.pairs_place(self.tables.coordinates)
        stretches, period = np.array([[first, 2 * count]], dtype=np.int64), self.rod.first_period
        return ContactWatch(stretches, period, WATCH_SHARE * period, read)

    def retainer_mass(self) -> float:
        """That of the rod, and what the coordinates do not hold of the wire that follows (kg)."""
        return self.rod.retainer_mass() + self.tables.retainer_mass


def _why_not(rod: FiniteElementRod) -> str:
    """Why a rod cannot be reduced; empty where it can."""
    name = rod.definition.name
    if rod.dynamics.contact_law.kernel is not None:
        return f"spring '{name}' has a contact law of its own, which a reduced rod does not know; use finite-element or multi-mass"
    if rod.dynamics.ends is not None:
        return f"the ends of spring '{name}' lift, which those of a reduced rod do not; use finite-element"
    return ""


class ReducedRodOptions(SpringOptions):
    """Options of the reduced rod."""

    elements_per_coil: int = Field(
        default=24, ge=8, le=200, description="elements of the rod along one turn of the wire"
    )


def _make(
    spring: InstalledSpring, options: ReducedRodOptions, rest: SpringAtRest | None
) -> ReducedRod:
    # lifting ends are an option of the rod; here end forces stop at zero instead
    as_rod = spring.with_options(
        ROD.word, elements_per_coil=options.elements_per_coil, lifting_ends=False
    )
    rod = ROD.build(as_rod)
    assert isinstance(rod, FiniteElementRod)
    return ReducedRod(rod)


SPEC = SpringModelSpec(
    "reduced-rod",
    "reduced rod",
    "#2e7d5b",
    ReducedRodOptions,
    _make,
    shows=("sections", "clash", "stress"),
    wire_only="a reduced rod is made from the wire; use modal-uniform or wave-rod",
    processor_time=0.6,
    beside=("multi-mass",),
    knows="the wire of the rod over lift in some forty coordinates, all its contact points",
    leaves_out="accuracy in hard clash, walls of a guide met in motion, ends that lift",
)
