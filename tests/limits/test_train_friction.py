"""Friction in the contacts of trains against closed forms: torque on a flat tappet's cam, moment of
a rubbing tip, energy.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from train_parts import LAW, STIFF, contacts, direct, finger, pushrod, rocker, system
from twins.train_step import sliding_state
from valvetrain.contact.friction import CoulombFriction
from valvetrain.integrate.train_friction import slowed
from valvetrain.integrate.train_record import TrainOptions
from valvetrain.integrate.train_run import runner
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.train_parts import FollowerParameters
from valvetrain.quantities.kinematics import rigid_table
from valvetrain.system.rigid_pose import rigid_poses

MU = 0.12


def rough(*places: str, coefficient: float = MU, width: float = 0.01):
    return contacts() | {
        place: replace(STIFF, friction_coefficient=coefficient, friction_velocity=width)
        for place in places
    }


def steady_cycle(train, cam_speed=150.0, cycles=3, **options):
    ready = runner(system(train), cam_speed, TrainOptions(samples=720, **options))
    state = ready.initial_state()
    for _ in range(cycles):
        state, record = ready.cycle(state)
    return ready.system, record


@pytest.mark.parametrize("rotation", [1, -1])
def test_a_flat_tappet_adds_mu_n_times_the_height_of_its_face_to_the_cam_torque(rotation):
    """Face across the guide: the tangent stands across the motion, so only the torque changes, by
    mu N (base radius + lift).
    """
    plain = direct(cam=replace(direct().cam, rotation=rotation))
    _, smooth = steady_cycle(plain)
    built, rubbed = steady_cycle(plain.replace(contacts=rough("cam")))
    assert rubbed.q == pytest.approx(smooth.q, abs=1e-15)
    cam = built.mechanism.interaction_index("cam")
    # the face stands one penetration nearer to the centre than the contour does
    height = (
        plain.cam.base_radius + rubbed.q[:, built.mechanism.index("tappet")] - rubbed.gaps[:, cam]
    )
    torque = (rubbed.cam_power - smooth.cam_power) / rubbed.cam_speed
    assert torque == pytest.approx(MU * rubbed.forces[:, cam] * height, rel=1e-9, abs=1e-9)
    assert np.max(torque) > 0.5
    assert rubbed.work[0] - smooth.work[0] == pytest.approx(rubbed.friction_loss, rel=1e-9)
    assert rubbed.friction_loss == pytest.approx(np.mean(torque) * 2 * np.pi, rel=1e-3)


@pytest.mark.parametrize(
    "train",
    [
        direct(),
        direct(follower=FollowerParameters("flat", mass=0.05, tilt=0.05, offset=3e-3)),
        finger(),
        pushrod(),
        direct(follower=FollowerParameters("domed", radius=0.04, mass=0.05, offset=2e-3)),
        finger(
            follower=FollowerParameters("flat"),
            lever=replace(finger().lever, pivot=(-0.03, -0.018)),
        ),
    ],
)
@pytest.mark.parametrize("rotation", [1, -1])
def test_cam_sliding_in_the_loop_is_that_of_rigid_kinematics(train, rotation):
    train = train.replace(cam=replace(train.cam, rotation=rotation))
    built = system(train)
    table, poses = rigid_table(built, train, 100.0, samples=120), rigid_poses(built)
    cam, lift = built.mechanism.interaction_index("cam"), table["valve_lift"]
    positions, modes = poses.positions(lift), poses.mode(lift)
    for row in range(120):
        gradients, slopes = sliding_state(built, positions[row], float(table.cam_angle[row]))
        sliding = slopes[cam] * 100.0 + gradients[cam] @ modes[row] * table["valve_velocity"][row]
        assert sliding == pytest.approx(table["sliding_velocity"][row], abs=2e-4)
    assert np.max(np.abs(table["sliding_velocity"])) > 1.0


def test_a_rubbing_tip_turns_its_lever_with_mu_n_times_the_arm():
    """Newton's law of the lever, moments taken of force vectors at the points where they act; the
    roller on the cam does not rub.
    """
    train = rocker(contacts=rough("valve_tip"), lever=replace(rocker().lever, tip_radius=8e-3))
    built, record = steady_cycle(train, 120.0)
    lever, sign = train.lever, built.mechanism.interactions[1].geometry[5]
    names, turn = built.interaction_names, record.q[:, built.mechanism.index("lever")]
    force = record.forces[:, names.index("valve_tip")]
    angle = lever.valve_angle + sign * turn
    # the valve opens downwards: its face looks up, the arc touches at its lowest point
    x, y = lever.valve_arm * np.cos(angle), lever.valve_arm * np.sin(angle) - lever.tip_radius
    slip = (
        -sign * record.v[:, built.mechanism.index("lever")] * y
    )  # of the lever's material along +x
    friction = -MU * force * np.tanh(slip / 0.01)
    moment = x * force - y * friction
    rest = (
        sign * lever.inertia * record.a[:, built.mechanism.index("lever")]
        + sign * lever.holding_torque
    )
    _, smooth = steady_cycle(rocker(lever=train.lever), 120.0)
    drive = rest - moment  # what the cam must turn the lever with, friction counted
    sliding = (np.abs(slip) > 0.1) & (force > 50.0)
    assert np.count_nonzero(sliding) > 100
    cam = built.mechanism.interaction_index("cam")
    arm = drive[sliding] / record.forces[sliding, cam]
    bare = (rest - x * force)[sliding] / record.forces[sliding, cam]
    # without friction the same geometry gives the arm; its two flanks carry the same arm only when
    # friction is counted
    reference = _arm(built, record)[sliding] * sign
    assert arm == pytest.approx(reference, rel=2e-3)
    assert np.max(np.abs(bare / reference - 1)) > 0.01
    assert record.friction_loss > 0
    assert record.work[0] > smooth.work[0] + 0.9 * record.friction_loss


def _arm(built, record):
    from valvetrain.system.train_forces import gap_state

    cam, lever = built.mechanism.interaction_index("cam"), built.mechanism.index("lever")
    return np.array(
        [
            -gap_state(built, q, a)[1][cam, lever]
            for q, a in zip(record.q, record.cam_angle, strict=True)
        ]
    )


@pytest.mark.parametrize(
    ("train", "places"),
    [(finger, ("cam", "valve_tip")), (pushrod, ("cam", "valve_tip")), (direct, ("cam",))],
)
def test_energy_balances_with_friction_and_friction_takes_it(train, places):
    _, record = steady_cycle(train(contacts=rough(*places)), 220.0, step_fraction=0.05)
    cam, constant, lost, spring = record.work
    assert cam + constant == pytest.approx(lost + spring, rel=5e-3)
    assert 0 < record.friction_loss < lost
    _, smooth = steady_cycle(train(), 220.0, step_fraction=0.05)
    assert smooth.friction_loss == 0.0
    assert lost - smooth.work[2] == pytest.approx(record.friction_loss, rel=0.05)


def test_friction_never_limits_the_step():
    """Thirty times more friction than the mass bears in one step of an explicit method, on a tip
    that turns back twice a cycle.
    """
    train = rocker(contacts=rough("valve_tip", coefficient=0.5, width=1e-5))
    energies = []
    for fraction in (0.5, 0.25):
        _, record = steady_cycle(train, 200.0, step_fraction=fraction)
        assert record.status.completed
        energies.append(record.friction_loss)
    assert energies[0] == pytest.approx(energies[1], rel=0.01)


@pytest.mark.parametrize("free", [-30.0, -1e-3, 0.0, 1e-9, 3e-3, 0.02, 5.0])
@pytest.mark.parametrize("most", [1e-6, 1e-2, 4.0])
def test_the_implicit_friction_step_solves_its_equation(free, most):
    found = slowed(free, most, 0.01)
    exact = brentq(
        lambda s: s + most * math.tanh(s / 0.01) - free,
        -abs(free) - 1e-12,
        abs(free) + 1e-12,
        xtol=1e-18,
    )
    assert found == pytest.approx(exact, rel=1e-10, abs=1e-14)
    assert CoulombFriction(most).force(1.0, found) == pytest.approx(
        found - free, abs=1e-12 + 1e-10 * abs(free)
    )


def test_one_key_in_the_case_file_brings_friction():
    from pathlib import Path

    guide = (Path(__file__).parents[2] / "docs/case-files-trains.md").read_text()
    text = guide.split("```toml\n")[1].split("```")[0]
    assert parse_case(text, "guide").train.contact("cam").friction_coefficient == 0.0
    keys = "[train.contacts.cam]\nfriction_coefficient = 0.1\nfriction_velocity = '5 mm/s'\n"
    case = parse_case(text.replace("[train.contacts.cam]\n", keys), "guide")
    assert case.train.contact("cam").friction_coefficient == 0.1
    assert case.train.contact("cam").friction_velocity == pytest.approx(5e-3)
    assert system(case.train.replace(spring_set="", springs={}), LAW).arrays.friction[
        0
    ] == pytest.approx([0.1, 5e-3])
