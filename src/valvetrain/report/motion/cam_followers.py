"""What touches the cam: faces, arcs and rollers, wide enough for the travel of the contact over the cycle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from valvetrain.mechanism.gap_kinds import CAM_FLAT
from valvetrain.mechanism.parts import Interaction
from valvetrain.parameters.train import FollowerParameters
from valvetrain.report.motion import outlines
from valvetrain.report.motion.parts import Array, Body, Shape

#: Room (m, rad) beyond the travel of the contact, thickness (m) of a pad, height of a tappet over its half width.
MARGIN, ARC_MARGIN, PAD, TAPPET_SHARE = 1.5e-3, 0.12, 4e-3, 0.9


@dataclass(frozen=True, eq=False)
class Contact:
    """The contact of a cam: its interaction, its contour table and the follower's shape."""

    interaction: Interaction
    table: Array
    follower: FollowerParameters

    @property
    def row(self) -> Array:
        """Geometry row."""
        return self.interaction.geometry_row()

    @property
    def turning(self) -> bool:
        """Whether the follower turns about a pivot."""
        return bool(self.row[0])

    @property
    def flat(self) -> bool:
        """Whether a flat face touches."""
        return self.interaction.kind == CAM_FLAT

    @property
    def driven(self) -> str:
        """Coordinate of the follower."""
        return self.interaction.coordinates[0]

    @property
    def sense(self) -> float:
        """+1 of a cam that turns counter-clockwise."""
        return float(self.row[10])

    @property
    def home(self) -> Array:
        """Arc centre, or point of the face, at zero lift (x, y in m)."""
        row = self.row
        return np.array(row[1:3] + (row[3:5] if self.turning else 0.0))

    @property
    def axis(self) -> Array:
        """Direction in which a sliding follower moves."""
        return np.array(self.row[3:5])

    def lobe(self) -> Array:
        """Outline (point, 2) of the cam in its own frame."""
        return outlines.lobe_outline(self.interaction.kind, self.row, self.table, self.follower.radius)

    @cached_property
    def slopes(self) -> tuple[float, float]:
        """Least and largest slope of the contour by the cam angle: of a flat face the place of the contact (m), of an arc its tangent."""
        slope = self.table[:, 1] if self.flat else self.table[:, 1] / self.table[:, 0]
        return float(np.min(self.sense * slope)), float(np.max(self.sense * slope))

    def half_width(self) -> float:
        """Half width (m) that a sliding follower needs."""
        if self.flat:
            tangent = np.array([-self.axis[1], self.axis[0]])
            offset = float(self.home @ tangent)
            return max(abs(-low - offset) for low in self.slopes) + MARGIN
        sine = np.sin(np.arctan(max(abs(low) for low in self.slopes)))
        return float(min(self.follower.radius * 0.98, self.follower.radius * sine + MARGIN)) if self.follower.radius else 4e-3

    def tappet_height(self) -> float:
        """Height (m) of a tappet from its contact to the valve, which no case holds."""
        return TAPPET_SHARE * self.half_width() + 6e-3


def sliding_follower(contact: Contact, moved: Array, name: str, cam_width: float, height: float | None) -> Body:
    """A tappet: flat face, dome, roller in a fork or knife edge; the body's y axis leads away from the cam."""
    follower, half = contact.follower, contact.half_width()
    tall = contact.tappet_height() if height is None else height
    axis = contact.axis
    pose = np.column_stack([contact.home + moved[:, None] * axis, np.full(len(moved), np.arctan2(axis[1], axis[0]) - np.pi / 2)])
    shapes: tuple[Shape, ...]
    if contact.flat and follower.tilt == 0:
        shapes = (outlines.disc(half, 0.0, tall),)
    elif contact.flat:
        lean = np.tan(follower.tilt)
        # The face leans in the body's frame, where the y axis is the axis of the tappet.
        shapes = (outlines.plate(np.array([[-half, -half * lean], [half, half * lean], [half, tall], [-half, tall]]), half),)
    elif follower.shape == "roller":
        fork = np.array([[-0.6 * half, 0.0], [0.6 * half, 0.0], [half, follower.radius + tall], [-half, follower.radius + tall]])
        shapes = (outlines.plate(outlines.circle(follower.radius), 0.4 * cam_width), outlines.plate(fork, 0.5 * cam_width))
    elif follower.radius:
        turn = np.linspace(0.0, np.arcsin(min(half / follower.radius, 1.0)), 16)
        dome = [(float(follower.radius * np.sin(one)), float(-follower.radius * np.cos(one))) for one in turn]
        top = max(tall, dome[-1][1] + 1e-3) if height is not None else tall
        shapes = (outlines.turned(*dome, (half, top), (0.0, top)),)
    else:
        shapes = (outlines.turned((0.0, 0.0), (half, 1.5 * half), (half, max(tall, 2 * half)), (0.0, max(tall, 2 * half))),)
    return Body(name, "follower", shapes, pose)


def turning_pad(contact: Contact, turned: Array, cam_angle: Array, depth: float, hub: float) -> tuple[Shape, ...]:
    """Pad or roller of a lever in the lever's frame (origin at the pivot), and the bar that carries it."""
    row, follower = contact.row, contact.follower
    arm, none = np.array(row[3:5]), np.zeros(2)
    if follower.shape == "roller":
        rim = outlines.circle(follower.radius, (float(arm[0]), float(arm[1])))
        return outlines.plate(rim, 1.3 * depth), outlines.plate(outlines.bar(none, hub, arm, 0.6 * follower.radius), depth)
    if contact.flat:
        low, high = sorted(-value for value in contact.slopes)
        normal = float(row[8])
        tangent = np.array([-np.sin(normal), np.cos(normal)])
        offset = float(contact.home @ tangent)
        pad = outlines.face(arm, normal, low - offset - MARGIN, high - offset + MARGIN, PAD)
        return outlines.plate(pad, 1.2 * depth), outlines.plate(outlines.bar(none, hub, pad.mean(axis=0), PAD / 2), depth)
    where = contact_direction(contact, turned, cam_angle)
    middle, reach = float(where.min() + where.max()) / 2, float(np.ptp(where)) / 2 + ARC_MARGIN
    pad = outlines.crescent(arm, follower.radius, middle - reach, middle + reach, PAD)
    foot = arm + (follower.radius - PAD / 2) * np.array([np.cos(middle), np.sin(middle)])
    return outlines.plate(pad, 1.2 * depth), outlines.plate(outlines.bar(none, hub, foot, PAD / 2), depth)


def contact_direction(contact: Contact, turned: Array, cam_angle: Array) -> Array:
    """Direction (frame,) in a lever's frame, unwrapped, from the arc's centre to the cam: where on its arc the pad is touched."""
    row = contact.row
    turn = row[5] * turned
    x = row[1] + np.cos(turn) * row[3] - np.sin(turn) * row[4]
    y = row[2] + np.sin(turn) * row[3] + np.cos(turn) * row[4]
    polar = np.arctan2(y, x)
    away = np.mod(polar - row[9] + np.pi, 2 * np.pi) - np.pi
    chi = np.mod(cam_angle - contact.sense * away, 2 * np.pi)
    nodes = np.arange(len(contact.table)) * 2 * np.pi / len(contact.table)
    pitch, slope = (np.interp(chi, nodes, contact.table[:, column], period=2 * np.pi) for column in (0, 1))
    # The pitch curve's normal leads from the cam to the centre; the contact lies the other way.
    normal = polar - np.arctan2(-contact.sense * slope, pitch)
    found: Array = np.unwrap(normal + np.pi - turn)
    return found
