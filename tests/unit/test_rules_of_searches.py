"""Unit: rules of searches: steps of differences, draws within bounds, what is asked for in which
order.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ndtr

from valvetrain.explore.distributions import Prior
from valvetrain.explore.draws import draws_of_peak
from valvetrain.explore.least_squares import Peak, covariance_of, least_squares
from valvetrain.explore.posterior import Datum, Posterior
from valvetrain.explore.space import Varied

BEGIN = np.array([0.25, 3.0])


def line(asked: list[tuple[float, float]]) -> Posterior:
    """Two quantities of which the sum and the difference are known; ``asked`` takes down every
    point.
    """

    def evaluate(points):
        asked.extend(map(tuple, points))
        return [{"sum": a + b, "difference": a - b} for a, b in points]

    unknowns = (
        Varied("a", distribution=Prior("uniform", -4.0, 4.0)),
        Varied("b", distribution=Prior("uniform", 0.0, 9.0)),
    )
    return Posterior(unknowns, (Datum("sum", 4.0, 0.1), Datum("difference", -2.0, 0.1)), evaluate)


@pytest.mark.parametrize("stated", [0.0, 0.07, 0.2])
def test_differences_are_taken_at_the_step_that_was_asked_for(stated):
    """A stated step is that of every difference, in standard deviations of the prior; 0 begins with
    0.03 of them and refines.
    """
    asked: list[tuple[float, float]] = []
    posterior = line(asked)
    least_squares(posterior, BEGIN, step=stated)
    spread = np.array([8.0, 9.0]) / math.sqrt(12)
    points = np.array(asked)
    for place in range(2):
        shifted = BEGIN + (stated or 0.03) * spread * np.eye(2)[place]
        assert np.isclose(points, shifted, rtol=0, atol=1e-9).all(axis=1).any()
        found = points[
            np.isclose(points[:, 1 - place], 3.0 - 2.0 * place, atol=1e-3)
        ]  # about the answer a = 1, b = 3
        away = np.abs(found[:, place] - (1.0 + 2.0 * place)) / spread[place]
        assert (
            bool(np.isclose(away, stated, atol=2e-3).any())
            if stated
            else not np.isclose(away, 0.03, atol=2e-3).any()
        )


def peak_at(*work: float) -> Peak:
    """A peak where sum and difference are known to a fifth of the priors' spread, linked."""
    return Peak(np.array(work), {}, 7.0, np.array([[4.0, 3.0], [0.0, 5.0]]))


@pytest.mark.parametrize("count", [1, 2, 5, 40])
@pytest.mark.parametrize("centre", [(0.0, 4.5), (3.95, 0.05)])
def test_as_many_draws_lie_within_the_bounds_as_were_asked_for(count, centre):
    """In the middle of the bounds each draw lies in a slice of its own of either normal law."""
    posterior, peak = line([]), peak_at(*centre)
    draws, heights = draws_of_peak(posterior, peak, count, np.random.default_rng(2))
    low, high = posterior.bounds
    assert len(draws) == count and np.all((draws >= low) & (draws <= high))
    root = np.linalg.cholesky(covariance_of(posterior, peak.jacobian))
    unit = np.linalg.solve(root, (draws - centre).T).T
    assert heights == pytest.approx(-0.5 * np.sum(unit**2, axis=1))
    if centre == (0.0, 4.5):
        for column in ndtr(unit).T:
            assert sorted(np.floor(column * count)) == list(range(count))


def test_a_peak_that_no_draw_stays_at_gives_none():
    draws, heights = draws_of_peak(line([]), peak_at(40.0, 4.5), 2, np.random.default_rng(2))
    assert not len(draws) and not len(heights)
