"""Limits: the error that a surrogate states is that of processes fitted without each point, holds for
functions that are known, and is not asked beyond its points.
"""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.explore.samplers import COUNT, sequence
from valvetrain.explore.surrogate import Surrogate, dependences_of, left_out, surrogate_of

pytest.importorskip("sklearn")
RUN = (None, "", "")


def fitted(function, count: int = 64, seed: int = 1, noise: float = 0.0) -> Surrogate:
    points = sequence(2, count, seed)
    values = function(points) + noise * np.random.default_rng(seed).standard_normal(count)
    found = surrogate_of("preload", RUN, ("wire", "coil"), points, values)
    assert found is not None
    return found


def fold(x: np.ndarray) -> np.ndarray:
    """A function with a kink, as of a stop that is reached."""
    return np.abs(x[:, 0] - 0.4) + x[:, 1]


def test_points_left_out_are_those_of_processes_without_them() -> None:
    """Limit: the same kernel fitted anew to all points but one."""
    from sklearn.gaussian_process import GaussianProcessRegressor

    one = fitted(fold, 24)
    cube = (sequence(2, 24, 1) - one.centre) / one.scale
    scaled = (one.computed - np.mean(one.computed)) / np.std(one.computed)
    miss, deviation = left_out(one.process)
    for k in range(0, 24, 5):
        others = np.arange(24) != k
        process = GaussianProcessRegressor(one.process.kernel_, optimizer=None)
        process.fit(cube[others], scaled[others])
        mean, spread = process.predict(cube[k : k + 1], return_std=True)
        size = np.std(one.computed)
        assert miss[k] == pytest.approx(size * (mean[0] - scaled[k]), rel=1e-4, abs=1e-6)
        assert deviation[k] == pytest.approx(size * spread[0], rel=1e-4)


@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_the_stated_error_is_about_the_true_one(noise: float) -> None:
    """Truth known: fresh points of the same function, with the same noise."""
    fresh = np.random.default_rng(9).random((2000, 2))
    for seed in (1, 2, 3):
        one = fitted(fold, 64, seed, noise)
        inside = np.clip(fresh, one.low, one.high)
        true = np.hypot(np.std(one.predict(inside)[0] - fold(inside)), noise)
        assert 0.7 < one.error / true < 2.5
        assert one.covered > 0.85 and one.share < 0.3


def test_a_surrogate_of_noise_does_not_stand_for_a_run() -> None:
    """False model: nothing but noise over the quantities."""
    one = fitted(lambda x: np.zeros(len(x)), noise=1.0)
    assert one.share > 0.9


def test_beyond_its_points_a_surrogate_is_refused_by_name() -> None:
    one = fitted(fold)
    assert np.isfinite(one.predict([[one.low[0], one.high[1] + 0.01]])[0]).all()
    for point in ([0.5, 1.2], [0.5, -0.2], [0.5, np.nan]):
        with pytest.raises(vt.InputError, match=r"coil.*beyond"):
            one.predict([[0.5, 0.5], point])


def ridge(count: int, seed: int, correlation: float) -> np.ndarray:
    """Even points (n, 2) in (0, 1) whose normal scores are correlated."""
    from scipy.stats import norm

    normal = np.random.default_rng(seed).standard_normal((count, 2))
    normal[:, 1] = correlation * normal[:, 0] + np.sqrt(1 - correlation**2) * normal[:, 1]
    return norm.cdf(normal)


def of_ridge(function, count: int = 64, seed: int = 1, correlation: float = 0.95) -> Surrogate:
    points = ridge(count, seed, correlation)
    found = surrogate_of("preload", RUN, ("wire", "coil"), points, function(points))
    assert found is not None
    return found


def stiff_off_the_ridge(x: np.ndarray) -> np.ndarray:
    """A function that on the ridge is all but its sum, and off it is not."""
    return x[:, 0] + x[:, 1] + 4 * np.maximum(np.abs(x[:, 0] - x[:, 1]) - 0.4, 0)


def test_off_the_points_of_dependent_quantities_a_surrogate_is_refused() -> None:
    """False there: the surrogate of a function that bends off the ridge errs by more than twenty times its own error."""
    one = of_ridge(stiff_off_the_ridge)
    off = [[one.low[0], one.high[1]], [one.high[0], one.low[1]]]
    there = one.process.predict((np.array(off) - one.centre) / one.scale)
    assert np.all(np.abs(there - stiff_off_the_ridge(np.array(off))) > 20 * one.error)
    for point in off:
        with pytest.raises(
            vt.InputError, match=r"wire and coil as they depend on each other .*0\.9"
        ):
            one.predict([[0.5, 0.5], point])


def test_along_dependent_quantities_a_surrogate_predicts() -> None:
    """Truth known: fresh points of the same law, one in a thousand of which may be further off than any."""
    for seed in (1, 2, 3):
        one = of_ridge(fold, 64, seed)
        fresh = ridge(1000, seed + 10, 0.95)
        fresh = fresh[np.all((fresh >= one.low) & (fresh <= one.high), axis=1)]
        (pair,) = one.dependences
        near = pair.distance((fresh - one.centre) / one.scale) <= 1.25 * pair.reach
        assert np.mean(near) > 0.99
        true = np.std(one.predict(fresh[near])[0] - fold(fresh[near]))
        assert 0.5 < one.error / true < 2.5
        assert np.isfinite(
            one.predict([[one.low[0], one.low[1]], [one.high[0], one.high[1]]])[0]
        ).all()


@pytest.mark.parametrize(("size", "count"), [(2, 16), (3, 64), (6, 128)])
def test_the_corners_of_independent_quantities_are_no_extrapolation(size: int, count: int) -> None:
    for seed in range(1, 6):
        points = sequence(size, count, seed)
        assert dependences_of((points - points.mean(axis=0)) / points.std(axis=0)) == ()
    one = fitted(fold)
    corners = [[x, y] for x in (one.low[0], one.high[0]) for y in (one.low[1], one.high[1])]
    assert np.isfinite(one.predict(corners)[0]).all()


def test_studies_draw_sobols_sequence_by_default() -> None:
    """The mean of a product of two even quantities is 1/4: within 0.001 by 128 points."""
    even = vt.explore.Prior("uniform", 0.0, 1.0)
    outputs = vt.Outputs(["area"], function=lambda x, y: x * y)
    table = vt.Experiment(None, vt.Space({"x": even, "y": even}), outputs).sample(workers=1)
    assert len(table) == COUNT == 128
    assert float(np.mean(table.values)) == pytest.approx(0.25, abs=1e-3)
