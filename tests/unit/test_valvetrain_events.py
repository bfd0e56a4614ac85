"""Events found in made-up cycles whose events are known."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.quantities.valvetrain_events import (
    CAUSE_INERTIA,
    CAUSE_SURGE,
    CAUSE_VIBRATION,
    CycleData,
    clash_events,
    find_events,
    intervals,
    of_kind,
)

COUNT, SPEED = 1440, 200.0
ANGLE = np.arange(COUNT) * 2 * np.pi / COUNT


def degrees(first: float, last: float) -> np.ndarray:
    place = np.degrees(ANGLE)
    return (place >= first) & (place < last)


def quiet(**changes) -> CycleData:
    """A valve open from 90 to 270 degrees that follows its rigid lift, no gap anywhere."""
    lift = np.where(degrees(90, 270), 8e-3 * np.sin(ANGLE - np.pi / 2) ** 2, -1e-6)
    rigid = np.where(degrees(90, 270), lift, 0.0)
    base = {
        "cam_angle": ANGLE, "cam_speed": SPEED, "valve_lift": lift, "valve_velocity": np.gradient(lift, ANGLE) * SPEED, "rigid_lift": rigid,
        "rigid_acceleration": np.where(degrees(135, 225), -1000.0, 1000.0), "gaps": {"cam": np.full(COUNT, -1e-5),
        "valve tip": np.full(COUNT, -1e-5)},
        "forces": {"cam": np.full(COUNT, 500.0), "valve tip": np.full(COUNT, 300.0)}, "rigid_force": np.full(COUNT, 400.0),
        "spring_force": np.full(COUNT, 500.0), "static_spring_force": np.full(COUNT, 500.0),
    }  # fmt: skip
    return CycleData(**(base | changes))


def test_intervals_close_the_ring():
    flag = np.zeros(10, dtype=bool)
    flag[[0, 1, 8, 9, 4]] = True
    assert sorted(intervals(flag)) == [(4, 1), (8, 4)]
    assert intervals(np.ones(5, dtype=bool)) == [(0, 5)]
    assert intervals(np.zeros(5, dtype=bool)) == []


def test_a_quiet_cycle_seats_once_and_nothing_else():
    events = find_events(quiet())
    assert [event.kind for event in events] == ["seating"]
    assert np.degrees(events[0].cam_angle) == pytest.approx(270, abs=1.5)
    assert events[0].details["touch"] == 1


@pytest.mark.parametrize(
    ("changes", "cause"),
    [
        ({"rigid_force": np.where(degrees(140, 180), -50.0, 400.0)}, CAUSE_INERTIA),
        ({"spring_force": np.where(degrees(140, 180), 300.0, 500.0)}, CAUSE_SURGE),
        ({}, CAUSE_VIBRATION),
    ],
)
def test_loft_has_angle_duration_size_and_cause(changes, cause):
    gap = np.where(degrees(150, 165), 1e-4, -1e-5)
    events = find_events(quiet(gaps={"cam": gap}, **changes))
    (loft,) = of_kind(events, "loft")
    assert np.degrees(loft.cam_angle) == pytest.approx(150, abs=0.3)
    assert loft.duration == pytest.approx(np.radians(15) / SPEED, rel=0.02)
    assert loft.size == pytest.approx(1e-4)
    assert loft.details["cause"] == cause
    assert not of_kind(events, "float")  # the valve still follows its rigid lift


def test_float_is_a_lift_above_the_rigid_one_over_the_nose():
    base = quiet()
    flying = base.valve_lift + np.where(degrees(160, 200), 3e-4, 0.0)
    events = find_events(quiet(gaps={"cam": np.where(degrees(158, 202), 3e-4, -1e-5)}, valve_lift=flying))
    (found,) = of_kind(events, "float")
    assert found.size == pytest.approx(3e-4)
    assert np.degrees(found.cam_angle) == pytest.approx(160, abs=0.5)


def test_gaps_on_the_base_circle_are_lash():
    assert not of_kind(find_events(quiet(gaps={"cam": np.where(degrees(0, 80), 1e-4, -1e-5)})), "loft")


def test_bounces_are_counted_with_height_and_seatings_with_their_place():
    base = quiet()
    lift = base.valve_lift.copy()
    for first, last, height in ((272, 280, 2e-4), (281, 285, 5e-5)):
        inside = degrees(first, last)
        lift[inside] = height * np.sin(np.linspace(0.05, np.pi - 0.05, inside.sum()))
    events = find_events(quiet(valve_lift=lift, valve_velocity=np.gradient(lift, ANGLE) * SPEED))
    bounces, seatings = of_kind(events, "bounce"), of_kind(events, "seating")
    assert [event.size for event in bounces] == pytest.approx([2e-4, 5e-5], rel=0.01)
    assert [event.details["touch"] for event in seatings] == [1, 2, 3]
    assert seatings[0].size > 0 and all(event.unit == "m/s" for event in seatings)


def test_clash_counts_only_pairs_that_part_and_gives_the_impulse():
    force = np.zeros((COUNT, 3))
    force[:, 0] = 20.0  # a closed end coil
    force[960:972, 1] = 300.0  # twelve samples of a quarter degree
    force[964:976, 2] = 100.0
    (clash,) = clash_events(ANGLE, SPEED, np.array([1.2, 2.0, 2.5]), force, "spring")
    assert clash.details["upper_coil"] == 2.0
    assert clash.size == pytest.approx(400.0)
    assert clash.details["impulse"] == pytest.approx((300 * 3 + 100 * 3) * np.radians(1) / SPEED, rel=0.05)
