"""State of a rod: positions and frames; travels through statics and modes while the mesh stays
frozen.
"""

from __future__ import annotations

from dataclasses import dataclass

from valvetrain.arrays import Array
from valvetrain.cosserat import quaternion as quat
from valvetrain.cosserat.mesh import RodMesh


@dataclass(frozen=True, slots=True)
class RodState:
    """Positions (nv, 3) in m, unit quaternions (nv + 1, 4) and the retainer's displacement (m,
    compressive positive).
    """

    position: Array
    frame: Array
    compression: float = 0.0


def free_state(mesh: RodMesh) -> RodState:
    """The stress-free state of a mesh."""
    return RodState(mesh.position.copy(), mesh.frame.copy(), 0.0)


def advance(state: RodState, change: Array, compression: float) -> RodState:
    """Add the unknowns' ``change`` (6 nv,): positions add, frames turn by body rotation vectors."""
    steps = change.reshape(-1, 6)
    frame = state.frame.copy()
    frame[1:] = quat.multiply(state.frame[1:], quat.from_rotation_vector(steps[:, 3:]))
    return RodState(state.position + steps[:, :3], frame, compression)
