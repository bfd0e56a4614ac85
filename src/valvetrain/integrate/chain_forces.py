"""What resists the motion of a chain of masses, with its tangents: the same forces in the balance
of an implicit step and in print.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from valvetrain.arrays import Array
from valvetrain.coil_contact.law import LINEAR, contact_response
from valvetrain.springs import chain_statics
from valvetrain.springs.multi_mass import MultiMassSpring


@dataclass(frozen=True, slots=True, eq=False)
class Resistance:
    """Forces of one instant. ``inner`` (N,): resisting forces (N) of the inner nodes; ``stiffness``
    and ``damping`` (N, N): their tangents; ``ends``: force (N) on retainer and seat, compressive
    positive; ``overlap`` (m) of every contact and ``contact_damping``, what its force is beyond
    that of the overlap (N), both (p,); ``dampers`` (N + 2,): forces (N) of all dampers on all
    nodes; ``largest``: force (N) of the largest term that the balance is the difference of, a
    contact's force or spring rate times place of a node.
    """

    inner: Array
    stiffness: Array
    damping: Array
    ends: tuple[float, float]
    overlap: Array
    contact_damping: Array
    dampers: Array
    largest: float


@dataclass(frozen=True, eq=False)
class ChainForces:
    """Forces of ``model`` from places and velocities of all nodes, 0 = seat ... N + 1 = retainer."""

    model: MultiMassSpring

    @cached_property
    def rows(self) -> Array:
        """Gradient of the contact depths (p, N + 2)."""
        return chain_statics.contact_rows(self.model.layout)

    @cached_property
    def steps(self) -> Array:
        """Differences of neighbouring nodes (N + 1, N + 2)."""
        count = len(self.model.layout.coil_number)
        return np.diff(np.eye(count), axis=0)

    def __call__(self, nodes: Array, velocities: Array) -> Resistance:
        """All forces at places (m) and ``velocities`` (m/s) of the nodes."""
        model, layout = self.model, self.model.layout
        stretch, rate = np.diff(nodes), np.diff(velocities)
        carried = layout.stiffness * (stretch + model.stiffness_damping * rate)
        elastic, held = layout.stiffness * stretch, np.ones(len(stretch))
        if not model.pulls:
            for end in (0, -1):
                held[end], elastic[end] = (
                    float(stretch[end] > 0 and carried[end] > 0),
                    max(elastic[end], 0.0),
                )
        carried = held * carried
        stiffness, depth = layout.contacts.stiffness, chain_statics.contact_depths(layout, nodes)
        found = contact_response(
            layout.contacts.law,
            depth,
            self.rows @ velocities,
            model.contact_damping_time,
            early=True,
        )
        pushed = stiffness * found.force
        closed = pushed > 0
        beyond = pushed - stiffness * found.elastic
        total, slowed = (
            carried @ self.steps + pushed @ self.rows,
            model.mass_damping * layout.masses * velocities[1:-1],
        )
        dampers = (carried - elastic) @ self.steps + beyond @ self.rows
        dampers[1:-1] += slowed
        largest = (
            float(np.max(layout.stiffness * np.abs(nodes[1:]))),
            float(np.max(pushed, initial=0.0)),
        )
        tangents = self._tangents(
            held * layout.stiffness,
            closed,
            (stiffness * found.tangent)[closed],
            (stiffness * found.damping)[closed],
        )
        return Resistance(
            total[1:-1] + slowed,
            *tangents,
            (float(total[-1]), float(0.0 - total[0])),
            depth,
            beyond,
            dampers,
            max(largest),
        )

    def _tangents(
        self, held: Array, closed: NDArray[np.bool_], tangent: Array, viscous: Array
    ) -> tuple[Array, Array]:
        """Stiffness and damping matrices of the inner nodes: elements of rates ``held`` (N/m) and
        the ``closed`` contacts of these tangents (N/m) and damping coefficients (N s/m).
        """
        model, layout, inner = self.model, self.model.layout, slice(1, -1)
        steps, rows = self.steps[:, inner], self.rows[closed][:, inner]
        elements = steps.T @ (held[:, None] * steps)
        contacts = rows.T @ (tangent[:, None] * rows)
        damped = (
            model.contact_damping_time * contacts
            if layout.contacts.law == LINEAR
            else rows.T @ (viscous[:, None] * rows)
        )
        damping = model.stiffness_damping * elements + damped
        damping[np.diag_indices_from(damping)] += model.mass_damping * layout.masses
        return elements + contacts, damping
