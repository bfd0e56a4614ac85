"""Every curve over the coil number: derivative and integral belong to its value, and the forms are
what they say.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from spring_shapes import FunctionCurve
from valvetrain.parameters.curves import (
    Constant,
    Curve,
    Parabola,
    PiecewiseLinear,
    SlopeOf,
    Table,
    WeightedSum,
    add_curves,
)

KNOTS = (0.0, 1.0, 2.5, 4.0, 6.0)
LINES = PiecewiseLinear(KNOTS, (4.0, 4.0, 7.0, 7.5, 5.0))
TABLE = Table(KNOTS, (4.0, 4.5, 7.0, 7.5, 5.0))
CURVES = {
    "constant": Constant(3.0),
    "lines": LINES,
    "table": TABLE,
    "function": FunctionCurve(lambda coil: 5 + np.sin(coil)),
    "parabola": Parabola(20.0, 26.0, 6.0),
    "slope": SlopeOf(Table(KNOTS, (0.0, 4.0, 12.0, 22.0, 33.0))),
    "sum": WeightedSum(TABLE, LINES, -0.5),
}


@pytest.mark.parametrize("name", CURVES)
def test_derivative_and_integral_belong_to_the_value(name):
    curve, step = CURVES[name], 1e-6
    assert isinstance(curve, Curve)
    coil = np.array([0.3, 0.9, 1.7, 2.2, 3.3, 5.1, 5.9])
    difference = (curve.value(coil + step) - curve.value(coil - step)) / (2 * step)
    assert curve.derivative(coil) == pytest.approx(difference, rel=1e-5, abs=1e-7)
    for upper in (0.4, 2.5, 5.7):
        area = quad(
            lambda u: float(curve.value(u)),
            0.0,
            upper,
            points=[knot for knot in KNOTS if knot < upper],
            epsabs=1e-11,
        )[0]
        assert float(curve.integral(upper)) == pytest.approx(area, rel=1e-9)
    assert (
        np.shape(curve.value(coil.reshape(7, 1)))
        == np.shape(curve.integral(coil.reshape(7, 1)))
        == (7, 1)
    )


def test_at_a_knot_of_lines_the_slope_is_that_of_the_line_which_begins_there():
    """Held constant before the first knot and from the last one on."""
    assert LINES.derivative(KNOTS).tolist() == pytest.approx([0.0, 2.0, 1 / 3, -1.25, 0.0])
    assert PiecewiseLinear(KNOTS, (1.0, 3.0, 3.0, 0.0, 4.0)).derivative(
        KNOTS
    ).tolist() == pytest.approx([2.0, 0.0, -2.0, 2.0, 0.0])
    assert LINES.derivative([-1.0, 7.0]).tolist() == [0.0, 0.0]


@pytest.mark.parametrize("weight", [None, 1.0, -1.0, 0.25])
@pytest.mark.parametrize(
    ("first", "second"),
    [
        (Constant(3.0), Constant(5.0)),
        (LINES, Constant(3.0)),
        (Constant(3.0), LINES),
        (TABLE, LINES),
        (LINES, TABLE),
    ],
)
def test_a_sum_without_a_weight_is_the_sum_of_both(first, second, weight):
    coil, share = np.linspace(0, 6, 37), 1.0 if weight is None else weight
    added = add_curves(first, second) if weight is None else add_curves(first, second, weight)
    assert added.value(coil) == pytest.approx(
        first.value(coil) + share * second.value(coil), rel=1e-12
    )


def test_a_height_gives_back_its_table():
    heights = (0.0, 4.0, 12.0, 22.0, 33.0)
    assert CURVES["slope"].integral(np.array(KNOTS)) == pytest.approx(heights, rel=1e-14)


def test_formulas_meet_their_ends_and_middle():
    barrel = CURVES["parabola"]
    assert barrel.value([0.0, 3.0, 6.0]) == pytest.approx([20.0, 26.0, 20.0])
