"""Contact forces of rigid theory: gas included, every joint of the drive, loss of contact at the
exact angle; against closed forms.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from train_parts import KINDS, LAW, direct, finger, system
from valvetrain.cam.closed_form import Harmonic
from valvetrain.mechanism.contour import monotone_table
from valvetrain.quantities.kinematics import rigid_motion, rigid_quantities

PRELOAD, RATE, SPRING_MASS = 300.0, 30e3, 0.04 / 3
GRAVITY = 9.80665


def pressed(train, force, law=LAW):
    """A train with a gas force (N, opening positive) that is constant but for one fifth of a turn."""
    gas = monotone_table(np.linspace(0, 2 * np.pi, 10, endpoint=False), np.full(10, float(force)))
    return replace(system(train, law), gas=gas)


def test_rigid_forces_carry_the_gas():
    """A force of -400 N on the valve presses the drive of a direct train with 400 N more, wherever
    the valve is open.
    """
    train = direct()
    without, held = rigid_motion(system(train), train), rigid_motion(pressed(train, -400.0), train)
    for cam_speed in (50.0, 200.0):
        plain, gas = without.table(cam_speed), held.table(cam_speed)
        up = plain["valve_lift"] > 0
        for name in ("contact_force", "valve_tip_contact_force", "spring_margin"):
            assert gas[name][up] - plain[name][up] == pytest.approx(400.0, abs=1e-6), name
        assert gas["cam_torque"] - plain["cam_torque"] == pytest.approx(
            400.0 * plain["valve_velocity"] / cam_speed * up, abs=1e-6
        )
        loaded = up & (plain["contact_force"] > 1)
        share = np.sqrt(gas["contact_force"][loaded] / plain["contact_force"][loaded])
        assert gas["hertz_pressure"][loaded] / plain["hertz_pressure"][loaded] == pytest.approx(
            share, rel=1e-9
        )


@pytest.mark.parametrize("force", [0.0, -500.0, 200.0])
def test_loss_of_contact_with_gas_is_that_of_newton(force):
    """Direct train: cam_speed**2 = (preload + rate lift - weight - gas) / (-mass lift''), the least
    over the event.
    """
    train = direct()
    built = pressed(train, force)
    mass = float(np.sum(built.masses))
    weight = GRAVITY * (train.follower.mass + train.valve.mass)
    fine = np.radians(np.linspace(41, 239, 2_000_001))
    lift, bend = LAW.lift(fine), LAW.lift(fine, 2)
    squares = np.where(
        bend < 0,
        (PRELOAD + RATE * lift - weight - force) / np.where(bend < 0, -mass * bend, 1.0),
        np.inf,
    )
    found = rigid_motion(built, samples=90)
    assert found.contact_loss()[0] == pytest.approx(math.sqrt(squares.min()), rel=1e-8)
    assert found.contact_loss()[1] == pytest.approx(fine[np.argmin(squares)], abs=1e-5)
    assert rigid_quantities(found)["rigid_contact_loss_engine_speed"] == 2 * found.contact_loss()[0]


def test_a_jump_of_acceleration_loses_contact_at_its_own_angle():
    """Harmonic rise to a dwell: acceleration jumps from its least to zero at the top, at an angle
    that no grid holds.
    """
    top, start, end = 5e-3, math.radians(40.13), math.radians(133.37)
    law = Harmonic(
        maximum_lift=top,
        opening_start=start,
        opening_end=end,
        closing_start=end + 0.5,
        closing_end=end + 2.5,
    )
    train = direct()
    built = system(train, law)
    mass, weight = float(np.sum(built.masses)), GRAVITY * (train.follower.mass + train.valve.mass)
    least = top / 2 * (math.pi / (end - start)) ** 2
    found = rigid_motion(built, samples=360)
    assert found.contact_loss()[0] == pytest.approx(
        math.sqrt((PRELOAD + RATE * top - weight) / (mass * least)), rel=1e-7
    )
    assert found.contact_loss()[1] == pytest.approx(end, abs=1e-6)


@pytest.mark.parametrize("start", [0.3, 1.9, 2.1, 5.0])
def test_loss_is_sought_close_to_both_sides_of_every_joint_of_the_law(start):
    """Joints anywhere in the turn, beyond its end too, lie between two of the angles, in unlike
    segments.
    """
    joints = start + np.array([0.0, 1.0, 1.5, 3.5])
    names = ("opening_start", "opening_end", "closing_start", "closing_end")
    law = Harmonic(maximum_lift=1e-3, **dict(zip(names, joints.tolist(), strict=True)))
    forces = rigid_motion(system(direct(), law), samples=90).forces
    points, segment = forces._points(np.linspace(0, 2 * np.pi, 90, endpoint=False))
    for joint in np.mod(joints, 2 * np.pi):
        after = int(np.searchsorted(points, joint))
        assert points[[after - 1, after]] == pytest.approx([joint - 1e-9, joint + 1e-9], abs=1e-10)
        assert segment[after] == segment[after - 1] + 1


def test_contact_is_lost_first_at_the_joint_that_rigid_theory_unloads_first():
    """A holding torque keeps the finger on the cam; the valve leaves its tip, whose force is
    Newton's law of the valve alone.
    """
    train = finger()
    train = train.replace(lever=replace(train.lever, holding_torque=60.0))
    built = system(train)
    motion = rigid_motion(built, train)
    valve = float(built.masses[built.mechanism.index("valve")])
    fine = np.radians(np.linspace(41, 239, 400_001))
    lift, bend = (built.mechanism.kinematics.valve_lift(fine, order) for order in (0, 2))
    squares = np.where(
        bend < 0,
        (PRELOAD + RATE * lift - GRAVITY * train.valve.mass)
        / np.where(bend < 0, -valve * bend, 1.0),
        np.inf,
    )
    assert motion.first_loss.place == "valve_tip"
    assert motion.contact_loss()[0] == pytest.approx(math.sqrt(squares.min()), rel=1e-8)
    assert motion.contact_loss()[1] == pytest.approx(fine[np.argmin(squares)], abs=1e-5)
    assert (
        np.min(motion.table(motion.contact_loss()[0])["contact_force"][motion.derivatives[0] > 0])
        > 0
    )


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("lash", [0.0, 2e-4])
def test_force_at_the_cam_is_the_virtual_work_of_all_loads(kind, lash):
    """Newton's law body by body gives at the cam what energy gives: inertia, spring, weight and gas
    over the travel of the cam's normal.
    """
    train = KINDS[kind](lash=lash)
    motion = rigid_motion(pressed(train, -150.0), train, 360)
    table = motion.table(250.0)
    worked = (table["inertia_force"] + table["spring_force"] - motion.weight + 150.0) * table[
        "motion_ratio"
    ]
    up = table["valve_lift"] > 0
    assert table["contact_force"][up] == pytest.approx(worked[up], rel=1e-6, abs=1e-4)
    assert not np.any(table["contact_force"][~up])
