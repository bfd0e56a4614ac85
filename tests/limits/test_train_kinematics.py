"""Cam geometry, rigid kinematics and quasi-statics against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from train_parts import KINDS, LAW, direct, finger, pushrod, system
from valvetrain.mechanism.build import build_mechanism
from valvetrain.mechanism.contour import curvature_radius_flat, curvature_radius_round
from valvetrain.mechanism.lumped import equivalent_mass
from valvetrain.mechanism.planar import piston_clearance, piston_travel
from valvetrain.mechanism.rigid import RatioCurve
from valvetrain.parameters.train_parts import CamParameters, CrankParameters, FollowerParameters
from valvetrain.quantities.kinematics import rigid_motion, rigid_table
from valvetrain.system.train_forces import gap_state

RADIUS, OFFSET, ROLLER = (
    0.02,
    0.004,
    0.01,
)  # an eccentric circle as a cam: everything is known of it


class EccentricFlat:
    """Lift of a flat follower on a circle of RADIUS, OFFSET from the cam centre."""

    continuity, joints = 9, ()

    def lift(self, cam_angle, derivative=0):
        angle = np.asarray(cam_angle, dtype=float)
        wave = [lambda x: 1 - np.cos(x), np.sin, np.cos, lambda x: -np.sin(x)][derivative]
        return OFFSET * wave(angle)


class EccentricRoller:
    """Lift of a central roller on the same circle."""

    continuity, joints = 9, ()

    def lift(self, cam_angle, derivative=0):
        angle = np.asarray(cam_angle, dtype=float)
        reach = lambda x: (
            -OFFSET * np.cos(x) + np.sqrt((RADIUS + ROLLER) ** 2 - (OFFSET * np.sin(x)) ** 2)
        )
        if derivative == 0:
            return reach(angle) - reach(np.zeros(1))[0]
        step = 1e-4
        return (
            self.lift(angle + step, derivative - 1) - self.lift(angle - step, derivative - 1)
        ) / (2 * step)


def test_an_eccentric_circle_has_its_own_radius_under_a_flat_follower():
    train = direct(cam=CamParameters(RADIUS - OFFSET))
    table = build_mechanism(train, EccentricFlat()).tables["cam contour"]
    assert curvature_radius_flat(table) == pytest.approx(RADIUS, rel=1e-6)


@pytest.mark.parametrize("rotation", [1, -1])
def test_an_eccentric_circle_has_its_own_radius_under_a_roller(rotation):
    train = direct(
        cam=CamParameters(RADIUS - OFFSET, rotation=rotation),
        follower=FollowerParameters("roller", ROLLER, 0.05),
    )
    built = system(train, EccentricRoller())
    table = built.mechanism.tables["cam contour"]
    assert curvature_radius_round(table, ROLLER) == pytest.approx(RADIUS, rel=1e-5)
    # gap to the exact circle: the cam's centre stands at OFFSET from the origin, opposite to the
    # follower at angle zero
    for angle in (0.4, 1.9, 3.3, 5.5):
        lift = EccentricRoller().lift(angle) - 20e-6
        centre = np.array([0.0, -(RADIUS - OFFSET + ROLLER) - lift])
        eccentre = OFFSET * np.array([-rotation * math.sin(angle), math.cos(angle)])
        exact = RADIUS + ROLLER - math.dist(centre, eccentre)
        pens, _, _ = gap_state(built, np.array([lift, 0.0]), angle)
        assert pens[0] == pytest.approx(exact, rel=2e-3)


def test_pressure_on_the_cam_is_that_of_the_handbooks_for_steel():
    """p0 = 0.418 sqrt(F E / (L R)) of a line contact, the cam's radius known everywhere and the
    follower flat.
    """
    train = direct(cam=CamParameters(RADIUS - OFFSET))
    table = rigid_table(system(train, EccentricFlat()), train, 100.0)
    force, lifted = table["contact_force"], table["valve_lift"] > 1e-5
    expected = 0.418 * np.sqrt(
        np.maximum(force, 0.0) * train.cam.youngs_modulus / (train.cam.width * RADIUS)
    )
    assert np.max(force[lifted]) > 100
    assert table["hertz_pressure"][lifted] == pytest.approx(expected[lifted], rel=2e-3)


def test_flat_follower_slides_with_the_speed_of_the_face_and_touches_beside_the_axis():
    train, omega = direct(), 200.0
    table = rigid_table(system(train), train, omega)
    lift, slope = LAW.lift(table.cam_angle), LAW.lift(table.cam_angle, 1)
    assert np.abs(table["sliding_velocity"]) == pytest.approx(
        omega * (train.cam.base_radius + lift), rel=1e-6
    )
    assert np.abs(table["contact_offset"]) == pytest.approx(np.abs(slope), abs=1e-8)


def test_direct_train_obeys_newton_and_loses_contact_where_the_closed_form_says():
    train, omega = direct(), 300.0
    built = system(train)
    table = rigid_table(built, train, omega)
    angle = table.cam_angle
    mass, weight = 0.05 + 0.09 + 0.04 / 3, (0.05 + 0.09) * 9.80665
    lift, bend = LAW.lift(angle), LAW.lift(angle, 2)
    open_valve = lift > 0
    expected = mass * bend * omega**2 + 300.0 + 30e3 * lift - weight
    assert table["contact_force"][open_valve] == pytest.approx(expected[open_valve], rel=1e-7)
    fine = np.linspace(0, 2 * np.pi, 20001)
    lift, bend = LAW.lift(fine), LAW.lift(fine, 2)
    risky = bend < 0
    squares = (300.0 + 30e3 * lift[risky] - weight) / (-mass * bend[risky])
    cam_speed, where = rigid_motion(built, samples=4320).contact_loss()
    assert cam_speed == pytest.approx(math.sqrt(squares.min()), rel=1e-5)
    assert where == pytest.approx(fine[risky][np.argmin(squares)], abs=math.radians(0.2))


def test_finger_lift_is_the_arc_of_its_tip():
    train = finger(model="planar")
    motion = build_mechanism(train, LAW, "tappet").kinematics
    angle = np.linspace(0, 2 * np.pi, 721)
    turn = LAW.lift(angle) / train.lever.drive_arm
    closed = train.lever.valve_arm * (
        np.sin(train.lever.valve_angle) - np.sin(train.lever.valve_angle - turn)
    )
    assert motion.valve_lift(angle) == pytest.approx(closed, abs=1e-12)
    step = 1e-4
    for order in (1, 2, 3):  # derivatives against differences of the one below
        around = (
            motion.valve_lift(angle + step, order - 1) - motion.valve_lift(angle - step, order - 1)
        ) / (2 * step)
        inside = np.abs(np.mod(angle, 2 * np.pi) - math.radians(140)) < math.radians(95)
        assert motion.valve_lift(angle, order)[inside] == pytest.approx(
            around[inside], abs=2e-6 * 100 ** (order - 1)
        )


def test_a_valve_lift_law_is_met_through_the_lever():
    motion = build_mechanism(finger(), LAW, "valve").kinematics
    angle = np.linspace(0, 2 * np.pi, 721)
    assert motion.valve_lift(angle) == pytest.approx(LAW.lift(angle), abs=1e-14)


@pytest.mark.parametrize(("kind", "base"), [("direct", 0.018), ("pushrod", 0.016)])
def test_a_roller_beside_the_cam_axis_rests_on_the_base_circle(kind, base):
    roller = FollowerParameters("roller", radius=0.01, offset=0.004, mass=0.05)
    (contour,) = build_mechanism(KINDS[kind](follower=roller), LAW, "tappet").tables.values()
    assert contour[:, 0].min() == pytest.approx(base + 0.01, rel=1e-12)


def test_pushrod_keeps_its_length():
    train = pushrod()
    motion = build_mechanism(train, LAW, "tappet").kinematics
    angle = np.linspace(0, 2 * np.pi, 361)
    lift = motion.valve_lift(angle)
    turn = np.arcsin(lift / train.lever.valve_arm)  # the valve arm is level at zero lift
    ball = np.array(train.lever.pivot)[:, None] + train.lever.drive_arm * np.array(
        [-np.cos(turn), np.sin(turn)]
    )
    foot = np.array(train.pushrod.lower_end)[:, None] + np.array(
        [np.zeros_like(angle), LAW.lift(angle)]
    )
    length = np.hypot(*(ball - foot))
    assert length == pytest.approx(length[0], abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_slow_cam_does_the_work_of_the_springs_and_weights_only(kind):
    train = KINDS[kind]()
    built = system(train)
    table = rigid_table(built, train, 1e-6)
    from valvetrain.system.rigid_pose import rigid_poses

    travel = built.mechanism.kinematics.valve_lift(table.cam_angle, 1)
    static = 300.0 + 30e3 * table["valve_lift"] - rigid_poses(built).weight(table["valve_lift"])
    assert table["cam_torque"] == pytest.approx(static * travel, abs=2e-5)
    assert np.mean(rigid_table(built, train, 300.0)["cam_torque"]) == pytest.approx(0.0, abs=1e-5)


def test_reduced_mass_of_a_lever_train_is_that_of_the_textbook():
    train = finger(model="planar")
    expected = (
        train.valve.mass
        + train.lever.inertia / (train.lever.valve_arm * math.cos(train.lever.valve_angle)) ** 2
    )
    assert equivalent_mass(build_mechanism(train, LAW)) == pytest.approx(expected, rel=1e-9)


def test_lumped_train_has_the_rigid_lift_of_the_planar_one():
    for make in KINDS.values():
        planar, lumped = (build_mechanism(make(model=model), LAW) for model in ("planar", "lumped"))
        assert lumped.kinematics.maximum_lift == planar.kinematics.maximum_lift


def test_ratio_curve_inverts_itself():
    drive = np.linspace(-0.05, 0.3, 80)
    curve = RatioCurve(drive, np.sin(drive))
    assert curve.inverse(np.array([0.0, 0.1, 0.25])) == pytest.approx(
        np.arcsin([0.0, 0.1, 0.25]), abs=1e-9
    )


def test_crank_slider_is_the_exact_one():
    crank = CrankParameters(0.033, 0.136, 0.007, math.radians(26))
    angle = np.linspace(0, 2 * np.pi, 37)
    turn = 2 * (angle - math.radians(26))
    pin = 0.033 * np.array([np.sin(turn), np.cos(turn)])
    height = 0.033 + 0.136 - piston_travel(crank, angle)
    assert np.hypot(pin[0], height - pin[1]) == pytest.approx(0.136, abs=1e-12)
    assert piston_travel(crank, math.radians(26 + 90)) == pytest.approx(0.066, abs=1e-12)
    assert piston_clearance(crank, math.radians(26), 0.002) == pytest.approx(0.005, abs=1e-12)
