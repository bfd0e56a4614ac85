"""What the loop logs of contacts: openings and closings within the step, largest gaps, forces;
independent of the samples kept.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from valvetrain.contact.dissipative import HuntCrossley, rebound
from valvetrain.contact.elastic import HertzPoint
from valvetrain.integrate.train_record import TrainOptions, TrainState
from valvetrain.integrate.train_run import runner
from valvetrain.integrate.train_steady import steady_train
from valvetrain.integrate.train_tuples import TRANSITIONS
from valvetrain.integrate.transitions import Transitions
from valvetrain.mechanism.gap_kinds import LINEAR
from valvetrain.mechanism.parts import AssembledMechanism, Coordinate, Interaction
from valvetrain.parameters.loading import load_case
from valvetrain.system.build import build
from valvetrain.system.train_system import TrainSystem

MASS, PULL = 0.1, 50.0
"""kg and N towards the floor."""


def bouncer(law) -> TrainSystem:
    floor = Interaction("seat", LINEAR, ("valve",), (0.0, -1.0), law)
    return TrainSystem(
        AssembledMechanism(
            "drop", (Coordinate("valve", MASS, force=-PULL),), (floor,), {}, "valve", "valve"
        )
    )


def dropped(law, height, duration, steps):
    ready = runner(
        bouncer(law), 2 * np.pi / duration, TrainOptions(samples=40, time_step=duration / steps)
    )
    h = ready.time_step
    return ready.cycle(
        TrainState(
            np.array([height]), np.array([PULL / MASS * h / 2]), (), np.zeros(0), np.zeros(5)
        )
    )[1]


def test_a_fall_ends_with_the_rate_and_at_the_instant_of_free_fall():
    """Free fall is a parabola, as is the interpolation: exact at any step. The rebound follows the
    law, its height the rebound.
    """
    height, duration, decay = 1e-3, 0.02, 0.6
    fall, final = math.sqrt(2 * height * MASS / PULL), math.sqrt(2 * height * PULL / MASS)
    for steps in (2000, 20000):
        found = dropped(HuntCrossley(1e9, decay), height, duration, steps).transitions
        assert list(found.closes[:4]) == [True, False, True, False] and found.overflow == 0
        assert found.gap_rate[0] == pytest.approx(final, rel=1e-9)
        assert found.cam_angle[0] == pytest.approx(2 * np.pi / duration * fall, rel=1e-9)
        assert found.largest_gap[0] == pytest.approx(height, rel=1e-9)
    away = -found.gap_rate[1]
    assert away / final == pytest.approx(
        rebound(decay * final), rel=0.06
    )  # the pull is some 4 % of the force of the impact
    assert (
        found.largest_gap[1]
        == found.largest_gap[2]
        == pytest.approx(away**2 * MASS / PULL / 2, rel=1e-5)
    )
    middle = 0.5 * (found.cam_angle[1] + found.cam_angle[2])
    assert found.largest_gap_cam_angle[1] == pytest.approx(middle, abs=2 * 2 * np.pi / steps)
    assert found.gap_rate[2] == pytest.approx(away, rel=1e-3)
    assert found.largest_force[0] == found.largest_force[1] > PULL


def test_more_transitions_than_the_log_holds_are_counted():
    record = dropped(HertzPoint(1e10), 1e-6, 0.4, 400_000)
    found = record.transitions
    assert len(found) == TRANSITIONS and found.overflow > 100
    assert (
        np.all(np.diff(found.cam_angle) > 0)
        and np.all(found.closes[::2])
        and not np.any(found.closes[1::2])
    )
    assert record.status.completed


@pytest.fixture(scope="module")
def pushrod_train():
    case = load_case("tdi-pushrod")
    return build(case).members[0].system(), 2 * math.pi * 4000 / 60 / 2


def seating(built, cam_speed, samples, time_step=None):
    steady = steady_train(
        runner(built, cam_speed, TrainOptions(samples=samples, time_step=time_step))
    )
    assert steady.status.completed, steady.status
    return steady.record.transitions.seating_velocity(built.interaction_names.index("seat")), steady


def test_seating_velocity_does_not_know_how_many_samples_are_kept(pushrod_train):
    built, cam_speed = pushrod_train
    step = 2 * np.pi / cam_speed / 5760 * (1 + 1e-9)
    found = [seating(built, cam_speed, samples, step)[0] for samples in (360, 720, 1440, 2880)]
    assert np.ptp(found) < 1e-3 * np.mean(found)
    # the steps of the default choice follow the samples; what is left is the error of the step
    own = [seating(built, cam_speed, samples)[0] for samples in (360, 720, 1440, 2880)]
    assert own == pytest.approx([found[0]] * 4, rel=0.01)


def test_seating_velocity_converges_with_the_step(pushrod_train):
    built, cam_speed = pushrod_train
    steps = (2880, 5760, 11520, 46080)
    rates = np.array(
        [
            seating(built, cam_speed, 360, 2 * np.pi / cam_speed / count * (1 + 1e-9))[0]
            for count in steps
        ]
    )
    errors = np.abs(rates[:3] - rates[3])
    assert errors[0] < 2e-4 * rates[3]
    assert (
        np.log2(errors[0] / errors[2]) > 2 * 1.5
    )  # over two halvings; what is left is of the size of the Newton steps at rest


def test_log_and_records_tell_one_story(pushrod_train):
    built, cam_speed = pushrod_train
    ready = runner(built, cam_speed, TrainOptions(samples=1440, impact_steps=0, window=(1.0, 2.0)))
    # as many samples as steps, none of which is divided: the records hold every step
    ready = runner(
        built, cam_speed, TrainOptions(samples=ready.steps, impact_steps=0, window=(1.0, 2.0))
    )
    _, record = ready.cycle(ready.initial_state())
    inside = (record.cam_angle >= 1.0) & (record.cam_angle <= 2.0)
    assert record.least_forces == pytest.approx(np.min(record.forces[inside], axis=0), rel=1e-14)
    least = np.argmin(record.forces[inside], axis=0)
    assert record.least_force_cam_angles == pytest.approx(record.cam_angle[inside][least])
    peak = np.argmax(np.abs(record.forces), axis=0)
    assert record.peak_force_cam_angles == pytest.approx(record.cam_angle[peak])
    for place, law in enumerate(built.arrays.laws):
        own, touching = record.transitions.of(place), record.gaps[:, place] < 0
        if law < 0:
            assert len(own) == 0
            continue
        changes = np.flatnonzero(touching[1:] != touching[:-1]) + 1
        inner = own.where(own.cam_angle <= record.cam_angle[-1])
        assert len(inner) == len(changes)
        assert np.all(
            (record.cam_angle[changes - 1] <= inner.cam_angle)
            & (inner.cam_angle <= record.cam_angle[changes])
        )
        assert np.array_equal(inner.closes, touching[changes])
        assert np.all((inner.gap_rate > 0) == inner.closes)


def test_an_open_stretch_that_passes_the_end_of_the_cycle_is_one():
    closes = np.array([True, False, True, False])
    found = Transitions(
        np.full(4, 3),
        closes,
        np.array([0.5, 2.0, 4.0, 6.0]),
        np.array([0.2, -1.0, 0.4, -0.3]),
        np.array([1e-5, 5e-3, 5e-3, 2e-5]),
        np.array([0.1, 3.0, 3.0, 6.2]),
        np.array([10.0, 10.0, 20.0, 20.0]),
    )
    stretches = found.open_stretches(3)
    assert stretches.largest_gap == pytest.approx(
        [2e-5, 5e-3]
    ) and stretches.largest_gap_cam_angle == pytest.approx([6.2, 3.0])
    assert found.main_closing(3) == 1 and found.seating_velocity(3) == 0.4
    assert found.seating_velocity(2) is None and len(found.of(2)) == 0
