"""The rod in the positions of its free vertices alone: rotations follow at rest, their inertia
stays.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from valvetrain.arrays import Array
from valvetrain.cosserat.buffer import inertia_of
from valvetrain.cosserat.contact_line import no_contact
from valvetrain.cosserat.mesh import RodMesh
from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.static import RodStatics


@dataclass(frozen=True, eq=False)
class CondensedRod:
    """``stiffness`` and ``mass`` (n, n) of the n position components of the free vertices about one
    state, both ends fixed; ``turning`` (r, n): rotations that follow a change of positions.

    ``stiffness`` is that of the wire, with what contact forces add as their direction turns with
    the wire, without the stiffness of closed contacts.
    """

    stiffness: Array
    mass: Array
    turning: Array


def elastic_statics(mesh: RodMesh) -> RodStatics:
    """Statics of the wire alone: no coil and no seat touches it."""
    nothing = np.full(mesh.vertices, np.inf)
    bare = replace(
        mesh,
        contact=no_contact(mesh.vertices),
        lower_seat_limit=-nothing,
        upper_seat_limit=nothing,
    )
    return RodStatics(bare, 0.0)


def position_slots(mesh: RodMesh) -> NDArray[np.int64]:
    """Places of the free vertices' positions among the unknowns (6 nv,)."""
    slots = np.arange(6 * mesh.vertices).reshape(-1, 6)
    return slots[mesh.first + 1 : mesh.last, :3].ravel()


def rotation_slots(bare: RodStatics) -> NDArray[np.int64]:
    """Places of the free rotations among the unknowns (6 nv,)."""
    slots = np.arange(6 * bare.mesh.vertices).reshape(-1, 6)
    return slots[:, 3:][bare.free.reshape(-1, 6)[:, 3:]]


def condensed(statics: RodStatics, bare: RodStatics, state: RodState) -> CondensedRod:
    """The wire about ``state``; ``statics`` with and ``bare`` (:func:`elastic_statics`) without
    contact.
    """
    mesh = statics.mesh
    tangent = bare.tangent(state)
    places, turns = position_slots(mesh), rotation_slots(bare)
    coupling = tangent[turns][:, places].toarray()
    turning = -splu(tangent[turns][:, turns].tocsc()).solve(coupling)
    stiffness = tangent[places][:, places].toarray() + coupling.T @ turning
    inertia = inertia_of(mesh)
    mass = np.diag(inertia[places]) + (turning.T * inertia[turns]) @ turning
    return CondensedRod(0.5 * (stiffness + stiffness.T), 0.5 * (mass + mass.T), turning)


def turning_of_contacts(
    statics: RodStatics, bare: RodStatics, state: RodState, closed: Array
) -> Array:
    """Stiffness (n, n) of contact forces that turn with the wire: the tangent with contact, less
    that without, less ``closed`` (n, n) of the closed contacts.
    """
    places = position_slots(statics.mesh)
    with_contact = statics.tangent(state)[places][:, places]
    alone = bare.tangent(state)[places][:, places]
    return np.asarray((with_contact - alone).toarray() - closed)
