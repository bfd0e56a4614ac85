"""Finger follower (end pivot) and centre-pivot rocker: the cam presses on a lever whose tip opens
the valve.
"""

from __future__ import annotations

import math

import numpy as np

from valvetrain.cam.contract import LiftLaw
from valvetrain.contact.law import ContactLaw
from valvetrain.errors import InputError
from valvetrain.mechanism.build import MechanismSpec
from valvetrain.mechanism.gap_kinds import ARC_RADIUS, LINEAR, POINT_PLANE
from valvetrain.mechanism.parts import AssembledMechanism, Coordinate, ElasticLink, Interaction
from valvetrain.mechanism.planar import (
    cam_contact,
    rotate,
    sample_angles,
    support_parts,
    turning_row,
    unit,
    valve_parts,
)
from valvetrain.mechanism.rigid import RatioCurve, RigidKinematics, check_lash
from valvetrain.parameters.train import TrainParameters
from valvetrain.parameters.train_parts import LeverParameters


def build_lever(
    train: TrainParameters, law: LiftLaw, laws: dict[str, ContactLaw], law_of: str
) -> AssembledMechanism:
    """Planar train with a cam-driven lever. ``law_of`` 'valve': lift at the valve with zero lash;
    'tappet': drive arm times lever angle (m).
    """
    lever = train.lever
    assert lever is not None
    arm, (px, py), flat = drive_arm(train, lever), lever.pivot, train.follower.shape == "flat"
    tip = tuple(lever.valve_arm * part for part in unit(lever.valve_angle))
    sign = opening_sign(train, tip)
    radial = (lever.pivot[0] + arm[0], lever.pivot[1] + arm[1])
    outward = sign * (radial[1] * arm[0] - radial[0] * arm[1])
    if outward <= 0:
        raise InputError(
            "the cam would press the lever so as to close the valve; move the pivot, or change drive_side or valve_angle"
        )
    ratio = tip_ratio(train, tip, sign)
    kinematics = RigidKinematics(
        law, "valve" if law_of == "valve" else "drive", ratio, lever.drive_arm, train.lash
    )
    check_lash(kinematics)
    angle, jumps = sample_angles(law)
    turn = sign * kinematics.drive(angle)
    moved = rotate(arm, turn)
    centre = (lever.pivot[0] + moved[0], lever.pivot[1] + moved[1])
    support, support_links, direction, support_name = support_parts(train, lever.mass)
    bodies, bars, driven, driving = lever_bodies(train, lever)
    face = math.atan2(radial[1], radial[0])
    contact, table = cam_contact(
        turning_row(lever.pivot, arm, sign, direction),
        (driven, support_name),
        train.follower,
        laws["cam"],
        angle,
        centre,
        turn,
        face,
        train.cam.rotation,
        jumps,
    )
    parts, links, valve, retainer = valve_parts(train, laws)
    tip_contact = valve_tip_contact(
        train, tip, sign, direction, (driving, support_name, retainer), laws["valve_tip"]
    )
    return AssembledMechanism(
        train.kind,
        (*bodies, *support, *parts),
        (contact, tip_contact, *bars, *support_links, *links),
        {"cam contour": table},
        valve,
        retainer,
        kinematics,
        travel=lever_travel(train, bodies, [] if flat else [(math.atan2(py, px), arm)], tip, sign),
    )


def drive_arm(train: TrainParameters, lever: LeverParameters) -> tuple[float, float]:
    """Arm from the pivot to the pad's arc centre (or a point of its flat face) at zero lift, from
    the base circle.
    """
    px, py = lever.pivot
    if lever.drive_angle is not None and train.follower.shape == "flat":
        return lever.drive_arm * math.cos(lever.drive_angle), lever.drive_arm * math.sin(
            lever.drive_angle
        )
    center_distance, distance = train.cam.base_radius + train.follower.radius, math.hypot(px, py)
    cosine = (center_distance**2 - distance**2 - lever.drive_arm**2) / (
        2 * distance * lever.drive_arm
    )
    if not -1 < cosine < 1:
        raise InputError(
            f"a lever arm of {lever.drive_arm * 1e3:g} mm on a pivot {distance * 1e3:g} mm from the cam centre cannot rest on a base "
            f"circle of "
            f"{train.cam.base_radius * 1e3:g} mm; change pivot, arm or radius"
        )
    polar = math.atan2(py, px) + lever.drive_side * math.acos(cosine)
    return lever.drive_arm * math.cos(polar), lever.drive_arm * math.sin(polar)


def opening_sign(train: TrainParameters, tip: tuple[float, ...]) -> float:
    """Sense of rotation (+1 counter-clockwise) in which the lever's tip opens the valve."""
    nx, ny = unit(train.valve.opening_direction)
    rate = -tip[1] * nx + tip[0] * ny
    if abs(rate) < 1e-3 * math.hypot(*tip):
        raise InputError(
            "the lever's valve arm is parallel to the valve axis, so turning it does not open the valve; change valve_angle"
        )
    return 1.0 if rate > 0 else -1.0


def tip_ratio(
    train: TrainParameters, tip: tuple[float, ...], sign: float, reach: float = 0.6
) -> RatioCurve:
    """Valve lift (m) over the lever angle (rad): n . (R(sign q) - 1) tip, over the range in which
    it grows.
    """
    nx, ny = unit(train.valve.opening_direction)
    drive = np.linspace(-0.1, reach, 281)
    moved = rotate((tip[0], tip[1]), sign * drive)
    lift = nx * (moved[0] - tip[0]) + ny * (moved[1] - tip[1])
    growing = (
        np.argmax(np.diff(lift)[28:] <= 0) if np.any(np.diff(lift)[28:] <= 0) else len(drive) - 29
    )
    return RatioCurve(drive[: 29 + growing], lift[: 29 + growing])


def lever_travel(
    train: TrainParameters,
    bodies: list[Coordinate],
    driven: list[tuple[float, tuple[float, ...]]],
    tip: tuple[float, ...],
    sign: float,
) -> dict[str, tuple[float, float]]:
    """Angles (rad) of a lever's ``bodies`` between its dead points: where turning it still moves
    the tip along the valve and every ``driven`` arm in its direction (rad).
    """
    low, high = -math.pi, math.pi
    for direction, (x, y) in ((train.valve.opening_direction, tip), *driven):
        dead = sign * (direction - math.atan2(y, x)) % (2 * math.pi)
        low, high = max(low, dead - math.pi), min(high, dead)
    return {body.name: (low, high) for body in bodies}


def lever_bodies(
    train: TrainParameters, lever: LeverParameters
) -> tuple[list[Coordinate], list[Interaction], str, str]:
    """One turning body, or two halves joined by a torsion link when the lever is elastic: parts,
    links, driven and driving names.
    """
    if lever.stiffness is None:
        return (
            [Coordinate("lever", lever.inertia, "rad", -lever.holding_torque)],
            [],
            "lever",
            "lever",
        )
    twist = ElasticLink(lever.stiffness * lever.valve_arm**2, lever.damping * lever.valve_arm**2)
    halves = [
        Coordinate("lever", lever.inertia / 2, "rad", -lever.holding_torque),
        Coordinate("lever tip", lever.inertia / 2, unit="rad"),
    ]
    ends = "lever", "lever tip"
    bending = Interaction("lever bending", LINEAR, ends, (0.0, 1.0, -1.0), twist, unit="rad")
    return halves, [bending], *ends


def valve_tip_contact(
    train: TrainParameters,
    tip: tuple[float, ...],
    sign: float,
    support: tuple[float, float],
    names: tuple[str, ...],
    law: ContactLaw,
) -> Interaction:
    """Arc of the lever's tip on the flat end of the stem, the lash between them."""
    assert train.lever is not None
    row = [
        *turning_row(train.lever.pivot, (tip[0], tip[1]), sign, support),
        *unit(train.valve.opening_direction),
        train.lash,
        1.0,
    ]
    row += [*[0.0] * (ARC_RADIUS - len(row)), train.lever.tip_radius]
    return Interaction("valve tip", POINT_PLANE, names, tuple(row), law)


FINGER = MechanismSpec("finger", ("cam", "valve_tip", "seat"), build_lever, needs=("lever",))
ROCKER = MechanismSpec("rocker", FINGER.places, build_lever, needs=("lever",))
