"""Pushrod and rocker: cam - tappet - pushrod - rocker - valve; the rocker's ratio follows from the
geometry of both arms.
"""

from __future__ import annotations

import math

import numpy as np

from valvetrain.cam.contract import LiftLaw
from valvetrain.contact.law import ContactLaw
from valvetrain.errors import InputError
from valvetrain.mechanism.build import MechanismSpec
from valvetrain.mechanism.gap_kinds import DISTANCE, LINEAR
from valvetrain.mechanism.lever import lever_bodies, lever_travel, opening_sign, valve_tip_contact
from valvetrain.mechanism.parts import AssembledMechanism, Coordinate, ElasticLink, Interaction
from valvetrain.mechanism.planar import (
    cam_contact,
    rotate,
    sample_angles,
    sliding_row,
    support_parts,
    turning_row,
    unit,
    valve_parts,
)
from valvetrain.mechanism.rigid import RatioCurve, RigidKinematics, check_lash
from valvetrain.parameters.train import TrainParameters


def build_pushrod(
    train: TrainParameters, law: LiftLaw, laws: dict[str, ContactLaw], law_of: str
) -> AssembledMechanism:
    """Planar pushrod train; the tappet slides along +y from the cam. ``law_of`` 'tappet' or 'valve'
    (at zero lash).
    """
    lever, rod, follower, cam = train.lever, train.pushrod, train.follower, train.cam
    assert lever is not None and rod is not None
    if lever.drive_angle is None:
        raise InputError(
            "the rocker of a pushrod train needs drive_angle, the direction of its pushrod arm with the valve closed"
        )
    arm = tuple(lever.drive_arm * part for part in unit(lever.drive_angle))
    tip = tuple(lever.valve_arm * part for part in unit(lever.valve_angle))
    sign = opening_sign(train, tip)
    ratio = _chain_ratio(train, (arm[0], arm[1]), (tip[0], tip[1]), sign)
    kinematics = RigidKinematics(
        law, "valve" if law_of == "valve" else "drive", ratio, 1.0, train.lash
    )
    check_lash(kinematics)
    angle, jumps = sample_angles(law)
    lift = kinematics.drive(angle)
    if follower.shape == "flat":
        reach = cam.base_radius / math.cos(follower.tilt) + follower.offset * math.tan(
            follower.tilt
        )
    else:
        reach = math.sqrt((cam.base_radius + follower.radius) ** 2 - follower.offset**2)
    origin = (follower.offset, reach)
    upper, lower, rods = _rod_parts(train)
    own_tappet = follower.mass > 0
    contact, table = cam_contact(
        sliding_row(origin, (0.0, 1.0)),
        ("tappet" if own_tappet else lower,),
        follower,
        laws["cam"],
        angle,
        (np.full_like(angle, origin[0]), origin[1] + lift),
        np.zeros_like(angle),
        math.pi / 2 + follower.tilt,
        cam.rotation,
        jumps,
    )
    support, support_links, direction, support_name = support_parts(train, lever.mass)
    bodies, bars, driven, driving = lever_bodies(train, lever)
    ball = (lever.pivot[0] + arm[0], lever.pivot[1] + arm[1])
    length = pushrod_length(train)
    along_rod = math.atan2(ball[1] - rod.lower_end[1], ball[0] - rod.lower_end[0])
    row = [
        *turning_row(lever.pivot, (arm[0], arm[1]), sign, direction),
        *rod.lower_end,
        0.0,
        1.0,
        length,
        0.0,
    ]
    socket = Interaction(
        "rocker", DISTANCE, (driven, support_name, upper, lower), tuple(row), laws["rocker"]
    )
    tappets, joints = _tappet_parts(train, lower, laws) if own_tappet else ([], [])
    parts, links, valve, retainer = valve_parts(train, laws)
    tip_contact = valve_tip_contact(
        train, tip, sign, direction, (driving, support_name, retainer), laws["valve_tip"]
    )
    return AssembledMechanism(
        "pushrod",
        (*tappets, *rods[0], *bodies, *support, *parts),
        (contact, *joints, socket, tip_contact, *rods[1], *bars, *support_links, *links),
        {"cam contour": table},
        valve,
        retainer,
        kinematics,
        travel=lever_travel(train, bodies, [(along_rod, arm)], tip, sign),
    )


def pushrod_length(train: TrainParameters) -> float:
    """Length (m) of the pushrod between both balls; NaN where its lever's ``drive_angle`` is unknown."""
    lever, rod = train.lever, train.pushrod
    if lever is None or rod is None or lever.drive_angle is None:
        return math.nan
    x, y = (lever.drive_arm * part for part in unit(lever.drive_angle))
    return math.dist((lever.pivot[0] + x, lever.pivot[1] + y), rod.lower_end)


def _tappet_parts(
    train: TrainParameters, lower: str, laws: dict[str, ContactLaw]
) -> tuple[list[Coordinate], list[Interaction]]:
    """A tappet of its own between cam and pushrod; without a mass the pushrod's end touches the cam
    itself.
    """
    follower = train.follower
    weight = follower.mass * train.gravity[1]
    tappet = Coordinate(
        "tappet", follower.mass, force=weight, damping=follower.damping, friction=follower.friction
    )
    return [tappet], [
        Interaction("tappet", LINEAR, ("tappet", lower), (0.0, 1.0, -1.0), laws["tappet"])
    ]


def _rod_parts(
    train: TrainParameters,
) -> tuple[str, str, tuple[list[Coordinate], list[Interaction]]]:
    """Pushrod as one mass, or two halves joined by its axial stiffness; names of its upper ('' when
    rigid) and lower end.
    """
    rod = train.pushrod
    assert rod is not None
    if rod.stiffness is None:
        return (
            "",
            "pushrod",
            ([Coordinate("pushrod", rod.mass, force=rod.mass * train.gravity[1])], []),
        )
    half = rod.mass / 2
    ends = [
        Coordinate(name, half, force=half * train.gravity[1]) for name in ("pushrod", "pushrod top")
    ]
    bar = Interaction(
        "pushrod bar",
        LINEAR,
        ("pushrod", "pushrod top"),
        (0.0, 1.0, -1.0),
        ElasticLink(rod.stiffness, rod.damping),
    )
    return "pushrod top", "pushrod", (ends, [bar])


def _chain_ratio(
    train: TrainParameters, arm: tuple[float, float], tip: tuple[float, float], sign: float
) -> RatioCurve:
    """Valve lift (m) over tappet lift (m): for each rocker angle the tappet lift that keeps the
    rod's length, in closed form.
    """
    lever, rod = train.lever, train.pushrod
    assert lever is not None and rod is not None
    nx, ny = unit(train.valve.opening_direction)
    turn = np.linspace(-0.08, 0.6, 341)
    moved, opened = rotate(arm, sign * turn), rotate(tip, sign * turn)
    bx, by = (
        lever.pivot[0] + moved[0] - rod.lower_end[0],
        lever.pivot[1] + moved[1] - rod.lower_end[1],
    )
    length = pushrod_length(train)
    if np.any(np.abs(bx) >= length):
        raise InputError(
            "the pushrod cannot follow the rocker over its travel; check pivot, arm and lower_end"
        )
    drive = by - np.sqrt(length**2 - bx**2)
    lift = nx * (opened[0] - tip[0]) + ny * (opened[1] - tip[1])
    steps = (np.diff(drive) > 0) & (np.diff(lift) > 0)
    start = int(np.argmin(np.abs(turn)))
    if not steps[start]:
        raise InputError(
            "raising the pushrod does not open the valve; check the sides of the rocker's two arms"
        )
    stop = start + (
        int(np.argmin(steps[start:])) if not np.all(steps[start:]) else len(steps) - start
    )
    first = start - (int(np.argmin(steps[:start][::-1])) if not np.all(steps[:start]) else start)
    return RatioCurve(drive[first : stop + 1], lift[first : stop + 1])


SPEC = MechanismSpec(
    "pushrod",
    ("cam", "tappet", "rocker", "valve_tip", "seat"),
    build_pushrod,
    needs=("lever", "pushrod"),
)
