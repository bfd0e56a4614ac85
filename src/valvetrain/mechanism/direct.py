"""Direct-acting tappet: cam - tappet - (lash) - valve, one axis."""

from __future__ import annotations

import math

import numpy as np

from valvetrain.cam.contract import LiftLaw
from valvetrain.contact.law import ContactLaw
from valvetrain.mechanism.build import MechanismSpec
from valvetrain.mechanism.gap_kinds import LINEAR
from valvetrain.mechanism.parts import AssembledMechanism, Coordinate, Interaction
from valvetrain.mechanism.planar import cam_contact, sample_angles, sliding_row, unit, valve_parts
from valvetrain.mechanism.rigid import RatioCurve, RigidKinematics, check_lash
from valvetrain.parameters.train import TrainParameters


def build_direct(
    train: TrainParameters, law: LiftLaw, laws: dict[str, ContactLaw], law_of: str = "valve"
) -> AssembledMechanism:
    """Planar direct-acting train; the tappet slides along the valve's opening direction and its
    lift is the law's.

    ``law``: lift law of tappet or valve (the same here, whatever ``law_of`` says). ``laws``:
    contact laws for ``cam``, ``valve_tip`` and ``seat``.
    """
    follower, cam = train.follower, train.cam
    away = train.valve.opening_direction
    ux, uy = unit(away)
    sideways = (-uy * follower.offset, ux * follower.offset)
    if follower.shape == "flat":
        reach = cam.base_radius / math.cos(follower.tilt) - follower.offset * math.tan(
            follower.tilt
        )
    else:
        reach = math.sqrt((cam.base_radius + follower.radius) ** 2 - follower.offset**2)
    origin = (ux * reach + sideways[0], uy * reach + sideways[1])
    angle, jumps = sample_angles(law)
    lift = np.asarray(law.lift(angle, 0), dtype=float)
    centre = (origin[0] + ux * lift, origin[1] + uy * lift)
    contact, table = cam_contact(
        sliding_row(origin, (ux, uy)),
        ("tappet",),
        follower,
        laws["cam"],
        angle,
        centre,
        np.zeros_like(angle),
        away + follower.tilt,
        cam.rotation,
        jumps,
    )
    parts, links, valve, retainer = valve_parts(train, laws)
    weight = follower.mass * (train.gravity[0] * ux + train.gravity[1] * uy)
    tappet = Coordinate(
        "tappet", follower.mass, force=weight, damping=follower.damping, friction=follower.friction
    )
    tip = Interaction(
        "valve tip", LINEAR, ("tappet", retainer), (-train.lash, 1.0, -1.0), laws["valve_tip"]
    )
    top = float(np.max(lift)) * 1.2 + 1e-4
    drive = np.linspace(-0.1 * top, top, 64)
    kinematics = RigidKinematics(law, "drive", RatioCurve(drive, drive), 1.0, train.lash)
    check_lash(kinematics)
    return AssembledMechanism(
        "direct",
        (tappet, *parts),
        (contact, tip, *links),
        {"cam contour": table},
        valve,
        retainer,
        kinematics,
    )


SPEC = MechanismSpec("direct", ("cam", "valve_tip", "seat"), build_direct, needs=("follower.mass",))
