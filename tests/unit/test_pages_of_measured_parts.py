"""Unit: every row of the page of measured lifts beside made-up numbers, in the units of the page."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.lift.figures import LiftFigure, figure_text

DEG = np.pi / 180


@pytest.mark.parametrize(
    ("value", "spread", "unit", "row"),
    [
        (9.1e-3, 2e-6, "mm", "9.1000 ± 0.0039 mm"),
        (120 * DEG, 0.05 * DEG, "deg", "120.000 ± 0.098 cam deg"),
        (1.5e-3 * DEG, 1e-5 * DEG, "mm deg", "1.500 ± 0.020 mm deg"),
        (0.02e-3 / DEG, 1e-6 / DEG, "mm/deg", "0.0200 ± 0.0020 mm/deg"),
        (-3e-6 / DEG**2, 1e-7 / DEG**2, "um/deg^2", "−3.00 ± 0.20 µm/deg²"),
        (4e-7 / DEG**3, 1e-7 / DEG**3, "mm/deg^3", "0.00040 ± 0.00020 mm/deg³"),
        (9e-3, 0.0, "mm", "9.0000 mm"),
        (9e-3, 20e-3, "mm", "9 ± 39 mm"),
    ],
)
def test_figures_of_a_lobe_in_the_units_of_the_trade_with_two_digits_of_their_interval(
    value, spread, unit, row
):
    assert figure_text(LiftFigure("key", "words", value, spread, unit)) == row


def test_figures_of_a_lobe_in_inches():
    peak = LiftFigure("peak_lift", "words", 9.144e-3, 2.54e-6, "mm")
    assert figure_text(peak, "imperial") == "0.36000 ± 0.00020 in"
    slope = LiftFigure("slope", "words", 0.0254e-3 / DEG, 0.0, "mm/deg")
    assert figure_text(slope, "imperial") == "1.0000 thou/deg"


def test_the_interval_of_a_size_does_not_reach_below_zero():
    """The largest jerk stood as 0.0044 ± 0.0058."""
    jerk = LiftFigure("largest_jerk", "jerk", 4.4e-6 / DEG**3, 2.96e-6 / DEG**3, "mm/deg^3")
    assert figure_text(jerk) == "0 to 0.0102 mm/deg³"
