"""Unit: every row of the page of measured lifts beside made-up numbers, in the units of the page."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.lift.figures import LiftFigure, figure_rows

DEG = np.pi / 180


@pytest.mark.parametrize(
    ("value", "spread", "unit", "row"),
    [
        (9.1e-3, 2e-6, "mm", ("9.1000", "±0.0039", "mm")),
        (120 * DEG, 0.05 * DEG, "deg", ("120.000", "±0.098", "cam deg")),
        (1.5e-3 * DEG, 1e-5 * DEG, "mm deg", ("1.500", "±0.020", "mm deg")),
        (0.02e-3 / DEG, 1e-6 / DEG, "mm/deg", ("0.0200", "±0.0020", "mm/deg")),
        (-3e-6 / DEG**2, 1e-7 / DEG**2, "um/deg2", ("-3.00", "±0.20", "µm/deg²")),
        (4e-7 / DEG**3, 1e-7 / DEG**3, "mm/deg3", ("0.00040", "±0.00020", "mm/deg³")),
        (0.25, 0.0, "", ("0.2500", "±0.0000", "")),
        (9e-3, 20e-3, "mm", ("9", "±39", "mm")),
    ],
)
def test_figures_of_a_lobe_in_the_units_of_the_trade_with_two_digits_of_their_interval(
    value, spread, unit, row
):
    assert figure_rows([LiftFigure("key", "words", value, spread, unit)]) == [("words", *row)]


def test_the_interval_of_a_size_does_not_reach_below_zero():
    """The largest jerk stood as 0.0044 ± 0.0058."""
    jerk = LiftFigure("largest_jerk", "jerk", 4.4e-6 / DEG**3, 2.96e-6 / DEG**3, "mm/deg3")
    assert figure_rows([jerk]) == [("jerk", "0.0044", "0 to 0.0102", "mm/deg³")]
