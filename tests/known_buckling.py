"""Numbers of a spring that buckles and leans, known by hand, in the manner of ``known_quantities``."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from known_quantities import Known
from spring_shapes import cylindrical
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.material import OTEVA_90_SC
from valvetrain.quantities.statics import buckling_quantities
from valvetrain.solution.static import Buckling, Leaning, SpringAtRest, StaticCurve

#: E = 2.6 G, of which textbooks print the constants.
STEEL = replace(OTEVA_90_SC, youngs_modulus=208e9, shear_modulus=80e9)


def buckling() -> Known:
    """Buckled at 15.5 mm of 20 mm at work, leaning from 16 mm on; the formula's constants for E =
    2.6 G are 13/16 and pi^2 16/23.
    """
    wire = cylindrical("1 mm", "10 mm", "4 mm", 20, ends="open", material=STEEL)
    steps, none = np.linspace(0.0, 21e-3, 8), np.zeros((8, 0))
    curve = StaticCurve(
        steps,
        500 * steps,
        np.full(8, 500.0),
        none,
        none,
        np.zeros(0),
        none,
        np.zeros(0),
        buckling=Buckling(15.5e-3, 65.5e-3, 7.6),
        leaning=Leaning(16e-3, 0.7),
    )
    found = buckling_quantities(
        InstalledSpring(wire, precompression=8e-3),
        SpringAtRest("slender", "finite-element", 8e-3, curve),
        12e-3,
    )
    return found, {
        "buckling_compression": 15.5e-3,
        "buckling_height": 65.5e-3,
        "buckling_clearance": -4.5e-3,
        "guide_contact_compression": 16e-3,
        "guide_force": 0.7,
        "formula_buckling_compression": 80e-3
        * 13
        / 16
        * (1 - math.sqrt(1 - 16 / 23 * (math.pi / 4) ** 2)),
    }
