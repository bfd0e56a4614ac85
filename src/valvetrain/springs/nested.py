"""Two springs one inside the other as one model, with optional rubbing between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from valvetrain.arrays import Array, Ints
from valvetrain.errors import InputError
from valvetrain.springs.chain_layout import ChainLayout
from valvetrain.springs.contract import (
    ContactWatch,
    EndForces,
    Kernel,
    SpringEnergy,
    SpringModel,
    SpringOutputs,
    contact_watch_of,
)
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.nested_kernels import nested_kernel
from valvetrain.springs.wave_rod import WaveRod
from valvetrain.springs.wave_rod_clash import WaveRodWithClash

#: Sections of the inner spring that rub, however fine its model is.
RUBBING_SECTIONS = 24


@dataclass(frozen=True, slots=True)
class RadialRubbing:
    """Coulomb friction of two interfering springs: ``normal_force`` (N) in all, spread evenly over
    the active length.

    Each section pair at the same share of the active length feels at most ``coefficient`` times its
    part of the normal force,
    against its axial slip; it sticks below that. The normal force is an input (such as a damper
    spring's press fit): radial
    motion of the coils is not modelled.
    """

    coefficient: float
    normal_force: float

    def __post_init__(self) -> None:
        for key in ("coefficient", "normal_force"):
            if not (np.isfinite(getattr(self, key)) and getattr(self, key) >= 0):
                raise InputError(
                    f"{key} of the rubbing of nested springs is {getattr(self, key)}; give zero or a positive number"
                )


@dataclass(frozen=True, eq=False)
class NestedSprings:
    """``outer`` and ``inner`` side by side between the same seat and retainer: forces, energies and
    masses on the retainer add.

    ``rubbing`` needs both members to be multi-mass or rod models. Raises :class:`InputError`
    otherwise.

    >>> import valvetrain as vt
    >>> pair = NestedSprings(vt.springs.MasslessSpring(30e3, 250.0), vt.springs.MasslessSpring(10e3, 80.0))
    >>> round(pair.force(pair.initial_state(10e-3), 10e-3, 0.0).retainer)
    730
    """

    outer: SpringModel
    inner: SpringModel
    rubbing: RadialRubbing | None = None
    name: str = "nested"

    def __post_init__(self) -> None:
        if self.rubbing is not None and any(
            _sections(member) is None for member in (self.outer, self.inner)
        ):
            raise InputError(
                "rubbing of nested springs needs sections that move: choose multi-mass or wave-rod for both, or leave rubbing out"
            )

    @property
    def members(self) -> tuple[SpringModel, SpringModel]:
        """Outer and inner spring."""
        return self.outer, self.inner

    @property
    def unknowns(self) -> int:
        return self.outer.unknowns + self.inner.unknowns

    @property
    def kernel(self) -> Kernel:
        kernel: Kernel = nested_kernel(self.outer.kernel, self.inner.kernel)
        return kernel

    @cached_property
    def _pairs(self) -> tuple[Ints, Array]:
        """Section numbers (s, 2) and inverse masses (s, 2) of the pairs that rub."""
        if self.rubbing is None:
            return np.zeros((0, 2), np.int64), np.zeros((0, 2))
        (outer_share, outer_mass), (inner_share, inner_mass) = (
            _sections(self.outer),  # type: ignore[misc]
            _sections(self.inner),  # type: ignore[misc]
        )
        count = min(RUBBING_SECTIONS, len(inner_share))
        inner = np.unique(np.round(np.linspace(0, len(inner_share) - 1, count)).astype(np.int64))
        outer = np.argmin(np.abs(outer_share[None, :] - inner_share[inner, None]), axis=1)
        return np.column_stack((outer, inner)), np.column_stack(
            (1 / outer_mass[outer], 1 / inner_mass[inner])
        )

    def parameters(self) -> Array:
        pairs, inverse = self._pairs
        limit = 0.0
        if self.rubbing is not None:
            limit = self.rubbing.coefficient * self.rubbing.normal_force / len(pairs)
        return np.concatenate(
            ([limit], self.outer.parameters(), self.inner.parameters(), inverse.ravel())
        )

    @cached_property
    def _outer_size(self) -> int:
        return len(self.outer.initial_state(0.0))

    def integers(self) -> Ints:
        pairs, _ = self._pairs
        outer, inner = self.outer.integers(), self.inner.integers()
        values = [len(member.parameters()) for member in self.members]
        head = [
            self.outer.unknowns,
            self.inner.unknowns,
            *values,
            len(outer),
            len(inner),
            len(pairs),
            self._outer_size,
        ]
        return np.concatenate((head, pairs.ravel(), outer, inner)).astype(np.int64)

    def with_time_step(self, time_step: float) -> NestedSprings:
        return replace(
            self,
            outer=self.outer.with_time_step(time_step),
            inner=self.inner.with_time_step(time_step),
        )

    def initial_state(self, retainer_displacement: float) -> Array:
        return self.joined([member.initial_state(retainer_displacement) for member in self.members])

    def joined(self, buffers: Sequence[Array]) -> Array:
        """The state of the pair from those of its members, outer first; what rubbing dissipated
        counts from zero.
        """
        pairs = list(zip(buffers, self.members, strict=True))
        positions = [buffer[: member.unknowns] for buffer, member in pairs]
        velocities = [buffer[member.unknowns : 2 * member.unknowns] for buffer, member in pairs]
        return np.concatenate((*positions, *velocities, np.zeros(1), *buffers))

    def split(self, state: Array) -> tuple[Array, Array]:
        """Copies of the members' buffers with the current positions and velocities."""
        n, m = self.outer.unknowns, self.inner.unknowns
        start = 2 * (n + m) + 1
        outer, inner = (
            state[start : start + self._outer_size].copy(),
            state[start + self._outer_size :].copy(),
        )
        outer[:n], outer[n : 2 * n] = state[:n], state[n + m : 2 * n + m]
        inner[:m], inner[m : 2 * m] = state[n : n + m], state[2 * n + m : 2 * (n + m)]
        return outer, inner

    def stable_time_step(self) -> float:
        return min(member.stable_time_step() for member in self.members)

    def energy(
        self,
        state: Array,
        retainer_displacement: float,
        retainer_velocity: float = 0.0,
        time_step: float = 0.0,
    ) -> SpringEnergy:
        parts = [
            member.energy(own, retainer_displacement, retainer_velocity, time_step)
            for member, own in zip(self.members, self.split(state), strict=True)
        ]
        kinetic, elastic, contact, dissipated = (sum(column) for column in zip(*parts, strict=True))
        return SpringEnergy(kinetic, elastic, contact, dissipated + float(state[2 * self.unknowns]))

    def force(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> EndForces:
        outer, inner = self.split(state)
        first = self.outer.force(outer, retainer_displacement, retainer_velocity)
        second = self.inner.force(inner, retainer_displacement, retainer_velocity)
        return EndForces(first.retainer + second.retainer, first.seat + second.seat)

    def tangent(self, state: Array, retainer_displacement: float) -> float:
        return sum(
            member.tangent(own, retainer_displacement)
            for member, own in zip(self.members, self.split(state), strict=True)
        )

    def outputs(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> SpringOutputs:
        """Sections of the outer spring with the forces of both; :meth:`member_outputs` gives each
        alone.
        """
        outer, _ = self.member_outputs(state, retainer_displacement, retainer_velocity)
        both = self.force(state, retainer_displacement, retainer_velocity)
        return replace(outer, retainer_force=both.retainer, seat_force=both.seat)

    def member_outputs(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> tuple[SpringOutputs, SpringOutputs]:
        """Outputs of the outer and of the inner spring."""
        outer, inner = self.split(state)
        return (
            self.outer.outputs(outer, retainer_displacement, retainer_velocity),
            self.inner.outputs(inner, retainer_displacement, retainer_velocity),
        )

    def contact_watch(self) -> ContactWatch | None:
        """That of the outer spring, whose sections represent the pair."""
        outer = contact_watch_of(self.outer)
        return (
            None
            if outer is None
            else replace(outer, stretches=outer.stretches + np.array([2 * self.unknowns + 1, 0]))
        )

    def retainer_mass(self) -> float:
        """Sum of both members' masses on the retainer (kg)."""
        return self.outer.retainer_mass() + self.inner.retainer_mass()


def _sections(model: SpringModel) -> tuple[Array, Array] | None:
    """Share 0..1 of the active length and mass (kg) of every inner section, or None where a model
    has no sections.
    """
    if isinstance(model, WaveRod):
        return np.arange(1, model.cells) / model.cells, np.full(model.cells - 1, model.cell_mass)
    layout: ChainLayout | None = None
    if isinstance(model, MultiMassSpring):
        layout = model.layout
    elif isinstance(model, WaveRodWithClash):
        layout = model.chain.layout
    if layout is None:
        return None
    flow = np.cumsum(1 / layout.stiffness)
    return flow[:-1] / flow[-1], layout.masses


def carried_state(
    state: Array,
    spring: SpringModel,
    other: SpringModel,
    retainer_displacement: float,
    retainer_velocity: float,
) -> Array:
    """The ``state`` of ``spring`` as a state of ``other``, the same spring by ``with_time_step``
    for another step.

    Where both have the same unknowns it is copied, bookkeeping included. Else (a rod whose cells
    follow the step) the departure from rest
    at ``retainer_displacement`` (m) and the velocities, zero at the seat and ``retainer_velocity``
    (m/s) above, are interpolated
    along evenly spaced unknowns; bookkeeping starts again.
    """
    if isinstance(spring, NestedSprings) and isinstance(other, NestedSprings):
        pairs = zip(spring.split(state), spring.members, other.members, strict=True)
        return other.joined(
            [
                carried_state(part, one, new, retainer_displacement, retainer_velocity)
                for part, one, new in pairs
            ]
        )
    if spring.unknowns == other.unknowns:
        return state.copy()
    n, m = spring.unknowns, other.unknowns
    found = np.asarray(other.initial_state(retainer_displacement), dtype=float).copy()
    departure = state[:n] - np.asarray(spring.initial_state(retainer_displacement))[:n]
    found[:m] += _on_grid(np.concatenate(([0.0], departure, [0.0])), m)
    found[m : 2 * m] = _on_grid(np.concatenate(([0.0], state[n : 2 * n], [retainer_velocity])), m)
    return found


def _on_grid(values: Array, count: int) -> Array:
    """``values`` on an even grid, ends included, at the ``count`` inner places of another."""
    return np.interp(
        np.arange(1, count + 1) / (count + 1), np.linspace(0.0, 1.0, len(values)), values
    )
