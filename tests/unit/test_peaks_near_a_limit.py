"""Unit: a peak between the points of a grid is looked into where its parabola, with caution, may
leave the bound; solver times as noted.
"""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.explore.limit_speed import CAUTION, _nearing
from valvetrain.runs.critical_scan import parabola_depth


@pytest.mark.parametrize(
    ("x", "y"),
    [
        ((0, 1, 2), (0, 1, 0)),
        ((0, 1, 2), (0, 1, 0.5)),
        ((0, 1, 3), (-2, 1, 0.9)),
        ((100, 150, 175), (0.3, 0.9, 0.9)),
        ((0, 2, 3), (0.9, 1, -4)),
    ],
)
def test_the_top_of_a_parabola_by_numpy(x, y):
    bend, slope, base = np.polyfit(x, y, 2)
    assert parabola_depth(x, -np.array(y, dtype=float)) == pytest.approx(
        base - slope**2 / (4 * bend) - y[1], abs=1e-9
    )


@pytest.mark.parametrize("y", [(0.0, 1.0, 2.0), (1.0, 0.0, 1.0), (3.0, 3.0, 3.0)])
def test_what_is_no_peak_rises_nowhere(y):
    assert parabola_depth(np.arange(3.0), -np.array(y)) == 0.0


SPEEDS = [1000.0, 1400.0, 1800.0, 2200.0]


@pytest.mark.parametrize(
    ("share", "near"), [(0.9, []), (1.1, [1200.0, 1600.0]), (4.0, [1200.0, 1600.0])]
)
def test_a_peak_is_looked_into_where_a_rise_times_the_caution_reaches_the_bound(share, near):
    """The peak at 1400 lies at -1 / share of what the caution adds to it."""
    shape = np.array([-0.4, 0.0, -0.1, -9.0])
    rise = parabola_depth(SPEEDS[:3], -shape[:3])
    assert (
        rise
        == pytest.approx(
            np.polyval(np.polyfit(SPEEDS[:3], shape[:3], 2), 1400 + 400 * 0.15 / 0.5), abs=1e-9
        )
        and CAUTION > 1
    )
    assert _nearing(SPEEDS, list(shape - CAUTION * rise / share), 10.0) == near


def test_middles_finer_than_the_resolution_are_not_asked_for():
    top = [-1.0, -0.001, -1.0, -9.0]
    assert (
        _nearing([0.0, 15.0, 60.0, 90.0], top, 10.0) == [37.5]
        and _nearing([0.0, 15.0, 30.0, 90.0], top, 10.0) == []
    )
    assert (
        _nearing(SPEEDS, [-3.0, -2.0, -1e-9, -1e-9], 10.0) == [1600.0, 2000.0]
        and _nearing(SPEEDS, [-1.0, -1.0, -1.0, -1.0], 10.0) == []
    )
