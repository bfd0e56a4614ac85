"""Static rate of the rod: slope of the force by the retainer's travel, the wire and its contacts following."""

from __future__ import annotations

import numpy as np

from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.static import RodStatics, sparse_of


def axial_rate(statics: RodStatics, state: RodState) -> float:
    """Slope dF/dx (N/m) of the retainer force by the compression at an equilibrium ``state``: the tangent, contacts as they are there."""
    mesh = statics.mesh
    _, _, band, contact = statics.assemble(state)
    matrix = sparse_of(band) if contact is None else sparse_of(band) + contact
    follow = np.zeros((mesh.vertices, 6))
    follow[mesh.last :, 2] = -1.0
    # the retainer's plane presses on the coils that touch it, whatever the rest does
    touching = state.position[:, 2] > mesh.upper_seat_limit - state.compression
    plane = statics.contact_stiffness * mesh.node_length * touching
    load = (matrix @ follow.ravel()).reshape(-1, 6)
    load[:, 2] += plane
    follow = statics.follow(follow, band, contact, load)
    pushed = (matrix @ follow.ravel()).reshape(-1, 6)[:, 2] + plane
    return float(-np.sum(pushed[mesh.last :]) + plane @ (follow[:, 2] + 1.0))
