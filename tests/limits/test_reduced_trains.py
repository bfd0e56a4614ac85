"""Masses, weights, dampings and frictions of a train's bodies by hand, and what of them a single
mass at the valve has to carry.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from train_parts import LAW, direct, finger, pushrod, rocker, system
from valvetrain.mechanism.build import build_mechanism
from valvetrain.parameters.train_parts import PushrodParameters
from valvetrain.quantities.kinematics import rigid_table

G = 9.80665


def rubbed(make, **changes):
    train = make(**changes)
    return train.replace(valve=replace(train.valve, damping=7.0, friction=2.0))


def bodies(train) -> dict[str, tuple[float, float, float, float]]:
    return {
        one.name: (one.mass, one.force, one.damping, one.friction)
        for one in build_mechanism(train, LAW).coordinates
    }


@pytest.mark.parametrize("model", ["planar", "lumped"])
def test_every_body_bears_its_mass_and_weight(model):
    """The valve opens downward: its weight helps; what rises with it, tappet and pushrod, weighs
    against; a lever is held down.
    """
    assert bodies(rubbed(direct, model=model)) == {
        "tappet": pytest.approx((0.05, 0.05 * G, 0, 0)),
        "valve": pytest.approx((0.09, 0.09 * G, 7, 2)),
    }
    assert bodies(rubbed(finger, model=model)) == {
        "lever": pytest.approx((7.5e-5, -0.3, 0, 0)),
        "valve": pytest.approx((0.12, 0.12 * G, 7, 2)),
    }
    assert bodies(rubbed(pushrod, model=model)) == {
        "tappet": pytest.approx((0.05, -0.05 * G, 0, 0)),
        "pushrod": pytest.approx((0.085, -0.085 * G, 0, 0)),
        "pushrod top": pytest.approx((0.085, -0.085 * G, 0, 0)),
        "lever": pytest.approx((3e-5, -0.3, 0, 0)),
        "valve": pytest.approx((0.03, 0.03 * G, 7, 2)),
    }


def test_a_valve_on_its_side_has_no_weight_along_its_stem():
    train = direct(valve=replace(direct().valve, opening_direction=math.radians(-30)))
    assert bodies(train)["valve"][1] == pytest.approx(0.09 * G * math.sin(math.radians(30)))


FINGER = 1 / (0.047 * math.cos(math.radians(5.9)))
REDUCED = [
    (direct, 0.05 + 0.09, (0.05 + 0.09) * G),
    (finger, 0.12 + 7.5e-5 * FINGER**2, 0.12 * G - 0.3 * FINGER),
    (rocker, 0.1 + 5e-5 / 0.04**2, 0.1 * G - 0.3 / 0.04),
    (
        pushrod,
        0.03 + 3e-5 / 0.04**2 + (0.05 + 0.17) * 0.625**2,
        0.03 * G - 0.3 / 0.04 - (0.05 + 0.17) * G * 0.625,
    ),
]


@pytest.mark.parametrize(
    ("make", "mass", "force"), REDUCED, ids=lambda one: getattr(one, "__name__", "")
)
def test_a_single_mass_carries_all_of_it_through_the_arms(make, mass, force):
    (valve,) = build_mechanism(rubbed(make, model="single-mass"), LAW).coordinates
    assert (valve.mass, valve.force, valve.damping, valve.friction) == pytest.approx(
        (mass, force, 7.0, 2.0), rel=1e-6
    )


def test_an_elastic_stem_parts_the_mass_and_keeps_the_weight():
    train = direct(
        valve=replace(direct().valve, stem_stiffness=2e7, head_fraction=0.7, stem_damping=11.0)
    )
    found = bodies(train)
    parts = [value for name, value in found.items() if name != "tappet"]
    assert sorted(one[0] for one in parts) == pytest.approx([0.027, 0.063])
    assert sum(one[1] for one in parts) == pytest.approx(0.09 * G)


def test_a_stiff_pushrod_is_halved_at_its_two_ends():
    train = pushrod(
        pushrod=PushrodParameters(0.26, lower_end=(0.0, 0.02), stiffness=3e7, damping=50.0)
    )
    found = bodies(train)
    assert found["pushrod"][0] == found["pushrod top"][0] == pytest.approx(0.13)


@pytest.mark.parametrize(
    ("make", "mass", "weight"), REDUCED, ids=lambda one: getattr(one, "__name__", "")
)
def test_the_rigid_table_keeps_its_books(make, mass, weight):
    """Margin = spring + inertia - weight; at the start of the lift the mass is the reduced one and
    rates follow the cam speed's powers.
    """
    train = make()
    slow, fast = (rigid_table(system(train), train, speed) for speed in (100.0, 200.0))
    opened = slow["valve_lift"] > 0
    books = slow["spring_force"] + slow["inertia_force"] - slow["spring_margin"]
    early = opened & (slow["valve_lift"] < 2e-5)
    assert books[early] == pytest.approx(weight, rel=0.02) and slow["reduced_mass"][
        early
    ] == pytest.approx(mass + 0.04 / 3, rel=0.02)
    for power, name in enumerate(
        ("valve_lift", "valve_velocity", "valve_acceleration", "valve_jerk")
    ):
        assert fast[name] == pytest.approx(2**power * slow[name])
    assert fast["inertia_force"] == pytest.approx(4 * slow["inertia_force"])
    assert slow["spring_force"] == pytest.approx(300 + 30e3 * slow["valve_lift"])
    assert slow["spring_margin"][~opened] == pytest.approx(300.0) and np.all(
        slow["inertia_force"][~opened] == 0
    )
    angle = slow.cam_angle
    for name, order in (
        ("valve_velocity", "valve_lift"),
        ("valve_acceleration", "valve_velocity"),
        ("valve_jerk", "valve_acceleration"),
    ):
        slope = np.gradient(slow[order], angle) * 100.0
        size = np.max(np.abs(slow[name]))
        assert np.median(np.abs(slope - slow[name])) < 2e-3 * size, name
    travel = (
        slow["valve_velocity"] / 100.0 / slow["motion_ratio"]
    )  # of the follower along the cam's normal, per cam angle
    assert slow["cam_torque"][opened] == pytest.approx(
        (slow["contact_force"] * travel)[opened], rel=1e-6, abs=1e-7
    )
