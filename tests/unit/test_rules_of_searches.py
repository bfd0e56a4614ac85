"""Unit: rules of searches: steps of differences, draws within bounds, what is asked for in which
order.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ndtr

from valvetrain.errors import InputError
from valvetrain.explore.draws import draws_of_peak
from valvetrain.explore.least_squares import Peak, covariance_of, least_squares, profile
from valvetrain.explore.posterior import Datum, Posterior, Unknown
from valvetrain.explore.space import Prior

BEGIN = np.array([0.25, 3.0])


def line(asked: list[tuple[float, float]]) -> Posterior:
    """Two quantities of which the sum and the difference are known; ``asked`` takes down every
    point.
    """

    def evaluate(points):
        asked.extend(map(tuple, points))
        return [{"sum": a + b, "difference": a - b} for a, b in points]

    unknowns = Unknown("a", Prior("uniform", -4.0, 4.0)), Unknown("b", Prior("uniform", 0.0, 9.0))
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


def test_a_profile_goes_from_the_best_to_two_and_a_half_deviations_on_either_side():
    """Sum and difference known to 0.1 each leave 0.05 sqrt(2) of a; its profile is a parabola of
    that width, the values lie within the bounds, and beyond what can be it is not a number.
    """
    posterior = line([])
    peak = least_squares(posterior, BEGIN)
    found = profile(posterior, peak, "a")
    away = (found.values - 1.0) / (0.05 * math.sqrt(2.0))
    assert away == pytest.approx(np.linspace(-2.5, 2.5, 9), abs=0.01)
    assert found.misfit == pytest.approx(away**2, abs=1e-3)
    with pytest.raises(InputError, match="no quantity 'c' to profile; choose from a, b"):
        profile(posterior, peak, "c")


def test_a_profile_of_one_quantity_is_the_misfit_itself():
    """Data 4 +- 0.1 and -2 +- 0.1 of the quantity and of its opposite: squares of the misses by
    their scatter; nothing beyond 3.
    """

    def evaluate(points):
        return [None if a > 3.0 else {"sum": a, "difference": -a} for (a,) in points]

    posterior = Posterior(
        (Unknown("a", Prior("uniform", -4.0, 4.0)),),
        (Datum("sum", 4.0, 0.1), Datum("difference", -2.0, 0.1)),
        evaluate,
    )
    slope = math.sqrt(posterior.spread[0] ** 2 / 0.64 - 1.0)  # leaves a deviation of 0.8
    found = profile(posterior, Peak(np.array([2.0]), {}, 400.0, np.array([[slope], [0.0]])), "a")
    assert found.values == pytest.approx(2.0 + 0.5 * np.arange(-4, 5))
    due = [((4 - a) ** 2 + (2 - a) ** 2) / 0.01 if a <= 3 else np.nan for a in found.values]
    assert found.misfit == pytest.approx(due, nan_ok=True)
