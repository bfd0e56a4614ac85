"""Unit: what meeting a missed measurement costs the others, from computed points of known misfits."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.explore.fit import conflicts_of
from valvetrain.explore.identify import identify
from valvetrain.explore.posterior import Datum, Posterior, Unknown
from valvetrain.explore.space import Prior

#: Three measurements of x itself: two at 10 and one at 20, each within 1; the prior is even.
DATA = (
    Datum("a", 10.0, 1.0),
    Datum("b", 10.0, 1.0),
    Datum("c", 20.0, 1.0),
    Datum("compared", 99.0, 1.0, used=False),
)
GRID = np.arange(0.0, 40.0, 0.5)


def outcome(x):
    return {one.key: x for one in DATA}


def conflicts(points, best, prior=Prior("uniform", 0.0, 40.0)):
    posterior = Posterior((Unknown("x", prior),), DATA, lambda points: [None] * len(points))
    return conflicts_of(
        posterior, (np.array([best]), outcome(best)), [(np.array([x]), told) for x, told in points]
    )


def test_cost_and_what_is_missed_instead_are_those_of_the_likeliest_point_that_meets_it():
    """2 (x - 10)^2 + (x - 20)^2 is least at 13.5 of the grid (66.75), within 2 of 20 at 18 (132),
    within 2 of 10 at 12 (72).
    """
    found = conflicts([(x, outcome(x)) for x in GRID], 13.5)
    assert [(one.datum.key, one.off, one.meeting) for one in found] == [
        ("c", -6.5, 9),
        ("a", 3.5, 9),
        ("b", 3.5, 9),
    ]
    assert found[0].cost == pytest.approx(132 - 66.75) and found[1].cost == pytest.approx(
        72 - 66.75
    )
    assert [(datum.key, off) for datum, off in found[0].instead] == [("a", 8.0), ("b", 8.0)]
    assert [(datum.key, off) for datum, off in found[1].instead] == [("c", -8.0)]


def test_the_prior_counts_in_the_cost():
    """With a prior of 10 +- 1 the least of 3 (x - 10)^2 + (x - 20)^2 on the grid is at 12.5 (75),
    within 2 of 20 at 18 (196).
    """
    (one,) = (
        one
        for one in conflicts(
            [(x, outcome(x)) for x in GRID], 12.5, Prior("normal", centre=10.0, spread=1.0)
        )
        if one.datum.key == "c"
    )
    assert one.cost == pytest.approx(196 - 75) and one.off == -7.5


def test_what_no_computed_point_meets_has_no_cost():
    found = conflicts([(x, outcome(x)) for x in GRID[GRID < 15]], 13.5)
    assert (
        [one.datum.key for one in found] == ["c", "a", "b"]
        and found[0].meeting == 0
        and np.isnan(found[0].cost)
        and not found[0].instead
    )


def test_impossible_points_and_those_that_lack_a_number_or_lie_outside_the_priors_count_for_none():
    points = [(18.0, None), (18.0, {"c": 18.0}), (13.5, outcome(13.5))]
    assert [(one.datum.key, one.meeting) for one in conflicts(points, 13.5)] == [
        ("c", 0),
        ("a", 0),
        ("b", 0),
    ]
    inside = conflicts([*points, (18.0, outcome(18.0))], 13.5)
    assert [one.meeting for one in inside] == [1, 0, 0]
    assert [
        one.meeting for one in conflicts([(18.0, outcome(18.0))], 13.5, Prior("uniform", 0.0, 17.0))
    ] == [0, 0, 0]


def test_the_likeliest_point_is_the_one_that_is_told_whatever_its_misfit():
    """Another branch may have the smaller misfit and the smaller probability: then the cost is
    negative.
    """
    (c, *_) = conflicts([(x, outcome(x)) for x in GRID], 30.0)
    assert c.datum.key == "a" and c.off == 20.0 and c.cost == pytest.approx(72 - 900)


def test_of_a_measurement_of_many_values_the_worst_stands_for_it():
    """A level line of 3 000 points through a slope: one row, whatever the number of values and of
    points.
    """
    stations = np.linspace(0.0, 1.0, 300)
    slope = [Datum(f"at {x:.4f}", 10.0 * x, 0.5, measurement="trace") for x in stations]
    posterior = Posterior(
        (Unknown("level", Prior("uniform", 0.0, 10.0)),),
        (*slope, Datum("mean", 9.0, 0.5)),
        lambda points: [],
    )
    points = [
        (np.array([x]), {one.key: x for one in (*slope, Datum("mean", 9.0, 0.5))})
        for x in np.linspace(0.0, 10.0, 3001)
    ]
    best = points[1530]
    found = conflicts_of(posterior, best, points)
    assert [(one.datum.name, round(one.off, 3)) for one in found] == [
        ("trace", 10.2),
        ("mean", -7.8),
    ]
    assert found[0].datum.key == "at 0.0000" and found[0].meeting == 301 and found[1].meeting == 601
    assert [(datum.key, round(off, 2)) for datum, off in found[1].instead] == [("at 0.0000", 16.0)]
    beyond = np.sum(np.abs(best[0][0] - 10.0 * stations) > 1.0)
    assert [one.values for one in found] == [beyond, 1]


def test_without_a_missed_measurement_there_is_no_conflict():
    data = [Datum("a", 10.0, 1.0), Datum("b", 11.0, 1.0)]
    assert (
        identify(
            {"x": Prior("uniform", 0.0, 40.0)},
            data,
            lambda points: [{"a": x, "b": x} for (x,) in points],
        ).conflicts
        == ()
    )
