"""Rigid motion of a train is found once; the table of any speed follows from it."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.parameters.loading import load_case
from valvetrain.quantities.kinematics import rigid_motion, rigid_quantities, rigid_table
from valvetrain.system.build import build
from valvetrain.system.train_forces import gap_state


@pytest.fixture(scope="module")
def parts():
    case = load_case("tdi-pushrod")
    system = build(case, spring_models=["massless"], spring_set=["stock"]).members[0].system()
    return case.train, system, rigid_motion(system, case.train, 360)


@pytest.mark.parametrize("cam_speed", [50.0, 200.0, 400.0])
def test_a_table_of_any_speed_is_that_found_at_this_speed_alone(parts, cam_speed):
    train, system, motion = parts
    alone, shared = rigid_table(system, train, cam_speed, 360), motion.table(cam_speed)
    assert (
        set(alone.columns)
        == set(shared.columns)
        >= {"contact_force", "hertz_pressure", "sliding_velocity"}
    )
    for name in alone.columns:
        np.testing.assert_array_equal(shared[name], alone[name])


def test_inertia_grows_with_the_square_of_speed_and_the_spring_does_not(parts):
    slow, fast = (parts[2].table(speed) for speed in (100.0, 200.0))
    np.testing.assert_allclose(fast["inertia_force"], 4 * slow["inertia_force"])
    np.testing.assert_array_equal(fast["spring_force"], slow["spring_force"])
    np.testing.assert_allclose(fast["sliding_velocity"], 2 * slow["sliding_velocity"])


def test_contact_force_is_nought_where_contact_is_lost(parts):
    motion = parts[2]
    cam_speed, angle = motion.contact_loss()
    shares = motion.forces.shares(np.array([angle]))
    at_cam = motion.forces.places.index("cam")
    assert (shares.static + shares.inertia * cam_speed**2)[0, at_cam] == pytest.approx(
        0.0, abs=1e-9 * shares.static[0, at_cam]
    )
    assert (
        np.min(motion.table(0.99 * cam_speed)["contact_force"])
        >= 0
        > np.min(motion.table(1.01 * cam_speed)["contact_force"])
    )
    found = rigid_quantities(motion)
    assert (
        found["rigid_contact_loss_engine_speed"] == 2 * cam_speed
        and found["rigid_contact_loss_cam_angle"] == angle
    )
    assert found["rigid_maximum_valve_lift"] == pytest.approx(8e-3, rel=1e-3)


def test_forces_of_all_angles_at_once_are_newtons_law_at_each(parts):
    """Oracle: least squares per angle on gradients of the gaps found by differences, and the
    balance of every body.
    """
    _, system, motion = parts
    angle, forces = np.linspace(2.1, 4.1, 23), motion.forces
    shares, kinematics = forces.shares(angle), system.mechanism.kinematics
    assert np.min(kinematics.valve_lift(angle)) > 0
    for row, one in enumerate(angle.tolist()):
        lift, velocity, acceleration = (
            float(kinematics.valve_lift(np.array([one]), order)[0]) for order in range(3)
        )
        tight = forces.poses_at(np.array([lift]))
        q = forces.poses.positions(tight)[0]
        by_difference = np.array(
            [
                (
                    gap_state(system, q + 1e-7 * unit, one)[0]
                    - gap_state(system, q - 1e-7 * unit, one)[0]
                )
                / 2e-7
                for unit in np.eye(len(q))
            ]
        )[:, forces.active]
        loads = system.arrays.body[:, 1].copy()
        loads[system.arrays.retainer] -= forces.static_spring_force(np.array([lift]))[0]
        change = (
            forces.poses.mode(tight)[0] * acceleration
            + forces.poses.mode(tight, 1)[0] * velocity**2
        )
        for told, side in ((shares.static, loads), (shares.inertia, -system.masses * change)):
            alone = np.linalg.lstsq(by_difference, side, rcond=None)[0]
            kept = [place for place, k in enumerate(forces.active) if system.arrays.laws[k] >= 0]
            np.testing.assert_allclose(told[row], alone[kept], rtol=1e-6)
