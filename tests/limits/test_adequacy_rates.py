"""Limits: how often a true model is refuted and its band left, how often a false one is found, on
synthesised repeats of known truth.

The scatter follows its neighbours along the angle; its harmonics are the same numbers whatever the
grid.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from valvetrain.compare_test.adequacy import (
    adequacy_test,
    difference_band,
    independent_places,
    ring_weights,
)
from valvetrain.compare_test.agreement import agreement, best_shift, shifted
from valvetrain.compare_test.comparison import SharedErrors
from valvetrain.errors import InputError

ANGLES = 144
TRIALS = 400


def repeats(draw, cycles, angles=ANGLES, reach=10.0, uneven=False):
    """Scatter (cycles, angles) of harmonics that fade out at ``reach``; ``uneven``: ten times as
    much about one angle.
    """
    turned = np.outer(np.arange(41), np.arange(angles) * 2 * np.pi / angles)
    drawn = draw.standard_normal((cycles, 2, 41)) * np.exp(-0.5 * (np.arange(41) / reach) ** 2)
    found = drawn[:, 0] @ np.cos(turned) + drawn[:, 1] @ np.sin(turned)
    return found * (0.3 + 3 * np.exp(-(((turned[1] - 3) / 0.4) ** 2))) if uneven else found


@pytest.mark.parametrize(
    ("cycles", "reach", "uneven"),
    [(2, 10.0, False), (5, 10.0, False), (12, 3.0, False), (8, 10.0, True)],
)
def test_a_true_model_is_refuted_one_time_in_twenty(cycles, reach, uneven):
    """And several times as often where every angle counts: these angles are no separate trials."""
    draw = np.random.default_rng(1)
    tests = [
        adequacy_test(
            repeats(draw, cycles, reach=reach, uneven=uneven), np.zeros(ANGLES), ring=True
        )
        for _ in range(TRIALS)
    ]
    refuted = np.mean([not test.adequate for test in tests])
    counted = np.mean(
        [not replace(test, independent=float(test.places)).adequate for test in tests]
    )
    assert 0.02 <= refuted <= 0.095 and counted > 0.2


def test_two_repeats_of_uneven_scatter_keep_no_level():
    """What the page says of fewer than four repeats: where the scatter is uneven, a true model is
    refuted far too often.
    """
    draw = np.random.default_rng(1)
    refuted = np.mean(
        [
            not adequacy_test(repeats(draw, 2, uneven=True), np.zeros(ANGLES), ring=True).adequate
            for _ in range(TRIALS)
        ]
    )
    assert refuted > 0.15


def test_a_known_bias_is_found_as_often_as_theory_says():
    """A bias in the mean of harmonic 0 alone, whose scatter has one degree of freedom: Student's
    power by its noncentral law.
    """
    from scipy import stats

    draw, cycles, bias = np.random.default_rng(2), 6, 1.2
    level = draw.standard_normal((TRIALS, cycles, 1)) + bias
    found = np.mean(
        [
            not adequacy_test(np.repeat(one, ANGLES, axis=1), np.zeros(ANGLES), ring=True).adequate
            for one in level
        ]
    )
    due = stats.ncf.sf(stats.f.isf(0.05, 1, cycles - 1), 1, cycles - 1, cycles * bias**2)
    assert found == pytest.approx(due, abs=0.06)


@pytest.mark.parametrize(
    ("cycles", "reach", "uneven"),
    [(4, 10.0, False), (8, 10.0, True), (15, 3.0, False), (15, 30.0, False)],
)
def test_the_band_holds_the_truth_at_all_angles_at_once(cycles, reach, uneven):
    draw = np.random.default_rng(3)
    bands = [
        difference_band(repeats(draw, cycles, reach=reach, uneven=uneven), np.zeros(ANGLES))
        for _ in range(TRIALS)
    ]
    held = np.mean([not band.outside.any() for band in bands])
    assert 0.92 <= held <= 0.99
    # Student's interval of each angle alone would leave the truth out somewhere on most turns
    single = np.mean(
        [np.all(np.abs(band.difference) <= band.half_width / band.factor * 2.2) for band in bands]
    )
    assert single < 0.7


@pytest.mark.parametrize("scale", [1.0, 3.0])
def test_the_verdict_does_not_depend_on_the_number_of_angles(scale):
    """The same repeats sampled 180, 720 and 2880 times: ratio, degrees of freedom, chance and band
    stay; counted chances do not.
    """
    found = []
    for angles in (180, 720, 2880):
        values = repeats(np.random.default_rng(5), 7, angles)
        model = scale * 0.3 * np.sin(2 * np.arange(angles) * 2 * np.pi / angles)
        test = adequacy_test(values, model, ring=True)
        found.append(
            (test.ratio, *test.degrees, test.p_value, difference_band(values, model).factor)
        )
    assert found[0] == pytest.approx(found[2], rel=5e-3) and found[1] == pytest.approx(
        found[2], rel=5e-4
    )


def test_independent_places_of_known_covariances():
    """Equal power in the harmonics up to K makes 2 K + 1 independent angles, white scatter makes
    all, one common level one.
    """
    draw = np.random.default_rng(6)
    turned = np.outer(np.arange(1, 13), np.arange(360) * 2 * np.pi / 360)
    flat = draw.standard_normal((200, 12)) @ np.cos(turned) + draw.standard_normal(
        (200, 12)
    ) @ np.sin(turned)
    for values, due in (
        (flat, 24.0),
        (draw.standard_normal((200, 360)), 360.0),
        (np.repeat(draw.standard_normal((200, 1)), 360, 1), 1.0),
    ):
        for some in (values, values[:12]):
            assert independent_places(some - some.mean(axis=0), ring=True) == pytest.approx(
                due, rel=0.12
            )


@pytest.mark.parametrize("degrees", [0.0, 0.13, -1.77, 12.4])
def test_a_known_shift_is_recovered_between_the_steps(degrees):
    """A closed form at 2 degree steps, turned by a known angle; with repeats, the interval holds
    it.
    """
    angle = np.arange(180) * 2 * np.pi / 180

    def curve(at):
        return np.exp(3 * np.cos(at - 3.0)) + 0.5 * np.cos(9 * at)

    late = np.radians(degrees)
    assert best_shift(curve(angle - late), curve(angle)) == pytest.approx(late, abs=1e-9)
    assert shifted(curve(angle), late) == pytest.approx(curve(angle - late), abs=1e-9)
    weights, even = ring_weights(angle)
    values = curve(angle) + 0.2 * repeats(np.random.default_rng(7), 9, 180)
    near = agreement(angle, values, curve(angle - late) + 0.4, weights, even)
    assert near.shift == pytest.approx(
        late, abs=2 * near.shift_reach
    ) and near.shift_reach < np.radians(1.0)
    assert near.bias == pytest.approx(0.4, abs=0.15) and near.rest < 0.35


def test_an_uneven_grid_counts_its_steps():
    """Angles twice as dense over half of the turn weigh half as much: bias of a step is the mean
    over the turn, not over the rows.
    """
    angle = np.concatenate([np.arange(0, 180, 1.0), np.arange(180, 360, 2.0)]) * np.pi / 180
    weights, even = ring_weights(angle)
    assert not even and weights.sum() == pytest.approx(1.0)
    assert float(weights @ (angle < np.pi)) == pytest.approx(0.5, abs=0.005)


def test_what_cannot_be_judged_is_refused():
    for values, words in (
        (np.ones((1, 20)), "no F-test"),
        (np.ones((3, 20)), "same number by number"),
    ):
        with pytest.raises(InputError, match=words):
            adequacy_test(values, np.zeros(20))
    with pytest.raises(InputError, match="none is left to test"):
        adequacy_test(np.random.default_rng(0).standard_normal((4, 5)), np.zeros(5), fitted=5)
    with pytest.raises(InputError, match="no band"):
        difference_band(np.ones((2, 20)), np.zeros(20))


def test_errors_that_all_repeats_share_are_counted():
    """An offset, a gain and an angle drawn once a test, standard deviations stated: a true model
    keeps its level and its band; without
    them it is refuted nearly always."""
    draw, angle = np.random.default_rng(10), np.arange(ANGLES) * 2 * np.pi / ANGLES
    shared = SharedErrors(offset=3.0, gain=0.02, cam_angle=0.03)

    def truth(at):
        return 200 + 100 * np.exp(6 * np.cos(at - 3.0) - 6)

    refuted, held, alone = [], [], []
    weights = np.full(ANGLES, 1 / ANGLES)
    for _ in range(TRIALS):
        offset, gain, late = draw.standard_normal(3) * (
            shared.offset,
            shared.gain,
            shared.cam_angle,
        )
        values = (1 + gain) * truth(angle - late) + offset + repeats(draw, 8)
        common = shared.shapes(angle, truth(angle))
        test = adequacy_test(values, truth(angle), ring=True, shared=tuple(common**2 @ weights))
        refuted.append(not test.adequate)
        alone.append(not adequacy_test(values, truth(angle), ring=True).adequate)
        held.append(not difference_band(values, truth(angle), shared=common).outside.any())
    assert 0.01 <= np.mean(refuted) <= 0.09 and np.mean(alone) > 0.7 and np.mean(held) >= 0.93


def in_a_circle(cycles, angles, harmonic):
    """Residuals a cos + b sin of a harmonic with a and b even, of length one and square to each
    other: their direction goes in a circle.
    """
    turned = harmonic * np.arange(angles) * 2 * np.pi / angles
    a, b = np.linalg.qr(np.column_stack([np.ones(cycles), np.eye(cycles)[:, :2]]))[0][:, 1:].T
    return np.outer(a, np.cos(turned)) + np.outer(b, np.sin(turned))


@pytest.mark.parametrize(("cycles", "harmonic"), [(4, 1), (6, 3), (12, 2)])
def test_the_width_of_a_band_is_that_of_the_path_of_its_directions(cycles, harmonic):
    """A circle a harmonic, 2 pi long: 2 k (1 + f^2 / n)^(-(n - 1) / 2) + P(|t| > f) is the level.
    The size of the scatter, also an uneven
    one, changes the standard errors alone."""
    from scipy import optimize, stats

    angles = 2880
    values, free = in_a_circle(cycles, angles, harmonic), cycles - 1
    due = optimize.brentq(
        lambda f: (
            2 * harmonic * (1 + f * f / free) ** (-(free - 1) / 2) + 2 * stats.t.sf(f, free) - 0.05
        ),
        1.0,
        200.0,
    )
    uneven = 1 + 0.9 * np.cos(np.arange(angles) * 2 * np.pi / angles)
    for size in (1.0, 1e-3, 700.0, uneven):
        band = difference_band(5.0 + size * values, np.zeros(angles))
        assert band.factor == pytest.approx(due, rel=1e-3)
        assert band.half_width == pytest.approx(
            due * size * np.ones(angles) / np.sqrt(cycles * free), rel=1e-3
        )
