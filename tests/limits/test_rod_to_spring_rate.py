"""Finite-element rod to the closed form G d**4 / (8 D**3 n) as the index grows and the helix
flattens.
"""

from __future__ import annotations

import numpy as np
import pytest

from spring_shapes import cylindrical
from valvetrain.springs.finite_element import FiniteElementRod


def rate_ratio(mean_diameter: float, curvature_correction: bool) -> float:
    """Static rate of the rod over the closed form: wire 1 mm, pitch 2 mm, 4 open turns fixed at
    their tips.
    """
    spring = cylindrical(1e-3, mean_diameter, 2e-3, 4.0, ends="open")
    rod = FiniteElementRod(
        spring,
        1e-4,
        elements_per_coil=48,
        curvature_correction=curvature_correction,
        seats="clamps",
    )
    low, high = (rod.force(rod.initial_state(x), x).retainer for x in (-1e-5, 1e-5))
    return (
        (high - low)
        / 2e-5
        / (spring.material.shear_modulus * 1e-3**4 / (8 * mean_diameter**3 * 4.0))
    )


@pytest.mark.parametrize("curvature_correction", [True, False])
def test_rod_reaches_the_rate_formula_at_order_two_in_index_and_pitch_angle(curvature_correction):
    errors = np.array(
        [abs(rate_ratio(diameter, curvature_correction) - 1) for diameter in (20e-3, 40e-3, 80e-3)]
    )
    assert errors[-1] < 2.5e-4
    orders = np.log2(errors[:-1] / errors[1:])
    assert np.all(np.diff(orders) > 0) and orders[-1] == pytest.approx(2.0, abs=0.15)
