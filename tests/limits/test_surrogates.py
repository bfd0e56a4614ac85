"""Limits: the error that a surrogate states is that of processes fitted without each point, holds for
functions that are known, and is not asked beyond its points.
"""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.explore.samplers import COUNT, sequence
from valvetrain.explore.surrogate import Surrogate, left_out, surrogate_of

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
    assert one.share > 0.9 and one.sentence.endswith("so it cannot replace a run.")


def test_beyond_its_points_a_surrogate_is_refused_by_name() -> None:
    one = fitted(fold)
    assert np.isfinite(one.predict([[one.low[0], one.high[1] + 0.01]])[0]).all()
    for point in ([0.5, 1.2], [0.5, -0.2], [0.5, np.nan]):
        with pytest.raises(vt.InputError, match=r"coil.*beyond"):
            one.predict([[0.5, 0.5], point])


def test_studies_draw_sobols_sequence_by_default() -> None:
    """The mean of a product of two even quantities is 1/4: within 0.001 by 128 points."""
    even = vt.explore.Prior("uniform", 0.0, 1.0)
    outputs = vt.Outputs(["area"], function=lambda x, y: x * y)
    table = vt.Experiment(None, vt.Space({"x": even, "y": even}), outputs).sample(workers=1)
    assert len(table) == COUNT == 128
    assert float(np.mean(table.values)) == pytest.approx(0.25, abs=1e-3)
