"""What the cam does before anything runs: ramp, velocity, acceleration, durations of its lift law, and
the contact and curvature that its contour has under the follower.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from valvetrain.cam.contract import LiftLaw
from valvetrain.mechanism.contour import curvature_radius_flat, curvature_radius_round
from valvetrain.mechanism.gap_kinds import CAM_FLAT, CAM_ROUND
from valvetrain.quantities.valve_events import lift_crossings

if TYPE_CHECKING:
    from valvetrain.system.problem import Gear

#: Cam angles at which a lift law is looked at, twenty a degree.
SAMPLES = 7200
#: Lifts (m) whose durations are given next to those of a cam card: 0.15 mm, 1 mm and 0.050 in.
HEIGHTS = (0.15e-3, 1e-3, 0.050 * 25.4e-3)
#: Heights (m) closer than this are one: 0.15 mm and 0.006 in.
ALIKE = 5e-6


def cam_quantities(law: LiftLaw, gear: Gear | None = None, ramp: float = 0.0) -> dict[str, float]:
    """Named quantities (SI) of a lift law and, of a planar train, of its cam.

    Parameters
    ----------
    law : lift over the cam angle, of the follower or of the valve
    gear : the train that it moves
    ramp : lift (m) at which the ramps of the law end; 0 of a law without

    Returns
    -------
    Largest velocities (m/rad) of opening and closing, largest and smallest acceleration (m/rad2), ramp
    velocities (m/rad) where the ramp ends, without one where the lash is taken up, and of a contour its least radii (m)
    and the distance (m) of the contact from the cam's centre; those alone that it has

    Examples
    --------
    >>> from valvetrain.cam.cam_card import CamCard
    >>> card = CamCard(maximum_lift=8e-3, nose=np.pi, duration=np.radians(118))
    >>> round(cam_quantities(card, ramp=1e-4)["cam_opening_ramp_velocity"] * 1e3 / 57.29578, 4)
    0.0127
    """
    angle = np.arange(SAMPLES) * 2 * np.pi / SAMPLES
    velocity, acceleration = (np.asarray(law.lift(angle, order)) for order in (1, 2))
    found = {
        "cam_opening_velocity": float(np.max(velocity)),
        "cam_closing_velocity": float(-np.min(velocity)),
        "cam_largest_acceleration": float(np.max(acceleration)),
        "cam_smallest_acceleration": float(np.min(acceleration)),
    }
    if ramp > 0:
        found = {"cam_ramp_lift": ramp} | found
    height = ramp or lash_lift(gear)
    if height > 0 and (ends := lift_crossings(law.lift, height)):
        before, after = (float(law.lift(np.array(end), 1)) for end in ends)
        found |= {"cam_opening_ramp_velocity": before, "cam_closing_ramp_velocity": -after}
    return found | (_contour_quantities(gear) if gear is not None else {})


def lash_lift(gear: Gear | None) -> float:
    """What the law lifts (m) until the lash of a train is taken up; 0 without lash."""
    if gear is None or not gear.mechanism.kinematics.lash > 0:
        return 0.0
    return float(gear.mechanism.kinematics.law_lift(0.0))


def cam_durations(law: LiftLaw, heights: Iterable[float] = ()) -> dict[float, float]:
    """Lift (m) -> crank angle (rad) above it, of ``heights`` (m) and those of :data:`HEIGHTS` that
    differ from them, lowest first; without those that the law does not reach.
    """
    every = sorted({height for height in heights if height > 0})
    every += [
        own for own in HEIGHTS if not any(abs(own - height) < ALIKE for height in tuple(every))
    ]
    found = {height: lift_crossings(law.lift, height) for height in sorted(every)}
    return {height: 2 * (ends[1] - ends[0]) for height, ends in found.items() if ends is not None}


def _contour_quantities(gear: Gear) -> dict[str, float]:
    """Least convex and concave radius of a contour; of a flat face how far the contact runs from the
    cam's centre and, of a sliding one, from its own axis.
    """
    mechanism, train = gear.mechanism, gear.parameters
    contact = mechanism.interactions[mechanism.interaction_index("cam")]
    if contact.kind not in (CAM_FLAT, CAM_ROUND):
        return {}
    table, row = mechanism.tables[contact.table], contact.geometry_row()
    flat = contact.kind == CAM_FLAT
    radius = (
        curvature_radius_flat(table)
        if flat
        else curvature_radius_round(table, train.follower.radius)
    )
    found = {"cam_least_radius": float(np.min(radius[radius > 0]))}
    if np.any(radius < 0):
        found["cam_hollow_radius"] = float(-np.max(radius[radius < 0]))
    if flat:
        away = -row[10] * table[:, 1]
        found["cam_contact_offset"] = float(np.max(np.abs(away)))
        if row[0] == 0.0:  # a sliding follower: its axis is where its point is along the face
            axis = -np.sin(row[8]) * row[1] + np.cos(row[8]) * row[2]
            found["cam_contact_face_radius"] = float(np.max(np.abs(away - axis)))
    return found
