"""Published: the closed formula of buckling against the constants that textbooks print of it for
spring steel.
"""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from valvetrain.parameters.material import OTEVA_90_SC
from valvetrain.quantities.statics import buckling_compression

#: E = 2.6 G, as A. M. Wahl, Mechanical Springs (1963), has it for steel.
STEEL = replace(OTEVA_90_SC, youngs_modulus=206e9, shear_modulus=206e9 / 2.6)


@pytest.mark.parametrize(("seating", "limit"), [(0.5, 5.24), (1.0, 2.62), (0.7, 3.74)])
def test_stable_up_to_the_slenderness_in_the_books(seating, limit):
    """L0/D = 5.24 between parallel plates and 2.62 hinged (Wahl; Shigley rounds to 5.26 and 2.63):
    shorter springs never buckle.
    """
    diameter = 0.01
    assert buckling_compression((limit - 0.01) * diameter, diameter, STEEL, seating) == math.inf
    assert (
        buckling_compression((limit + 0.01) * diameter, diameter, STEEL, seating)
        < 0.82 * limit * diameter
    )


@pytest.mark.parametrize("slenderness", [5.5, 6.0, 8.0, 12.0])
def test_the_curve_of_wahl(slenderness):
    """s / L0 = 0.812 (1 - sqrt(1 - 6.87 (nu L0 / D)^-2)), his constants for steel."""
    diameter = 0.01
    wahl = 0.812 * (1 - math.sqrt(1 - 6.87 / (0.5 * slenderness) ** 2))
    assert buckling_compression(slenderness * diameter, diameter, STEEL) / (
        slenderness * diameter
    ) == pytest.approx(wahl, rel=3e-3)


def test_a_long_spring_is_a_column_of_euler():
    """Far beyond the limit shear is nothing: pi^2 beta / (nu L0)^2 over the rate, beta / k = E D^2
    L0 / (2 (E + 2 G)) (Timoshenko and Gere,
    Theory of Elastic Stability, on helical springs)."""
    length, diameter = 0.5, 0.01
    column = (
        STEEL.youngs_modulus
        * diameter**2
        * length
        / (2 * (STEEL.youngs_modulus + 2 * STEEL.shear_modulus))
    )
    euler = (math.pi / (0.5 * length)) ** 2 * column
    assert buckling_compression(length, diameter, STEEL) == pytest.approx(euler, rel=0.01)
