"""Unit: rules of searches: steps of differences, draws within bounds, what is asked for in which order."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ndtr

from valvetrain.identification import solve
from valvetrain.identification.datum import Datum
from valvetrain.identification.draws import silent
from valvetrain.identification.least_squares import Peak
from valvetrain.identification.multistart import _inside
from valvetrain.identification.posterior import Posterior, Unknown
from valvetrain.identification.prior import Prior
from valvetrain.identification.search import Search
from valvetrain.studies.optimum.measure import REST, RUNS, Measure, measuring
from valvetrain.studies.points.point import Outcome

BEGIN = np.array([0.25, 3.0])


def line(asked: list[tuple[float, float]]) -> Posterior:
    """Two quantities of which the sum and the difference are known; ``asked`` takes down every point."""

    def evaluate(points):
        asked.extend(map(tuple, points))
        return [{"sum": a + b, "difference": a - b} for a, b in points]

    unknowns = Unknown("a", Prior("uniform", -4.0, 4.0)), Unknown("b", Prior("uniform", 0.0, 9.0))
    return Posterior(unknowns, (Datum("sum", 4.0, 0.1), Datum("difference", -2.0, 0.1)), evaluate)


@pytest.mark.parametrize("stated", [0.0, 0.07, 0.2])
@pytest.mark.parametrize("way", [solve._around, solve._ends])
def test_differences_are_taken_at_the_step_that_was_asked_for(way, stated):
    """A stated step is that of every difference, in standard deviations of the prior; 0 begins with 0.03 of them and refines."""
    asked: list[tuple[float, float]] = []
    posterior = line(asked)
    way(posterior, Search("least-squares", starts=1, keep=1, difference_step=stated, draws=20), BEGIN[None, :], silent)
    spread = np.array([8.0, 9.0]) / math.sqrt(12)
    points = np.array(asked)
    for place in range(2):
        shifted = BEGIN + (stated or 0.03) * spread * np.eye(2)[place]
        assert np.isclose(points, shifted, rtol=0, atol=1e-9).all(axis=1).any()
        found = points[np.isclose(points[:, 1 - place], 3.0 - 2.0 * place, atol=1e-3)]  # about the answer a = 1, b = 3
        away = np.abs(found[:, place] - (1.0 + 2.0 * place)) / spread[place]
        assert bool(np.isclose(away, stated, atol=2e-3).any()) if stated else not np.isclose(away, 0.03, atol=2e-3).any()


@pytest.mark.parametrize("count", [1, 2, 5, 40])
@pytest.mark.parametrize("centre", [(0.0, 4.5), (3.95, 0.05)])
def test_as_many_draws_lie_within_the_bounds_as_were_asked_for(count, centre):
    """In the middle of the bounds each draw lies in a slice of its own of either normal law, also where both are linked."""
    posterior = line([])
    peak = Peak(np.array(centre), {}, 0.0, np.zeros((2, 2)), np.array([[0.04, 0.03], [0.03, 0.09]]), 1)
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


AT_REST, RUNNING = ((None, "massless", "only"),), tuple((speed, "massless", "only") for speed in (400.0, 500.0))


@pytest.mark.parametrize(
    ("sources", "batches"),
    [
        ((REST,), [[(REST, AT_REST[0])]]),
        ((RUNS,), [[(RUNS, one) for one in RUNNING]]),
        ((RUNS, REST), [[(REST, AT_REST[0])], [(RUNS, one) for one in RUNNING]]),
        ((RUNS, RUNS, REST), [[(REST, AT_REST[0])], [(RUNS, one) for one in RUNNING]]),
        ((), []),
    ],
)
def test_a_design_asks_once_for_what_its_measures_need_and_at_rest_first(sources, batches):
    """No batch is empty: each costs a round of all designs that go on together."""
    measures = [
        Measure(source, f"number_{place}", AT_REST if source == REST else RUNNING, "a number") for place, source in enumerate(sources)
    ]
    going, asked = measuring(measures), []
    try:
        asks = next(going)
        while True:
            asked.append(asks)
            values = [{f"number_{place}": 10.0 * place + (run[0] or 0.0) for place in range(3)} for _, run in asks]
            asks = going.send([Outcome(values=one) for one in values])
    except StopIteration as end:
        found = end.value
    assert asked == batches and found.code == "completed" and not found.failure
    due = [10.0 * place + (0.0 if source == REST else 500.0) for place, source in enumerate(sources)]
    assert [found.values[one] for one in measures] == due
