"""Values known for springs at rest: of one state of the rod, of a closed spring, of a retainer that
moves.
"""

from __future__ import annotations

import numpy as np

from spring_shapes import cylindrical
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.statics import design_quantities, rest_quantities
from valvetrain.solution.modes import ModalResult
from valvetrain.solution.static import RestPoint, SpringAtRest

Known = tuple[dict[str, float], dict[str, float | tuple[float, float]]]


def installed_state() -> Known:
    """Each number of a state stands under its own name."""
    point = RestPoint(7e-3, 288.0, 44e3, 39e-3, 370e6, 376e6, 660e6, -0.126, 0.277, 10.3, -0.0223)
    modes = ModalResult(
        7e-3,
        np.array([130.0, 600.0]),
        np.zeros((2, 2, 3)),
        np.arange(2.0),
        np.ones(2),
        (0, 1),
        attached_mass=0.05,
    )
    return rest_quantities(
        SpringAtRest("spring", "finite-element", 7e-3, None, modes, installed=point)
    ), {
        "installed_nominal_shear_stress": 370e6,
        "installed_shear_stress": 376e6,
        "installed_equivalent_stress": 660e6,
        "installed_retainer_torque": -0.126,
        "installed_retainer_moment": 0.277,
        "installed_retainer_side_force": 10.3,
        "installed_retainer_rotation_angle": -0.0223,
        "moving_retainer_mode_1_frequency": 130.0,
        "moving_retainer_mode_2_frequency": 600.0,
    }


def closed_wire() -> Known:
    """Closed and ground, 8 turns of 4 mm wire, 52 mm free: R s_c and its shear by EN 13906-1, k =
    6.5 / 5.25 at index 6.
    """
    wire = cylindrical("4 mm", "24 mm", total_coils=8, free_length="52 mm", ends="closed-ground")
    force = wire.material.shear_modulus * 4e-3**4 / (8 * 24e-3**3 * 6) * 20e-3
    return design_quantities(InstalledSpring(wire=wire, precompression=7e-3)), {
        "solid_force": force,
        "solid_nominal_shear_stress": 6.5 / 5.25 * 8 * force * 24e-3 / (np.pi * 4e-3**3),
        "largest_pitch": 44e-3 / 6,
    }


REST_GROUPS = (installed_state, closed_wire)
