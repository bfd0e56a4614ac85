"""A spring between any body of a train and the ground adds its own force to the rigid train and changes
nothing else, in every train kind and model.

Oracle: the cam does the work that such a spring stores, so the torque of the cam changes by k q dq/dangle,
where the body's place q follows from the lift law and the closed form of the lever.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from train_parts import KINDS, LAW
from valvetrain.contact.library import build_contact_law
from valvetrain.errors import InputError
from valvetrain.mechanism.build import build_mechanism
from valvetrain.mechanism.gap_kinds import LINEAR
from valvetrain.mechanism.lumped import build_lumped, build_single_mass
from valvetrain.mechanism.parts import SPRING, ElasticLink, Interaction
from valvetrain.parameters.train_parts import SupportParameters
from valvetrain.quantities.kinematics import rigid_motion
from valvetrain.registry import BUILT_IN
from valvetrain.springs.massless import MasslessSpring
from valvetrain.system.train_system import TrainSystem

PRELOAD = 0.3  # share of the spring's largest deflection by which it is strained at home
STRENGTH = 5.0  # growth of its force (N) or moment (N m) over the travel of the body
ANGLES = np.linspace(math.radians(90), math.radians(190), 21)  # the valve is open


def train(kind: str):
    """A train of a kind with lash, elastic stem and, with a lever, an elastic pivot and lever."""
    base = KINDS[kind](lash=2e-4)
    base = base.replace(valve=replace(base.valve, stem_stiffness=5e7))
    if base.lever is None:
        return base
    lever = replace(base.lever, stiffness=4e7)
    return base.replace(lever=lever, support=SupportParameters(5e7, 0.1, 50.0))


def places(built: TrainSystem, base, angle: np.ndarray) -> dict[str, np.ndarray]:
    """Place (m, rad) of every body of the rigid train at cam angles, without its rigid poses."""
    motion = built.mechanism.kinematics
    found = dict.fromkeys(("valve", "valve tip"), motion.valve_lift(angle))
    found["support"] = np.zeros_like(angle)
    drive = motion.drive(angle)
    if base.lever is None:
        return found | {"tappet": drive}
    if base.pushrod is None:
        return found | dict.fromkeys(("lever", "lever tip"), drive)
    turned = np.arcsin((motion.valve_lift(angle) + base.lash) / base.lever.valve_arm)
    return (
        found
        | dict.fromkeys(("tappet", "pushrod", "pushrod top"), drive)
        | dict.fromkeys(("lever", "lever tip"), turned)
    )


def held(mechanism, body: str, constant: float, law):
    """The mechanism with a spring from a body to the ground."""
    unit = mechanism.coordinates[mechanism.index(body)].unit
    role = SPRING if law.code >= 0 else ""
    spring = Interaction("hold", LINEAR, (body,), (constant, 1.0), law, unit=unit, role=role)
    return replace(mechanism, interactions=(*mechanism.interactions, spring))


def on_a_spring(mechanism) -> TrainSystem:
    return TrainSystem(mechanism, (MasslessSpring(30e3, 300.0, 0.04),))


def test_every_kind_is_looked_at():
    assert set(KINDS) == set(BUILT_IN["mechanisms"])


@pytest.mark.parametrize("kind", KINDS)
def test_a_spring_to_the_ground_adds_its_own_force_and_changes_nothing_else(kind):
    base = train(kind)
    built = on_a_spring(build_mechanism(base, LAW))
    plain, step = rigid_motion(built, samples=180), 1e-5
    before, cam = plain.forces.shares(ANGLES), plain.forces.places.index("cam")
    at, ahead, behind = (places(built, base, ANGLES + turn) for turn in (0.0, step, -step))
    tight = plain.forces.poses_at(at["valve"])
    rate = {name: (ahead[name] - behind[name]) / (2 * step) for name in at}
    for body in built.coordinate_names:
        largest = max(float(np.max(at[body])), 1e-3)
        stiffness, constant = STRENGTH / largest, PRELOAD * largest
        due = stiffness * (constant + at[body]) * rate[body]
        # one that pulls too, and one that cannot
        for law in (
            ElasticLink(stiffness),
            build_contact_law("linear", contact_stiffness=stiffness),
        ):
            changed = on_a_spring(held(built.mechanism, body, constant, law))
            motion = rigid_motion(changed, samples=180)
            after = motion.forces.shares(ANGLES)
            torque = (after.static - before.static)[:, cam] * before.per_angle
            np.testing.assert_allclose(torque, due, rtol=1e-6, atol=1e-8)
            np.testing.assert_array_equal(after.inertia, before.inertia)
            np.testing.assert_array_equal(motion.reduced_mass, plain.reduced_mass)
            assert motion.forces.places == plain.forces.places
            # what it takes at the valve is in the margin of the springs too
            taken = plain.forces.poses.weight(tight) - motion.forces.poses.weight(tight)
            np.testing.assert_allclose(taken * rate["valve"], due, rtol=1e-5, atol=1e-8)
            speeds = [one.contact_loss()[0] for one in (plain, motion)]
            assert speeds[1] == pytest.approx(speeds[0], rel=0.2)


@pytest.mark.parametrize("reduce", [build_lumped, build_single_mass])
@pytest.mark.parametrize("kind", KINDS)
def test_reduced_models_keep_the_spring(kind, reduce):
    """Near zero lift, where all models have the ratios of the planar one, and with its unit."""
    planar = build_mechanism(KINDS[kind](), LAW)
    body = planar.coordinates[0]
    law = ElasticLink(2000.0)
    angle = np.array([LAW.opening_start + 0.2])

    def torque(change) -> float:
        one, other = (
            rigid_motion(on_a_spring(change(each)), samples=90).forces.shares(angle)
            for each in (held(planar, body.name, 0.01, law), planar)
        )
        return float((one.static - other.static)[0, 0] * one.per_angle[0])

    assert torque(reduce) == pytest.approx(torque(lambda one: one), rel=0.01)
    reduced = reduce(held(planar, body.name, 0.01, law))
    (kept,) = (item for item in reduced.interactions if item.name == "hold")
    assert kept.load == (("moment", "N m") if body.unit == "rad" else ("force", "N"))


def test_a_stop_of_a_body_is_no_contact_of_the_drive():
    """A contact with the ground opens as the valve does; it neither drives nor ties the train."""
    built = on_a_spring(build_mechanism(KINDS["pushrod"](), LAW))
    stop = Interaction("stop", LINEAR, ("lever",), (0.0, -0.03), build_contact_law("linear", contact_stiffness=1e7), unit="m")  # fmt: skip
    changed = replace(
        built,
        mechanism=replace(built.mechanism, interactions=(stop, *built.mechanism.interactions)),
    )
    names = [changed.interaction_names[k] for k in changed.mechanism.drive]
    assert names == ["cam", "tappet", "rocker", "valve_tip"]
    one, other = (
        rigid_motion(item, samples=180).forces.shares(ANGLES).static for item in (built, changed)
    )
    np.testing.assert_allclose(one, other, rtol=1e-9)


def test_a_body_that_nothing_ties_to_the_valve_is_refused():
    mechanism = build_mechanism(KINDS["finger"](support=SupportParameters(5e7, 0.1, 50.0)), LAW)
    loose = tuple(
        replace(one, role=SPRING) if one.name == "support" else one
        for one in mechanism.interactions
    )
    with pytest.raises(InputError):
        rigid_motion(TrainSystem(replace(mechanism, interactions=loose)))


def test_a_gap_of_turning_bodies_needs_its_unit():
    mechanism = build_mechanism(KINDS["finger"](), LAW)
    spring = Interaction("hold", LINEAR, ("lever",), (0.0, 1.0), ElasticLink(20.0))
    with pytest.raises(InputError):
        replace(mechanism, interactions=(*mechanism.interactions, spring))
