"""Trains that several tests share, built without case files."""

from __future__ import annotations

import math

from valvetrain.cam.closed_form import SinePower
from valvetrain.mechanism.build import build_mechanism
from valvetrain.parameters.schema_contact import ContactParameters
from valvetrain.parameters.train import TrainParameters
from valvetrain.parameters.train_parts import (
    CamParameters,
    FollowerParameters,
    LeverParameters,
    PushrodParameters,
    ValveParameters,
)
from valvetrain.springs.massless import MasslessSpring
from valvetrain.system.train_system import TrainSystem

STIFF = ContactParameters("linear", {"contact_stiffness": 3e7, "damping": 300.0})
LAW = SinePower(
    maximum_lift=5e-3, opening_start=math.radians(40), closing_end=math.radians(240), power=4
)
PLACES = ("cam", "tappet", "rocker", "valve_tip", "seat")


def contacts(law: ContactParameters = STIFF) -> dict[str, ContactParameters]:
    return dict.fromkeys(PLACES, law)


def direct(**changes) -> TrainParameters:
    base = TrainParameters(
        "direct",
        CamParameters(0.018),
        FollowerParameters("flat", mass=0.05),
        valve=ValveParameters(0.09),
        contacts=contacts(),
    )
    return base.replace(**changes)


def finger(**changes) -> TrainParameters:
    lever = LeverParameters(
        (-0.03, -0.028),
        0.03354,
        0.047,
        inertia=7.5e-5,
        valve_angle=math.radians(5.9),
        holding_torque=0.3,
    )
    follower = FollowerParameters("domed", radius=0.025)
    return TrainParameters(
        "finger",
        CamParameters(0.018),
        follower,
        valve=ValveParameters(0.12),
        contacts=contacts(),
        lever=lever,
    ).replace(**changes)


def rocker(**changes) -> TrainParameters:
    lever = LeverParameters(
        (0.03, 0.022), 0.032, 0.04, inertia=5e-5, drive_side=1, holding_torque=0.3
    )
    return TrainParameters(
        "rocker",
        CamParameters(0.018),
        FollowerParameters("roller", radius=0.01),
        valve=ValveParameters(0.1),
        contacts=contacts(),
        lever=lever,
    ).replace(**changes)


def pushrod(**changes) -> TrainParameters:
    lever = LeverParameters(
        (0.025, 0.2), 0.025, 0.04, inertia=3e-5, drive_angle=math.pi, holding_torque=0.3
    )
    rod = PushrodParameters(0.17, lower_end=(0.0, 0.02), stiffness=3e7, damping=50.0)
    return TrainParameters(
        "pushrod",
        CamParameters(0.016),
        FollowerParameters("flat", mass=0.05),
        valve=ValveParameters(0.03),
        contacts=contacts(),
        lever=lever,
        pushrod=rod,
    ).replace(**changes)


KINDS = {"direct": direct, "finger": finger, "rocker": rocker, "pushrod": pushrod}


def system(train: TrainParameters, law=LAW, lift_of: str = "tappet", spring=None) -> TrainSystem:
    chosen = MasslessSpring(30e3, 300.0, 0.04) if spring is None else spring
    return TrainSystem(build_mechanism(train, law, lift_of), (chosen,), name=train.kind)


#: A case file: one mass, one spring known by its card.
SINGLE_MASS = """
title = "One mass, one spring"
[lift_law]
kind = "polynomial"
lift_of = "valve"
maximum_lift = "9 mm"
opening_start = "110 deg"
opening_end = "180 deg"
closing_start = "180 deg"
closing_end = "250 deg"
exponents = "3-4-5"
[operation]
engine_speeds = "6000 rpm"
[train]
kind = "direct"
model = "single-mass"
spring_set = "card"
spring_model = "massless"
contacts = "steel"
[train.cam]
base_radius = "40 mm"
width = "14 mm"
[train.follower]
shape = "flat"
mass = "45 g"
[train.valve]
mass = "80 g"
[[train.springs.card]]
preload = "300 N"
open_load = "700 N"
open_lift = "9 mm"
mass = "30 g"
"""
