"""Section stiffness of a round wire: shear, tension, bending, torsion, with the curvature of the
bar.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array
from valvetrain.parameters.material import Material


@dataclass(frozen=True, slots=True)
class Section:
    """Stiffness and inertia per length of wire at n places, all arrays of shape (n,) in SI.

    ``shear`` = kappa G A (N), ``tension`` = E A (N), ``bending`` = E I (N m2), ``torsion`` = G J (N
    m2),
    ``mass`` = rho A (kg/m), ``bending_inertia`` = rho I (kg m), ``torsion_inertia`` = 2 rho I (kg
    m).
    """

    shear: Array
    tension: Array
    bending: Array
    torsion: Array
    mass: Array
    bending_inertia: Array
    torsion_inertia: Array


def shear_factor(material: Material) -> float:
    """Shear factor of the round section, 6 (1 + nu) / (7 + 6 nu) (Cowper 1966)."""
    poisson_ratio = material.poisson_ratio
    return 6 * (1 + poisson_ratio) / (7 + 6 * poisson_ratio)


def curvature_factor(index: Array, shear: float) -> Array:
    """Factor on G J for a curved bar of ``index`` D/d: 1 / (1 - 3/(16 c^2) - 1/(2 kappa c^2)).

    Goehner's series for a ring sector under torsion, less the direct shear that the rod carries
    itself.
    """
    return 1.0 / (1.0 - 3.0 / (16.0 * index**2) - 1.0 / (2.0 * shear * index**2))


def round_section(wire_diameter: Array, material: Material, index: Array | None = None) -> Section:
    """Section of round wire of ``wire_diameter`` (m); with ``index`` the torsion is corrected for
    curvature.
    """
    area = np.pi / 4 * wire_diameter**2
    second_moment = np.pi / 64 * wire_diameter**4
    kappa = shear_factor(material)
    torsion = 2 * material.shear_modulus * second_moment
    if index is not None:
        torsion = torsion * curvature_factor(index, kappa)
    return Section(
        shear=kappa * material.shear_modulus * area,
        tension=material.youngs_modulus * area,
        bending=material.youngs_modulus * second_moment,
        torsion=torsion,
        mass=material.density * area,
        bending_inertia=material.density * second_moment,
        torsion_inertia=2 * material.density * second_moment,
    )
