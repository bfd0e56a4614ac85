"""Multi-mass spring: a chain of masses along the wire with unilateral clash between all
neighbouring coils.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from pydantic import Field

from valvetrain.arrays import Array, Ints
from valvetrain.coil_contact.law import (
    LINEAR,
    CoilContactLaw,
    contact_response,
    law_address,
    law_numbers,
    law_of,
)
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.spring_options import SpringOptions
from valvetrain.solution.static import SpringAtRest
from valvetrain.springs import chain_kernels, chain_statics
from valvetrain.springs.chain_layout import ChainLayout, chain_from_definition, uniform_chain
from valvetrain.springs.chain_statics import CONTACT_STIFFNESS
from valvetrain.springs.contract import (
    WATCH_SHARE,
    ContactWatch,
    EndForces,
    SpringEnergy,
    SpringOutputs,
)
from valvetrain.springs.spec import SpringModelSpec
from valvetrain.units import Given, keep_si, si

CONTACT_DAMPING_TIME = 1e-6


@dataclass(frozen=True, eq=False)
class MultiMassSpring:
    """Chain ``layout`` installed at ``precompression`` (m from the free state).

    ``mass_damping`` (1/s) acts on the absolute velocity, ``stiffness_damping`` (s) inside the
    elements, ``contact_damping_time`` (s)
    is damping over stiffness of a coil contact (never adhesive). Where it does not pull
    (``pulls``), an end element longer than free is
    open: the spring has left its seat or its retainer. Half the last element and the upper inactive
    coils move with the retainer.

    >>> import valvetrain as vt
    >>> problem = vt.system.build.build("job-t")
    >>> chain = problem.model_of("multi-mass", problem.springs[0])
    >>> isinstance(chain, MultiMassSpring)
    True
    """

    layout: ChainLayout
    precompression: float
    mass_damping: float = 0.0
    stiffness_damping: float = 0.0
    contact_damping_time: float = CONTACT_DAMPING_TIME
    name: str = "multi-mass"
    pulls: bool = True

    def __post_init__(self) -> None:
        keep_si(
            self,
            f"spring '{self.name}'",
            precompression="compression",
            mass_damping="damping rate",
            stiffness_damping="time",
            contact_damping_time="time",
        )
        for key in ("precompression", "mass_damping", "stiffness_damping", "contact_damping_time"):
            if not getattr(self, key) >= 0:
                raise InputError(
                    f"{key} of spring '{self.name}' is {getattr(self, key)}; give zero or a positive number"
                )

    @classmethod
    def from_definition(
        cls,
        spring: SpringDefinition,
        precompression: Given,
        *,
        masses_per_coil: int = 12,
        contact_stiffness: float = CONTACT_STIFFNESS,
        contact_law: CoilContactLaw = LINEAR,
        **options: Any,
    ) -> MultiMassSpring:
        """From the wire: ``masses_per_coil`` elements per turn; ``contact_stiffness`` in N/m per m
        of wire (0: coils pass through).
        """
        if masses_per_coil < 1 or masses_per_coil != int(masses_per_coil):
            raise InputError(
                f"masses_per_coil of spring '{spring.name}' is {masses_per_coil}; give a whole number, 12 is typical"
            )
        compression = si(precompression, "compression", f"precompression of spring '{spring.name}'")
        if contact_stiffness > 0:
            spring.refuse_solid(compression)
        first, last = spring.free_coils
        layout = chain_from_definition(
            spring, max(2, round((last - first) * masses_per_coil)), contact_stiffness, contact_law
        )
        return cls(layout, compression, **options)

    @classmethod
    def from_card(
        cls,
        rate: Given,
        preload: Given,
        mass: Given,
        *,
        elements: int = 5,
        inactive_mass: float = 0.0,
        **options: Any,
    ) -> MultiMassSpring:
        """From rate (N/m), preload (N) and mass (kg): uniform, without coil gaps (a card does not
        give them).

        Five elements are the published chain of 6 masses, one of them fixed and one moving with the
        valve.
        """
        rate, preload, mass = (
            si(rate, "spring_rate", "rate"),
            si(preload, "force", "preload"),
            si(mass, "mass", "mass"),
        )
        if not preload >= 0:
            raise InputError(
                f"preload of the spring card is {preload} N; give zero or a positive force"
            )
        return cls(uniform_chain(rate, mass, elements, inactive_mass), preload / rate, **options)

    @property
    def unknowns(self) -> int:
        return len(self.layout.masses)

    @property
    def kernel(self) -> Any:
        return chain_kernels.advance_chain

    @cached_property
    def _parameters(self) -> Array:
        c = self.layout.contacts
        head = [
            self.precompression,
            self.mass_damping,
            self.stiffness_damping,
            self.contact_damping_time,
        ]
        masses, weights = self.layout.masses, c.spans()[1]
        return np.concatenate(
            (
                head,
                self.layout.stiffness,
                masses,
                1 / masses,
                c.gap,
                c.stiffness,
                c.fraction,
                weights,
                law_numbers(c.law),
            )
        )

    def parameters(self) -> Array:
        return self._parameters.copy()

    def integers(self) -> Ints:
        c = self.layout.contacts
        head = [self.unknowns, c.count, c.regular(self.unknowns), c.ends, int(self.pulls)]
        law = np.array([law_address(c.law)], dtype=np.int64)
        return np.concatenate((head, c.upper, c.lower, c.spans()[0], law)).astype(np.int64)

    def with_time_step(self, time_step: float) -> MultiMassSpring:
        return self

    def initial_state(self, retainer_displacement: float) -> Array:
        state = np.zeros(chain_kernels.state_size(self.unknowns, self.layout.contacts.count))
        state[: self.unknowns] = self._at_rest(retainer_displacement)[1:-1]
        return state

    def _at_rest(self, retainer_displacement: float) -> Array:
        """Nodes at rest; a spring that cannot pull is free above its free length."""
        compression = self.precompression + retainer_displacement
        if self.pulls or compression >= 0:
            return chain_statics.solve_static(self.layout, compression)
        return np.append(np.zeros(self.unknowns + 1), compression)

    @cached_property
    def _time_step(self) -> float:
        root = 1 / np.sqrt(self.layout.masses)
        elements = chain_statics.element_matrix(self.layout)[1:-1, 1:-1]
        contacts = self.layout.contacts
        steepest = np.full(contacts.count, contacts.law.steepest)
        closed = chain_statics.stiffness_matrix(self.layout, steepest)[1:-1, 1:-1]
        damped = self.stiffness_damping * elements + self.contact_damping_time * (closed - elements)
        stiff, lossy = (
            float(np.linalg.eigvalsh(root[:, None] * m * root)[-1]) for m in (closed, damped)
        )
        # Damping works on predicted velocities, so the two limits are separate: h^2 K < 4 and h C <
        # 2 (mass-scaled).
        return float(min(2 / np.sqrt(stiff), 2 / lossy if lossy > 0 else np.inf))

    def stable_time_step(self) -> float:
        return self._time_step

    def frequencies(self, retainer_displacement: float, count: int = 3) -> Array:
        """First ``count`` natural frequencies (Hz), both ends fixed, about the static state;
        touching coils stay closed.
        """
        compression = self.precompression + retainer_displacement
        return chain_statics.frequencies(self.layout, compression, count)

    @cached_property
    def first_period(self) -> float:
        """First natural period (s) as installed, both ends fixed."""
        return 1 / float(self.frequencies(0.0, 1)[0])

    @cached_property
    def _contact_rows(self) -> Array:
        return chain_statics.contact_rows(self.layout)

    def _nodes(self, state: Array, retainer_displacement: float) -> Array:
        return np.concatenate(
            ([0.0], state[: self.unknowns], [self.precompression + retainer_displacement])
        )

    def _velocities(self, state: Array, retainer_velocity: float) -> Array:
        return np.concatenate(
            ([0.0], state[self.unknowns : 2 * self.unknowns], [retainer_velocity])
        )

    def _node_forces(self, nodes: Array, velocities: Array) -> tuple[Array, Array]:
        """Force on every node (N, towards the seat) and force of every contact; of nodes at n instants
        (N + 1, n) as many columns.
        """
        layout, stretch = self.layout, np.diff(nodes, axis=0)
        rate = self.stiffness_damping * np.diff(velocities, axis=0)
        push = (layout.stiffness * (stretch + rate).T).T
        rows, depth = self._contact_rows, chain_statics.contact_depths(layout, nodes)
        found = contact_response(
            layout.contacts.law, depth, rows @ velocities, self.contact_damping_time
        )
        contact = (layout.contacts.stiffness * found.force.T).T
        if not self.pulls:
            for end in (0, -1):
                push[end] = np.where(stretch[end] > 0, np.maximum(push[end], 0.0), 0.0)
        none = np.zeros_like(push[:1])
        along = np.concatenate((push, none)) - np.concatenate((none, push))
        return along - (contact.T @ rows).T, contact

    def energy(
        self,
        state: Array,
        retainer_displacement: float,
        retainer_velocity: float = 0.0,
        time_step: float = 0.0,
    ) -> SpringEnergy:
        """Elastic energy counted from the free state; the end masses belong to the valve."""
        nodes, velocities = (
            self._nodes(state, retainer_displacement),
            self._velocities(state, retainer_velocity),
        )
        speed = velocities[1:-1]
        if time_step > 0:
            kick = (
                self._node_forces(nodes, velocities)[0][1:-1] / self.layout.masses
                - self.mass_damping * speed
            )
            speed = speed + time_step / 2 * kick
        elastic, contact = chain_statics.potential(self.layout, nodes)
        if not self.pulls:
            elastic -= sum(
                self.layout.stiffness[end] * min(np.diff(nodes)[end], 0.0) ** 2 / 2
                for end in (0, -1)
            )
        return SpringEnergy(
            float(self.layout.masses @ speed**2 / 2),
            elastic,
            contact,
            float(state[2 * self.unknowns]),
        )

    def force(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> EndForces:
        forces, _ = self._node_forces(
            self._nodes(state, retainer_displacement), self._velocities(state, retainer_velocity)
        )
        return EndForces(float(-forces[-1]), float(forces[0]))

    def tangent(self, state: Array, retainer_displacement: float) -> float:
        if (
            not self.pulls
            and self.precompression + retainer_displacement <= state[self.unknowns - 1]
        ):
            return replace(self, pulls=True).tangent(state, retainer_displacement) - float(
                self.layout.stiffness[-1]
            )
        nodes = self._nodes(state, retainer_displacement)
        tangent = chain_statics.contact_responses(self.layout, nodes).tangent
        last = self._contact_rows[:, -1]
        return float(self.layout.stiffness[-1] + self.layout.contacts.stiffness * tangent @ last**2)

    @cached_property
    def _installed(self) -> Array:
        return chain_statics.solve_static(self.layout, self.precompression)

    def outputs(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> SpringOutputs:
        nodes, velocities = (
            self._nodes(state, retainer_displacement),
            self._velocities(state, retainer_velocity),
        )
        forces, contact = self._node_forces(nodes, velocities)
        depths = chain_statics.contact_depths(self.layout, nodes)
        return self._shown(nodes, velocities, forces, depths, contact)

    def outputs_at(
        self, states: Array, displacements: Array, velocities: Array
    ) -> list[SpringOutputs]:
        """See :class:`valvetrain.springs.contract.OutputsTogether`."""
        seat, inner = np.zeros((1, len(states))), states[:, : 2 * self.unknowns].T
        positions, speeds = inner[: self.unknowns], inner[self.unknowns :]
        nodes = np.concatenate((seat, positions, [self.precompression + displacements]))
        moving = np.concatenate((seat, speeds, [velocities]))
        forces, contact = self._node_forces(nodes, moving)
        depths = chain_statics.contact_depths(self.layout, nodes)
        every = (np.ascontiguousarray(one.T) for one in (nodes, moving, forces, depths, contact))
        return [self._shown(*rows) for rows in zip(*every, strict=True)]

    def _shown(
        self, nodes: Array, velocities: Array, forces: Array, depths: Array, contact: Array
    ) -> SpringOutputs:
        return SpringOutputs(
            float(-forces[-1]),
            float(forces[0]),
            self.layout.coil_number,
            self._installed - nodes,
            -velocities,
            self.layout.contacts.upper_coil,
            -depths,
            contact,
        )

    def contact_watch(self) -> ContactWatch | None:
        """Overlap and damping impulse of every contact, which the kernel leaves behind the
        positions and velocities.
        """
        contacts = self.layout.contacts
        if not contacts.count:
            return None
        order = np.argsort(contacts.upper_coil, kind="stable")
        stiffness = contacts.stiffness[order]

        def read(
            record: Array, spacing: float, time_step: float
        ) -> tuple[Ints, Array, Array, Array]:
            touched = np.flatnonzero(np.max(record[:, : contacts.count], axis=0)[order] > 0)
            chosen, pushed = order[touched], stiffness[touched, None]
            overlap, impulse = (
                np.ascontiguousarray(record[:, first + chosen].T) for first in (0, contacts.count)
            )
            found = contact_response(contacts.law, overlap, stiffness=pushed)
            force = found.elastic + np.where(overlap > 0, impulse / time_step, 0.0)
            return touched, contacts.upper_coil[chosen], force, found.energy

        first = chain_kernels.overlap_place(self.unknowns)
        stretches = np.array([[first, 2 * contacts.count]], dtype=np.int64)
        return ContactWatch(stretches, self.first_period, WATCH_SHARE * self.first_period, read)

    def retainer_mass(self) -> float:
        """Half the last element plus the wire of the upper inactive coils (kg)."""
        return self.layout.retainer_mass


class MultiMassOptions(SpringOptions):
    """Options of the chain of masses."""

    wire_only: ClassVar[tuple[str, ...]] = ("masses_per_coil", "from_rod")
    card_only: ClassVar[tuple[str, ...]] = ("elements",)
    masses_per_coil: int = Field(
        default=12, ge=1, le=2000, description="masses along one turn of the wire"
    )
    from_rod: bool = Field(
        default=True,
        description="force at mid travel and first surge frequency of a wire taken from its rod; without it by formula",
    )
    elements: int = Field(
        default=5, ge=1, le=2000, description="elements of the chain made from a card"
    )


def _make(
    spring: InstalledSpring, options: MultiMassOptions, rest: SpringAtRest | None
) -> MultiMassSpring:
    damping: dict[str, Any] = {
        "mass_damping": spring.damping.mass_damping, "stiffness_damping": spring.damping.stiffness_damping,
        "contact_damping_time": spring.contact.damping_time, "pulls": spring.pulls,
    }  # fmt: skip
    if spring.card is not None:
        card = spring.card
        assert card.mass is not None
        return MultiMassSpring.from_card(
            card.rate, card.preload, card.mass, elements=options.elements, **damping
        )
    assert spring.wire is not None
    chain = MultiMassSpring.from_definition(
        spring.wire,
        spring.precompression,
        masses_per_coil=options.masses_per_coil,
        contact_stiffness=spring.contact.stiffness,
        contact_law=law_of(spring.contact),
        **damping,
    )
    if not options.from_rod:
        return chain
    from valvetrain.springs.chain_from_rod import match  # it corrects this class

    chain = match(chain, spring).chain
    assert isinstance(chain, MultiMassSpring)
    return chain


SPEC = SpringModelSpec(
    "multi-mass",
    "multi-mass chain",
    "#7a4fa0",
    MultiMassOptions,
    _make,
    shows=("sections", "clash"),
    processor_time=0.5,
    beside=("wave-rod-clash",),
    knows="chain along the wire, clash between all coils from the real gaps",
    leaves_out="lateral and torsional motion",
    citation="vasilyev2016",
)
