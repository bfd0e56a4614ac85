"""Unit: rules of searches: steps of differences, draws within bounds, what is asked for in which
order.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ndtr

from valvetrain.errors import InputError
from valvetrain.explore import least_squares as profiles
from valvetrain.explore import solve
from valvetrain.explore.draws import silent
from valvetrain.explore.identification_file import Search
from valvetrain.explore.least_squares import Peak, _inside
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
    solve._ends(
        posterior,
        Search("least-squares", starts=1, keep=1, difference_step=stated, draws=20),
        BEGIN[None, :],
        silent,
    )
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


@pytest.mark.parametrize("count", [1, 2, 5, 40])
@pytest.mark.parametrize("centre", [(0.0, 4.5), (3.95, 0.05)])
def test_as_many_draws_lie_within_the_bounds_as_were_asked_for(count, centre):
    """In the middle of the bounds each draw lies in a slice of its own of either normal law, also
    where both are linked.
    """
    posterior = line([])
    peak = Peak(
        np.array(centre), {}, 0.0, np.zeros((2, 2)), np.array([[0.04, 0.03], [0.03, 0.09]]), 1
    )
    found = list(_inside(posterior, peak, count, np.random.default_rng(2)))
    assert len(found) == count
    draws = np.array([at for at, _ in found])
    low, high = posterior.bounds
    assert np.all((draws >= low) & (draws <= high))
    unit = np.linalg.solve(np.linalg.cholesky(peak.covariance), (draws - centre).T).T
    assert [height for _, height in found] == pytest.approx(-0.5 * np.sum(unit**2, axis=1))
    if centre == (0.0, 4.5):
        for column in ndtr(unit).T:
            assert sorted(np.floor(column * count)) == list(range(count))


def test_a_peak_that_no_draw_stays_at_gives_none():
    peak = Peak(np.array([40.0, 4.5]), {}, 0.0, np.zeros((2, 2)), 1e-4 * np.eye(2), 1)
    assert not list(_inside(line([]), peak, 2, np.random.default_rng(2)))


class Capturing:
    """Least squares that leave what is free where it began, and fail at values above 2."""

    def __init__(self) -> None:
        self.asked: list[tuple[tuple[float, ...], int, list[bool]]] = []

    def __call__(self, posterior, begin, *, iterations, free):
        if begin[0] > 2.0:
            raise InputError("no possible spring")
        self.asked.append((tuple(begin), iterations, free.tolist()))
        return Peak(begin + 0.5 * free, {}, 10.0 * begin[0], np.zeros((2, 2)), np.eye(2), 1)


def test_a_profile_goes_from_the_best_to_two_and_a_half_deviations_on_either_side(monkeypatch):
    """Four values a side within the bounds, each search from the end of the one before; what cannot
    be is not a number.
    """
    tried = Capturing()
    monkeypatch.setattr(profiles, "least_squares", tried)
    peak = Peak(np.array([0.0, 3.0]), {}, 7.0, np.zeros((2, 2)), np.diag([1.44, 0.09]), 1)
    told: list[str] = []
    found = profiles.profile(line([]), peak, "a", report=told.append)
    assert (
        found.name == "a"
        and found.values == pytest.approx(np.arange(-4, 5) * 0.75)
        and told == ["profile of a"] * 8
    )
    assert found.misfit == pytest.approx(
        [-30.0, -22.5, -15.0, -7.5, 7.0, 7.5, 15.0, np.nan, np.nan], nan_ok=True
    )
    starts = [begin for begin, _, _ in tried.asked]
    due = [(-0.75 * n, 3.0 + 0.5 * (n - 1)) for n in (1, 2, 3, 4)] + [(0.75, 3.0), (1.5, 3.5)]
    assert np.array(starts) == pytest.approx(np.array(due))
    assert all(iterations == 10 and free == [False, True] for _, iterations, free in tried.asked)
    near = profiles.profile(
        line([]),
        Peak(np.array([-3.0, 3.0]), {}, 7.0, np.zeros((2, 2)), np.diag([1.44, 0.09]), 1),
        "a",
    )
    assert near.values == pytest.approx([-4.0, -3.75, -3.5, -3.25, -3.0, -2.25, -1.5, -0.75, 0.0])
    with pytest.raises(InputError, match="no quantity 'c' to profile; choose from a, b"):
        profiles.profile(line([]), peak, "c")


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
    peak = Peak(np.array([2.0]), {}, 400.0, np.zeros((2, 1)), np.array([[0.64]]), 1)
    found = profiles.profile(posterior, peak, "a")
    assert found.values == pytest.approx(2.0 + 0.5 * np.arange(-4, 5))
    due = [((4 - a) ** 2 + (2 - a) ** 2) / 0.01 if a <= 3 else np.nan for a in found.values]
    assert found.misfit == pytest.approx(due, nan_ok=True)
