"""Search for the periodic orbit on toy maps of known answer (closed form), then on trains (limit
between methods: an extrapolation never leaves what plain revolutions bound).
"""

from __future__ import annotations

import numpy as np
import pytest

from train_parts import contacts, direct, system
from valvetrain.cam.closed_form import SinePower
from valvetrain.integrate.spring_return import rigid_motion, spring_return
from valvetrain.integrate.steady import PROBE_CYCLES, accelerate, repeat_cycles
from valvetrain.integrate.train_record import TrainOptions
from valvetrain.integrate.train_run import runner
from valvetrain.integrate.train_steady import _weights, steady_train
from valvetrain.parameters.schema_contact import ContactParameters
from valvetrain.parameters.train_parts import CamParameters, FollowerParameters, ValveParameters
from valvetrain.runs.train_runs import speed_blocks
from valvetrain.springs.massless import MasslessSpring
from valvetrain.springs.multi_mass import MultiMassSpring

ROTATION = (
    0.97
    * np.kron(np.eye(3), np.array([[0.6, -0.8], [0.8, 0.6]]))
    * np.repeat([1.0, 0.9, 0.8], 2)[:, None]
)
TARGET = np.linspace(1, 2, 6)


def linear(x):
    """A slowly turning contraction with the fixed point TARGET, as surge modes are."""
    return TARGET + ROTATION @ (x - TARGET)


def logistic(rate):
    return lambda x: rate * x * (1 - x)


def test_both_methods_find_the_fixed_point_and_the_faster_one_in_fewer_cycles():
    weights, start = np.ones(6), np.zeros(6)
    slow, fast = (
        repeat_cycles(linear, start, weights, 1e-9, 1000),
        accelerate(linear, start, weights, 1e-9, 1000),
    )
    for found in (slow, fast):
        assert found.converged and found.period == 1
        assert found.state == pytest.approx(TARGET, abs=1e-7)
        assert found.residuals[-1] <= 1e-9
    assert len(slow.residuals) == slow.cycles > 400  # 0.97**n reaches 1e-9 after some 700
    assert fast.cycles <= 15


@pytest.mark.parametrize("method", [repeat_cycles, accelerate])
@pytest.mark.parametrize(("rate", "period"), [(2.8, 1), (3.2, 2), (3.5, 4), (3.9, 0)])
def test_the_period_of_what_does_not_settle_is_told(method, rate, period):
    found = method(logistic(rate), np.array([0.3]), np.ones(1), 1e-8, 400)
    assert found.period == period
    assert found.converged is (period == 1)


def test_an_orbit_that_repels_is_accepted_only_without_the_test():
    """1 - 1/r of the logistic map, which has period 2 at 3.2."""
    repels = accelerate(logistic(3.2), np.array([0.3]), np.ones(1), 1e-8, 400, probed=False)
    assert repels.period == 1 and repels.state == pytest.approx(1 - 1 / 3.2, abs=1e-6)


@pytest.mark.parametrize("method", [repeat_cycles, accelerate])
def test_what_comes_no_nearer_to_repeating_is_given_up_soon_by_the_impatient(method):
    """Contract: chaos costs fewer cycles, its period may stay unknown; a contraction, slow as it be, is found."""

    def search(cycle, **options):
        return method(cycle, np.array([0.3]), np.ones(1), 1e-6, 48, **options)

    patient, brief = (search(logistic(3.9), patient=one) for one in (True, False))
    assert patient.period == brief.period == 0 and brief.cycles < patient.cycles
    slow = repeat_cycles(lambda x: 0.8 * x, np.ones(1), np.ones(1), 1e-6, 100, patient=False)
    assert slow.converged and slow.cycles > 50


@pytest.mark.parametrize("method", [repeat_cycles, accelerate])
def test_both_methods_search_alike_unless_told_otherwise(method):
    """A change below 1e-6; periods up to eight, and none of the sixteen that the logistic map has
    at 3.566.
    """
    slow = method(lambda x: TARGET + 0.5 * (x - TARGET), np.zeros(6), np.ones(6))
    assert slow.converged and 1e-7 < slow.tolerance <= 1e-6 and slow.residuals[-1] <= 1e-6
    assert slow.state == pytest.approx(TARGET, abs=2e-6)
    assert [
        method(logistic(rate), np.array([0.3]), np.ones(1), 1e-6, 2000).period
        for rate in (3.55, 3.566)
    ] == [8, 0]


def test_a_map_that_leaves_all_bounds_ends_the_search():
    found = repeat_cycles(lambda x: x * np.inf, np.ones(1), np.ones(1))
    assert not found.converged and found.cycles == 1


def test_a_cycle_that_leaves_all_bounds_gives_its_start():
    """So that a record of it shows how it ended."""
    maps = (
        lambda x: np.where(x < 3, x + 1, np.nan),
        lambda x: np.where(x < 30, 1.1 * x**2 + 1, np.nan),
    )
    for search in (repeat_cycles, accelerate):
        for cycle in maps:
            found = search(cycle, np.ones(1), np.ones(1), 1e-9)
            assert not found.converged and np.all(np.isfinite(found.state))
            assert np.isnan(cycle(found.state))[0] and not np.isfinite(found.residuals[-1])


def test_both_methods_find_the_same_orbit_of_a_train_and_the_record_repeats():
    spring = MultiMassSpring.from_card(30e3, 300.0, 0.04, elements=5, mass_damping=16.0)
    ready = runner(system(direct(), spring=spring), 250.0, TrainOptions(samples=720))
    slow, fast = (
        steady_train(ready, "repeat", 1e-6, 200),
        steady_train(ready, "anderson", 1e-6, 200),
    )
    assert slow.search.converged and fast.search.converged
    assert slow.status.completed and fast.status.completed
    assert fast.search.cycles < 0.5 * slow.search.cycles
    assert fast.record.spring_forces == pytest.approx(slow.record.spring_forces, abs=0.05)
    _, again = ready.cycle(fast.start)
    assert np.array_equal(again.q, fast.record.q)  # a cycle is repeatable to the bit


def test_a_train_that_needs_two_cycles_says_so():
    periods = set()
    for cam_speed in np.linspace(330, 520, 12):
        ready = runner(
            system(direct(), spring=MasslessSpring(12e3, 120.0, 0.04)),
            cam_speed,
            TrainOptions(samples=720),
        )
        found = steady_train(ready, "repeat", 1e-6, 80)
        periods.add(found.search.period)
        if not found.search.converged:
            assert found.status.completed is found.scatter.repeats  # the valve decides
            assert ("every" in found.status.message) is (found.search.period > 1)
    assert periods - {1}, "every speed settled, so nothing was tested; raise the speeds"


@pytest.mark.parametrize(("power", "engine_rpm"), [(4, 1440), (2, 2880)])
def test_an_impacting_follower_stays_where_plain_revolutions_stay(power, engine_rpm):
    """A weak spring throws a heavy follower off its cam on every lift; the motion is irregular, and
    its extrapolation used to reach 18 and 36 000 km/s.
    """
    hard = ContactParameters("linear", {"contact_stiffness": 1e8, "damping": 2000.0})
    law = SinePower(
        maximum_lift=20e-3, opening_start=np.pi / 3, closing_end=5 * np.pi / 3, power=power
    )
    train = direct(
        contacts=contacts(hard),
        model="single-mass",
        cam=CamParameters(0.06),
        follower=FollowerParameters("flat", mass=0.1),
        valve=ValveParameters(0.9),
    )
    built = system(train, law, spring=MasslessSpring(2e3, 60.0, 0.0))
    ready = runner(built, engine_rpm * np.pi / 60, TrainOptions(samples=720))
    plain, fast = (steady_train(ready, method, cycles=300) for method in ("repeat", "anderson"))
    assert {plain.status.code, fast.status.code} <= {"completed", "not-converged"}
    largest = np.abs(plain.record.v).max()
    assert 1 < largest < 20 and np.abs(fast.record.v).max() < 3 * largest


@pytest.mark.parametrize(("radius", "tested"), [(0.45, False), (0.8, True), (0.97, True)])
def test_an_orbit_is_disturbed_only_where_the_map_seen_leaves_doubt(radius, tested):
    """Closed form: all multipliers of the map have one size, and 0.6 is where trust ends."""
    turned = radius / 0.97 * ROTATION / np.repeat([1.0, 0.9, 0.8], 2)[:, None]
    asked, plain = (
        accelerate(
            lambda x: TARGET + turned @ (x - TARGET),
            np.zeros(6),
            np.ones(6),
            1e-9,
            1000,
            probed=one,
        )
        for one in (True, False)
    )
    assert asked.converged and np.array_equal(asked.state, plain.state)
    assert asked.cycles - plain.cycles == (PROBE_CYCLES if tested else 0)


SPRING = MultiMassSpring.from_card(30e3, 300.0, 0.04, elements=5, mass_damping=16.0)


def ready_at(cam_speed):
    return runner(system(direct(), spring=SPRING), cam_speed, TrainOptions(samples=720))


def returned(ready):
    return spring_return(ready, _weights(ready.initial_state(), ready))


def test_a_correction_that_knows_the_map_ends_the_search_in_two_cycles():
    """Closed form: of a linear map one step with (1 - A)^-1 is the fixed point."""
    inverse = np.linalg.inv(np.eye(6) - ROTATION)
    found = accelerate(
        linear, np.zeros(6), np.ones(6), 1e-9, correct=lambda change: inverse @ change
    )
    assert found.converged and found.cycles == 2 and found.state == pytest.approx(TARGET, abs=1e-9)


def test_all_modes_of_a_spring_decay_over_a_turn_by_its_mass_damping():
    """Closed form: every multiplier of the return has the size exp(-a T / 2) where damping follows mass."""
    ready = ready_at(250.0)
    (part,) = returned(ready).parts
    multipliers = np.linalg.eigvals(np.eye(8) - np.linalg.inv(part.inverse))
    assert np.abs(multipliers) == pytest.approx(np.exp(-8.0 * 2 * np.pi / 250.0), rel=1e-4)


def test_the_answer_of_the_springs_repeats_after_a_turn_of_the_same_motion():
    ready = ready_at(250.0)
    springs, motion = returned(ready), rigid_motion(ready)
    first = springs.answer(ready.initial_state(), motion)
    second = springs.answer(first, motion)
    still = np.abs(ready.initial_state().springs[0] - first.springs[0])[:4].max()
    assert still > 5e-7 and second.springs[0] == pytest.approx(first.springs[0], abs=1e-7)


@pytest.mark.parametrize("cam_speed", [80.0, 120.0])
def test_a_speed_alone_and_from_its_neighbour_has_one_motion_in_few_cycles(cam_speed):
    """The forces agree within 1e-4 of the largest."""
    alone = steady_train(ready_at(cam_speed))
    near = steady_train(ready_at(cam_speed), start=steady_train(ready_at(0.99 * cam_speed)).orbit)
    assert near.search.cycles <= alone.search.cycles <= 6
    apart = np.abs(near.record.forces - alone.record.forces).max()
    assert apart < 1e-4 * alone.record.forces.max()


def test_the_blocks_of_a_sweep_hold_neighbours_alone():
    """Contract: all speeds once in their order, at most five a block, none after a wide step or a falling speed."""
    speeds = (100.0, 102.0, 104.0, 106.0, 108.0, 110.0, 140.0, 141.0, 120.0)
    blocks = speed_blocks(speeds, 5)
    assert sum(blocks, ()) == speeds and [len(one) for one in blocks] == [5, 1, 2, 1]
    assert speed_blocks(speeds, 1) == tuple((one,) for one in speeds)
