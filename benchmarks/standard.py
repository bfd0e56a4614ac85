"""The standard springs and motions of the speed measurements, in this package's own words (SI
units).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.cosserat.mesh import RodMesh, mesh_spring
from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.static import RodStatics, compress
from valvetrain.cosserat.transient import RodTransient, simulate
from valvetrain.parameters.curves import PiecewiseLinear
from valvetrain.parameters.material import Material
from valvetrain.parameters.spring import SpringDefinition

Array = NDArray[np.float64]

STEEL = Material("steel", 206e9, 79.6e9, 7850.0)
#: 1.6 % of critical at 600 Hz, once by stiffness (s), once by mass (1/s).
DAMPING = {"stiffness": (0.0, 8.48826e-6), "mass": (120.637, 0.0)}
PRECOMPRESSION, LIFT, CAM_SPEED, REVOLUTIONS = 7e-3, 10e-3, 4000 * 2 * np.pi / 60, 2
#: Output every half cam degree.
PER_TURN = 720
INTERVAL = 2 * np.pi / CAM_SPEED / PER_TURN


def lift(time: Array | float) -> Array:
    """Lift (m) of the retainer: 10 mm sin^4 over 127 to 233 cam degrees."""
    degrees = np.degrees(CAM_SPEED * np.asarray(time)) % 360.0
    inside = (degrees >= 127.0) & (degrees <= 233.0)
    square = np.sin(np.pi * (degrees - 127.0) / 106.0) ** 2
    return np.where(inside, LIFT * square * square, 0.0)


def motion(time: Array | float) -> Array:
    """Retainer displacement (m) from the free state."""
    return PRECOMPRESSION + lift(time)


def spring_t() -> SpringDefinition:
    """The uniform open spring of jobs T, S and M."""
    return SpringDefinition(
        4e-3, 24e-3, 7.5e-3, total_coils=6.0, material=STEEL, ends="open", name="T"
    )


def spring_c(pitch_factor: float = 1.0) -> SpringDefinition:
    """The spring of jobs C and B: close lower coils, free height 45 mm; ``pitch_factor`` scales the
    open pitch.
    """
    pitch = PiecewiseLinear(
        (0.0, 1.25, 1.75, 6.0), (4.4e-3, 4.4e-3, 8.533e-3 * pitch_factor, 8.533e-3 * pitch_factor)
    )
    return SpringDefinition(
        4e-3, 24e-3, pitch, total_coils=6.0, material=STEEL, ends="open", name="C"
    )


def rod(
    spring: SpringDefinition, per_coil: int, damping: str, contact: bool
) -> tuple[RodMesh, RodDynamics, RodState]:
    """Mesh, dynamics and installed state; section without curvature correction, so that peers solve
    the same equations.
    """
    mesh = mesh_spring(spring, per_coil, curvature_correction=False, contact=contact)
    mass_damping, stiffness_damping = DAMPING[damping]
    start = compress(RodStatics(mesh), [PRECOMPRESSION])[-1]
    return mesh, RodDynamics(mass_damping, stiffness_damping), start.state


def transient(
    mesh: RodMesh, dynamics: RodDynamics, start: RodState, time_step: float | None = None
) -> RodTransient:
    """Both revolutions, sampled every half cam degree."""
    return simulate(mesh, start, motion, INTERVAL, REVOLUTIONS * PER_TURN, dynamics, time_step)


def relative_rms(trace: Array, reference: Array) -> float:
    """Root mean square of the difference over the second revolution, over the root mean square of
    the reference there.
    """
    second = slice(-PER_TURN - 1, None)
    return float(
        np.sqrt(np.mean((trace[second] - reference[second]) ** 2) / np.mean(reference[second] ** 2))
    )
