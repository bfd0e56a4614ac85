"""Unit: searches find known quantities, honour bounds, and do not depend on the number of workers."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from valvetrain.errors import InputError, MissingExtraError
from valvetrain.explore.distributions import Prior
from valvetrain.explore.draws import linear_draws
from valvetrain.explore.identification_file import Method, Search
from valvetrain.explore.identified import Identified
from valvetrain.explore.least_squares import least_squares
from valvetrain.explore.posterior import Datum, Posterior
from valvetrain.explore.solve import solve
from valvetrain.explore.space import Varied
from valvetrain.explore.store import Store

TRUE_RATE, TRUE_MASS = 42e3, 0.05
WIDE = (
    Varied("rate", distribution=Prior("uniform", 30e3, 60e3)),
    Varied("mass", distribution=Prior("uniform", 0.02, 0.09)),
)


def spring_numbers(points: np.ndarray) -> list[dict[str, float] | None]:
    """Closed forms of a uniform spring: force at 7 mm and first surge frequency; none is stiffer
    than 59 N/mm.
    """
    return [
        None if rate > 59e3 else {"force": rate * 7e-3, "surge": 0.5 * math.sqrt(rate / mass)}
        for rate, mass in points
    ]


def data_of(rate: float, mass: float, scatter: float = 1.0) -> tuple[Datum, ...]:
    return Datum("force", rate * 7e-3, scatter), Datum(
        "surge", 0.5 * math.sqrt(rate / mass), scatter
    )


SPRING = Posterior(WIDE, data_of(TRUE_RATE, TRUE_MASS), spring_numbers)


def solved(posterior: Posterior, search: Search) -> Identified:
    with Store(None) as journal:
        return solve(posterior, search, journal, np.array([50e3, 0.04]))


def test_known_parameters_are_recovered_without_a_prior_that_pulls() -> None:
    found = least_squares(SPRING, np.array([50e3, 0.04]))
    assert found.work[0] == pytest.approx(TRUE_RATE, rel=1e-6)
    assert found.work[1] == pytest.approx(TRUE_MASS, rel=1e-6)
    assert found.misfit < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("method", get_args(Method))
def test_each_method_finds_the_closed_form(method: str) -> None:
    """Rate from the force, mass from both; the spread of the rate is that of the force."""
    found = solved(SPRING, Search(method, live_points=200, starts=4))
    assert found.best["rate"] == pytest.approx(TRUE_RATE, rel=1e-3)
    assert found.best["mass"] == pytest.approx(TRUE_MASS, rel=1e-3)
    interval = found.branches[0].quantities["rate"]
    assert interval.deviation == pytest.approx(1.0 / 7e-3, rel=0.25)
    assert interval.low < TRUE_RATE < interval.high
    assert len(found.branches) == 1 and not found.branches[0].information.groups


def test_bounds_hold_even_when_the_data_lie_outside() -> None:
    far = (Datum("force", 62e3 * 7e-3, 1.0), Datum("surge", 300.0, 1.0))
    found = least_squares(Posterior(WIDE, far, spring_numbers), np.array([50e3, 0.04]))
    assert 30e3 <= found.work[0] <= 59e3, "beyond that no spring exists"
    assert 0.02 <= found.work[1] <= 0.09


def test_an_impossible_start_is_refused() -> None:
    with pytest.raises(InputError, match="no possible spring"):
        least_squares(SPRING, np.array([59.5e3, 0.04]))


@pytest.mark.parametrize(
    "method", ["least-squares", pytest.param("nested", marks=pytest.mark.long)]
)
def test_priors_that_hold_no_possible_point_are_refused(method) -> None:
    stiff = replace(
        SPRING, unknowns=(Varied("rate", distribution=Prior("uniform", 59.1e3, 60e3)), WIDE[1])
    )
    with pytest.raises(InputError, match="computed"):
        solved(stiff, Search(method, live_points=20))


@pytest.mark.parametrize(
    ("prior", "share", "value"),
    [
        (Prior("uniform", 2.0, 4.0), 0.25, 2.5),
        (Prior("log-uniform", 1.0, 100.0), 0.5, 10.0),
        (Prior("normal", centre=3.0, spread=2.0), 0.975, 3.0 + 2.0 * 1.959963984540054),
        (Prior("normal", low=3.0, centre=3.0, spread=2.0), 0.5, 3.0 + 2.0 * 0.6744897501960817),
        (Prior("lognormal", centre=3.0, spread=math.log(2.0)), 0.8413447460685429, 6.0),
    ],
)
def test_priors_have_the_quantiles_of_the_textbook(
    prior: Prior, share: float, value: float
) -> None:
    work = prior.from_share(share)
    assert float(prior.value(work)) == pytest.approx(value, rel=1e-9)
    assert float(prior.share(work)) == pytest.approx(share, rel=1e-9)
    low, high = prior.work_bounds
    at = np.linspace(low, high, 20001)
    assert np.trapezoid(np.exp(prior.log_density(at)), at) == pytest.approx(1.0, rel=1e-6)
    assert prior.log_density(low - 1.0) == -np.inf and prior.log_density(high + 1.0) == -np.inf


@pytest.mark.parametrize("given", [{"scatter": 0.0}, {"scatter": math.nan}, {"value": math.inf}])
def test_data_that_are_none_are_refused(given: dict[str, float]) -> None:
    with pytest.raises(InputError):
        Datum(**({"key": "force", "value": 1.0, "scatter": 1.0} | given))


@pytest.mark.parametrize("library", ["nautilus", "sklearn.cluster"])
def test_a_library_that_is_not_installed_is_named_with_its_remedy(library, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(MissingExtraError, match=r"pip install 'valvetrain\[studies\]'"):
        solved(SPRING, Search("nested", live_points=20))


def test_what_a_computation_raises_reaches_the_caller() -> None:
    calls = 0

    def fails(points: np.ndarray) -> list[dict[str, float] | None]:
        nonlocal calls
        calls += 1
        if calls == 3:
            raise ZeroDivisionError("here")
        return spring_numbers(points)

    with pytest.raises(ZeroDivisionError, match="here"):
        solved(replace(SPRING, evaluate=fails), Search("nested", live_points=30, lanes=4))


@pytest.mark.parametrize(("bend", "holds"), [(1e6, True), (0.3, False)])
@pytest.mark.parametrize("count", [3, 10])
def test_a_linearised_posterior_is_noted_where_it_does_not_hold(
    count: int, bend: float, holds: bool
) -> None:
    """Data b tanh(x / b): straight lines for a large b, whose posterior is normal; for a small b
    they flatten off beside the peak.
    """
    unknowns = tuple(
        Varied(f"x{place}", distribution=Prior("uniform", -50.0, 50.0)) for place in range(count)
    )

    def told(points: np.ndarray) -> list[dict[str, float]]:
        return [
            {f"y{place}": bend * math.tanh(value / bend) for place, value in enumerate(row)}
            for row in points.tolist()
        ]

    posterior = Posterior(
        unknowns, tuple(Datum(f"y{place}", 0.0, 1.0) for place in range(count)), told
    )
    peak = least_squares(posterior, np.full(count, 0.01))
    draws = linear_draws(posterior, [peak], [1.0], 400, 1)
    assert draws.work.shape == (400, count) and not np.any(draws.labels)
    assert np.std(draws.work, axis=0) == pytest.approx(np.ones(count), rel=0.1)
    assert (not draws.note) == holds
