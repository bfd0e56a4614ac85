"""End coils that lift: the inactive wire at either end as a rigid body that moves along the axis on
its own seat, pressed by the law of contact of the coils and never pulled.

An end coil keeps its place across the axis and does not turn. Its seat is where it carries the
force of the state that a run starts from, so that a spring at rest is the same as with bonded ends.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array
from valvetrain.coil_contact.law import CoilContactLaw, contact_response
from valvetrain.cosserat.mesh import RodMesh

#: Stiffness of a seat (N/m per m of wire) where coils pass through each other.
SEAT_STIFFNESS = 2e10


@dataclass(frozen=True, slots=True)
class EndCoils:
    """``mass`` (kg) and ``length`` (m) of the inactive wire at seat and retainer."""

    mass: tuple[float, float] = (0.0, 0.0)
    length: tuple[float, float] = (0.0, 0.0)

    def masses(self, mesh: RodMesh) -> Array:
        """Masses (2,) kg of the bodies that lift: the inactive wire and half an element."""
        return np.array(self.mass) + mesh.node_mass[[mesh.first, mesh.last]]

    def stiffnesses(self, mesh: RodMesh, contact_stiffness: float) -> Array:
        """Stiffness (2,) N/m of their contact with seat and retainer."""
        lengths = np.array(self.length) + mesh.node_length[[mesh.first, mesh.last]]
        return (contact_stiffness or SEAT_STIFFNESS) * lengths


def overlap_of(law: CoilContactLaw, force: float, stiffness: float) -> float:
    """Overlap (m) at which a contact carries ``force`` (N) at rest; zero where it would pull."""
    depth = max(force, 0.0) / stiffness
    for _ in range(50 if depth > 0 else 0):
        found = contact_response(law, depth, stiffness=stiffness)
        depth -= (float(found.elastic) - force) / float(found.tangent)
    return depth
