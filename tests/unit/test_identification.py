"""Unit: the identification finds known parameters, honours bounds and does not depend on the number of workers."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

from valvetrain.errors import InputError
from valvetrain.studies.identification import Target, Unknown, identify

TRUE_RATE, TRUE_MASS = 42e3, 0.05
UNKNOWNS = (Unknown("rate", 30e3, 60e3, 50e3, 10e3), Unknown("mass", 0.02, 0.09, 0.04, 0.02))


def spring_numbers(vector: np.ndarray) -> dict[str, float] | None:
    """Closed forms of a uniform spring: force at 7 mm and first surge frequency."""
    rate, mass = vector
    if rate > 59e3:
        return None
    return {"force": rate * 7e-3, "surge": 0.5 * np.sqrt(rate / mass)}


def targets() -> tuple[Target, ...]:
    true = spring_numbers(np.array([TRUE_RATE, TRUE_MASS]))
    assert true is not None
    return Target("force", true["force"], 1.0), Target("surge", true["surge"], 1.0)


def test_known_parameters_are_recovered() -> None:
    with ThreadPoolExecutor(2) as pool:
        found = identify(UNKNOWNS, targets(), spring_numbers, pool, prior_weight=1e-6, iterations=30)
    assert found.parameters["rate"] == pytest.approx(TRUE_RATE, rel=1e-4)
    assert found.parameters["mass"] == pytest.approx(TRUE_MASS, rel=1e-4)
    assert found.misfit < 1e-4


def test_same_bits_for_any_number_of_workers() -> None:
    results = []
    for workers in (1, 3):
        with ProcessPoolExecutor(workers) as pool:
            results.append(identify(UNKNOWNS, targets(), spring_numbers, pool, iterations=6))
    assert results[0] == results[1]


def test_bounds_hold_even_when_the_data_lie_outside() -> None:
    far = (Target("force", 59.5e3 * 7e-3, 1.0), Target("surge", 300.0, 1.0))
    with ThreadPoolExecutor(2) as pool:
        found = identify(UNKNOWNS, far, spring_numbers, pool, iterations=20)
    for unknown in UNKNOWNS:
        assert unknown.low <= found.parameters[unknown.name] <= unknown.high
    assert found.parameters["rate"] <= 59e3, "beyond that no spring exists"


def test_an_impossible_start_is_refused() -> None:
    begin = (Unknown("rate", 30e3, 60e3, 59.5e3, 10e3), UNKNOWNS[1])
    with ThreadPoolExecutor(1) as pool, pytest.raises(InputError, match="no possible spring"):
        identify(begin, targets(), spring_numbers, pool)


def sum_and_difference(vector: np.ndarray) -> dict[str, float]:
    """A linear model: what it tells of its two numbers has a closed form."""
    return {"sum": vector[0] + vector[1], "difference": 2 * (vector[0] - vector[1])}


def test_standard_errors_and_draws_are_those_of_the_linear_model() -> None:
    """Posterior covariance inv(J' J / s^2 + 1 / p^2) of a linear model with normal priors."""
    unknowns = (Unknown("one", -100.0, 100.0, 1.0, 2.0), Unknown("two", -100.0, 100.0, 2.0, 5.0))
    wanted = (Target("sum", 5.0, 0.5), Target("difference", -3.0, 4.0))
    with ThreadPoolExecutor(1) as pool:
        found = identify(unknowns, wanted, sum_and_difference, pool, iterations=30)
    slope = np.array([[1.0, 1.0], [2.0, -2.0]]) / np.array([[0.5], [4.0]])
    covariance = np.linalg.inv(slope.T @ slope + np.diag([1 / 4, 1 / 25]))
    np.testing.assert_allclose(found.covariance, covariance, rtol=1e-6)
    assert list(found.standard_error) == ["one", "two"]
    np.testing.assert_allclose(list(found.standard_error.values()), np.sqrt(np.diag(covariance)), rtol=1e-6)
    draws = np.array(found.sample(unknowns, 4000, seed=3))
    np.testing.assert_allclose(draws.mean(axis=0), list(found.parameters.values()), atol=0.1)
    np.testing.assert_allclose(np.cov(draws.T), covariance, rtol=0.15)
    narrow = (Unknown("one", 0.9, 1.1, 1.0, 2.0), unknowns[1])
    assert np.all(np.abs(np.array(found.sample(narrow, 50))[:, 0] - 1.0) <= 0.1 + 1e-12)
