"""Unit: every number of one turn of a run-up from a made-up record whose entries are all different."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from valvetrain.integrate.train_tuples import LOADS
from valvetrain.integrate.transitions import Transitions
from valvetrain.quantities.train_numbers import OpenWindow, turn_quantities
from valvetrain.solution.force_peak import ForcePeak

NAMES = ("cam", "tappet", "valve tip", "pushrod bar", "seat")
TOP, COUNT = 10e-3, 360
ANGLE = np.radians(np.arange(float(COUNT)))
#: The rigid valve counts as open between these.
WINDOW = OpenWindow(np.radians(100.0), np.radians(260.0), TOP)


def kinematics(angle, derivative: int = 0):
    """10 mm of rigid lift about 180 degrees, hollow below 140 and above 220 degrees; of derivatives
    the second by half the angle.
    """
    half = np.minimum(np.abs(np.asarray(angle) % (2 * np.pi) - np.pi) * 9 / 8, np.pi / 2)
    return TOP * np.cos(half) ** 2 if derivative == 0 else -2 * TOP * np.cos(2 * half)


def touches(*rows: tuple[int, bool, float, float, float]) -> Transitions:
    """Interaction, whether it closes, cam degrees, closing speed (m/s), largest gap (m)."""
    columns = (
        [np.array(column) for column in zip(*rows, strict=True)] if rows else [np.zeros(0)] * 5
    )
    place, closes, degrees, rate, gap = columns
    return Transitions(
        place.astype(np.int64),
        closes.astype(bool),
        np.radians(degrees),
        rate,
        gap,
        0 * gap,
        0 * gap,
    )


def turn(gaps=(), raised=(), transitions=(), names=NAMES, **more) -> dict[str, float]:
    """``gaps``: (place, first degree, last degree, m); ``raised``: (first, last, m above the rigid
    lift).
    """
    apart, lift = np.zeros((COUNT, len(names))), kinematics(ANGLE)
    for name, first, last, size in gaps:
        apart[first : last + 1, names.index(name)] = size
    for first, last, size in raised:
        lift[first : last + 1] += size
    inside = {"pushrod bar"}
    mechanism = SimpleNamespace(
        index={"tappet": 0, "valve": 1}.get,
        valve="valve",
        interactions=[
            SimpleNamespace(
                name=name, role="link" if name in inside else "contact", load=("force", "N")
            )
            for name in names
        ],
        cam=0,
        seat=names.index("seat") if "seat" in names else None,
        drive=tuple(k for k, name in enumerate(names) if name not in {"seat", *inside}),
        kinematics=SimpleNamespace(valve_lift=kinematics),
    )
    told = {
        "cam_angle": ANGLE + 4 * np.pi, "q": np.column_stack([np.full(COUNT, 7.0), lift]), "gaps": apart,
        "loads": 100.0 * (1 + np.arange(len(LOADS)))[:, None] + np.arange(4.0), "bodies": np.array([[1.0] * 5, [9.9e-3, 2, 3, 4, 5]]),
        "peak_forces": 1000.0 + np.arange(len(names)), "least_forces": 50.0 + np.arange(len(names)), "transitions": touches(*transitions),
    }  # fmt: skip
    told["force_peak"] = lambda load: ForcePeak(10.0 * len(load), 0.5, np.nan)
    return turn_quantities(
        SimpleNamespace(mechanism=mechanism, interaction_names=names),
        SimpleNamespace(**told | more),
        WINDOW,
    )


def test_forces_and_lift_are_those_of_every_step():
    """Row of the retainer 500, of the seat 600 N; the lowest stands in the third column; peaks below the cut-off are the record's."""
    assert turn() == pytest.approx(
        {
            "peak_cam_contact_force": 1000.0,
            "peak_tappet_contact_force": 1001.0,
            "peak_valve_tip_contact_force": 1002.0,
            "peak_pushrod_bar_force": 1003.0,
            "peak_seat_contact_force": 1004.0,
            "minimum_cam_contact_force": 50.0,
            "minimum_tappet_contact_force": 51.0,
            "minimum_valve_tip_contact_force": 52.0,
            "peak_retainer_force": 80.0,
            "raw_peak_retainer_force": 500.0,
            "minimum_retainer_force": 502.0,
            "peak_spring_force": 40.0,
            "raw_peak_spring_force": 600.0,
            "minimum_spring_force": 602.0,
            "peak_valve_lift": 9.9e-3,
            "lift_loss_displacement": 1e-4,
            "loft_gap": 0.0,
            "float_excess_lift": 0.0,
        }
    )
    bare = turn(names=("cam",))
    assert (
        not {"minimum_valve_tip_contact_force", "seating_velocity"} & set(bare)
        and bare["minimum_cam_contact_force"] == 50.0
    )


@pytest.mark.parametrize(
    ("gaps", "loft"),
    [
        ([("cam", 150, 160, 3e-4)], 3e-4),
        ([("cam", 150, 160, 3e-4), ("cam", 200, 210, 4e-4)], 4e-4),
        ([("cam", 150, 160, 1.9e-6)], 1.9e-6),
        ([("cam", 150, 160, 2.1e-6)], 2.1e-6),
        ([("cam", 20, 60, 3e-4)], 0.0),
        ([("cam", 262, 300, 3e-4)], 0.0),
        ([("tappet", 150, 160, 3e-4)], 0.0),
    ],
)
def test_loft_is_the_largest_gap_at_the_cam_while_the_valve_is_open(gaps, loft):
    """Contract: wide open any gap is a loft, as in a run and in the search over speed."""
    assert turn(gaps)["loft_gap"] == pytest.approx(loft)


@pytest.mark.parametrize(
    ("gaps", "raised", "excess"),
    [
        ([("cam", 150, 200, 3e-4)], [(160, 190, 2e-4)], 2e-4),
        ([("tappet", 150, 200, 3e-4)], [(160, 190, 2e-4)], 2e-4),
        ([("valve tip", 150, 200, 3e-4)], [(160, 190, 2e-4)], 2e-4),
        (
            [("seat", 150, 200, 3e-4), ("pushrod bar", 150, 200, 3e-4)],
            [(160, 190, 2e-4)],
            0.0,
        ),  # no place that drives the valve
        ([("cam", 150, 170, 3e-4)], [(175, 190, 2e-4)], 0.0),  # raised where nothing is open
        (
            [("cam", 100, 130, 3e-4)],
            [(100, 130, 2e-4)],
            0.0,
        ),  # on the flank the rigid valve is still gathering speed
        ([("cam", 150, 200, 1e-6)], [(160, 190, 2e-4)], 0.0),
        ([("cam", 150, 200, 3e-4)], [(160, 190, 1.9e-5)], 0.0),
        ([("cam", 150, 200, 3e-4)], [(160, 190, -2e-4)], 0.0),
        ([("cam", 150, 200, 3e-4)], [(160, 170, 2.1e-5), (180, 190, 2.2e-5)], 2.2e-5),
    ],
)
def test_float_is_lift_above_the_rigid_one_over_the_nose_with_the_train_open(gaps, raised, excess):
    assert turn(gaps, raised)["float_excess_lift"] == pytest.approx(excess)


@pytest.mark.parametrize(
    ("transitions", "seating"),
    [
        ([(4, True, 270.0, 0.4, 9e-3)], (0.4, 270.0)),
        ([(4, True, 270.0, 0.4, 9e-3), (4, True, 630.0, 0.7, 9e-3)], (0.4, 270.0)),
        ([(4, False, 90.0, -0.3, 9e-3), (4, True, 640.0, 0.5, 8e-3)], (0.5, 280.0)),
        (
            [(4, True, 275.0, 0.1, 0.9e-3), (4, True, 280.0, 0.5, 1.1e-3)],
            (0.5, 280.0),
        ),  # a bounce of less than a tenth of the lift
        ([(1, True, 270.0, 0.4, 9e-3)], None),
        ([(4, False, 270.0, -0.4, 9e-3)], None),
        ([], None),
    ],
)
def test_seating_is_the_first_touch_of_the_seat_after_the_valve_was_open(transitions, seating):
    found = turn(transitions=transitions)
    if seating is None:
        assert not {"seating_velocity", "seating_cam_angle"} & set(found)
    else:
        assert (found["seating_velocity"], np.degrees(found["seating_cam_angle"])) == pytest.approx(
            seating
        )


@pytest.mark.parametrize(
    ("begin", "end", "inside"),
    [(100.0, 260.0, (100, 180, 260, 470)), (300.0, 400.0, (300, 359, 0, 40, 760))],
)
def test_a_window_holds_its_ends_in_every_turn(begin, end, inside):
    window = OpenWindow(np.radians(begin), np.radians(end), TOP)
    rounding = np.where(np.arange(len(inside) + 2) == 0, 1e-9, -1e-9)
    assert window.holds(
        np.radians(np.array([*inside, begin - 1, end + 1]) + rounding)
    ).tolist() == [True] * len(inside) + [False, False]
