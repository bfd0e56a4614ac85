"""Sobol indices beside the closed form of Ishigami and Homma (1990), and what makes a spread."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.explore.distributions import Uniform
from valvetrain.explore.samplers import sampler, sensitivity_of
from valvetrain.explore.space import Varied

NAMES = ("first", "second", "third")
ANGLES = tuple(Varied(name, distribution=Uniform(-np.pi, np.pi)) for name in NAMES)
RUN = (None, "", "")
A, B = 7.0, 0.1


def design(count, seed=1, varied=ANGLES):
    spec = sampler("saltelli")
    return spec.draw(varied, spec.read_options({"count": count, "seed": seed}))


def ishigami(points):
    return (
        np.sin(points[:, 0])
        + A * np.sin(points[:, 1]) ** 2
        + B * points[:, 2] ** 4 * np.sin(points[:, 0])
    )


def closed_form():
    """First-order and total indices, from the variances of the function's parts."""
    one, two = 0.5 * (1 + B * np.pi**4 / 5) ** 2, A**2 / 8
    both = 8 * B**2 * np.pi**8 / 225
    whole = one + two + both
    return np.array([one, two, 0]) / whole, np.array([one + both, two, both]) / whole


def test_indices_of_the_ishigami_function_are_those_of_its_closed_form():
    found = sensitivity_of("peak_spring_force", RUN, NAMES, ishigami(design(20480)))
    first, total = closed_form()
    assert found.first == pytest.approx(first, abs=0.02) and found.total == pytest.approx(
        total, abs=0.02
    )
    assert found.rows == 4096 and found.dropped == 0


def test_intervals_hold_the_closed_form_about_as_often_as_they_say():
    """Six true values in each of 30 designs; 95 % is 171 of 180, and fewer than 155 would be a
    chance of one in ten thousand.
    """
    first, total = closed_form()
    inside = 0
    for seed in range(30):
        found = sensitivity_of("peak_spring_force", RUN, NAMES, ishigami(design(640, seed)))
        for true, interval in ((first, found.first_interval), (total, found.total_interval)):
            inside += int(np.count_nonzero((interval[:, 0] <= true) & (true <= interval[:, 1])))
    assert inside >= 155


def test_the_quantity_that_makes_the_spread_is_named():
    points = design(640)
    told = sensitivity_of("peak_spring_force", RUN, NAMES, 10 * points[:, 1] + points[:, 0])
    assert np.argmax(told.total) == 1
    assert told.total_interval[1, 0] > told.total_interval[[0, 2], 1].max()


def test_base_rows_with_a_failed_point_are_left_out_and_counted():
    points = design(5120)
    values = ishigami(points)
    rows = len(values) // 5
    values[[3, rows + 3, 2 * rows + 10]] = np.nan
    told = sensitivity_of("peak_spring_force", RUN, NAMES, values)
    assert told.dropped == 2 and told.rows == rows - 2
    assert told.total == pytest.approx(closed_form()[1], abs=0.05)
    values[10:] = np.nan
    assert sensitivity_of("peak_spring_force", RUN, NAMES, values) is None
