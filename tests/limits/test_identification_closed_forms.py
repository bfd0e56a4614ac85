"""Limits: linear data under normal errors have a posterior, an evidence and percentiles in closed
form; methods must meet them.

Further: stated intervals hold the truth as often as they say, both branches of a case with two are
found, and what the data cannot determine
is said.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import norm

import valvetrain as vt
from valvetrain.views.results import answer_of

#: Three linear data of two quantities, with normal priors.
SLOPES = np.array([[1.0, 1.0], [2.0, -2.0], [0.5, 1.0]])
VALUES, SCATTER = np.array([5.0, -3.0, 2.0]), np.array([0.5, 4.0, 1.0])
CENTRE, SPREAD = np.array([1.0, 2.0]), np.array([2.0, 5.0])
COVARIANCE = np.linalg.inv(SLOPES.T @ np.diag(SCATTER**-2) @ SLOPES + np.diag(SPREAD**-2))
MEAN = COVARIANCE @ (SLOPES.T @ (VALUES / SCATTER**2) + CENTRE / SPREAD**2)
#: Distribution of the data before they are seen.
OPEN = SLOPES @ np.diag(SPREAD**2) @ SLOPES.T + np.diag(SCATTER**2)
MISS = VALUES - SLOPES @ CENTRE
LOG_EVIDENCE = (
    -0.5 * MISS @ np.linalg.solve(OPEN, MISS) - 0.5 * np.linalg.slogdet(2 * np.pi * OPEN)[1]
)
PRIORS = {
    name: vt.explore.Prior("normal", centre=CENTRE[k], spread=SPREAD[k])
    for k, name in enumerate(("one", "two"))
}
DATA = [vt.explore.Datum(f"number {k}", VALUES[k], SCATTER[k]) for k in range(3)]


def linear(points: np.ndarray) -> list[dict[str, float]]:
    return [
        {f"number {k}": float(value) for k, value in enumerate(SLOPES @ point)} for point in points
    ]


@pytest.fixture(scope="module")
def found() -> vt.explore.Identified:
    return vt.identify(PRIORS, DATA, linear, search=vt.explore.Search(draws=2000))


def test_least_squares_meet_posterior_and_evidence(found: vt.explore.Identified) -> None:
    got = found.branches[0].quantities
    np.testing.assert_allclose([one.best for one in got.values()], MEAN, rtol=1e-6)
    np.testing.assert_allclose(
        [one.deviation for one in got.values()], np.sqrt(np.diag(COVARIANCE)), rtol=1e-6
    )
    np.testing.assert_allclose(
        [one.low for one in got.values()],
        norm.ppf(0.025, MEAN, np.sqrt(np.diag(COVARIANCE))),
        rtol=1e-5,
    )
    correlation = COVARIANCE[0, 1] / math.sqrt(COVARIANCE[0, 0] * COVARIANCE[1, 1])
    assert found.branches[0].correlation[0, 1] == pytest.approx(correlation, rel=1e-6)
    assert found.log_evidence == pytest.approx(LOG_EVIDENCE, rel=1e-9), (
        "a normal posterior is its own Laplace approximation"
    )
    assert not found.note, "its linearised posterior holds"


def test_percentiles_of_measurements_are_those_of_their_prediction(
    found: vt.explore.Identified,
) -> None:
    """What would be measured is normal about the computed mean, with the variance of computation
    and error together.
    """
    variance = np.diag(SLOPES @ COVARIANCE @ SLOPES.T) + SCATTER**2
    due = 100 * norm.cdf((VALUES - SLOPES @ MEAN) / np.sqrt(variance))
    np.testing.assert_allclose([one.percentile for one in found.predicted], due, atol=0.4)
    spread = np.sqrt(np.diag(SLOPES @ COVARIANCE @ SLOPES.T))
    np.testing.assert_allclose(
        [one.middle for one in found.predicted], SLOPES @ MEAN, atol=0.03 * spread.max()
    )
    np.testing.assert_allclose(
        [one.high - one.low for one in found.predicted], 2 * norm.ppf(0.975) * spread, rtol=0.06
    )


def test_information_is_that_of_the_linear_model(found: vt.explore.Identified) -> None:
    told = found.branches[0].information
    np.testing.assert_allclose(told.determined, 1 - np.diag(COVARIANCE) / SPREAD**2, rtol=1e-6)


def test_nested_sampling_meets_posterior_and_evidence() -> None:
    got = vt.identify(PRIORS, DATA, linear, search=vt.explore.Search("nested", live_points=300))
    deviation = np.sqrt(np.diag(COVARIANCE))
    np.testing.assert_allclose(
        [one.mean for one in got.branches[0].quantities.values()], MEAN, atol=0.15 * deviation.max()
    )
    np.testing.assert_allclose(
        [one.deviation for one in got.branches[0].quantities.values()], deviation, rtol=0.12
    )
    assert len(got.branches) == 1
    assert got.log_evidence == pytest.approx(LOG_EVIDENCE, abs=0.1)


def surge(points: np.ndarray) -> list[dict[str, float]]:
    """A spring's force at 7 mm, its first surge frequency, and its energy there."""
    return [
        {
            "force": 7e-3 * rate,
            "surge": 0.5 * math.sqrt(rate / mass),
            "energy": 0.5 * rate * 7e-3**2,
        }
        for rate, mass in points
    ]


def test_stated_intervals_hold_the_truth_as_often_as_they_say() -> None:
    """400 springs drawn from the prior, measured with noise: intervals of 95 % hold the true rate
    and mass in 90 to 98 of 100.
    """
    priors = {
        "rate": vt.explore.Prior("normal", centre=40e3, spread=6e3),
        "mass": vt.explore.Prior("lognormal", centre=0.05, spread=0.2),
    }
    scatter = {"force": 3.0, "surge": 6.0, "energy": 0.02}
    random = np.random.default_rng(11)
    inside = {"rate": 0, "mass": 0}
    for _ in range(400):
        true = {
            "rate": random.normal(40e3, 6e3),
            "mass": 0.05 * math.exp(0.2 * random.standard_normal()),
        }
        (computed,) = surge(np.array([[true["rate"], true["mass"]]]))
        data = [
            vt.explore.Datum(key, random.normal(computed[key], one), one)
            for key, one in scatter.items()
        ]
        got = (
            vt.identify(priors, data, surge, search=vt.explore.Search(draws=1))
            .branches[0]
            .quantities
        )
        for name in inside:
            inside[name] += got[name].low <= true[name] <= got[name].high
    assert 360 <= inside["rate"] <= 392 and 360 <= inside["mass"] <= 392, inside


def square(points: np.ndarray) -> list[dict[str, float]]:
    """An offset that shows by its square alone: either sign fits; a second quantity leans on it."""
    return [{"square": offset**2, "sum": offset + other} for offset, other in points]


@pytest.mark.parametrize(
    "search",
    [vt.explore.Search("nested", live_points=300), vt.explore.Search(starts=20, keep=6)],
    ids=["nested", "starts"],
)
def test_both_branches_are_found_and_weighed(search: vt.explore.Search) -> None:
    """Shares by the densities of ``sum`` at either sign: normal of variance 1 + 0.3^2 about zero."""
    priors = {
        "offset": vt.explore.Prior("uniform", -2.0, 3.0),
        "other": vt.explore.Prior("normal", centre=0.0, spread=1.0),
    }
    got = vt.identify(
        priors,
        [vt.explore.Datum("square", 1.0, 0.1), vt.explore.Datum("sum", 0.5, 0.3)],
        square,
        search=search,
    )
    assert answer_of(got).findings.by("I105")[0].fields["count"] == "2"
    due = norm.pdf([0.5, 1.5], 0.0, math.sqrt(1.09))
    assert [math.copysign(1, branch.quantities["offset"].best) for branch in got.branches] == [
        1.0,
        -1.0,
    ]
    assert got.branches[0].share == pytest.approx(due[0] / due.sum(), abs=0.12)
    for branch in got.branches:
        assert abs(branch.quantities["offset"].best) == pytest.approx(1.0, abs=0.02)
        assert branch.quantities["offset"].deviation == pytest.approx(0.05, rel=0.25)


def test_springs_in_parallel_cannot_be_told_apart_and_it_is_said() -> None:
    """Of two rates in parallel a load tells the sum; a second load at another compression changes
    nothing, a frequency of one does.
    """
    priors = {
        name: vt.explore.Prior("normal", centre=centre, spread=5e3)
        for name, centre in (("outer rate", 30e3), ("inner rate", 15e3))
    }

    def parallel(points: np.ndarray) -> list[dict[str, float]]:
        return [
            {
                "seat": 7e-3 * (one + two),
                "open": 17e-3 * (one + two),
                "surge": 0.5 * math.sqrt(two / 0.02),
            }
            for one, two in points
        ]

    loads = [vt.explore.Datum("seat", 320.0, 2.0), vt.explore.Datum("open", 777.0, 4.0)]
    found = vt.identify(priors, loads, parallel)
    assert found.branches[0].information.groups == ((0, 1),)
    assert answer_of(found).verdict.code == "I103"
    more = [*loads, vt.explore.Datum("surge", 430.0, 2.0)]
    assert vt.identify(priors, more, parallel).branches[0].information.groups == ()


def test_a_quantity_that_no_datum_depends_on_is_named() -> None:
    priors = {
        "rate": vt.explore.Prior("uniform", 20e3, 60e3),
        "mass": vt.explore.Prior("normal", centre=0.05, spread=0.01),
    }
    found = vt.identify(priors, [vt.explore.Datum("force", 280.0, 2.0)], surge)
    assert found.branches[0].information.determined[1] == pytest.approx(0.0, abs=1e-6)
    assert answer_of(found).verdict.fields["names"] == "mass"


def test_three_quantities_that_show_as_one_sum_are_named_together() -> None:
    priors = {name: vt.explore.Prior("normal", centre=1.0, spread=1.0) for name in "abc"}
    found = vt.identify(
        priors,
        [vt.explore.Datum("sum", 3.0, 0.1)],
        lambda points: [{"sum": float(p.sum())} for p in points],
    )
    groups = found.branches[0].information.groups
    assert {place for group in groups for place in group} == {0, 1, 2}
