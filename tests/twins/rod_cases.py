"""Small rods and random states for the tests of the rod."""

from __future__ import annotations

import numpy as np

from spring_shapes import cylindrical
from valvetrain.cosserat import quaternion as quat
from valvetrain.cosserat.mesh import RodMesh, mesh_spring
from valvetrain.cosserat.state import RodState
from valvetrain.parameters.curves import PiecewiseLinear
from valvetrain.parameters.material import Material
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import OPEN_END, EndCoil

STEEL = Material("steel", 206e9, 79.6e9, 7850.0)


def small_spring(
    total_coils: float = 3.2, pitch: float = 5e-3, hand: str = "right", ends: EndCoil = OPEN_END
) -> SpringDefinition:
    """Slightly conical spring with a narrow lower coil."""
    return SpringDefinition(
        wire_diameter=PiecewiseLinear((0.0, total_coils), (4.0e-3, 3.7e-3)),
        mean_diameter=PiecewiseLinear((0.0, total_coils), (24e-3, 22e-3)),
        pitch=PiecewiseLinear((0.0, 1.3, 1.7, total_coils), (4.2e-3, 4.2e-3, pitch, pitch)),
        total_coils=total_coils,
        material=STEEL,
        lower_end=ends,
        upper_end=ends,
        hand=hand,
        name="small",
    )


def uniform_spring(
    wire=4e-3, diameter=24e-3, pitch=7.5e-3, coils=6.0, material=STEEL, **changes
) -> SpringDefinition:
    """Uniform helix clamped at both wire tips."""
    from valvetrain.parameters.curves import Constant

    return cylindrical(
        wire,
        diameter,
        Constant(pitch),
        coils,
        material=material,
        lower_end=OPEN_END,
        upper_end=OPEN_END,
        **changes,
    )


def random_state(
    mesh: RodMesh, seed: int, shift: float = 2e-4, turn: float = 2e-2, closed: float = 0.12
) -> RodState:
    """The free state squeezed by the share ``closed`` of its height, with random shifts (m) and
    turns (rad) of free vertices and edges.
    """
    rng = np.random.default_rng(seed)
    position, frame = mesh.position.copy(), mesh.frame.copy()
    position[:, 2] *= 1 - closed
    inside, edges = slice(mesh.first + 1, mesh.last), slice(mesh.first + 1, mesh.last + 1)
    position[inside] += shift * rng.standard_normal(position[inside].shape)
    frame[edges] = quat.multiply(
        frame[edges],
        quat.from_rotation_vector(turn * rng.standard_normal(frame[edges][:, 1:].shape)),
    )
    return RodState(position, frame, closed * float(mesh.position[mesh.last, 2]))


def small_mesh(per_coil: int = 12, **options) -> RodMesh:
    """A mesh with contact of :func:`small_spring`."""
    return mesh_spring(small_spring(**options), per_coil)
