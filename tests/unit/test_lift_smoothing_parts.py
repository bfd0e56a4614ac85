"""The smoothing of measured lifts part by part, to plain algebra: least squares, covariance,
likelihood, and the mean along the event.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import BSpline
from scipy.stats import multivariate_normal

from valvetrain.cam.closed_form import SinePower
from valvetrain.errors import InputError
from valvetrain.measured import lift_smoothing as smoothing
from valvetrain.quantities.plausible import lift_extremes, refuse_implausible_motion

ANGLES = np.sort(
    np.radians(np.arange(60.0, 161.0, 5.0)) + np.random.default_rng(2).uniform(-0.01, 0.01, 21)
)
LIFTS = 9e-3 * np.cos((ANGLES - np.radians(110)) / np.radians(50) * np.pi / 2).clip(0) ** 4
NOISY = LIFTS + np.random.default_rng(3).normal(0, 20e-6, len(LIFTS))


@pytest.fixture(scope="module")
def fit():
    return smoothing._Fit(ANGLES, NOISY, None, False)


def basis(knots: np.ndarray, derivative: int):
    """Free functions of the event one by one: three coefficients at either end are zero."""
    count = len(knots) - 6
    return [BSpline(knots, np.eye(count)[n], 5).derivative(derivative) for n in range(3, count - 3)]


def averaged(square: np.ndarray, window: int) -> np.ndarray:
    """Mean of each cell over as many neighbours on either side as there are, its largest one."""
    reach = min(window, (len(square) - 1) // 2)
    found = np.array([square[max(n - reach, 0) : n + reach + 1].mean() for n in range(len(square))])
    return np.maximum(found / found.max(), smoothing.MIN_SHARE)


def test_the_scale_is_the_expected_square_of_the_jerk_over_neighbours(fit):
    scale = fit._local_scale()
    draws = (
        fit.mean(fit.ratio)
        + np.random.default_rng(1).standard_normal((20000, fit.design.shape[1]))
        @ fit.factor(fit.ratio).T
    )
    square = np.mean((draws @ fit.jerk.T) ** 2, axis=0).reshape(-1, 4).mean(axis=1)
    assert scale.reshape(-1, 4) == pytest.approx(
        np.repeat(averaged(square, fit.window)[:, None], 4, axis=1), rel=0.05
    )
    per = np.arange(1.0, 21.0) ** 2
    given = np.repeat(per, 4)
    one = smoothing._Fit.__new__(smoothing._Fit)
    one.jerk, one.ratio, one.window = np.diag(np.sqrt(given)), 1.0, smoothing.WINDOW
    one.mean, one.factor = lambda ratio: np.ones(80), lambda ratio: np.zeros((80, 80))
    assert one._local_scale() == pytest.approx(
        np.repeat(averaged(per, smoothing.WINDOW), 4), rel=1e-12
    )


def test_the_mean_is_least_squares_with_the_jerk_held_down_and_its_factor_the_covariance(fit):
    functions, jerks = basis(fit.knots, 0), basis(fit.knots, 3)
    design = np.column_stack([one(ANGLES) for one in functions])
    assert fit.basis == pytest.approx(design, abs=1e-12)
    ratio = 1e7
    stretches = np.unique(fit.knots)
    scale = np.ones(len(stretches) - 1)
    penalty = np.zeros((len(jerks), len(jerks)))
    for i in range(len(jerks)):
        for j in range(max(i - 5, 0), min(i + 6, len(jerks))):
            penalty[i, j] = sum(
                quad(
                    lambda x, i=i, j=j: float(jerks[i](x)) * float(jerks[j](x)),
                    low,
                    high,
                    epsrel=1e-10,
                )[0]
                / one
                for low, high, one in zip(stretches, stretches[1:], scale, strict=False)
            )
    plain = smoothing._Fit.__new__(smoothing._Fit)
    plain.design, plain.lifts, plain.noise = design, NOISY, 2e-5
    plain.penalty = (fit.jerk * fit.weights[:, None]).T @ fit.jerk
    assert plain.penalty == pytest.approx(penalty, rel=1e-8, abs=1e-9 * penalty.max())
    whole = design.T @ design + penalty / ratio
    root = np.linalg.cholesky(penalty / ratio)
    stacked = np.linalg.lstsq(
        np.vstack([design, root.T]), np.append(NOISY, np.zeros(len(jerks))), rcond=None
    )[0]
    assert plain.mean(ratio) == pytest.approx(stacked, rel=1e-6, abs=1e-12)
    factor = plain.factor(ratio)
    assert factor @ factor.T == pytest.approx(2e-5**2 * np.linalg.inv(whole), rel=1e-6, abs=1e-22)


@pytest.mark.parametrize("stated", [None, 3e-5])
def test_the_likeliest_noise_and_ratio_are_those_of_the_density(fit, stated):
    """Lifts are normal with covariance s^2 (1 + r D P^-1 D'): no other ratio, nor another noise
    where none is stated, is likelier.
    """
    penalty = (fit.jerk * fit.weights[:, None]).T @ fit.jerk
    noise, ratio = smoothing._likeliest(fit.design, penalty, NOISY, stated, stated is not None)
    assert stated is None or noise == stated

    def density(noise: float, ratio: float) -> float:
        spread = np.eye(len(NOISY)) + ratio * fit.design @ np.linalg.solve(penalty, fit.design.T)
        return float(multivariate_normal(np.zeros(len(NOISY)), noise**2 * spread).logpdf(NOISY))

    best = density(noise, ratio)
    for factor in (0.8, 1.25):
        assert density(noise, ratio * factor) < best
        assert stated is not None or density(noise * factor, ratio) < best
    if stated is None:
        assert 10e-6 < noise < 35e-6


def test_an_event_begins_and_ends_at_the_scatter_of_its_base_circle():
    angles = np.radians(np.arange(0.0, 300.0))
    away = (angles - np.radians(150)) / np.radians(60)
    lifts = 9e-3 * np.where(np.abs(away) < 1, np.cos(away * np.pi / 2) ** 4, 0.0)
    scatter = np.random.default_rng(5).normal(0, 1e-6, 300)
    begin, end, base, runout, _ = smoothing._event(angles, lifts + scatter + 2e-4, None)
    assert base == pytest.approx(2e-4, abs=3e-7) and runout == pytest.approx(1e-6, rel=0.25)
    over = np.flatnonzero(lifts + scatter > base - 2e-4 + 4 * runout)
    # the lift below that is as wide as from there to eight times as much
    high = np.flatnonzero(lifts + scatter > base - 2e-4 + 8 * 4 * runout)
    assert begin == 2 * (over[0] - 1) - high[0] and end == 2 * (over[-1] + 1) - high[-1]
    assert smoothing._event(angles[92:209], lifts[92:209], None) == (0, 116, 0.0, 0.0, 0)
    wide = smoothing._event(angles, lifts + scatter, 100e-6)
    assert wide[0] <= 90 and wide[1] >= 210  # however large the noise, the whole lobe


def test_the_range_of_a_law_and_no_speed_at_all():
    law = SinePower(maximum_lift=9e-3, opening_start=1.0, closing_end=3.0)
    rate = np.pi / 2
    least, largest, first, second = lift_extremes(law)
    assert (least, largest) == pytest.approx((0.0, 9e-3), abs=2e-8)
    # sin^4: slope largest at 60 deg, 4 (3/4)^1.5 / 2; bend at the top, 4
    assert first == pytest.approx(
        9e-3 * rate * 4 * 0.75**1.5 * 0.5, rel=1e-4
    ) and second == pytest.approx(9e-3 * rate**2 * 4, rel=1e-4)
    refuse_implausible_motion(law, ())
    with pytest.raises(InputError, match="lift"):
        refuse_implausible_motion(
            SinePower(maximum_lift=0.9, opening_start=1.0, closing_end=3.0), ()
        )
    with pytest.raises(InputError):
        refuse_implausible_motion(law, (10.0, 1e5))


@pytest.mark.parametrize("scale", [1e-25, 1e-12, 1e12, 1e25])
def test_the_likeliest_noise_does_not_depend_on_the_unit_of_the_jerk(fit, scale):
    """A ratio of variances goes with the square of that unit."""
    noise, ratio = smoothing._likeliest(fit.design, fit.penalty, NOISY, None, False)
    found = smoothing._likeliest(fit.design, scale * fit.penalty, NOISY, None, False)
    assert found == pytest.approx((noise, scale * ratio), rel=1e-4)
