"""Lobes of arcs and straights: lift, radii and jumps against plane geometry, and the trains they
drive.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from train_parts import LAW, direct, system
from valvetrain.cam.arcs import Tangent, ThreeArc
from valvetrain.cam.spline import Spline
from valvetrain.mechanism.build import build_mechanism
from valvetrain.mechanism.contour import curvature_radius_flat, curvature_radius_round
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.train_parts import CamParameters, FollowerParameters

BASE, TOP, NOSE = 0.018, 8e-3, math.pi
START = NOSE - math.radians(65)
ARCS = ThreeArc(
    base_radius=BASE, nose_radius=4e-3, maximum_lift=TOP, nose=NOSE, opening_start=START
)
SHARP = ThreeArc(
    base_radius=BASE,
    nose_radius=0.8e-3,
    maximum_lift=TOP,
    nose=NOSE,
    opening_start=NOSE - math.radians(62.3),
)


def outline(law: ThreeArc, count: int = 400_001) -> tuple[np.ndarray, np.ndarray]:
    """Points of the lobe, nose on the x axis: only circles, each by its centre and radius."""
    direction = np.linspace(-math.pi, math.pi, count)
    beyond, half = law.flank_radius - law.base_radius, law.half_event
    normal = math.atan2(beyond * math.sin(half), law.nose_distance + beyond * math.cos(half))
    side, away = np.sign(direction), np.abs(direction)
    flank = (away > normal) & (away < half)
    x = np.where(away <= normal, law.nose_distance, np.where(flank, -beyond * math.cos(half), 0.0))
    y = np.where(flank, -side * beyond * math.sin(half), 0.0)
    radius = np.where(
        away <= normal, law.nose_radius, np.where(flank, law.flank_radius, law.base_radius)
    )
    return x + radius * np.cos(direction), y + radius * np.sin(direction)


@pytest.mark.parametrize("law", [ARCS, SHARP])
def test_flat_face_rests_on_the_highest_point_of_the_outline(law):
    x, y = outline(law)
    for turn in np.radians([0.0, 3.0, 10.0, 25.0, 45.0, 60.0, 64.0, 80.0]):
        highest = np.max(x * math.cos(turn) + y * math.sin(turn))
        assert law.lift(NOSE + turn) == pytest.approx(highest - BASE, abs=1e-10)
        assert law.lift(NOSE - turn) == pytest.approx(highest - BASE, abs=1e-10)
    assert law.lift(NOSE) == pytest.approx(TOP, abs=1e-15)


@pytest.mark.parametrize("radius", [5e-3, 9e-3, 0.1])
def test_roller_touches_the_outline_and_does_not_cut_it(radius):
    law = ThreeArc(
        base_radius=BASE,
        nose_radius=4e-3,
        maximum_lift=TOP,
        nose=NOSE,
        opening_start=ARCS.opening_start,
        follower_radius=radius,
    )
    x, y = outline(law)
    for turn in np.radians([0.0, 3.0, 10.0, 25.0, 45.0, 60.0, 64.0]):
        centre = BASE + radius + float(law.lift(NOSE + turn))
        distance = np.hypot(x - centre * math.cos(turn), y - centre * math.sin(turn))
        assert np.min(distance) == pytest.approx(radius, abs=1e-9)


def test_radii_under_a_flat_face_are_those_of_the_arcs_and_the_acceleration_jumps_between_them():
    angle = NOSE - np.radians([80.0, 64.9, 60.0, 30.0, 25.0, 0.0])
    normal = NOSE - ARCS.half_nose
    radius = BASE + ARCS.lift(angle) + ARCS.lift(angle, 2)
    wanted = np.where(
        angle < ARCS.opening_start, BASE, np.where(angle < normal, ARCS.flank_radius, 4e-3)
    )
    assert radius == pytest.approx(wanted, abs=1e-14)
    before, after = (
        BASE + ARCS.lift(normal + side) + ARCS.lift(normal + side, 2) for side in (-1e-9, 1e-9)
    )
    assert (before, after) == (pytest.approx(ARCS.flank_radius), pytest.approx(4e-3))


def test_a_tangent_lobe_lifts_a_roller_as_its_straight_does():
    law = Tangent(
        base_radius=BASE, nose_radius=5e-3, maximum_lift=TOP, nose=NOSE, follower_radius=9e-3
    )
    half = math.acos((BASE - 5e-3) / (BASE + TOP - 5e-3))
    assert law.half_event == pytest.approx(half)
    for since in np.radians([0.5, 3.0, 8.0]):
        # the roller's centre runs along a straight parallel to the flank, base_radius +
        # follower_radius from the cam's centre
        assert law.lift(NOSE - half + since) == pytest.approx(
            (BASE + 9e-3) * (1 / math.cos(since) - 1), abs=1e-15
        )
    end = NOSE - law.half_nose
    for order in (0, 1):
        assert law.lift(end - 1e-10, order) == pytest.approx(
            law.lift(end + 1e-10, order), abs=1e-10
        )
    centre = BASE + 9e-3 + float(law.lift(NOSE + 0.1))
    assert math.dist(
        (centre * math.cos(0.1), centre * math.sin(0.1)), (law.nose_distance, 0)
    ) == pytest.approx(5e-3 + 9e-3)


@pytest.mark.parametrize("law", [ARCS, SHARP], ids=["4 mm nose", "0.8 mm nose"])
def test_a_flat_tappet_runs_on_a_three_arc_lobe_of_exact_radii(law):
    built = build_mechanism(direct(cam=CamParameters(BASE)), law)
    found = curvature_radius_flat(built.tables["cam contour"])
    angle = np.arange(len(found)) * 2 * math.pi / len(found)
    clear = np.min([np.abs(angle - joint) for joint in law.joints], axis=0) > math.radians(0.3)
    away = np.abs(angle - NOSE)
    wanted = np.where(
        away < law.half_nose,
        law.nose_radius,
        np.where(away < law.half_event, law.flank_radius, BASE),
    )
    assert found[clear] == pytest.approx(wanted[clear], rel=1e-5)
    assert law.nose_radius * (1 - 1e-5) < found.min() and found.max() < law.flank_radius * (
        1 + 1e-5
    )


def test_a_roller_tappet_runs_on_the_straight_flank_of_a_tangent_lobe():
    law = Tangent(
        base_radius=BASE, nose_radius=5e-3, maximum_lift=TOP, nose=NOSE, follower_radius=9e-3
    )
    train = direct(
        cam=CamParameters(BASE), follower=FollowerParameters("roller", radius=9e-3, mass=0.05)
    )
    found = curvature_radius_round(build_mechanism(train, law).tables["cam contour"], 9e-3)
    at = lambda degrees: found[round(degrees * 4)]
    assert at(180.0) == pytest.approx(5e-3, rel=1e-4) and at(60.0) == pytest.approx(BASE, rel=1e-4)
    flank = math.degrees(NOSE - (law.half_event + law.half_nose) / 2)
    assert abs(1 / at(flank)) < 0.05  # 1/m


def test_loss_of_contact_on_a_three_arc_lobe_is_at_the_end_of_the_flank_or_the_nose():
    """On the nose arc lift'' = -d cos(away) and lift = d cos(away) - (base - nose): the least ratio
    lies at one of its ends.
    """
    from valvetrain.quantities.kinematics import rigid_motion

    built = system(direct(cam=CamParameters(BASE)), ARCS)
    mass, weight, d = float(np.sum(built.masses)), 9.80665 * (0.05 + 0.09), ARCS.nose_distance
    squares = {
        away: (300.0 - weight + 30e3 * (d * math.cos(away) - (BASE - 4e-3)))
        / (mass * d * math.cos(away))
        for away in (0.0, ARCS.half_nose)
    }
    speed, angle = rigid_motion(built).contact_loss()
    least = min(squares, key=squares.get)
    assert speed == pytest.approx(math.sqrt(squares[least]), rel=1e-7)
    assert NOSE - angle == pytest.approx(least, abs=1e-4)  # the first of two equal ones


LOBE = """[lift_law]
kind = "three-arc"
lift_of = "tappet"
base_radius = "18 mm"
nose_radius = "4 mm"
maximum_lift = "8 mm"
nose = "180 deg"
"""


def test_a_case_tells_the_lobe_by_its_opening_or_by_its_flank():
    opened = parse_case(LOBE + 'opening_start = "115 deg"\n').lift_law.values
    told = parse_case(LOBE + f'flank_radius = "{ARCS.flank_radius * 1e3!r} mm"\n').lift_law.values
    assert (
        told["opening_start"]
        == pytest.approx(opened["opening_start"], abs=1e-9)
        == pytest.approx(math.radians(115))
    )


@pytest.mark.parametrize("law", [ARCS, SHARP], ids=["4 mm nose", "0.8 mm nose"])
@pytest.mark.parametrize("step", [0.5, 1.0, 2.0])
def test_a_table_of_a_three_arc_lobe_keeps_its_radii_under_a_flat_tappet(law, step):
    """A spline through the table swings where the acceleration jumps: down to a radius of -5.9 mm
    for a nose of 0.8 mm.
    """
    angle = np.radians(np.arange(100.0, 260.0 + step, step))
    table = Spline(cam_angles=tuple(angle), lifts=tuple(law.lift(angle)))
    fine = np.radians(np.linspace(95, 265, 20_001))
    radius = BASE + table.lift(fine) + table.lift(fine, 2)
    assert (
        radius.min() == pytest.approx(law.nose_radius, abs=3e-6 * step**2)
        and radius.max() < law.flank_radius + 4e-6 * step**2
    )
    largest = np.max(np.abs(law.lift(fine, 2)))
    assert (
        np.max(np.abs(table.lift(fine) - law.lift(fine)))
        < 1.01 * largest * math.radians(step) ** 2 / 6
    )
    build_mechanism(direct(cam=CamParameters(BASE)), table)


def test_steps_of_unequal_length_end_at_rest_too():
    angle = np.radians(
        np.concatenate(
            [
                np.arange(100.0, 150.0, 2.0),
                np.arange(150.0, 200.0, 1.0),
                np.arange(200.0, 262.0, 3.0),
            ]
        )
    )
    table = Spline(cam_angles=tuple(angle), lifts=tuple(ARCS.lift(angle)))
    end = table.joints[-1] - 1e-9
    assert table.continuity == 2 and np.abs(
        [table.lift(end, order) for order in (0, 1, 2)]
    ) == pytest.approx([0, 0, 0], abs=1e-8)
    assert np.max(np.abs(table.lift(angle) - ARCS.lift(angle))) < 20e-6


def test_a_smooth_table_is_run_through_exactly():
    angle = np.radians(np.arange(40.0, 242.0, 2.0))
    table = Spline(
        cam_angles=tuple(angle),
        lifts=tuple(LAW.lift(angle) * (np.abs(angle - math.radians(140)) < math.radians(99.9))),
    )
    assert table.lift(angle) == pytest.approx(LAW.lift(angle), abs=1e-15)
