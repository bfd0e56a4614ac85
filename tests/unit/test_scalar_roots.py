"""The root that speeds and ramps are found by."""

from __future__ import annotations

from itertools import count

import numpy as np
import pytest
from scipy.optimize import brentq

from valvetrain.cam.pieces import solve


@pytest.mark.parametrize(
    "curve",
    [
        lambda x: x**3 - 2,
        lambda x: np.exp(x) - 3,
        lambda x: 0.5 - x,
        lambda x: np.arctan(20 * (x - 1.01)),
    ],
)
def test_a_root_is_that_of_scipy(curve):
    asked = count()

    def counted(x: float) -> float:
        next(asked)
        return float(curve(x))

    assert solve(counted, (0.0, 2.0)) == pytest.approx(
        brentq(curve, 0.0, 2.0, xtol=1e-15), rel=1e-13
    )
    assert next(asked) < 40
    assert solve(counted, (2.0, 0.0)) == pytest.approx(
        brentq(curve, 0.0, 2.0, xtol=1e-15), rel=1e-13
    )


def test_a_root_at_a_bound_between_equals_and_nowhere():
    assert solve(lambda x: x, (-1.0, 0.0)) == 0.0 and solve(
        lambda x: x, (0.0, 1.0)
    ) == pytest.approx(0.0, abs=1e-15)
    assert solve(lambda x: 0.0, (1.0, 2.0)) == 2.0
    assert (
        solve(lambda x: x + 3.0, (0.0, 1.0)) is None
        and solve(lambda x: -x - 3.0, (0.0, 1.0)) is None
    )
