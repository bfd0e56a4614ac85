"""Unit: what the log of a train's contacts notes of made-up motions, beside numpy and the motions
themselves.
"""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from valvetrain.integrate import train_log
from valvetrain.integrate.train_tuples import (
    ANGLE,
    CLOSES,
    HIGHEST,
    HIGHEST_ANGLE,
    LOWEST,
    LOWEST_ANGLE,
    MAX_FORCE,
    MAX_GAP,
    MAX_GAP_ANGLE,
    MIN_FORCE,
    MIN_FORCE_ANGLE,
    NOSE_FORCE,
    OPEN_FORCE,
    PEAK_FORCE,
    PEAK_FORCE_ANGLE,
    PLACE,
    RATE,
)

NAMES = (
    "crossing",
    "note_crossing",
    "close_stretch",
    "note_contact",
    "note_load",
    "note_loads",
    "nose_share",
    "in_window",
)


@pytest.fixture(autouse=True)
def plain_python(monkeypatch):
    """The kernels as they are written, not compiled."""
    for name in NAMES:
        monkeypatch.setattr(train_log, name, getattr(train_log, name).py_func)


@pytest.mark.parametrize("ratio", [1.0, 0.4, 2.5])
@pytest.mark.parametrize(
    ("root", "rate", "bend"),
    [
        (0.3, 2.0, 0.4),
        (0.75, 1.5, -0.5),
        (0.5, -2.0, 0.0),
        (0.2, -1.0, -0.6),
        (0.999, -3.0, 0.7),
        (0.01, 2.0, 0.0),
    ],
)
def test_a_parabola_is_crossed_where_and_as_fast_as_it_is(root, rate, bend, ratio):
    """Penetration rate (t - root) + bend (t - root)^2 with t = 0 at the step before and 1 at the
    last; rate per step.
    """
    earlier, before, now = (rate * (t - root) + bend * (t - root) ** 2 for t in (-ratio, 0.0, 1.0))
    assert (now > 0) == (rate > 0) and (before > 0) != (now > 0)
    assert train_log.crossing(earlier, before, now, ratio) == pytest.approx((root, rate), abs=1e-12)


def test_a_crossing_lies_within_the_step_whatever_the_steps_before_say():
    assert train_log.crossing(-1.0, 0.0, 0.0, 1.0)[0] == 0.0
    assert all(
        0.0 <= train_log.crossing(earlier, -1e-9, 1e-9, 1.0)[0] <= 1.0
        for earlier in (-1.0, 1.0, -1e-9, 0.0)
    )


SPEED, STEP = 200.0, 1e-5  # rad/s of cam, s


def swings(times):
    """Penetration (m) that opens and closes four times, and the force of a linear contact."""
    pen = 4e-5 * np.sin(2 * math.pi * 900 * times + 0.4) + 1e-5 * np.cos(2 * math.pi * 370 * times)
    return pen, 2e6 * np.maximum(pen, 0.0)


@pytest.mark.parametrize("unilateral", [True, False])
def test_forces_and_transitions_of_a_contact(unilateral):
    steps = np.arange(-2, 300)
    times = steps * STEP
    pen, force = swings(times)
    pen, force, angles = (
        pen[2:],
        force[2:] if unilateral else 1e6 * pen[2:] - 30.0,
        SPEED * times[2:],
    )
    window, nose_at = (angles > 0.1) & (angles < 0.45), 137.3
    scratch = SimpleNamespace(
        before=np.zeros((3, 2)), track=np.zeros((3, 4)), latest=np.full(3, -1)
    )
    scratch.before[2] = swings(times[1::-1])[0]
    records = SimpleNamespace(extremes=np.zeros((3, 7)), transitions=np.zeros((20, 7)))
    records.extremes[:, MIN_FORCE] = math.inf
    clock = np.zeros(15)
    clock[1], clock[2], clock[11], clock[12] = SPEED, 0.0, STEP, STEP
    motion = SimpleNamespace(counters=np.zeros(6, dtype=int), clock=clock)
    for n in range(300):
        nose = nose_at - (n - 1) if n - 1 <= nose_at < n else -1.0
        train_log.note_contact(
            2,
            pen[n],
            force[n],
            unilateral,
            False,
            bool(window[n]),
            nose,
            angles[n],
            motion,
            scratch,
            records,
        )
    assert not records.extremes[:2, : PEAK_FORCE_ANGLE + 1].any() and not scratch.track[:2].any()
    found, largest = records.extremes[2], int(np.argmax(np.abs(force)))
    assert found[[PEAK_FORCE, PEAK_FORCE_ANGLE]] == pytest.approx(
        (abs(force[largest]), angles[largest])
    )
    least = int(np.argmin(np.where(window, force, np.inf)))
    assert found[[MIN_FORCE, MIN_FORCE_ANGLE]] == pytest.approx((force[least], angles[least]))
    assert found[OPEN_FORCE] == pytest.approx(max(force[window].max(), 0.0))
    assert found[NOSE_FORCE] == pytest.approx(np.interp(nose_at, np.arange(300), force))
    assert (
        scratch.before[2] == pytest.approx((pen[-1], pen[-2])) and scratch.track[2, 3] == force[-1]
    )
    turns = np.flatnonzero((pen[1:] > 0) != (pen[:-1] > 0)) if unilateral else []
    assert motion.counters[2] == len(turns)
    rows, fine = records.transitions[: len(turns)], np.linspace(0, 1, 2001)
    for row, turn in zip(rows, turns, strict=True):
        around = swings((turn + fine) * STEP)[0]
        at = turn + fine[int(np.argmin(np.abs(around)))]
        rate = (swings((at + 1e-3) * STEP)[0] - swings((at - 1e-3) * STEP)[0]) / (2e-3 * STEP)
        assert row[[PLACE, CLOSES]].tolist() == [2.0, float(rate > 0)]
        assert row[ANGLE] == pytest.approx(at * STEP * SPEED, abs=2e-3 * STEP * SPEED) and row[
            RATE
        ] == pytest.approx(rate, rel=5e-3)
    for first, last, row, after in zip(turns[:-1], turns[1:], rows[:-1], rows[1:], strict=True):
        inside = slice(first + 1, last + 1)
        if row[CLOSES]:
            assert row[MAX_FORCE] == after[MAX_FORCE] == pytest.approx(force[inside].max())
        else:
            place = first + 1 + int(np.argmin(pen[inside]))
            assert row[[MAX_GAP, MAX_GAP_ANGLE]] == pytest.approx((-pen[place], angles[place]))
            assert after[[MAX_GAP, MAX_GAP_ANGLE]] == pytest.approx((-pen[place], angles[place]))


def test_the_first_step_of_a_run_moves_no_step_before_and_a_full_log_counts_on():
    scratch = SimpleNamespace(
        before=np.array([[-1e-6, -3e-6]]), track=np.zeros((1, 4)), latest=np.full(1, -1)
    )
    records = SimpleNamespace(extremes=np.zeros((1, 7)), transitions=np.zeros((0, 7)))
    clock = np.zeros(15)
    clock[1], clock[11], clock[12] = SPEED, STEP, STEP
    motion = SimpleNamespace(counters=np.zeros(6, dtype=int), clock=clock)
    train_log.note_contact(0, -1e-6, 0.0, True, True, False, -1.0, 0.0, motion, scratch, records)
    assert (
        scratch.before.tolist() == [[-1e-6, -3e-6]]
        and motion.counters[2] == 0
        and records.extremes[0, NOSE_FORCE] == 0.0
    )
    train_log.note_contact(0, 1e-6, 5.0, True, False, False, -1.0, 0.1, motion, scratch, records)
    assert (
        motion.counters[2] == 1
        and scratch.latest[0] == -1
        and scratch.before.tolist() == [[1e-6, -1e-6]]
    )


def test_the_step_before_may_have_been_of_another_length():
    """A free fall through the touch: penetration and rate of a parabola with steps of 1 and 0.5 of
    :data:`STEP`.
    """
    pen = [1e-6 * (t - 0.7) + 0.5e-6 * (t - 0.7) ** 2 for t in (-1.0, 0.0, 0.5, 1.0)]
    for earlier, before, now, first, last in (
        (pen[0], pen[1], pen[3], 1.0, 1.0),
        (pen[1], pen[2], pen[3], 0.5, 0.5),
        (pen[0], pen[2], pen[3], 1.5, 0.5),
    ):
        scratch = SimpleNamespace(
            before=np.array([[before, earlier]]), track=np.zeros((1, 4)), latest=np.full(1, -1)
        )
        log, clock = np.zeros((1, 7)), np.zeros(15)
        clock[1], clock[11], clock[12] = SPEED, last * STEP, first * STEP
        train_log.note_crossing(
            0, now, 0.7, SimpleNamespace(counters=np.zeros(6, dtype=int), clock=clock), scratch, log
        )
        assert log[0, ANGLE] == pytest.approx(0.7 - 0.3 * STEP * SPEED) and log[
            0, RATE
        ] == pytest.approx(1e-6 / STEP)


def test_a_cam_that_gains_speed_was_slower_at_the_crossing():
    """Half a step ago at 200 rad/s and 1e6 rad/s^2: the angle lies h / 2 times the mean speed of
    that stretch back.
    """
    scratch = SimpleNamespace(
        before=np.array([[-1e-6, -3e-6]]), track=np.zeros((1, 4)), latest=np.full(1, -1)
    )
    log, clock = np.zeros((1, 7)), np.zeros(15)
    clock[1], clock[2], clock[11], clock[12] = SPEED, 1e6, STEP, STEP
    train_log.note_crossing(
        0, 1e-6, 0.7, SimpleNamespace(counters=np.zeros(6, dtype=int), clock=clock), scratch, log
    )
    assert (
        0.7 - log[0, ANGLE] == pytest.approx(0.5 * STEP * (SPEED - 0.5 * 0.5 * STEP * 1e6))
        and scratch.track[0, 1] == log[0, ANGLE]
    )


def test_loads_keep_their_extremes_and_where_they_stood():
    """Four end forces of two springs, the sums at their retainers and seats, and the torque power /
    speed.
    """
    rng = np.random.default_rng(2)
    loads, powers, ends = (
        np.zeros((7, 4)),
        rng.normal(size=30) * 900,
        rng.normal(size=(30, 4)) * 300,
    )
    loads[:, HIGHEST], loads[:, LOWEST] = -np.inf, np.inf
    angles = np.linspace(0, 6, 30)
    for power, end, angle in zip(powers, ends, angles, strict=True):
        train_log.note_loads(power, angle, SPEED, np.array([0, 0, 0, 0, *end]), loads)
    due = np.column_stack([ends, ends[:, 0] + ends[:, 2], ends[:, 1] + ends[:, 3], powers / SPEED])
    for row, values in zip(loads, due.T, strict=True):
        top, bottom = int(np.argmax(values)), int(np.argmin(values))
        assert row[[HIGHEST, HIGHEST_ANGLE, LOWEST, LOWEST_ANGLE]] == pytest.approx(
            (values[top], angles[top], values[bottom], angles[bottom])
        )


@pytest.mark.parametrize("turn", [0, 3, -2])
@pytest.mark.parametrize(
    ("away", "first", "share"),
    [
        (0.0, False, 1.0),
        (0.25, False, 0.75),
        (0.75, False, 0.25),
        (1.001, False, -1.0),
        (3.0, False, -1.0),
        (-0.1, False, -1.0),
        (0.5, True, 1.0),
        (1.5, True, -1.0),
    ],
)
def test_the_nose_is_passed_in_the_step_that_holds_it(away, first, share, turn):
    """``away``: steps since the nose; the share counts from the begin of the step, and the first
    step of a run has none before it.
    """
    clock = np.zeros(15)
    clock[11], clock[14] = STEP, 1.1
    assert train_log.nose_share(
        1.1 + away * STEP * SPEED + turn * 2 * math.pi, SPEED, first, clock
    ) == pytest.approx(share, abs=1e-9)


@pytest.mark.parametrize(
    ("angle", "inside"),
    [
        (5.9, False),
        (6.0, True),
        (6.2, True),
        (6.4, True),
        (0.3, True),
        (0.7, True),
        (0.75, False),
        (3.0, False),
    ],
)
@pytest.mark.parametrize("turn", [0, 1, -4])
def test_a_window_may_pass_the_end_of_the_turn(angle, inside, turn):
    """From 6 rad over the end of the turn to 0.717 rad."""
    assert train_log.in_window(angle + turn * 2 * math.pi + 1e-12, 6.0, 1.0) is inside
