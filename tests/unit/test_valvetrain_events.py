"""Events found in made-up closed cycles of a train whose events are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synthetic_train import ANGLE, CAM_SPEED, COUNT, TIME, degrees, found, lift_of, rigid, train
from valvetrain.quantities.clash import clash_events
from valvetrain.quantities.forces import counted_quantities
from valvetrain.quantities.train_numbers import of_kind
from valvetrain.solution.status import Cause, Event


def test_a_quiet_cycle_seats_once_and_nothing_else():
    run = found()
    (seating,) = run.events
    assert seating.kind == "seating" and np.degrees(seating.cam_angle) == pytest.approx(
        270, abs=1.5
    )
    assert seating.details["touch"] == 1
    assert (
        run.quantities["seating_cam_angle"] == seating.cam_angle
        and run.quantities["bounce_count"] == 0
    )


def test_a_straight_landing_is_met_exactly_between_the_samples():
    """A valve that falls at 0.5 m/s meets its seat where the straight line does, whatever the blow
    does to the sample after it.
    """
    touch = np.radians(269.9)
    lift = np.where(
        degrees(90, 250),
        lift_of(ANGLE),
        np.where(ANGLE < touch, 0.5 * (touch - ANGLE) / CAM_SPEED, -1e-6),
    )
    lift[degrees(0, 90)] = -1e-6
    velocity = np.where(ANGLE < touch, -0.5, 0.2)
    run = found(valve_lift=lift, valve_velocity=velocity)
    assert run.quantities["seating_velocity"] == pytest.approx(0.5, rel=1e-12)
    assert run.quantities["seating_cam_angle"] == pytest.approx(touch, abs=1e-9)


def test_the_log_of_the_integrator_is_the_truth_of_a_seating():
    seen = {"largest_gap": 8e-3, "release_cam_angle": np.radians(90.0)}
    logged = Event(
        "touch", np.radians(270.1), np.radians(270.1) / CAM_SPEED, 0.0, 0.321, "m/s", "seat", seen
    )
    trembling = Event(
        "touch", np.radians(270.4), 0.0, 0.0, 0.02, "m/s", "seat", seen | {"largest_gap": 1e-6}
    )
    other = Event("touch", np.radians(270.0), 0.0, 0.0, 9.0, "m/s", "cam", seen)
    run = found(train(events=(other, logged, trembling)))
    assert (
        run.quantities["seating_velocity"] == 0.321
        and run.quantities["seating_cam_angle"] == logged.cam_angle
    )
    assert {event.kind for event in run.events} == {"seating"}
    assert (
        found(run).quantities == run.quantities
    )  # seen again from the file, where the log is no more


def test_losses_of_contact_are_those_of_the_log_and_stay_so():
    """Between two samples, a quarter of a degree apart, the cam opens and closes; a stretch of lash
    counts from the rigid opening on. A gap of 1 µm counts with the valve open by more than a tenth of its
    lift, as in the search over engine speed, and is vibration on a ramp.
    """
    small = [(210.0, 212.0, 1e-6), (93.0, 93.5, 1e-6)]
    seen = [(150.05, 150.2, 5e-5), (-20.0, 90.4, 1e-4), *small]
    logged = tuple(
        Event(
            "touch",
            np.radians(end),
            0.0,
            0.0,
            0.1,
            "m/s",
            "cam",
            {"largest_gap": gap, "release_cam_angle": np.radians(begin)},
        )
        for begin, end, gap in seen
    )
    gap = np.where(ANGLE < np.radians(90.4), 1e-4, -1e-5)
    run = found(train(events=logged, statistics={"contacts_logged_ratio": 1.0}, cam_gap=gap))
    lofts = of_kind(run.events, "loft")
    assert [np.degrees(event.cam_angle) for event in lofts] == pytest.approx(
        [90.0, 150.05, 210.0], abs=0.01
    )
    assert [event.counts for event in lofts] == [False, True, True]  # the first ends on the ramp
    assert run.quantities["loss_of_contact_duration"] == pytest.approx(
        np.radians(0.15 + 2.0) / CAM_SPEED, rel=0.01
    )
    assert found(run).quantities == run.quantities and found(run).events == run.events


def test_a_float_across_a_nose_whose_acceleration_is_zero_at_one_sample_is_found():
    """The stretches before and after that sample follow at once: the second lost its end, and with
    it the float.
    """
    flying = np.where(degrees(90, 270), lift_of(ANGLE), -1e-6) + np.where(
        degrees(190, 200), 3e-4, 0.0
    )
    table = rigid(
        valve_acceleration=np.where(
            degrees(135, 225) & (np.arange(COUNT) != 720),
            -1000.0,
            np.where(degrees(135, 225), 0, 1e3),
        )
    )
    run = found(table=table, cam_gap=np.where(degrees(158, 202), 3e-4, -1e-5), valve_lift=flying)
    assert run.quantities["float_duration"] == pytest.approx(
        np.radians(10) / CAM_SPEED, abs=2 * TIME[1]
    )


@pytest.mark.parametrize(
    ("force", "spring", "cause"),
    [(-50.0, 500.0, Cause.INERTIA), (400.0, 300.0, Cause.SURGE), (400.0, 500.0, Cause.VIBRATION)],
)
def test_loft_has_angle_duration_size_and_cause(force, spring, cause):
    gap = np.where(degrees(150, 165), 1e-4, -1e-5)
    table = rigid(contact_force=np.where(degrees(140, 180), force, 400.0))
    run = found(table=table, cam_gap=gap, retainer_force=np.where(degrees(140, 180), spring, 500.0))
    (loft,) = of_kind(run.events, "loft")
    assert np.degrees(loft.cam_angle) == pytest.approx(150, abs=0.3)
    assert loft.duration == pytest.approx(np.radians(15) / CAM_SPEED, rel=0.02)
    assert loft.size == pytest.approx(1e-4)
    assert loft.details["cause"] == cause
    # what surge takes off is told of surge alone: 500 N at rest, 300 N left
    assert loft.details.get("spring_force_loss") == (200.0 if cause == Cause.SURGE else None)
    assert not of_kind(run.events, "float")  # the valve still follows its rigid lift
    assert run.quantities["loft_count"] == 1 and run.quantities["loft_gap"] == loft.size


def test_a_loss_below_the_error_of_its_sum_is_none():
    """Minus 6.67e-6 J stood in the table of a massless spring; 5e-3 J are a loss of any spring."""
    run = found()

    def lost(energy: float) -> float:
        counted = {"spring_dissipated_energy": energy, "peak_retainer_force": 1500.0, "peak_valve_lift": 0.0146}  # fmt: skip
        return counted_quantities(replace(run, statistics=counted))["cycle_damper_energy"]

    assert lost(-6.67e-6) == 0.0 and lost(5e-3) == 5e-3


def test_gaps_on_the_base_circle_are_lash():
    assert not of_kind(found(cam_gap=np.where(degrees(0, 80), 1e-4, -1e-5)).events, "loft")


def test_loss_at_the_valve_tip_is_told_by_its_place():
    (event,) = of_kind(
        found(valve_tip_gap=np.where(degrees(150, 165), 1e-4, -1e-5)).events, "loss-of-contact"
    )
    assert event.where == "valve_tip"


@pytest.mark.parametrize("events", [1, 2])
def test_bounces_are_counted_with_height_and_events_of_the_law_are_none(events):
    """Two bounces after the first event of the law; a second event of 1.5 mm with a bounce after it."""
    lift, law = np.where(degrees(90, 270), lift_of(ANGLE), -1e-6), lift_of(ANGLE)
    sizes = ((272, 280, 2e-4), (281, 285, 5e-5), (300, 340, 1.5e-3), (341, 346, 3e-4))
    for first, last, height in sizes[: 2 * events]:
        inside = degrees(first, last)
        lift[inside] = height * np.sin(np.linspace(0.05, np.pi - 0.05, inside.sum()))
    law[degrees(300, 340)] = np.maximum(0, lift[degrees(300, 340)])
    run = found(
        table=rigid(valve_lift=law), valve_lift=lift, valve_velocity=np.gradient(lift, TIME)
    )
    bounces, seatings = of_kind(run.events, "bounce"), of_kind(run.events, "seating")
    sizes = [2e-4, 5e-5, 3e-4][: events + 1]
    assert [event.size for event in bounces] == pytest.approx(sizes, rel=0.01)
    assert [event.details["touch"] for event in seatings] == list(range(1, 2 + 2 * events))
    assert seatings[0].size > 0 and all(event.unit == "m/s" for event in seatings)
    assert run.quantities["bounce_count"] == len(sizes)
    assert run.quantities["bounce_height"] == pytest.approx(max(sizes), rel=0.01)


def _pairs(place: int = 0):
    """A closed end coil, and two neighbours that meet together for six and six samples, begun at
    sample 960 + ``place``.
    """
    force = np.zeros((COUNT, 3))
    force[:, 0] = 20.0
    force[960:966, 1], force[962:968, 2] = 300.0, 100.0
    force = np.roll(force, place, axis=0)
    return np.array([1.2, 2.0, 2.5]), force, np.where(force > 0, -1e-6, 1e-4)


def test_clash_counts_only_pairs_that_part_and_gives_impulse_and_energy():
    upper, force, gap = _pairs()
    (clash,) = clash_events(train(pairs={"spring": (upper, force, gap)}))
    assert clash.details["upper_coil"] == 2 and clash.size == pytest.approx(400.0)
    assert clash.details["impulse"] == pytest.approx(
        (300 * 1.5 + 100 * 1.5) * np.radians(1) / CAM_SPEED, rel=0.05
    )
    assert clash.details["energy"] == pytest.approx(0.5 * 400 * 1e-6)
    assert clash.details["cause"] == Cause.COILS_STRIKE and clash.where == "coils 1-2"


@pytest.mark.parametrize("place", [0, 100, 470, 473, 475, 478, 480, 700])
def test_a_closed_cycle_has_no_seam(place):
    """The same clash anywhere round the ring, across its end too, is one event of the same numbers."""
    (here,) = clash_events(train(pairs={"spring": _pairs()}))
    (there,) = clash_events(train(pairs={"spring": _pairs(place)}))
    assert there.size == here.size and there.duration == pytest.approx(here.duration)
    assert there.details["impulse"] == pytest.approx(here.details["impulse"])
    assert np.cos(there.cam_angle - here.cam_angle - 2 * np.pi * place / COUNT) == pytest.approx(
        1.0, abs=1e-9
    )
    assert -0.01 < there.cam_angle < 2 * np.pi


def test_nested_springs_are_told_apart_and_long_contacts_are_rests():
    upper, force, gap = _pairs()
    rest = np.zeros((COUNT, 1))
    rest[300:900] = 50.0
    pairs = {"outer": (upper, force, gap), "inner": ([3.0], rest, np.where(rest > 0, -2e-6, 1e-4))}
    run = found(train(springs=("outer", "inner"), pairs=pairs))
    first, second = of_kind(run.events, "clash")
    assert (first.where, second.where) == ("inner coils 2-3", "outer coils 1-2")
    assert first.details["cause"] == Cause.COILS_REST
    assert run.quantities["clash_count"] == 2 and run.quantities["peak_clash_force"] == 400.0
    assert run.quantities["clash_energy"] == pytest.approx(0.5 * 50 * 2e-6 + 0.5 * 400 * 1e-6)
    assert run.quantities["largest_clash_energy"] == pytest.approx(0.5 * 400 * 1e-6)
    assert run.quantities["largest_clash_impulse"] == pytest.approx(
        max(event.details["impulse"] for event in (first, second))
    )


def test_a_landing_is_as_hard_as_the_hardest_of_its_samples():
    """The cam opens from 150 to 165 degrees; the blow of 1234 N comes three samples after, a weaker
    one later on.
    """
    force = np.where(degrees(150, 165), 0.0, 300.0)
    land = int(np.argmax(ANGLE >= np.radians(165)))
    force[land + 2], force[land + 30] = 1234.0, 5000.0
    (loft,) = of_kind(
        found(cam_gap=np.where(degrees(150, 165), 1e-4, -1e-5), cam_contact_force=force).events,
        "loft",
    )
    assert loft.details["landing_force"] == 1234.0
    assert np.degrees(loft.details["landing_cam_angle"]) == pytest.approx(165, abs=0.3)


def test_a_follower_that_comes_down_after_the_rigid_valve_has_seated_lands_there():
    """Contract: the loft counts while the rigid valve is open, its landing is where the contact closes;
    found on tdi-pushrod, whose blow at 283 degrees was told as a landing at 270 without force.
    """
    away = degrees(230, 285)
    force = np.where(away, 0.0, 300.0)
    force[int(np.argmax(ANGLE >= np.radians(285))) + 1] = 3536.0
    (loft,) = of_kind(
        found(cam_gap=np.where(away, 1e-4, -1e-5), cam_contact_force=force).events, "loft"
    )
    assert loft.duration < np.radians(45) / CAM_SPEED
    assert np.degrees(loft.details["landing_cam_angle"]) == pytest.approx(285, abs=0.3)
    assert loft.details["landing_force"] == 3536.0
