"""A train that left the range of its model ends with the status ``out-of-range`` (contract), and
motion that only flies far does not (limit: an impacting oscillator).
"""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt
from train_parts import KINDS, direct, system
from valvetrain.integrate.contract import RunUp
from valvetrain.integrate.run import run as integrate
from valvetrain.integrate.train_record import TrainOptions
from valvetrain.integrate.train_run import runner
from valvetrain.integrate.train_steady import steady_train
from valvetrain.parameters.templates import template_text
from valvetrain.solution.provenance import Provenance
from valvetrain.springs.massless import MasslessSpring
from valvetrain.system.train_system import TrainSystem

RPM = np.pi / 30
WEAK = MasslessSpring(4e3, 60.0, 0.03)


@pytest.mark.parametrize("kind", ["finger", "rocker", "pushrod"])
def test_a_lever_thrown_past_its_dead_point_fails_the_run_and_keeps_the_motion(kind):
    built = system(KINDS[kind](), spring=WEAK)
    calm, thrown = (
        steady_train(runner(built, engine_rpm / 2 * RPM, TrainOptions(samples=720)))
        for engine_rpm in (2000, 12000)
    )
    assert calm.status.code == "completed"
    assert thrown.status.code == "out-of-range" and thrown.status.where == "lever"
    lever = np.degrees(thrown.record.q[:, built.coordinate_names.index("lever")])
    dead = np.degrees(built.mechanism.travel["lever"][1])
    assert lever.max() > dead > lever[0] and "the lever has turned to" in thrown.status.message
    assert 0 < thrown.status.time < 60 / 6000  # within the revolution that is kept


def test_the_dead_points_of_a_lever_are_where_it_moves_tip_or_pad_no_further():
    """Closed form: the tip of the rocker lies square to its valve, so that it opens for a quarter
    turn; the pad of the finger comes furthest where its arm points away from the cam.
    """
    rocker, finger = (
        system(KINDS[kind]()).mechanism.travel["lever"] for kind in ("rocker", "finger")
    )
    assert np.degrees(rocker[1]) == pytest.approx(90.0, abs=1e-9) and -np.pi / 2 < rocker[0] < 0
    pivot, arm, rest = np.hypot(0.03, 0.028), 0.03354, 0.018 + 0.025  # base circle and pad
    between = np.arccos((rest**2 - pivot**2 - arm**2) / (2 * pivot * arm))
    assert finger[0] == pytest.approx(between - np.pi, abs=1e-9)


def test_a_cam_that_touches_nothing_fails_the_run():
    """A gas force beyond the spring holds the valve of a bucket tappet open, away from the cam."""
    gas = np.zeros((1440, 3))
    gas[:, 0] = 2000.0
    train = direct(model="single-mass")
    held = system(train, spring=MasslessSpring(30e3, 300.0, 0.04))
    built = TrainSystem(held.mechanism, held.springs, gas)
    found = steady_train(runner(built, 100.0, TrainOptions(samples=720)), cycles=200)
    assert found.record.peak_forces[0] == 0
    assert found.status.code == "out-of-range" and found.status.where == "cam"
    assert "5 mm" in found.status.message


def test_a_flight_of_more_than_a_revolution_is_motion_of_the_model():
    """A heavy follower on a weak spring comes back to its cam: no failure, whatever its period."""
    from valvetrain.parameters.train_parts import ValveParameters

    train = direct(model="single-mass", valve=ValveParameters(0.9))
    built = system(train, spring=MasslessSpring(2e3, 60.0, 0.0))
    flown = 0
    for cam_rpm in (1500, 2000, 2500, 3000):
        found = steady_train(runner(built, cam_rpm * RPM, TrainOptions(samples=720)), cycles=100)
        assert found.status.code in ("completed", "not-converged")
        ready, state = found.runner, found.start
        for _ in range(12):
            state, record = ready.cycle(state)
            flown += not record.touches_cam(built)
    assert flown, "every revolution touched its cam, so nothing was tested; raise the speeds"


def test_a_run_up_ends_where_the_lever_is_thrown():
    built = system(KINDS["finger"](), spring=WEAK)
    ends = integrate(
        built, 1500 * RPM, RunUp(6000 * RPM, 1e3), provenance=Provenance("own", "massless")
    )
    assert ends.status.code == "out-of-range"
    assert float(ends.channel("lever_angle").max()) > np.radians(96)


def test_a_sweep_shows_such_a_speed_as_failed_and_gives_it_no_point():
    stiff, weak = 'preload = "320 N"\nrate = "42 N/mm"', 'preload = "100 N"\nrate = "10 N/mm"'
    text = template_text("finger")
    assert stiff in text
    case = vt.Case(text.replace(stiff, weak))
    sweep = vt.sweep(
        case,
        ["3000 rpm", "14000 rpm"],
        models="massless",
        spring_sets="stiff",
        critical_speeds=False,
        workers=1,
    )
    calm, thrown = sweep.solutions
    assert calm.status.completed and thrown.status.code == "out-of-range"
    lost = sweep.series(calm.label, "peak_cam_contact_force").values
    assert np.isfinite(lost[0]) and np.isnan(lost[1]) and not thrown.quantities
    assert any("14000 rpm: out-of-range" in line for line in sweep.failures)
