"""Stretches of cam angle on the ring: against plain counting on a fine grid."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.quantities.train_events import TURN, covered, shared, span_of, spans_above

FINE = np.arange(72000) * TURN / 72000


def mask(spans):
    return (
        np.any([(FINE - begin) % TURN < end - begin for begin, end in spans], axis=0)
        if spans
        else np.zeros(len(FINE), dtype=bool)
    )


def test_crossings_of_a_sine_are_met_between_the_samples():
    angle = np.arange(359) * TURN / 359
    (span,) = spans_above(angle, np.sin(angle - 5.5), 0.5)
    assert span == pytest.approx(
        (5.5 + np.pi / 6 - (TURN if 5.5 + np.pi / 6 > TURN else 0), 5.5 + 5 * np.pi / 6), abs=1e-4
    )
    assert (
        spans_above(angle, np.ones(359)) == [(0.0, TURN)]
        and spans_above(angle, -np.ones(359)) == []
    )


def test_neighbours_that_meet_at_one_sample_keep_their_own_ends():
    angle = np.arange(8) * TURN / 8
    values = np.array([-1.0, 1, 1, 0, 1, 1, -1, -1])
    first, second = spans_above(angle, values)
    assert first[1] == pytest.approx(second[0]) and second[1] - second[0] == pytest.approx(
        2.5 * TURN / 8
    )


@pytest.mark.parametrize("seed", range(5))
def test_shared_and_covered_are_what_counting_says(seed):
    draw = np.random.default_rng(seed)
    first, second = (
        [span_of(begin, begin + length) for begin, length in draw.uniform(0, [TURN, 2.5], (4, 2))]
        for _ in range(2)
    )
    both = mask(first) & mask(second)
    assert covered(first) == pytest.approx(np.mean(mask(first)) * TURN, abs=1e-3)
    assert covered(shared(first, second)) == pytest.approx(np.mean(both) * TURN, abs=2e-3)
