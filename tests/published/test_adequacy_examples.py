"""Published: Fisher's test against worked examples of textbooks, tables of F, and scipy's analysis
of variance.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from valvetrain.compare_test.adequacy import (
    AdequacyTest,
    adequacy_test,
    chance,
    critical_ratio,
)

#: Etch rates (angstrom per minute) at four powers, five runs each: Montgomery, Design and Analysis
#: of Experiments, the plasma etching
#: experiment; its analysis of variance prints the mean squares 22290.18 and 333.70 and F = 66.80.
ETCH = np.array([
    [575, 542, 530, 539, 570], [565, 593, 590, 579, 610], [600, 651, 610, 637, 629], [725, 700, 715, 685, 710],
], dtype=float)  # fmt: skip


def test_the_analysis_of_variance_of_a_textbook():
    """A model of one fitted number, the mean of all, is refuted by exactly the printed ratio where
    each power counts as independent.
    """
    found = replace(adequacy_test(ETCH.T, np.full(4, ETCH.mean()), fitted=1), independent=4.0)
    assert (found.adequacy, found.reproducibility, found.ratio) == pytest.approx(
        (22290.18, 333.70, 66.80), rel=2e-4
    )
    assert found.degrees == (3.0, 16.0) and not found.adequate
    other = stats.f_oneway(*ETCH)
    assert (found.ratio, found.p_value) == pytest.approx((other.statistic, other.pvalue), rel=1e-9)


def test_lack_of_fit_of_a_line_to_a_balanced_set():
    """A straight line through the same rates: sums of squares by numpy's least squares, the chance
    by scipy.
    """
    power = np.repeat([160.0, 180.0, 200.0, 220.0], 5)
    line = np.polyfit(power, ETCH.ravel(), 1)
    total = np.sum((ETCH.ravel() - np.polyval(line, power)) ** 2)
    pure = np.sum((ETCH - ETCH.mean(axis=1, keepdims=True)) ** 2)
    ratio = (total - pure) / 2 / (pure / 16)
    found = replace(
        adequacy_test(ETCH.T, np.polyval(line, [160.0, 180.0, 200.0, 220.0]), fitted=2),
        independent=4.0,
    )
    assert found.ratio == pytest.approx(ratio, rel=1e-9) and found.p_value == pytest.approx(
        stats.f.sf(ratio, 2, 16), rel=1e-9
    )


def test_printed_percentage_points_of_f():
    """5 % points as every table of F prints them, and the lack of fit of the bank example (Kutner
    and others, F = 14.80, 4 and 5).
    """
    for (first, second), point in {
        (3, 16): 3.24,
        (4, 30): 2.69,
        (1, 3): 10.13,
        (10, 60): 1.99,
        (4, math.inf): 2.37,
    }.items():
        assert critical_ratio(first, second) == pytest.approx(point, abs=0.006)
    assert chance(14.80, 4, 5) == pytest.approx(0.0056, abs=1e-4)


def test_stated_scatters_are_judged_by_chi_square():
    """With infinitely many degrees of freedom of reproducibility the ratio is chi square over its
    degrees of freedom.
    """
    found = AdequacyTest(mean_square=1.9, reproducibility=1.0, repeats=0, places=7, independent=7.0)
    assert found.p_value == pytest.approx(stats.chi2.sf(7 * 1.9, 7), rel=1e-6)
    assert found.critical == pytest.approx(stats.chi2.isf(0.05, 7) / 7, rel=1e-6)


def test_a_model_is_adequate_up_to_the_critical_ratio():
    for square in (3.0, 40.0):
        test = AdequacyTest(
            mean_square=square, reproducibility=2.0, repeats=6, places=100, independent=10.0
        )
        assert test.adequate is (square < 2 * critical_ratio(10, 50))


def test_a_difference_just_beyond_what_is_refutable_is_refuted():
    residuals = np.random.default_rng(4).standard_normal((6, 40))
    residuals -= residuals.mean(axis=0)
    reach = adequacy_test(residuals, np.zeros(40)).refutable
    assert adequacy_test(residuals, np.full(40, 0.999 * reach)).adequate
    assert not adequacy_test(residuals, np.full(40, 1.001 * reach)).adequate
