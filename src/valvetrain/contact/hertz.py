"""Hertz contact mechanics: pressure and half width of cam and follower, stiffness of point and line contacts.

K. L. Johnson, Contact Mechanics (1985), chapter 4; A. Palmgren, Ball and Roller Bearing Engineering (1959), for the line stiffness.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.contact.law import Array
from valvetrain.errors import InputError
from valvetrain.parameters.material import Material


def contact_modulus(first: Material, second: Material) -> float:
    """E* (Pa) with 1/E* = (1 - nu1**2)/E1 + (1 - nu2**2)/E2."""
    compliance = (1 - first.poisson_ratio**2) / first.youngs_modulus + (1 - second.poisson_ratio**2) / second.youngs_modulus
    return 1 / compliance


def effective_radius(first_radius: ArrayLike, second_radius: ArrayLike = np.inf) -> Array:
    """R (m) with 1/R = 1/R1 + 1/R2; a flat is infinite, a hollow negative.

    Raises :class:`InputError` where the hollow is no wider than the body in it (no Hertz contact).
    """
    curvature = 1 / np.asarray(first_radius, dtype=float) + 1 / np.asarray(second_radius, dtype=float)
    if np.any(curvature <= 0):
        raise InputError("a hollow surface is no wider than the body in it, so there is no Hertz contact; enlarge the hollow radius")
    return 1 / curvature


def line_half_width(force: ArrayLike, length: float, radius: ArrayLike, modulus: float) -> Array:
    """Half width (m) b = sqrt(4 F R / (pi L E*)) of a line contact; force in N, length L and effective radius R in m."""
    _positive(length=length, modulus=modulus)
    found: Array = np.sqrt(4 * np.maximum(force, 0.0) * np.asarray(radius) / (np.pi * length * modulus))
    return found


def line_peak_pressure(force: ArrayLike, length: float, radius: ArrayLike, modulus: float) -> Array:
    """Peak pressure (Pa) p0 = sqrt(F E* / (pi L R)) of a line contact."""
    _positive(length=length, modulus=modulus)
    return np.sqrt(np.maximum(force, 0.0) * modulus / (np.pi * length * np.asarray(radius)))


def line_stiffness(length: float, modulus: float) -> float:
    """K (N/m**(10/9)) of F = K d**(10/9): Palmgren's d = 1.36 F**0.9 / (E***0.9 L**0.8), nearly free of the radii."""
    _positive(length=length, modulus=modulus)
    return float(modulus * length ** (8 / 9) / 1.36 ** (10 / 9))


def point_stiffness(radius: float, modulus: float) -> float:
    """K (N/m**1.5) of F = K d**1.5 for an effective sphere radius (m): 4/3 E* sqrt(R)."""
    _positive(radius=radius, modulus=modulus)
    return float(4 / 3 * modulus * np.sqrt(radius))


def point_peak_pressure(force: ArrayLike, radius: float, modulus: float) -> Array:
    """Peak pressure (Pa) p0 = (6 F E***2 / (pi**3 R**2))**(1/3) of a sphere."""
    _positive(radius=radius, modulus=modulus)
    return (6 * np.maximum(force, 0.0) * modulus**2 / (np.pi**3 * radius**2)) ** (1 / 3)


def _positive(**values: float) -> None:
    for key, value in values.items():
        if not (np.isfinite(value) and value > 0):
            raise InputError(f"{key} of a Hertz contact is {value}; give a positive number")
