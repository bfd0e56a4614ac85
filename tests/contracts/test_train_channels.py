"""Every channel of a train's run keeps the relation that its name and unit ask for: rates, sums,
gaps against forces, work.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from valvetrain.mechanism.planar import piston_clearance
from valvetrain.parameters.loading import load_case
from valvetrain.runs.api import simulate

#: Forces inside elastic parts, whose sizes other tests hold to closed forms
#: (tests/limits/test_train_dynamics.py).
INSIDE = {"lever_bending_moment", "support_force", "stem_force"}


@pytest.fixture(scope="module")
def ran():
    case = load_case("vaz-ohc")
    (run,) = simulate(case, engine_speeds=(250.0,), models=("massless",)).solutions
    return case, run


def rate(run, channel: str) -> np.ndarray:
    """Central difference in time round the closed cycle."""
    values, step = run.channel(channel), run.time[1] - run.time[0]
    return (np.roll(values, -1) - np.roll(values, 1)) / (2 * step)


def alike(one: np.ndarray, other: np.ndarray, share: float = 0.02) -> bool:
    """The same curve: median difference within a share of the largest value; impacts are sharper
    than the samples.
    """
    return bool(np.median(np.abs(one - other)) <= share * np.max(np.abs(other)))


def test_rates_are_those_of_what_they_name(ran):
    _, run = ran
    known = {
        "valve_velocity": "valve_lift",
        "valve_acceleration": "valve_velocity",
        "retainer_acceleration": "retainer_velocity",
    }
    for channel, before in known.items():
        assert alike(rate(run, before), run.channel(channel)), channel
    assert alike(run.channel("retainer_velocity"), run.channel("valve_velocity"), 0.05)
    np.testing.assert_allclose(run.time, run.cam_angle / (run.engine_speed / 2))
    assert np.max(run.channel("valve_lift")) > 8e-3 and np.argmax(
        run.channel("valve_velocity")
    ) < np.argmax(run.channel("valve_lift"))


def test_forces_of_a_nest_add_up_and_rest_on_their_static_curve(ran):
    _, run = ran
    for end in ("seat_force", "retainer_force"):
        np.testing.assert_allclose(
            run.channel(f"outer_{end}") + run.channel(f"inner_{end}"), run.channel(end), rtol=1e-9
        )
    lift, still = np.clip(run.channel("valve_lift"), 0, None), run.channel("static_retainer_force")
    closed = lift < 1e-6
    assert np.ptp(still[closed]) < 5.0 and still[np.argmax(lift)] > 1.3 * still[closed].mean()
    assert alike(run.channel("retainer_force"), still, 0.05)


@pytest.mark.parametrize("place", ["cam", "valve_tip", "seat"])
def test_an_open_contact_carries_nothing_and_a_closed_one_presses(ran, place):
    _, run = ran
    gap, force = run.channel(f"{place}_gap"), run.channel(f"{place}_contact_force")
    assert np.all(force >= 0) and np.max(force) > 100
    assert np.all(force[gap > 2e-6] == 0) and np.all(gap[force > 50] < 1e-6)


def test_the_torque_of_the_cam_does_the_work_of_the_cycle(ran):
    _, run = ran
    torque, force = run.channel("cam_torque"), run.channel("cam_contact_force")
    work = float(np.mean(torque)) * 2 * math.pi
    assert work == pytest.approx(float(run.statistics["cycle_work_energy"]), rel=0.03)
    assert (
        0.002 < np.max(torque) / np.max(force) < 0.05
    )  # an arm of some millimetres, less than the cam is wide
    rising = (run.channel("rigid_valve_lift") > 1e-3) & (rate(run, "rigid_valve_lift") > 0)
    assert np.mean(run.channel("cam_torque")[rising]) > 0


def test_the_lever_turns_with_the_valve_and_the_piston_keeps_its_distance(ran):
    case, run = ran
    train = case.train
    arm = train.lever.valve_arm * math.cos(train.lever.valve_angle)
    assert alike(
        np.abs(run.channel("lever_speed")) * arm, np.abs(run.channel("valve_velocity")), 0.05
    )
    lift = np.clip(run.channel("valve_lift"), 0, None)
    assert alike(
        run.channel("piston_clearance"), piston_clearance(train.crank, run.cam_angle, lift), 1e-3
    )
    assert np.max(run.channel("piston_clearance")) > np.min(run.channel("piston_clearance")) > 0
    turned = 2 * (run.cam_angle - train.crank.top_dead_centre) - run.channel("crank_angle")
    assert np.allclose(turned / (4 * np.pi), np.round(turned / (4 * np.pi)), atol=1e-9)
    assert np.max(np.abs(run.channel("crank_angle"))) <= 2 * np.pi


def test_the_rigid_channels_are_the_law_and_near_the_run(ran):
    _, run = ran
    assert np.max(run.channel("rigid_valve_lift")) == pytest.approx(9.7e-3, rel=1e-3)
    opened = run.channel("rigid_valve_lift") > 1e-3
    assert alike(run.channel("valve_lift")[opened], run.channel("rigid_valve_lift")[opened], 0.03)
    assert alike(
        run.channel("cam_contact_force")[opened], run.channel("rigid_contact_force")[opened], 0.25
    )


def test_places_of_bodies_have_the_rates_and_strain_the_links_between_them(ran):
    """Rates of the places are velocities that are told besides; k x + c x' of the case is the force
    of every elastic link.
    """
    case, run = ran
    train = case.train
    assert alike(rate(run, "lever_angle"), run.channel("lever_speed")) and alike(
        rate(run, "valve_tip_displacement"), run.channel("retainer_velocity")
    )
    links = {
        "stem_force": (("valve_tip_displacement", "valve_lift"), train.valve.stem_stiffness, train.valve.stem_damping),
        "support_force": (("support_displacement",), train.support.stiffness, train.support.damping),
        "lever_bending_moment": (
            ("lever_angle", "lever_tip_angle"), train.lever.stiffness * train.lever.valve_arm**2,
            train.lever.damping * train.lever.valve_arm**2,
        ),
    }  # fmt: skip
    for force, (names, stiffness, damping) in links.items():
        first, *second = names
        strain = run.channel(first) - (run.channel(second[0]) if second else 0.0)
        speed = rate(run, first) - (rate(run, second[0]) if second else 0.0)
        assert alike(stiffness * strain + damping * speed, run.channel(force)), force


def test_no_channel_is_without_its_relation(ran):
    _, run = ran
    known = {
        "valve_lift", "valve_velocity", "valve_acceleration", "retainer_velocity", "retainer_acceleration", "retainer_force", "seat_force",
        "static_retainer_force", "outer_retainer_force", "outer_seat_force", "inner_retainer_force", "inner_seat_force", "cam_torque",
        "lever_speed", "lever_angle", "lever_tip_angle", "support_displacement", "valve_tip_displacement", "piston_clearance",
        "rigid_valve_lift", "rigid_contact_force", "crank_angle",
        "rigid_spring_force", "rigid_spring_margin", "rigid_hertz_pressure", "cam_contact_pressure",  # tests/limits/test_field_views.py
        *(f"{place}_{word}" for place in ("cam", "valve_tip", "seat") for word in ("gap", "contact_force")),
    }  # fmt: skip
    assert not set(map(str, run.channels.data_vars)) - known - INSIDE
