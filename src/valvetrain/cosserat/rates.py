"""What the retainer feels of the rod at rest: slope of its force and torque, and the force and moment on it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix

from valvetrain.cosserat import quaternion as quat
from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.static import RodStatics, sparse_of

Array = NDArray[np.float64]


def turning_field(statics: RodStatics, state: RodState) -> Array:
    """Unit rotation (nv, 6) of the retainer and its inactive wire about the axis: velocities in space, spins in the frames."""
    last, found = statics.mesh.last, np.zeros((statics.mesh.vertices, 6))
    found[last:, 0], found[last:, 1] = -state.position[last:, 1], state.position[last:, 0]
    found[last:, 3:] = quat.to_matrix(state.frame[last + 1 :])[:, 2, :]
    return found


def _plane(statics: RodStatics, state: RodState) -> Array:
    """Stiffness (nv,) in N/m of the retainer's plane on the wire that touches it."""
    touching = state.position[:, 2] > statics.mesh.upper_seat_limit - state.compression
    found: Array = statics.contact_stiffness * statics.mesh.node_length * touching
    return found


def end_stiffness(statics: RodStatics, state: RodState) -> Array:
    """Slopes (2, 2) of retainer force (N) and torque (N m) by compression (m) and rotation (rad), the wire following, contacts as they are.

    Both are derivatives of the energy; the torque counts as that which holds the retainer at its angle.
    """
    mesh, plane = statics.mesh, _plane(statics, state)
    _, residual, band, contact = statics.assemble(state)
    matrix = sparse_of(band) if contact is None else sparse_of(band) + contact
    down, turn = np.zeros((mesh.vertices, 6)), turning_field(statics, state)
    down[mesh.last :, 2] = -1.0
    pushed, followed = [], []
    for unit, on_plane in ((down, plane), (turn, 0.0 * plane)):
        load = (matrix @ unit.ravel()).reshape(-1, 6)
        load[:, 2] += on_plane
        followed.append(statics.follow(unit, band, contact, load))
        pushed.append((matrix @ followed[-1].ravel()).reshape(-1, 6))
    on_retainer = [-np.sum(one[mesh.last :, 2]) + plane @ follow[:, 2] for one, follow in zip(pushed, followed, strict=True)]
    on_retainer[0] += np.sum(plane) - np.sum(plane[mesh.last :])
    # a force across the axis turns with the arm it acts on
    arms = float(np.sum(residual.reshape(-1, 6)[mesh.last :, :2] * state.position[mesh.last :, :2]))
    return np.array([on_retainer, [on_retainer[1], float(np.sum(turn * pushed[1])) - arms]])


def axial_rate(statics: RodStatics, state: RodState) -> float:
    """Slope dF/dx (N/m) of the retainer force by the compression at an equilibrium, contacts as they are there; a retainer that may
    turn turns along."""
    slopes = end_stiffness(statics, state)
    return float(slopes[0, 0] - (slopes[0, 1] ** 2 / slopes[1, 1] if statics.turns else 0.0))


def end_coupling(statics: RodStatics, state: RodState, tangent: csc_matrix) -> tuple[Array, float]:
    """Pull (6 nv,) on the unknowns and stiffness (N/m) of the retainer itself under unit compression, all else at its place."""
    last, plane = statics.mesh.last, _plane(statics, state)
    unit = np.zeros((statics.mesh.vertices, 6))
    unit[last:, 2] = -1.0
    pull = (tangent @ unit.ravel()).reshape(-1, 6)
    pull[:, 2] += plane
    return pull.ravel(), float(-np.sum(pull[last:, 2]) + np.sum(plane[:last]) + np.sum(plane[last:]))


def retainer_torque(statics: RodStatics, state: RodState) -> float:
    """Torque (N m) about the axis that holds the retainer at its angle."""
    _, residual, _, _ = statics.assemble(state, with_tangent=False)
    return float(np.sum(residual.reshape(-1, 6) * turning_field(statics, state)))


def retainer_loads(statics: RodStatics, state: RodState, plane_height: float) -> tuple[Array, Array]:
    """Force (3,) N and moment (3,) N m of the wire on the retainer, about the axis at ``plane_height`` (m, in the rod's coordinates)."""
    mesh, x = statics.mesh, state.position
    _, residual, _, _ = statics.assemble(state, with_tangent=False)
    unknowns = residual.reshape(-1, 6)
    force = np.zeros_like(x)
    force[mesh.last :] = -unknowns[mesh.last :, :3]
    touched = np.flatnonzero(plane := _plane(statics, state))
    force[touched, 2] += plane[touched] * (x[touched, 2] - (mesh.upper_seat_limit[touched] - state.compression))
    arm = x - np.array([0.0, 0.0, plane_height])
    frames = quat.to_matrix(state.frame[mesh.last + 1 :])
    moment = np.sum(np.cross(arm, force), axis=0) - np.einsum("nij,nj->i", frames, unknowns[mesh.last :, 3:])
    return force.sum(axis=0), moment
