"""One call integrates every system: how long, by which integrator, with what kept; run-ups beside
steady states.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from train_parts import LAW, direct, system
from valvetrain.errors import InputError
from valvetrain.integrate.contract import Cycles, Periodic, RunOptions, RunUp
from valvetrain.integrate.run import run
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.springs.massless import MasslessSpring
from valvetrain.springs.modal_uniform import ModalUniform
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.wave_rod import WaveRod
from valvetrain.system.prescribed import PrescribedSpring

CAM_SPEED = 200.0
UNIFORM = EquivalentSpring(rate=30e3, preload=250.0, active_mass=0.04)
DAMPED = MultiMassSpring.from_card(30e3, 250.0, 0.04, elements=6, mass_damping=400.0)


def prescribed(*springs) -> PrescribedSpring:
    return PrescribedSpring(springs or (DAMPED,), LAW)


def train(spring=DAMPED):
    return system(direct(), spring=spring)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: run(train(), math.nan), "cam speed must be positive"),
        (
            lambda: run(train(), 100.0, options=RunOptions(integrator="leapfrog")),
            "no integrator 'leapfrog' runs a train",
        ),
        (
            lambda: run(prescribed(), 100.0, options=RunOptions(integrator="harmonic")),
            "no integrator 'harmonic' runs a prescribed-spring",
        ),
        (
            lambda: run(prescribed(), 100.0, options=RunOptions(integrator="leapfrogg")),
            "did you mean leapfrog",
        ),
        (lambda: run(prescribed(), 100.0, RunUp(300.0, 1e-6)), "is taken for a mistake"),
        (lambda: PrescribedSpring((), LAW), "one or two springs"),
    ],
)
def test_what_cannot_be_run_is_refused_in_one_sentence(make, words):
    with pytest.raises(InputError) as error:
        make()
    assert words in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize("make", [prescribed, train])
def test_what_is_kept_does_not_change_what_is_computed(make):
    kept = {
        word: run(make(), CAM_SPEED, Cycles(2), RunOptions(samples=180, keep=word))
        for word in ("all", "contacts", "ends")
    }
    for name in ("seat_force", "retainer_force"):
        for word in ("contacts", "ends"):
            assert np.array_equal(kept[word].channel(name), kept["all"].channel(name))
    assert kept["all"].has("axial_displacement", "axial_velocity") and not kept["ends"].has(
        "axial_displacement"
    )


def test_cycles_of_a_train_are_turns_from_rest():
    """The last of n turns is the n-th turn of the same start, and turns that settle come to the
    periodic state.
    """
    made = {
        count: run(train(), CAM_SPEED, Cycles(count), RunOptions(samples=360))
        for count in (1, 2, 20)
    }
    assert [made[count].statistics["steady_cycles_count"] for count in made] == [1, 2, 20]
    assert all(one.status.completed and len(one.time) == 360 for one in made.values())
    settled = run(train(), CAM_SPEED, Periodic(), RunOptions(samples=360)).channel("retainer_force")
    far = {
        count: float(np.max(np.abs(made[count].channel("retainer_force") - settled)))
        for count in made
    }
    assert far[20] < 0.05 and far[20] < 0.1 * far[1]


def test_cycles_and_periods_of_a_prescribed_spring_come_to_the_same():
    many = run(prescribed(), CAM_SPEED, Cycles(20), RunOptions(samples=360))
    settled = run(prescribed(), CAM_SPEED, Periodic(40, tolerance=1e-6), RunOptions(samples=360))
    assert settled.status.completed and settled.statistics["steady_residual_ratio"] <= 1e-6
    assert settled.channel("seat_force") == pytest.approx(many.channel("seat_force"), abs=0.05)


@pytest.mark.parametrize("make", [prescribed, train])
def test_a_motion_that_does_not_repeat_says_so(make):
    found = run(
        make(), CAM_SPEED, Periodic(2, method="repeat", tolerance=1e-12), RunOptions(samples=72)
    )
    assert found.status.code == "not-converged" and found.status.remedy
    assert len(found.time) >= 72  # what was computed is there


def _last_turn(solution, name: str, speed_at_end: float):
    """Angle within the turn and a channel over the last whole turn of a run-up."""
    angle, values = solution.cam_angle, solution.channel(name)
    last = np.floor(angle[-1] / (2 * np.pi)) * 2 * np.pi
    part = (angle >= last - 2 * np.pi) & (angle < last)
    return angle[part] - (last - 2 * np.pi), values[part]


@pytest.mark.parametrize("make", [prescribed, train])
def test_a_slow_run_up_passes_through_the_steady_states(make):
    first, last = 195.0, 200.0
    acceleration = 5.0  # rad/s2: thirty turns for a rise by 2.5 percent
    up = run(make(), first, RunUp(last, acceleration), RunOptions(samples=720, keep="ends"))
    assert up.status.completed
    time, angle = up.time, up.cam_angle
    assert angle == pytest.approx(first * time + acceleration * time**2 / 2, rel=1e-9, abs=1e-9)
    turned, force = _last_turn(up, "retainer_force", last)
    still = run(
        make(),
        last - 0.5 * acceleration * 2 * np.pi / last,
        Periodic(),
        RunOptions(samples=720, keep="ends"),
    )
    around = np.interp(turned, still.cam_angle, still.channel("retainer_force"), period=2 * np.pi)
    assert np.max(np.abs(force - around)) < 0.02 * np.ptp(around)
    # the first turn starts from rest and shows its transient, so the comparison above is not empty
    begin = run(make(), first, Periodic(), RunOptions(samples=720, keep="ends"))
    early = angle < 2 * np.pi
    steady = np.interp(
        angle[early], begin.cam_angle, begin.channel("retainer_force"), period=2 * np.pi
    )
    assert np.max(np.abs(up.channel("retainer_force")[early] - steady)) > 2 * np.max(
        np.abs(force - around)
    )


def test_a_run_down_is_a_run_up_of_the_other_sign():
    for made in (prescribed(), train()):
        down = run(made, 200.0, RunUp(150.0, -400.0), RunOptions(samples=72, keep="ends"))
        assert down.status.completed
        assert down.cam_angle == pytest.approx(
            200.0 * down.time - 200.0 * down.time**2, rel=1e-9, abs=1e-9
        )


@pytest.mark.parametrize(
    "springs",
    [
        (MasslessSpring(30e3, 250.0, 0.04), MasslessSpring(14e3, 130.0, 0.02)),
        (DAMPED, MultiMassSpring.from_card(14e3, 130.0, 0.02, elements=4, mass_damping=300.0)),
        (
            WaveRod(UNIFORM, friction=200.0),
            WaveRod(EquivalentSpring(14e3, 130.0, 0.02), friction=200.0),
        ),
        (ModalUniform(UNIFORM, 4, damping_ratio=0.05), MasslessSpring(14e3, 130.0, 0.02)),
    ],
    ids=["massless", "multi-mass", "wave-rod", "mixed"],
)
def test_a_nested_pair_under_prescribed_motion_is_the_sum_of_its_springs(springs):
    both = run(prescribed(*springs), CAM_SPEED, Cycles(2), RunOptions(samples=180))
    alone = [
        run(prescribed(spring), CAM_SPEED, Cycles(2), RunOptions(samples=180)) for spring in springs
    ]
    for name in ("seat_force", "retainer_force"):
        assert both.channel(name) == pytest.approx(
            sum(one.channel(name) for one in alone), rel=1e-12
        )
        for word, one in zip(("outer", "inner"), alone, strict=True):
            assert np.array_equal(both.channel(f"{word}_{name}"), one.channel(name))
    assert both.status.completed and both.springs == ("outer", "inner")


def test_a_prescribed_run_that_blows_up_keeps_what_it_had():
    stiff = MultiMassSpring.from_card(30e3, 250.0, 0.04, elements=6)
    found = run(
        prescribed(stiff),
        400.0,
        Cycles(3),
        RunOptions(samples=72, time_step=1.3 * stiff.stable_time_step()),
    )
    assert found.status.code == "diverged" and found.status.remedy and found.status.time > 0
    assert len(found.time) < 73 and found.has("seat_force")


def test_a_run_up_shorter_than_one_turn_has_its_own_angle_and_may_be_evaluated():
    from valvetrain.quantities.evaluate import evaluate

    for made in (prescribed(), train()):
        up = run(made, 100.0, RunUp(110.0, 400.0), RunOptions(samples=360, keep="ends"))
        assert up.status.completed and len(up.time) in (360, 361)
        assert up.cam_angle == pytest.approx(
            100.0 * up.time + 200.0 * up.time**2, rel=1e-9, abs=1e-9
        )
        assert evaluate(up).quantities["peak_retainer_force"] > 250.0


@pytest.mark.parametrize(
    ("method", "cycles", "settles"),
    [("anderson", 400, True), ("repeat", 400, True), ("repeat", 2, False)],
)
def test_a_train_says_how_far_it_settled_and_in_which_steps(method, cycles, settles):
    """Settled, the last change lies within the tolerance; the turns after a start from rest do not
    settle it, and its status says so.
    """
    found = run(
        train(), CAM_SPEED, Periodic(cycles, tolerance=1e-7, method=method), RunOptions(samples=360)
    )
    told = found.statistics
    assert told["time_step_duration"] * told["steps_per_cycle_count"] == pytest.approx(
        2 * math.pi / CAM_SPEED, rel=1e-9
    )
    assert (
        told["steady_tolerance_ratio"] == 1e-7
        and told["steps_per_cycle_count"] % 360 == 0 < told["wall_time_per_cycle_duration"]
    )
    assert found.status.completed == (told["steady_residual_ratio"] <= 1e-7) == settles
    assert not settles or (
        told["motion_period_count"] == 1 and 2 < told["steady_cycles_count"] < 400
    )


def test_a_number_of_revolutions_is_run_whatever_repeats():
    """A massless spring repeats bit by bit from the first revolution on (contract)."""
    made = run(
        prescribed(MasslessSpring(30e3, 250.0)), CAM_SPEED, Cycles(3), RunOptions(samples=72)
    )
    assert made.statistics["steady_cycles_count"] == 3
    assert made.time[0] == pytest.approx(2 * 2 * math.pi / CAM_SPEED)
