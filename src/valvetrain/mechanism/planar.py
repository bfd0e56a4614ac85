"""Planar building blocks shared by all trains: geometry rows, cam contact from a rigid motion,
valve and support parts.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array
from valvetrain.contact.law import ContactLaw
from valvetrain.mechanism.contour import (
    NODES,
    Lift,
    check_flat,
    check_round,
    lift_jumps,
    table_from_samples,
)
from valvetrain.mechanism.gap_kinds import ARC_RADIUS, CAM_FLAT, CAM_ROUND, LINEAR
from valvetrain.mechanism.parts import LINK, Coordinate, ElasticLink, Interaction
from valvetrain.parameters.train import TrainParameters
from valvetrain.parameters.train_parts import CrankParameters, FollowerParameters


def unit(direction: float) -> tuple[float, float]:
    """Unit vector of a polar angle (rad)."""
    return math.cos(direction), math.sin(direction)


def rotate(vector: tuple[float, float], turn: Any) -> tuple[Any, Any]:
    """A vector turned by an angle (rad, may be an array)."""
    c, s = np.cos(turn), np.sin(turn)
    return c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]


def turning_row(
    pivot: tuple[float, float], arm: tuple[float, float], sign: float, support: tuple[float, float]
) -> list[float]:
    """Columns 0-7 of a point on a turning body."""
    return [1.0, *pivot, *arm, sign, *support]


def sliding_row(origin: tuple[float, float], direction: tuple[float, float]) -> list[float]:
    """Columns 0-7 of a point on a sliding body."""
    return [0.0, *origin, *direction, 1.0, 0.0, 0.0]


def cam_contact(
    base_row: list[float],
    coordinates: tuple[str, ...],
    follower: FollowerParameters,
    law: ContactLaw,
    cam_angle: Array,
    centre: tuple[Array, Array],
    turn: Array,
    face_direction: float,
    rotation: int,
    jumps: tuple[int, ...] = (),
) -> tuple[Interaction, Array]:
    """Cam contact and its contour table, ground so that the rigid follower passes through the given
    poses.

    ``centre``: path of the arc centre (or of a point of the flat face) over ``cam_angle``; ``turn``
    (rad): rotation of the body; ``face_direction``: polar angle of a flat face's normal at zero
    lift; ``jumps``: indices of ``cam_angle`` at which the acceleration jumps. Raises
    :class:`InputError` for a cam with cusp or undercut.
    """
    x, y = centre
    if follower.shape == "flat":
        direction = face_direction + turn
        height = x * np.cos(direction) + y * np.sin(direction)
        chi = cam_angle - rotation * (direction - face_direction)
        table = table_from_samples(chi, height, jumps=jumps)
        check_flat(table)
        row = [*base_row, face_direction, face_direction, float(rotation)]
        return Interaction("cam", CAM_FLAT, coordinates, tuple(row), law, "cam contour"), table
    polar = np.unwrap(np.arctan2(y, x))
    reference = float(polar[0])
    table = table_from_samples(
        cam_angle - rotation * (polar - reference), np.hypot(x, y), jumps=jumps
    )
    check_round(table, follower.radius)
    row = [*base_row, 0.0, reference, float(rotation), *[0.0] * (ARC_RADIUS - 11), follower.radius]
    return Interaction("cam", CAM_ROUND, coordinates, tuple(row), law, "cam contour"), table


def sample_angles(law: Lift, per_node: int = 4) -> tuple[Array, tuple[int, ...]]:
    """Cam angles (rad) at which rigid poses are sampled for a contour, jumps of the law's second
    derivative among them, and the indices of those.
    """
    count = NODES * per_node
    angle, step, (jumps, *_) = (
        np.arange(count) * 2 * np.pi / count,
        2 * np.pi / count,
        lift_jumps(law),
    )
    if not len(jumps):
        return angle, ()
    jumps = np.sort(np.mod(jumps, 2 * np.pi))
    off = np.mod(angle[:, None] - jumps + step / 2, 2 * np.pi) - step / 2
    angle = np.sort(np.append(angle[np.all(np.abs(off) > step / 4, axis=1)], jumps))
    return angle, tuple(np.searchsorted(angle, jumps).tolist())


def valve_parts(
    train: TrainParameters, laws: dict[str, ContactLaw]
) -> tuple[list[Coordinate], list[Interaction], str, str]:
    """Valve coordinates, stem and seat: returns parts, the coordinate called valve lift, and the
    one carrying the retainer.
    """
    valve = train.valve
    ux, uy = unit(valve.opening_direction)
    along = train.gravity[0] * ux + train.gravity[1] * uy
    guide: dict[str, Any] = {"damping": valve.damping, "friction": valve.friction}
    if valve.stem_stiffness is None:
        parts = [Coordinate("valve", valve.mass, force=valve.mass * along, **guide)]
        seat = Interaction("seat", LINEAR, ("valve",), (0.0, -1.0), laws["seat"])
        return parts, [seat], "valve", "valve"
    head = valve.mass * valve.head_fraction
    tip = valve.mass - head
    parts = [
        Coordinate("valve", head, force=head * along, **guide),
        Coordinate("valve tip", tip, force=tip * along),
    ]
    stem = ElasticLink(valve.stem_stiffness, valve.stem_damping)
    links = [
        Interaction("seat", LINEAR, ("valve",), (0.0, -1.0), laws["seat"]),
        Interaction("stem", LINEAR, ("valve tip", "valve"), (0.0, 1.0, -1.0), stem),
    ]
    return parts, links, "valve", "valve tip"


def support_parts(
    train: TrainParameters, carried_mass: float
) -> tuple[list[Coordinate], list[Interaction], tuple[float, float], str]:
    """Elastic pivot: its coordinate, its link to the ground, its direction and its name ('' when
    rigid).
    """
    support = train.support
    if support is None:
        return [], [], (0.0, 0.0), ""
    ex, ey = unit(support.direction)
    mass = support.mass + carried_mass
    weight = mass * (train.gravity[0] * ex + train.gravity[1] * ey)
    law = ElasticLink(support.stiffness, support.damping)
    link = Interaction("support", LINEAR, ("support",), (0.0, 1.0), law, role=LINK)
    return [Coordinate("support", mass, force=weight)], [link], (ex, ey), "support"


def crank_angle(crank: CrankParameters, cam_angle: ArrayLike) -> Array:
    """Crank angle (rad) from top dead centre of gas exchange, from -2 pi to 2 pi."""
    found: Array = 2 * (np.mod(_from_top(crank, cam_angle) + np.pi, 2 * np.pi) - np.pi)
    return found


def _from_top(crank: CrankParameters, cam_angle: ArrayLike) -> Array:
    assert crank.top_dead_centre is not None, "system/build.py places it by the nose"
    found: Array = np.asarray(cam_angle, dtype=float) - crank.top_dead_centre
    return found


def piston_travel(crank: CrankParameters, cam_angle: ArrayLike) -> Array:
    """Distance (m) of the piston below its top dead centre; the crank turns twice per cam revolution.

    Exact slider: s = top - (r cos a + sqrt(l**2 - (r sin a - e)**2)), with offset e and top dead
    centre at ``top_dead_centre`` (of the centred crank; an offset shifts the true highest point by
    a fraction of a degree).
    """
    angle = 2 * _from_top(crank, cam_angle)
    reach = crank.radius * np.cos(angle) + np.sqrt(
        crank.rod_length**2 - (crank.radius * np.sin(angle) - crank.offset) ** 2
    )
    top = np.sqrt((crank.radius + crank.rod_length) ** 2 - crank.offset**2)
    found: Array = top - reach
    return found


def piston_clearance(crank: CrankParameters, cam_angle: ArrayLike, valve_lift: ArrayLike) -> Array:
    """Gap (m) between piston crown and valve along the cylinder; negative where they would meet."""
    found: Array = (
        crank.clearance
        + piston_travel(crank, cam_angle)
        - np.asarray(valve_lift) * np.cos(crank.valve_inclination)
    )
    return found
