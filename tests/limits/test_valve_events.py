"""Valve events and spring margin against closed forms, and free of the samples kept."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

import synthetic_study as made
from train_parts import contacts, direct
from valvetrain.cam.closed_form import Harmonic
from valvetrain.integrate.contract import Periodic, RunOptions
from valvetrain.integrate.run import run
from valvetrain.mechanism.build import build_mechanism
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.parameters.templates import TEMPLATES, template_text
from valvetrain.parameters.train_parts import CamParameters
from valvetrain.quantities.evaluate import evaluate
from valvetrain.quantities.kinematics import rigid_motion
from valvetrain.quantities.signal import ring_peak
from valvetrain.quantities.train_numbers import OpenWindow, margin_quantities
from valvetrain.quantities.valve_events import (
    lift_crossings,
    open_window,
    rigid_events,
    run_events,
    sampled_crossings,
)
from valvetrain.runs.prepared import prepare
from valvetrain.runs.train_runs import prepare_trains, rigid_numbers
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Event, PartialFailures
from valvetrain.springs.massless import MasslessSpring
from valvetrain.system.build import build
from valvetrain.system.train_system import TrainSystem

TOP, FLANK, NOSE = 8e-3, math.radians(62), math.pi
LAW = Harmonic(
    maximum_lift=TOP,
    opening_start=NOSE - FLANK,
    opening_end=NOSE,
    closing_start=NOSE,
    closing_end=NOSE + FLANK,
)
THOU = 1.27e-3


def before_nose(height: float) -> float:
    """Angle (rad) before the nose at which the harmonic lift h / 2 (1 - cos(pi x)) stands at
    ``height``.
    """
    return FLANK * (1 - math.acos(1 - 2 * height / TOP) / math.pi)


@pytest.mark.parametrize("height", [1e-6, 1e-3, THOU, 7.9e-3])
def test_crossings_of_a_harmonic_lift_are_its_arc_cosine(height):
    found = lift_crossings(LAW.lift, height)
    assert found == pytest.approx(
        (NOSE - before_nose(height), NOSE + before_nose(height)), abs=1e-11
    )


def test_a_lift_that_never_stands_there_has_no_events_and_one_over_the_zero_of_the_angle_has():
    assert lift_crossings(LAW.lift, 9e-3) is None
    turned = lambda angle: LAW.lift(np.asarray(angle) + NOSE)
    opens, closes = lift_crossings(turned, 1e-3)
    assert opens == pytest.approx(math.tau - before_nose(1e-3)) and closes - opens == pytest.approx(
        2 * before_nose(1e-3)
    )


def test_a_valve_without_lash_opens_where_its_lobe_begins_and_not_at_a_grid_point():
    """Lift rests at zero on one side, so no sign changes there: the angle came out as that of a
    grid of a quarter degree.
    """
    begin, end = math.radians(118.13), math.radians(242.21)
    law = Harmonic(
        maximum_lift=TOP, opening_start=begin, opening_end=NOSE, closing_start=NOSE, closing_end=end
    )
    found = rigid_events(build_mechanism(direct(cam=CamParameters(0.030)), law).kinematics)
    assert found["rigid_valve_lash_opening_cam_angle"] == pytest.approx(begin, abs=1e-7)
    assert found["rigid_valve_lash_closing_cam_angle"] == pytest.approx(end, abs=1e-7)


@pytest.mark.parametrize("first", [0.7, 2.0, 5.0])
def test_the_open_window_of_two_humps_is_that_of_the_higher(first):
    """A short high hump and a long low one 120 degrees on: begin and end are those of the first, to
    the root.
    """

    def valve_lift(angle):
        high, low = (
            np.cos(np.mod(np.asarray(angle) - place + np.pi, math.tau) - np.pi)
            for place in (first, first + math.tau / 3)
        )
        return np.maximum(5e-3 * (high - 0.9), 0) / 0.1 + np.maximum(2e-3 * (low - 0.7), 0) / 0.3

    kinematics = SimpleNamespace(valve_lift=valve_lift)
    half, (begin, end) = math.acos(0.91), open_window(kinematics)
    assert begin == pytest.approx(
        (first - half) % math.tau, abs=1e-6
    ) and end - begin == pytest.approx(2 * half, abs=1e-6)
    window = OpenWindow.of(kinematics)
    assert (window.begin, window.end, window.top) == pytest.approx((begin, end, 5e-3), abs=1e-6)


def test_the_rigid_valve_opens_where_the_lash_is_taken_up():
    """A bucket: valve lift is cam lift less the lash, so every event of the valve is one of the
    lobe higher up.
    """
    lash = 0.2e-3
    found = rigid_events(
        build_mechanism(direct(lash=lash, cam=CamParameters(0.030)), LAW).kinematics
    )
    for word, height in (("lash", 0.0), ("1_mm", 1e-3), ("50_thou", THOU)):
        half = before_nose(height + lash)
        assert found[f"rigid_valve_{word}_opening_cam_angle"] == pytest.approx(
            NOSE - half, abs=1e-9
        )
        assert found[f"rigid_valve_{word}_closing_cam_angle"] == pytest.approx(
            NOSE + half, abs=1e-9
        )
        assert found[f"rigid_valve_{word}_open_crank_angle_range"] == pytest.approx(
            4 * half, abs=1e-9
        )
    assert found["lobe_50_thou_open_crank_angle_range"] == pytest.approx(
        4 * before_nose(THOU), abs=1e-9
    )


def test_a_peak_between_samples_is_that_of_its_parabola():
    """Of a sine the top is 1 to the fourth power of the step, wherever the samples fall; the
    largest sample is short by its square.
    """
    for shift in (0.0, 0.3, 0.5):
        values = np.sin(np.arange(180) * math.tau / 180 + shift * math.tau / 180)
        assert ring_peak(values) == pytest.approx(1.0, abs=2e-6)
    assert np.max(values) < 1 - 1e-4
    assert ring_peak(np.array([3.0, 1.0, 1.0, 2.0])) == pytest.approx(3 + 1 / (8 * 3)), (
        "the ends of a turn are neighbours"
    )


def test_sampled_crossings_gain_four_orders():
    errors = []
    for count in (45, 90, 180, 360):
        angle = np.arange(count) * math.tau / count
        opens, _ = sampled_crossings(angle, LAW.lift(angle), LAW.lift(angle, 1), THOU)
        errors.append(abs(opens - (NOSE - before_nose(THOU))))
    assert errors[-1] < 1e-8 and errors[0] / errors[-1] > 8**3 / 4


def test_the_spring_margin_is_that_of_a_mass_on_a_spring():
    """Nose of a bucket train: surplus F0 + k h - m a w^2, and its ratio; masses of tappet 50 g and
    valve 90 g, no weight along x.
    """
    train = direct(gravity=(0.0, 0.0), cam=CamParameters(0.030), contacts=contacts())
    system = TrainSystem(build_mechanism(train, LAW), (MasslessSpring(40e3, 300.0),))
    cam_speed = 250.0
    found = margin_quantities(rigid_motion(system, train).table(cam_speed))
    needed = 0.14 * (math.pi / FLANK) ** 2 * TOP / 2 * cam_speed**2
    angle = NOSE - np.linspace(0, FLANK / 2, 20001)
    shares = -0.14 * LAW.lift(angle, 2) * cam_speed**2
    surplus = 300 + 40e3 * LAW.lift(angle) - shares
    assert needed == pytest.approx(np.max(shares), rel=1e-6)
    assert found["minimum_spring_margin_force"] == pytest.approx(np.min(surplus[:-1]), rel=2e-3)
    assert found["minimum_spring_margin_ratio"] == pytest.approx(
        np.min(((300 + 40e3 * LAW.lift(angle)) / shares)[:-1]), rel=2e-3
    )


@pytest.mark.parametrize("cam_speed", [50.0, 250.0])
def test_the_loads_needed_keep_a_fifth_of_inertia_and_no_more(cam_speed):
    """A spring of the seat load and open load named has no surplus over 1.2 m a at its least, at a high speed at the
    rate of the case, at a low one from none closed.
    """
    train = direct(gravity=(0.0, 0.0), cam=CamParameters(0.030), contacts=contacts())
    system = TrainSystem(build_mechanism(train, LAW), (MasslessSpring(40e3, 300.0),))
    found = margin_quantities(rigid_motion(system, train).table(cam_speed))
    seat, full = found["needed_closed_spring_force"], found["needed_open_spring_force"]
    angle = NOSE - np.linspace(0, 0.99 * FLANK / 2, 20001)
    shares = -1.2 * 0.14 * LAW.lift(angle, 2) * cam_speed**2
    surplus = seat + (full - seat) * LAW.lift(angle) / TOP - shares
    assert np.min(surplus) == pytest.approx(0.0, abs=2e-3 * np.max(shares))
    assert seat == 0 if cam_speed == 50 else full - seat == pytest.approx(40e3 * TOP)


@pytest.mark.parametrize("model", ["massless", "modal-uniform", "multi-mass", "wave-rod"])
@pytest.mark.parametrize("spring_set", ["card", "dual"])
def test_the_margin_is_zero_at_the_float_speed_of_rigid_parts_whatever_spring_runs(
    model, spring_set
):
    """47 N were left by modal springs and chains, whose mass the rigid train did not carry. Off by
    the half degree of cam between the samples.
    """
    case = parse_case(template_text("pushrod", cards=True))
    problem = build(case, spring_models=(model,), spring_set=(spring_set,))
    ready, _ = prepare_trains(problem, [500.0], PartialFailures())
    numbers = rigid_numbers(ready, ())[spring_set]
    found = margin_quantities(ready[0].motion.table(numbers["rigid_contact_loss_engine_speed"] / 2))
    assert found["minimum_spring_margin_force"] == pytest.approx(0.0, abs=0.5)
    assert found["minimum_spring_margin_ratio"] == pytest.approx(1.0, abs=1e-3)


@cache
def card_runs() -> tuple[Solution, ...]:
    """The pushrod template with massless springs at 5000 rpm, with three numbers of samples."""
    problem = build(load_case(str(TEMPLATES / "pushrod.toml")), spring_models=("massless",))
    ready = prepare(problem, problem.members[0], {}, "")
    cam_speed = 2500 * math.pi / 30
    frame = replace(ready.frame, rigid=ready.motion.table(cam_speed))
    runs = (
        run(ready.system, cam_speed, Periodic(), RunOptions(samples, rest=ready.rest))
        for samples in (360, 720, 1440)
    )
    return tuple(evaluate(one, frame) for one in runs)


def test_events_torque_and_margin_of_a_run_do_not_move_with_the_samples_kept():
    coarse, middle, fine = (one.quantities for one in card_runs())
    names = [
        name
        for name in fine
        if name.startswith(
            ("valve_lash", "valve_1_mm", "valve_50_thou", "minimum_spring_margin", "mean_cam")
        )
    ]
    assert len(names) == 15
    for name in ("peak_cam_torque", "minimum_cam_torque"):
        assert middle[name] == pytest.approx(fine[name], rel=2e-4) and coarse[
            name
        ] == pytest.approx(fine[name], rel=3e-3)
    for name in names:
        allowed = (
            {"rel": 1e-9} if "cam_angle" not in name and "range" not in name else {"abs": 2e-5}
        )
        assert [coarse[name], middle[name]] == pytest.approx([fine[name]] * 2, **allowed), name


def test_a_card_that_says_its_timing_has_its_events_at_speed_against_dead_centre():
    """The pushrod template: an intake with top dead centre at 180 cam degrees."""
    found = card_runs()[-1].quantities
    for event, end, dead, sign in (("ivo", "opening", 180, -2), ("ivc", "closing", 270, 2)):
        expected = sign * (found[f"valve_50_thou_{end}_cam_angle"] - math.radians(dead))
        assert found[f"{event}_50_thou_crank_angle"] == pytest.approx(expected)
    assert not [name for name in found if name.startswith("ev")]


def test_the_mean_torque_carries_what_the_train_loses():
    """Over a closed cycle the work of the cam is heat: of contacts, links, guides and springs, and
    nothing else.
    """
    found = card_runs()[-1].quantities
    lost = found["cycle_dissipated_energy"] + found["spring_dissipated_energy"]
    assert found["mean_cam_torque"] * math.tau == pytest.approx(lost, rel=2e-2)
    assert found["mean_cam_power"] == pytest.approx(
        found["mean_cam_torque"] * 2500 * math.pi / 30, rel=1e-9
    )


def test_the_first_touch_closes_the_valve_wherever_it_stands_in_the_list():
    """A later touch may come first by its angle, where the seating passes the zero of the angle."""
    touches = [
        Event(
            "seating",
            angle,
            0.0,
            0.0,
            0.3,
            "m/s",
            "seat",
            {"touch": touch, "release_cam_angle": release},
        )
        for angle, touch, release in ((0.3, 2, 0.1), (6.1, 1, 3.0))
    ]
    found = run_events(made.rod_run().reduced(), touches)
    assert found["valve_lash_opening_cam_angle"] == 3.0 and found[
        "valve_lash_closing_cam_angle"
    ] == pytest.approx(6.1)
    assert found["valve_lash_open_crank_angle_range"] == pytest.approx(6.2)
    assert run_events(made.rod_run().reduced(), touches[:1]) == {}
    # top dead centre of gas exchange at 3.1 cam rad: it opens 0.2 crank rad before it, and closes 6.0 after it
    timed = run_events(made.rod_run().reduced(), touches, 3.1)
    assert timed["ivo_lash_crank_angle"] == pytest.approx(0.2)
    assert timed["ivc_lash_crank_angle"] == pytest.approx(6.0 - math.pi)
    assert not [name for name in found if name.endswith("lash_crank_angle")]
