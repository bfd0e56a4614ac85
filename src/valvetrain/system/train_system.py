"""A train assembled from a mechanism, its springs and its loads: frozen, flat arrays, no verbs of
running or plotting.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, NamedTuple, Protocol, runtime_checkable

import numpy as np

from valvetrain.arrays import Array, Ints
from valvetrain.contact.kernels import OWN_LAW, WIDTH
from valvetrain.contact.law import LawKernel, OwnLaw
from valvetrain.errors import InputError
from valvetrain.mechanism.gap_kinds import COORDINATES_PER_INTERACTION
from valvetrain.mechanism.parts import AssembledMechanism, WithDifferentialMemory
from valvetrain.parameters.train_parts import CrankParameters
from valvetrain.springs.contract import LargeSpring, SpringModel
from valvetrain.system.contract import TRAIN
from valvetrain.system.prescribed import names_of

Integers = Ints


@runtime_checkable
class WithStaticCurve(Protocol):
    """A spring that finds many states of rest faster together than one by one."""

    def static_forces(self, retainer_displacements: Array) -> Array:
        """Retainer force (N) at each displacement (m)."""
        ...


class TrainArrays(NamedTuple):
    """What the compiled loop reads; shapes: n interactions, N coordinates, m tables.

    ``kinds``, ``table_of``, ``laws`` (n,); ``coordinate_of`` (n, 4), -1 for none; ``geometry`` (n,
    16); ``law_parameters`` (n, 8); ``memory_of`` (n + 1,): where the memory of each interaction
    begins in the flat array of all, the last entry being its length; ``friction`` (n, 2)
    coefficient and slip rate (m/s); ``tables`` (m, nodes, 3); ``body`` (N, 5) mass, constant force,
    guide damping, friction, friction velocity; ``gas`` (1, nodes, 3) N over cam angle.
    """

    kinds: Integers
    coordinate_of: Integers
    table_of: Integers
    laws: Integers
    geometry: Array
    law_parameters: Array
    memory_of: Integers
    friction: Array
    tables: Array
    body: Array
    gas: Array
    gas_coordinate: int
    retainer: int


@dataclass(frozen=True)
class TrainSystem:
    """Equations of motion of one train: M a = constant + gas - sum(gap gradient * law force) -
    spring force.

    ``springs``: none, one or two spring models (outer, inner) between the cylinder head and the
    retainer. ``gas``: (nodes, 3) table of the force (N, opening positive) on the valve over the cam
    angle, or None. ``crank``: slider that the valve must clear.
    """

    kind: ClassVar[str] = TRAIN

    mechanism: AssembledMechanism
    springs: tuple[SpringModel, ...] = ()
    gas: Array | None = None
    name: str = ""
    crank: CrankParameters | None = None

    def __post_init__(self) -> None:
        if len(self.springs) > 2:
            raise InputError(
                f"a valve carries at most two springs (outer, inner); {len(self.springs)} are given"
            )

    @property
    def has_large_springs(self) -> bool:
        """Whether only samples and repeats of a spring are saved, for its number of states: a rod or a solid."""
        return any(isinstance(spring, LargeSpring) for spring in self.springs)

    @property
    def spring_names(self) -> tuple[str, ...]:
        return names_of(self.springs)

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """Names of the coordinates, in the order of ``q``."""
        return tuple(coordinate.name for coordinate in self.mechanism.coordinates)

    @property
    def interaction_names(self) -> tuple[str, ...]:
        """Codes of the interactions (``valve_tip``), in the order of the forces."""
        return tuple(one.name.replace(" ", "_") for one in self.mechanism.interactions)

    @property
    def spring_mass(self) -> float:
        """Mass (kg) of the springs that moves with the retainer."""
        return float(sum(spring.retainer_mass() for spring in self.springs))

    @cached_property
    def arrays(self) -> TrainArrays:
        """Flat arrays of the compiled loop."""
        return _assemble(self)

    @cached_property
    def law_kernels(self) -> tuple[LawKernel, ...]:
        """Kernels of the contact laws that bring their own, each once, in the order of their codes
        from ``OWN_LAW`` on.
        """
        found: list[LawKernel] = []
        for interaction in self.mechanism.interactions:
            law = interaction.law
            if law.code == OWN_LAW and isinstance(law, OwnLaw) and law.kernel not in found:
                found.append(law.kernel)
        return tuple(found)

    @cached_property
    def _remembering(self) -> tuple[tuple[int, WithDifferentialMemory], ...]:
        """Laws whose memory belongs to the motion, with the first place of each."""
        pairs = zip(self.arrays.memory_of.tolist(), self.mechanism.interactions, strict=False)
        return tuple(
            (first, one.law) for first, one in pairs if isinstance(one.law, WithDifferentialMemory)
        )

    def differential_memory(self, displacement: float) -> tuple[Integers, Array]:
        """Places in the flat memory of the laws that belong to the motion, and their sizes in a
        motion of ``displacement`` (m).
        """
        places, scales = [np.zeros(0, dtype=np.int64)], [np.zeros(0)]
        for first, law in self._remembering:
            places.append(np.arange(first, first + law.states))
            scales.append(law.memory_scale(displacement))
        return np.concatenate(places), np.concatenate(scales)

    @property
    def masses(self) -> Array:
        """Mass (kg) or inertia (kg m2) per coordinate, the spring's share included, shape (N,)."""
        return self.arrays.body[:, 0]

    def with_springs(self, springs: Sequence[SpringModel]) -> TrainSystem:
        """The same train on other springs; itself where they are the same."""
        if len(springs) == len(self.springs) and all(
            new is old for new, old in zip(springs, self.springs, strict=True)
        ):
            return self
        return replace(self, springs=tuple(springs))

    def spring_force(self, displacement: float) -> float:
        """Static force (N) of all springs at a retainer displacement (m)."""
        return float(
            sum(s.force(s.initial_state(displacement), displacement).retainer for s in self.springs)
        )

    def spring_forces(self, displacements: Array) -> Array:
        """Static force (N) of all springs at retainer displacements (n,) in m, shape (n,)."""
        total = np.zeros(len(displacements))
        for spring in self.springs:
            if isinstance(spring, WithStaticCurve):
                total += spring.static_forces(displacements)
            else:
                total += [
                    spring.force(spring.initial_state(value), value).retainer
                    for value in displacements.tolist()
                ]
        return total


def _assemble(system: TrainSystem) -> TrainArrays:
    mechanism = system.mechanism
    count, total = len(mechanism.interactions), len(mechanism.coordinates)
    table_names = list(mechanism.tables)
    tables = (
        np.stack([mechanism.tables[name] for name in table_names])
        if table_names
        else np.zeros((1, 4, 3))
    )
    kinds, table_of, laws = (np.zeros(count, dtype=np.int64) for _ in range(3))
    index = np.full((count, COORDINATES_PER_INTERACTION), -1, dtype=np.int64)
    geometry = np.stack([interaction.geometry_row() for interaction in mechanism.interactions])
    law_parameters, friction = np.zeros((count, WIDTH)), np.zeros((count, 2))
    memory_of = np.cumsum(
        [0, *(interaction.law.states for interaction in mechanism.interactions)], dtype=np.int64
    )
    for k, interaction in enumerate(mechanism.interactions):
        kinds[k] = interaction.kind
        table_of[k] = table_names.index(interaction.table) if interaction.table else 0
        values = interaction.law.parameters()
        laws[k], law_parameters[k, : len(values)] = interaction.law.code, values
        if laws[k] == OWN_LAW and isinstance(interaction.law, OwnLaw):
            laws[k] += system.law_kernels.index(interaction.law.kernel)
        if interaction.friction is not None:
            friction[k] = interaction.friction.coefficient, interaction.friction.slip_rate
        for slot, name in enumerate(interaction.coordinates):
            index[k, slot] = mechanism.index(name) if name else -1
    body = np.zeros((total, 5))
    for i, part in enumerate(mechanism.coordinates):
        body[i] = part.mass, part.force, part.damping, part.friction, part.friction_velocity
    body[mechanism.index(mechanism.retainer), 0] += system.spring_mass
    gas = (
        np.zeros((1, 4, 3))
        if system.gas is None
        else np.ascontiguousarray(system.gas, dtype=float)[None]
    )
    return TrainArrays(
        kinds,
        index,
        table_of,
        laws,
        geometry,
        law_parameters,
        memory_of,
        friction,
        np.ascontiguousarray(tables, dtype=float),
        body,
        gas,
        -1 if system.gas is None else mechanism.index(mechanism.valve),
        mechanism.index(mechanism.retainer),
    )
