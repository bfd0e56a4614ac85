"""Every lift law: derivatives agree with each other, the promised continuity is reached at all
joints, the base circle is exactly zero.
"""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest

from valvetrain import registry
from valvetrain.cam import build_lift_law
from valvetrain.cam.contract import TURN, LiftLaw
from valvetrain.cam.event import event_of_table
from valvetrain.cam.flanks import FlankModel
from valvetrain.cam.polydyne import Polydyne
from valvetrain.cam.spline import Spline
from valvetrain.errors import InputError
from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.parameters.loading import load_case, parse_case

#: A table is a spline by another name.
LAWS = [word for word in registry.names("lifts") if word != "table"]
FLANKS = {
    "maximum_lift": 0.009,
    "opening_start": 1.7,
    "opening_end": 3.0,
    "closing_start": 3.2,
    "closing_end": 4.9,
}
TABLE = {
    "cam_angles": tuple(np.radians([90, 110, 130, 150, 165, 180, 195, 210, 230, 250, 270])),
    "lifts": (0.0, 2e-4, 1e-3, 4e-3, 7e-3, 9e-3, 7e-3, 4e-3, 1e-3, 2e-4, 0.0),
}
RAMPS = {"maximum_lift": 0.009, "ramp_lift": 4e-4, "ramp_start": 1.6, "event_start": 2.2}
LOBE = {"base_radius": 0.018, "nose_radius": 5e-3, "maximum_lift": 9e-3, "nose": 3.1}
CASES: dict[str, dict[str, Any]] = {
    word: FLANKS for word in LAWS if registry.find("lifts", word).table is FlankModel
} | {
    "zero": {},
    "spline": TABLE,
    "spline septic": TABLE | {"degree": 7},
    "spline smoothed": TABLE | {"smoothing": 2e-5},
    "spline over the zero of the angle": TABLE
    | {"cam_angles": tuple(angle + 2.6 for angle in TABLE["cam_angles"])},
    "polynomial": FLANKS,
    "polynomial 4-5-6-7": FLANKS | {"exponents": (4, 5, 6, 7)},
    "polydyne": {
        "maximum_lift": 0.009,
        "opening_start": 1.7,
        "closing_end": 4.9,
        "dynamic_deflection": 5e-4,
    },
    "polydyne between ramps": {
        "maximum_lift": 0.009,
        "opening_start": 1.9,
        "closing_end": 4.7,
        "dynamic_deflection": 5e-4,
        "ramp_lift": 3e-4,
        "ramp_length": 0.4,
    },
    "cam-card": {"maximum_lift": 0.009, "nose": 3.1, "duration": 2.1, "ramp_lift": 3e-4},
    "cam-card of three durations": {
        "maximum_lift": 0.009,
        "nose": 3.1,
        "duration": 2.1,
        "advertised_duration": 2.5,
        "upper_duration": 1.37,
        "ramp_blend": 1.0,
    },
    "harmonic without dwell": FLANKS | {"closing_start": 3.0},
    "sine-power": {
        "maximum_lift": 0.01,
        "opening_start": math.radians(127),
        "closing_end": math.radians(233),
        "power": 4,
    },
    "sine-power squared": {
        "maximum_lift": 0.01,
        "opening_start": 2.0,
        "closing_end": 4.0,
        "power": 2,
    },
    "ramped": RAMPS | {"event_end": 4.0, "ramp_end": 4.7},
    "ramped throughout": RAMPS | {"event_end": 4.0, "ramp_end": 4.7, "ramp_blend": 1.0},
    "ramped by pulses": RAMPS | {"event_end": 4.0, "ramp_end": 4.9, "flank": "pulses"},
    "shaped": RAMPS | {"nose": 3.14, "flank_shape": (1.0, 0.8, -0.7, -0.5, -1.0)},
    "shaped to an end of its own": RAMPS
    | {"nose": 3.1, "event_end": 4.1, "flank_shape": (1.0, 0.8, -0.7, -0.5, -1.0)},
    "shaped by two flanks": RAMPS
    | {
        "nose": 3.1,
        "flank_shape": (1.0, 0.8, -0.7, -0.5, -1.0),
        "closing_flank_shape": (0.4, 1, -0.5, -1),
    },
    "three-arc": LOBE | {"opening_start": 2.0},
    "three-arc under a roller": LOBE | {"opening_start": 2.0, "follower_radius": 9e-3},
    "tangent": LOBE | {"follower_radius": 9e-3},
    "measured": {
        "cam_angles": tuple(np.radians(np.arange(100.0, 261.0))),
        "lifts": tuple(0.009 * np.clip(1 - (np.arange(-80.0, 81.0) / 60) ** 2, 0, None) ** 3),
        "noise": 1e-6,
    },
    "stations": {
        "cam_angles": (1.5, 2.0, 3.0, 4.4, 4.8),
        "lifts": (0.0, 1e-3, 8e-3, 1e-3, 0.0),
        "velocities": (0.0, 4e-3, 0.0, -5e-3, 0.0),
        "accelerations": (0.0, 0.0, -2e-2, 0.0, 0.0),
    },
}


def make(name: str) -> LiftLaw:
    kind = next(kind for kind in sorted(LAWS, key=len, reverse=True) if name.startswith(kind))
    return build_lift_law(LiftLawParameters(kind, CASES[name]))


def away_from_joints(law: LiftLaw, margin: float) -> np.ndarray:
    angle = np.linspace(-7.0, 7.0, 4001)
    for joint in law.joints:
        distance = np.abs(np.mod(angle - joint + math.pi, TURN) - math.pi)
        angle = angle[distance > margin]
    return angle


def test_every_kind_is_tried():
    assert {name.split(" ")[0] for name in CASES} == set(LAWS)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("derivative", [1, 2, 3])
def test_derivatives_agree_with_differences(name, derivative):
    law, step = make(name), 1e-5
    assert isinstance(law, LiftLaw)
    angle = away_from_joints(law, 2 * step)
    difference = (
        law.lift(angle + step, derivative - 1) - law.lift(angle - step, derivative - 1)
    ) / (2 * step)
    size = max(np.max(np.abs(law.lift(angle, derivative))), 1e-12)
    assert np.max(np.abs(law.lift(angle, derivative) - difference)) < 2e-6 * size + 1e-12


@pytest.mark.parametrize("name", CASES)
def test_promised_continuity_is_reached_and_not_more(name):
    law, step = make(name), 1e-7
    joints = np.asarray(law.joints)
    if name == "zero":
        return
    for derivative in range(min(law.continuity, 3) + 1):
        jump = np.abs(law.lift(joints + step, derivative) - law.lift(joints - step, derivative))
        steepest = np.max(np.abs(law.lift(np.linspace(0, TURN, 20001), min(derivative + 1, 3))))
        largest = np.max(np.abs(law.lift(np.linspace(0, TURN, 20001), derivative)))
        allowed = 40 * step * max(steepest, largest) if derivative < 3 else 1e-3 * largest
        assert np.max(jump) < allowed, derivative
    if law.continuity < 3:
        jump = np.abs(
            law.lift(joints + step, law.continuity + 1)
            - law.lift(joints - step, law.continuity + 1)
        )
        assert np.max(jump) > 1e-3 * np.max(
            np.abs(law.lift(np.linspace(0, TURN, 20001), law.continuity + 1))
        )


@pytest.mark.parametrize("name", [name for name in CASES if name != "zero"])
def test_base_circle_is_exactly_zero_and_the_law_periodic(name):
    law = make(name)
    first, last = min(law.joints), max(law.joints)
    rest = np.linspace(last + 1e-9, first + TURN - 1e-9, 1001)
    for derivative in range(4):
        assert np.all(law.lift(rest, derivative) == 0.0)
    angle = np.linspace(first, last, 101)
    assert law.lift(angle + 3 * TURN) == pytest.approx(law.lift(angle), abs=1e-14)
    assert (
        np.shape(law.lift(angle.reshape(1, 101), 1)) == (1, 101) and np.shape(law.lift(1.0)) == ()
    )


def test_spline_passes_its_table_and_smoothing_keeps_its_distance():
    angles, lifts = np.array(TABLE["cam_angles"]), np.array(TABLE["lifts"])
    for degree in (5, 7):
        assert Spline(**TABLE, degree=degree).lift(angles) == pytest.approx(lifts, abs=1e-15)
    smooth = Spline(**TABLE, smoothing=2e-5)
    assert np.sqrt(np.mean((smooth.lift(angles) - lifts) ** 2)) == pytest.approx(2e-5, rel=1e-3)
    fine = np.linspace(angles[0], angles[-1], 5001)
    assert np.mean(smooth.lift(fine, 3) ** 2) < np.mean(Spline(**TABLE).lift(fine, 3) ** 2)


def test_smoothing_recovers_the_acceleration_under_noise():
    law = make("cycloidal")
    angles = np.linspace(1.7, 4.9, 120)
    noise = np.random.default_rng(4).normal(0.0, 2e-6, 120)
    lifts = np.where((angles <= 1.7) | (angles >= 4.9), 0.0, law.lift(angles) + noise)
    lifts[[0, -1]] = 0.0
    fine = np.linspace(1.8, 4.8, 2001)
    scale = np.max(np.abs(law.lift(fine, 2)))
    raw, smooth = (
        Spline(cam_angles=tuple(angles), lifts=tuple(lifts), smoothing=value)
        for value in (0.0, 2e-6)
    )
    assert np.max(np.abs(smooth.lift(fine, 2) - law.lift(fine, 2))) < 0.15 * scale
    assert np.max(np.abs(raw.lift(fine, 2) - law.lift(fine, 2))) > 0.5 * scale


def test_tables_are_cut_to_their_event():
    degrees = np.arange(0, 360, 10.0)
    lifts = np.where(np.abs(degrees - 100) < 45, 1e-3, 0.0)
    angles, cut = event_of_table(tuple(np.radians(degrees)), tuple(lifts))
    assert np.degrees(angles[0]) == pytest.approx(50) and np.degrees(angles[-1]) == pytest.approx(
        150
    )
    assert cut[0] == cut[-1] == 0.0 and min(cut[1:-1]) > 0
    # An event over the zero of the angle is rolled into one piece; a closing 360 degree row changes
    # nothing.
    around = np.where(np.minimum(degrees, 360 - degrees) < 45, 1e-3, 0.0)
    for extra in (False, True):
        rows = (
            (np.append(degrees, 360.0), np.append(around, around[0]))
            if extra
            else (degrees, around)
        )
        angles, cut = event_of_table(tuple(np.radians(rows[0])), tuple(rows[1]))
        assert np.degrees(angles[0]) == pytest.approx(310) and np.degrees(
            angles[-1]
        ) == pytest.approx(410)
        assert len(cut) == 11 and np.allclose(np.diff(angles), np.radians(10))
    with pytest.raises(InputError, match="begin and end on the base circle"):
        event_of_table((0.0, 0.5, 1.0, 1.5), (0.0, 1.0, 1.0, 1.0))
    with pytest.raises(InputError, match="no lift above"):
        event_of_table((0.0, 0.5, 1.0, 1.5), (0.0, 0.0, 0.0, 0.0))
    with pytest.raises(InputError, match="base circle"):
        event_of_table(tuple(np.radians(degrees)), (1e-3,) * 36)


def test_beehive_law_keeps_the_published_stages():
    case = load_case("gu2021-beehive-blind")
    law = build_lift_law(case.lift_law)
    degrees = lambda low, high, count=2001: np.radians(np.linspace(low, high, count))
    assert law.continuity >= 2
    for derivative in range(4):
        assert np.all(law.lift(degrees(-90, 90 - 1e-6), derivative) == 0.0)
    # Very low lift between 90 and 127, the main event to 233, low again until 270, symmetric about
    # 180.
    assert np.max(law.lift(degrees(90, 127))) < 0.06 * law.lift(np.pi)
    assert np.all(law.lift(degrees(90.01, 180), 1) > -1e-15)
    assert law.lift(degrees(90, 180)) == pytest.approx(law.lift(degrees(270, 180)), abs=1e-15)
    # The acceleration turns only as often as it must: ramp, opening flank, nose, and back.
    acceleration = law.lift(degrees(90, 270, 20001), 2)
    signs = np.sign(acceleration[np.abs(acceleration) > 1e-6 * np.max(np.abs(acceleration))])
    assert np.count_nonzero(np.diff(signs)) == 2
    slopes = np.diff(law.lift(degrees(127, 180, 20001), 2))
    turns = np.count_nonzero(
        np.diff(np.sign(slopes[np.abs(slopes) > 1e-9 * np.max(np.abs(slopes))]))
    )
    assert turns <= len(case.lift_law.values["flank_shape"]) - 1


@pytest.mark.parametrize(
    ("kind", "values", "words"),
    [
        ("spline", TABLE | {"degree": 3}, "degree 5 or 7"),
        ("spline", TABLE | {"smoothing": 5e-3}, "flatten"),
        ("cycloidal", FLANKS | {"opening_end": 5.0}, "must follow each other"),
        ("cycloidal", {"maximum_lift": 0.01}, "do not fit"),
        ("wavelet", {}, "unknown"),
    ],
)
def test_impossible_laws_are_refused(kind, values, words):
    with pytest.raises(InputError, match=words):
        law = build_lift_law(LiftLawParameters(kind, values))
        law.lift(1.0)


def test_a_polydyne_event_takes_over_lift_and_velocity_of_its_ramps():
    """Ramp of constant velocity: ramp_lift = velocity * length * (1 - blend / 2); the event keeps
    it, without acceleration.
    """
    ramp, length, blend = 3e-4, 0.4, 0.25
    law = Polydyne(
        maximum_lift=9e-3,
        opening_start=1.9,
        closing_end=4.7,
        ramp_lift=ramp,
        ramp_length=length,
        ramp_blend=blend,
    )
    velocity = ramp / (length * (1 - blend / 2))
    for side in (-1e-9, 1e-9):
        for angle, sign in ((1.9, 1), (4.7, -1)):
            found = [float(law.lift(angle + side, order)) for order in range(3)]
            assert found == pytest.approx([ramp, sign * velocity, 0.0], abs=1e-9)
    assert (
        law.lift(1.9 - 0.5 * length, 1) == pytest.approx(velocity) and law.lift(1.9 - length) == 0.0
    )
    assert law.lift(3.3) == pytest.approx(9e-3, abs=1e-15) and law.lift(3.3, 1) == pytest.approx(
        0.0, abs=1e-15
    )
    # C_p of 2-10-18-26-34 from the conditions themselves
    powers = np.array([2, 10, 18, 26, 34])
    half, falling = 1.4, [np.ones(5)]
    for order in range(4):
        falling.append(falling[-1] * (powers - order))
    factors = np.linalg.solve(np.array(falling), [9e-3 - ramp, velocity * half, 0, 0, 0])
    x = 0.6
    assert law.lift(3.3 + x * half) == pytest.approx(9e-3 - float(factors @ x**powers), rel=1e-9)


@pytest.mark.parametrize("name", ["", "lifts", "velocities", "accelerations"])
def test_stations_of_a_case_file_are_as_many_as_their_angles(name):
    """Equal numbers are a law through its stations; one missing anywhere is refused with both
    counts.
    """
    rows = {
        "cam_angles": ["100 deg", "140 deg", "180 deg", "220 deg", "260 deg"], "lifts": ["0 mm", "4 mm", "9 mm", "4 mm", "0 mm"],
        "velocities": ["0 mm/deg", "0.2 mm/deg", "0 mm/deg", "-0.2 mm/deg", "0 mm/deg"], "accelerations": ["0 mm/deg^2"] * 5,
    }  # fmt: skip
    if name:
        rows[name] = rows[name][:-1]
    text = '[lift_law]\nkind = "stations"\n' + "".join(
        f"{key} = {json.dumps(values)}\n" for key, values in rows.items()
    )
    if name:
        with pytest.raises(InputError, match=f"{name} has 4 entries but cam_angles 5"):
            parse_case(text)
        return
    law = build_lift_law(parse_case(text).lift_law)
    np.testing.assert_allclose(
        1e3 * law.lift(np.radians([140.0, 180.0, 220.0])), [4.0, 9.0, 4.0], atol=1e-9
    )


def test_a_shaped_law_closes_where_it_is_told_as_it_opens():
    """``event_end`` at the mirror of ``event_start`` changes nothing; elsewhere height and slope of
    the ramp are met there.
    """
    shape = {"nose": 3.1, "flank_shape": (1.0, 0.8, -0.7, -0.5, -1.0)}
    mirrored, told, late = (
        build_lift_law(LiftLawParameters("shaped", RAMPS | shape | end))
        for end in ({}, {"event_end": 4.0}, {"event_end": 4.1})
    )
    angle = np.linspace(1.5, 4.8, 3001)
    for order in (0, 1, 2):
        scale = np.abs(mirrored.lift(angle, order)).max()
        np.testing.assert_allclose(
            told.lift(angle, order), mirrored.lift(angle, order), atol=1e-12 * scale, rtol=0
        )
    before = angle[angle <= 3.1]
    assert np.array_equal(late.lift(before, 2), mirrored.lift(before, 2))
    assert late.lift(np.array([4.1]))[0] == pytest.approx(4e-4, rel=1e-12)
    assert late.lift(np.array([4.1]), 1)[0] == pytest.approx(
        -mirrored.lift(np.array([2.2]), 1)[0], rel=1e-9
    )
    assert not np.any(late.lift(np.array([4.7, 4.75]))) and late.lift(np.array([4.69]))[0] > 0


def test_a_closing_flank_of_its_own_shape_meets_nose_and_ramp():
    """The same control values change nothing; others keep the opening flank and the acceleration of
    the nose, and end in the ramp.
    """
    opening = {"nose": 3.1, "flank_shape": (1.0, 0.8, -0.7, -0.5, -1.0)}
    mirrored, same, other = (
        build_lift_law(LiftLawParameters("shaped", RAMPS | opening | shape))
        for shape in (
            {},
            {"closing_flank_shape": opening["flank_shape"]},
            {"closing_flank_shape": (0.3, 1.0, 1.0, -0.6, -0.6, -9.0)},
        )
    )
    angle = np.linspace(1.5, 4.8, 3001)
    for order in (0, 1, 2):
        scale = np.abs(mirrored.lift(angle, order)).max()
        np.testing.assert_allclose(
            same.lift(angle, order), mirrored.lift(angle, order), atol=1e-12 * scale, rtol=0
        )
    before, after = angle[angle <= 3.1], angle[angle > 3.1]
    assert np.array_equal(other.lift(before, 2), mirrored.lift(before, 2))
    assert np.abs(other.lift(after) - mirrored.lift(after)).max() > 1e-4
    assert other.lift(np.array([4.0]))[0] == pytest.approx(4e-4, rel=1e-12)
    assert other.lift(np.array([3.1 + 1e-9]), 2)[0] == pytest.approx(
        mirrored.lift(np.array([3.1]), 2)[0], rel=1e-6
    )
    # Two integrals of its acceleration, by the trapezoidal rule, are its own velocity and lift.
    fine = np.linspace(3.1, 4.0, 20001)
    velocity = np.cumsum(np.diff(fine) * (other.lift(fine, 2)[1:] + other.lift(fine, 2)[:-1]) / 2)
    assert velocity[-1] == pytest.approx(-mirrored.lift(np.array([2.2]), 1)[0], rel=1e-5)
    assert 9e-3 + np.sum(np.diff(fine)[1:] * (velocity[1:] + velocity[:-1]) / 2) == pytest.approx(
        4e-4, abs=1e-7
    )
