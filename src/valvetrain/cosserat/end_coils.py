"""End coils that lift: the inactive wire at either end as a rigid body that moves along the axis on
its own seat, pressed by the law of contact of the coils and never pulled.

An end coil keeps its place across the axis and does not turn. Its seat stands where it carries the
force of the state that a run starts from, so that a spring at rest is the same as with bonded ends.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.coil_contact.kernels import LINEAR, linear_contact, own_contact
from valvetrain.coil_contact.law import CoilContactLaw, contact_response
from valvetrain.compiled import njit
from valvetrain.cosserat.layout import ROW
from valvetrain.cosserat.mesh import RodMesh

Array = NDArray[np.float64]
Z, VZ, FZ, CZ, END = (ROW[n] for n in ("Z", "VZ", "FZ", "CZ", "END"))
#: Of the row ``END``: mass, stiffness and height of the seat of both ends, the force on it, closing
#: speed of the retainer; height and mass are those of the retainer in the second half.
MASS, STIFFNESS, SEAT, FORCE, LOSS, RATE = (np.uint64(n) for n in (0, 2, 4, 6, 8, 10))
ENTRIES, ONE = 11, np.uint64(1)
#: Stiffness of a seat (N/m per m of wire) where coils pass through each other.
SEAT_STIFFNESS = 2e10
OPTIONS: dict[str, Any] = {
    "cache": True, "nogil": True, "error_model": "numpy", "_nrt": False, "forceinline": True,
}  # fmt: skip


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


@njit(**OPTIONS)
def end_contacts(b, first, last, displacement, damping_time, dt, law, row):
    """Force (N) of retainer and seat on their end coils at a ``displacement`` (m) of the retainer."""
    for end in range(2):
        e = END + np.uint64(end)
        if end == 0:
            depth, closing = b[e + SEAT] - b[Z + first], -b[VZ + first]
        else:
            depth = b[Z + last] - (b[e + SEAT] - displacement)
            closing = b[VZ + last] + b[END + RATE]
        force, elastic = 0.0, 0.0
        if depth > 0.0:
            if law == LINEAR:
                force, elastic = linear_contact(
                    law, row, b[e + STIFFNESS], damping_time, depth, closing
                )
            else:
                force, elastic = own_contact(
                    law, row, b[e + STIFFNESS], damping_time, depth, closing
                )
        b[e + FORCE] = force
        b[e + LOSS] = dt * (force - elastic) * closing
    return b[END + FORCE + ONE], b[END + FORCE]


@njit(**OPTIONS)
def move_end_coils(b, first, last, vertices, dt):
    """Advance both end coils by the forces of this step; returns the energy (J) that their seats
    took.
    """
    low = b[FZ + first + ONE] + b[END + FORCE]
    for i in range(np.uint64(0), first + ONE):
        low += b[CZ + i]
    high = -b[FZ + last] - b[END + FORCE + ONE]
    for i in range(last, vertices):
        high += b[CZ + i]
    low = b[VZ + first] + dt * low / b[END + MASS]
    high = b[VZ + last] + dt * high / b[END + MASS + ONE]
    for i in range(np.uint64(0), first + ONE):
        b[VZ + i] = low
        b[Z + i] += dt * low
    for i in range(last, vertices):
        b[VZ + i] = high
        b[Z + i] += dt * high
    return b[END + LOSS] + b[END + LOSS + ONE]
