"""Buckling of a spring by the closed formula, and what is said of it beside the rod's own answer."""

from __future__ import annotations

import math

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.material import OTEVA_90_SC, Material
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.solution.static import SpringAtRest
from valvetrain.units import Given, si

#: A spring is cylindrical, as the formula has it, where its mean diameter varies by no more than
#: this share.
SAME_DIAMETER = 1e-6


def buckling_compression(
    free_length: Given,
    mean_diameter: Given,
    material: Material = OTEVA_90_SC,
    seating_coefficient: float = 0.5,
) -> float:
    """Compression at which a cylindrical spring buckles by the closed formula of Haringx, as in EN
    13906-1.

    s_K = L_0 / (2 (1 - G/E)) [1 - sqrt(1 - (1 - G/E) / (1/2 + G/E) (pi D / (nu L_0))^2)], J. A.
    Haringx, "On highly compressible helical
    springs and rubber rods", Philips Research Reports 3 (1948) 401-449. The spring is taken for an
    elastic column with shear, its lead
    angle for small.

    Parameters
    ----------
    free_length : L_0 (m, "81 mm" or a pint quantity)
    mean_diameter : D of the wire's axis (m)
    material : its elastic and shear modulus count
    seating_coefficient : nu, 0.5 with both ends fixed parallel and in line, 0.7 with one fixed and
        one hinged, 1 with both hinged, 2 with
        one fixed and one free

    Returns
    -------
    Compression (m); infinite for a spring too short to buckle at any

    Raises
    ------
    InputError : a length or coefficient that is not positive, a slip of units

    Examples
    --------
    >>> round(buckling_compression("80 mm", "10 mm"), 5)
    0.01584
    >>> buckling_compression("40 mm", "10 mm")
    inf
    """
    length, diameter = (
        si(free_length, "spring_length", "free_length"),
        si(mean_diameter, "mean_diameter", "mean_diameter"),
    )
    for name, value in (
        ("free_length", length),
        ("mean_diameter", diameter),
        ("seating_coefficient", seating_coefficient),
    ):
        if not (math.isfinite(value) and value > 0):
            raise InputError(
                f"{name} of a spring that may buckle must be positive; it is {value:g}"
            )
    ratio = material.shear_modulus / material.youngs_modulus
    root = (
        1.0
        - (1.0 - ratio) / (0.5 + ratio) * (math.pi * diameter / (seating_coefficient * length)) ** 2
    )
    return math.inf if root < 0.0 else length * 0.5 / (1.0 - ratio) * (1.0 - math.sqrt(root))


def formula_compression(wire: SpringDefinition) -> float | None:
    """Buckling compression (m) of a wire between two seats by the formula, before it is solid; None
    where it has none.

    The formula knows cylindrical springs; L_0 is the height between the places where the wire is
    held, of axis to axis.
    """
    coil = np.linspace(*wire.free_coils, 129)
    diameter = np.asarray(wire.mean_diameter.value(coil))
    if np.ptp(diameter) > SAME_DIAMETER * np.max(diameter):
        return None
    ends = wire.centreline(np.array(wire.free_coils))[:, 2]
    found = buckling_compression(float(ends[1] - ends[0]), float(diameter[0]), wire.material)
    return found if found < wire.free_length - wire.solid_height else None


def buckling_quantities(
    spring: InstalledSpring, rest: SpringAtRest, maximum_lift: float
) -> dict[str, float]:
    """Where the spring buckles by the rod and by the formula (m), what is left at the largest lift
    (m), and how it
    leans on its guide."""
    found: dict[str, float] = {}
    if rest.curve is not None and rest.curve.buckling is not None:
        buckling = rest.curve.buckling
        found = {
            "buckling_compression": buckling.compression, "buckling_height": buckling.height,
            "buckling_clearance": buckling.compression - spring.precompression - maximum_lift,
        }  # fmt: skip
    if rest.curve is not None and rest.curve.leaning is not None:
        found |= {
            "guide_contact_compression": rest.curve.leaning.compression,
            "guide_force": rest.curve.leaning.force,
        }
    formula = None if spring.wire is None else formula_compression(spring.wire)
    return found if formula is None else found | {"formula_buckling_compression": formula}
