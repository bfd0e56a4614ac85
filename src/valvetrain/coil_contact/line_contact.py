"""Stiffness of contact between coils by elasticity: round wires pressed together along a line, and what
their sections give way by becoming oval.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from valvetrain.errors import InputError
from valvetrain.parameters.material import Material


class LineContact(NamedTuple):
    """``half_width`` (m) of the contact, ``approach`` (m) of the two axes, ``secant`` and ``tangent``
    stiffness (N/m per m of wire).
    """

    half_width: float
    approach: float
    secant: float
    tangent: float


def line_contact(wire_diameter: float, material: Material, force_per_length: float) -> LineContact:
    """Two equal wires (diameter in m) under a force per length (N/m) along a line, plane strain.

    A disc squeezed between two opposite lines has, of each half, the compression
    q (1 - nu^2) / (pi E) (2 ln(4 R / a) - 1) with the half width a of Hertz (johnson1985, section 5.6);
    the axes of two wires approach by twice that. The stiffness rises with the logarithm of the force.
    Raises :class:`InputError` for a diameter or force that is not positive.

    >>> import valvetrain as vt
    >>> steel = vt.load_case("job-c").springs[0].wire.material
    >>> found = line_contact(4e-3, steel, 10e3)
    >>> round(found.half_width * 1e6, 1), round(found.tangent / 1e10, 2)
    (10.6, 3.15)
    """
    if not (wire_diameter > 0 and force_per_length > 0):
        raise InputError(
            f"contact of wires needs a positive diameter and force; they are {wire_diameter:g} m and {force_per_length:g} N/m"
        )
    radius = wire_diameter / 2
    compliance = 2 * (1 - material.poisson_ratio**2) / (math.pi * material.youngs_modulus)
    # two wires of radius R: relative radius R / 2, and a^2 = 4 q (R / 2) / (pi E*), E* = E / (2 (1 - nu^2))
    half_width = math.sqrt(2 * force_per_length * radius * compliance)
    depth = 2 * math.log(4 * radius / half_width)
    approach = force_per_length * compliance * (depth - 1)
    return LineContact(
        half_width, approach, force_per_length / approach, 1 / (compliance * (depth - 2))
    )
