"""What the retainer feels of the rod at rest: slope of its force and torque, and the force and
moment on it.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_matrix

from valvetrain.arrays import Array
from valvetrain.cosserat import quaternion as quat
from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.static import RodStatics, sparse_of


def turning_field(statics: RodStatics, state: RodState) -> Array:
    """Unit rotation (nv, 6) of the retainer and its inactive wire about the axis: velocities in
    space, spins in the frames.
    """
    last, found = statics.mesh.last, np.zeros((statics.mesh.vertices, 6))
    found[last:, 0], found[last:, 1] = -state.position[last:, 1], state.position[last:, 0]
    found[last:, 3:] = quat.to_matrix(state.frame[last + 1 :])[:, 2, :]
    return found


def _plane(statics: RodStatics, state: RodState) -> Array:
    """Stiffness (nv,) in N/m of the retainer's plane on the wire that touches it."""
    found: Array = (
        statics.contact_stiffness
        * statics.mesh.node_length
        * statics.retainer_contact(state).tangent
    )
    return found


def end_stiffness(statics: RodStatics, state: RodState) -> Array:
    """Slopes (2, 2) of retainer force (N) and torque (N m) by compression (m) and rotation (rad),
    the wire following, contacts as they are.

    Both are derivatives of the energy; the torque counts as that which holds the retainer at its
    angle.
    """
    mesh, turn = statics.mesh, turning_field(statics, state)
    residual, (down, turned) = _slopes(statics, state, (_down(statics), turn))
    (slope, _), (on_retainer, pushed) = down, turned
    # a force across the axis turns with the arm it acts on
    arms = float(np.sum(residual.reshape(-1, 6)[mesh.last :, :2] * state.position[mesh.last :, :2]))
    return np.array([[slope, on_retainer], [on_retainer, float(np.sum(turn * pushed)) - arms]])


def _down(statics: RodStatics) -> Array:
    """Unit compression (nv, 6) of the retainer and its inactive wire."""
    found = np.zeros((statics.mesh.vertices, 6))
    found[statics.mesh.last :, 2] = -1.0
    return found


def _slopes(
    statics: RodStatics, state: RodState, units: tuple[Array, ...]
) -> tuple[Array, list[tuple[float, Array]]]:
    """The residual, and of each motion of the retainer, the first of them compression: slope of its
    force, and the pull (nv, 6).
    """
    mesh, plane = statics.mesh, _plane(statics, state)
    _, residual, band, contact = statics.assemble(state)
    matrix = sparse_of(band) if contact is None else sparse_of(band) + contact
    found = []
    for place, unit in enumerate(units):
        load = (matrix @ unit.ravel()).reshape(-1, 6)
        load[:, 2] += plane if place == 0 else 0.0
        follow = statics.follow(unit, band, contact, load)
        pushed = (matrix @ follow.ravel()).reshape(-1, 6)
        own = np.sum(plane) - np.sum(plane[mesh.last :]) if place == 0 else 0.0
        found.append((float(-np.sum(pushed[mesh.last :, 2]) + plane @ follow[:, 2] + own), pushed))
    return residual, found


def axial_rate(statics: RodStatics, state: RodState) -> float:
    """Slope dF/dx (N/m) of the retainer force by the compression at an equilibrium, contacts as
    they are there; a retainer that may
    turn turns along."""
    if not statics.turns:
        return _slopes(statics, state, (_down(statics),))[1][0][0]
    slopes = end_stiffness(statics, state)
    return float(slopes[0, 0] - slopes[0, 1] ** 2 / slopes[1, 1])


def end_coupling(statics: RodStatics, state: RodState, tangent: csc_matrix) -> tuple[Array, float]:
    """Pull (6 nv,) on the unknowns and stiffness (N/m) of the retainer itself under unit
    compression, all else at its place.
    """
    last, plane = statics.mesh.last, _plane(statics, state)
    unit = np.zeros((statics.mesh.vertices, 6))
    unit[last:, 2] = -1.0
    pull = (tangent @ unit.ravel()).reshape(-1, 6)
    pull[:, 2] += plane
    return pull.ravel(), float(
        -np.sum(pull[last:, 2]) + np.sum(plane[:last]) + np.sum(plane[last:])
    )


def retainer_torque(statics: RodStatics, state: RodState) -> float:
    """Torque (N m) about the axis that holds the retainer at its angle."""
    _, residual, _, _ = statics.assemble(state, with_tangent=False)
    return float(np.sum(residual.reshape(-1, 6) * turning_field(statics, state)))


def retainer_loads(
    statics: RodStatics, state: RodState, plane_height: float
) -> tuple[Array, Array]:
    """Force (3,) N and moment (3,) N m of the wire on the retainer, about the axis at
    ``plane_height`` (m, in the rod's coordinates).
    """
    mesh, x = statics.mesh, state.position
    _, residual, _, _ = statics.assemble(state, with_tangent=False)
    unknowns = residual.reshape(-1, 6)
    force = np.zeros_like(x)
    force[mesh.last :] = -unknowns[mesh.last :, :3]
    force[:, 2] += (
        statics.contact_stiffness * mesh.node_length * statics.retainer_contact(state).elastic
    )
    arm = x - np.array([0.0, 0.0, plane_height])
    frames = quat.to_matrix(state.frame[mesh.last + 1 :])
    moment = np.sum(np.cross(arm, force), axis=0) - np.einsum(
        "nij,nj->i", frames, unknowns[mesh.last :, 3:]
    )
    return force.sum(axis=0), moment
