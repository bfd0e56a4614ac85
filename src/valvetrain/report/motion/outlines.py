"""Outlines of rigid parts in their own frames (m): lobes from contour tables, pads, bars, discs and turned profiles."""

from __future__ import annotations

import numpy as np

from valvetrain.mechanism.gap_kinds import CAM_FLAT
from valvetrain.report.motion.parts import Array, Shape

#: Points of a lobe and of a full circle.
LOBE_POINTS, CIRCLE_POINTS = 720, 40


def lobe_outline(kind: int, row: Array, table: Array, follower_radius: float, points: int = LOBE_POINTS) -> Array:
    """Outline (point, 2) of a cam in its own frame, which lies on the plane's at cam angle zero.

    Parameters
    ----------
    kind : ``CAM_FLAT`` (the table is a support function) or ``CAM_ROUND`` (a pitch curve)
    row : geometry row of the cam contact
    table : (nodes, 3) contour table, m and its derivatives by the cam angle
    follower_radius : arc (m) of a round follower
    points : points of the outline, taken from the table's nodes

    Returns
    -------
    The closed outline, counter-clockwise for a cam that turns clockwise: material under a follower at polar direction
    ``reference - sense chi``. A flat face touches it at h n + h' t; a round one at the pitch curve less its radius along the normal.
    """
    step = max(1, len(table) // points)
    value, slope = table[::step, 0], table[::step, 1]
    reference, sense = float(row[9]), float(row[10])
    polar = reference - sense * np.arange(0, len(table), step) * 2 * np.pi / len(table)
    radial, around = np.column_stack([np.cos(polar), np.sin(polar)]), np.column_stack([-np.sin(polar), np.cos(polar)])
    by_polar = (-sense * slope)[:, None]
    normal = (value[:, None] * radial - by_polar * around) / np.hypot(value, slope)[:, None]
    found: Array = value[:, None] * radial + (by_polar * around if kind == CAM_FLAT else -follower_radius * normal)
    return found


def circle(radius: float, centre: tuple[float, float] = (0.0, 0.0), points: int = CIRCLE_POINTS) -> Array:
    """Outline of a circle."""
    turn = np.arange(points) * 2 * np.pi / points
    return np.column_stack([centre[0] + radius * np.cos(turn), centre[1] + radius * np.sin(turn)])


def bar(first: Array, first_radius: float, second: Array, second_radius: float) -> Array:
    """Outline of a bar with round ends: the hull of two circles."""
    along = second - first
    distance = float(np.hypot(*along))
    if distance <= abs(first_radius - second_radius):
        return circle(max(first_radius, second_radius), tuple(first if first_radius > second_radius else second))
    direction = float(np.arctan2(along[1], along[0]))
    open_angle = float(np.arccos((first_radius - second_radius) / distance))
    near = np.linspace(open_angle, 2 * np.pi - open_angle, 20) + direction
    far = np.linspace(-open_angle, open_angle, 20) + direction
    ends = [
        centre + radius * np.column_stack([np.cos(turn), np.sin(turn)])
        for centre, radius, turn in ((first, first_radius, near), (second, second_radius, far))
    ]
    return np.concatenate(ends)


def crescent(centre: Array, radius: float, first: float, last: float, thickness: float) -> Array:
    """Outline of a pad: the arc of ``radius`` from ``first`` to ``last`` (rad), ``thickness`` deep towards its centre."""
    turn = np.linspace(first, last, 32)
    inner = max(radius - thickness, 0.0)
    outside = centre + radius * np.column_stack([np.cos(turn), np.sin(turn)])
    inside = centre + inner * np.column_stack([np.cos(turn[::-1]), np.sin(turn[::-1])])
    return np.concatenate([outside, inside])


def face(point: Array, normal: float, first: float, last: float, thickness: float) -> Array:
    """Outline of a flat pad whose face passes ``point`` across ``normal`` (rad), from ``first`` to ``last`` (m) along it."""
    n, t = np.array([np.cos(normal), np.sin(normal)]), np.array([-np.sin(normal), np.cos(normal)])
    corners = [point + first * t, point + last * t, point + last * t + thickness * n, point + first * t + thickness * n]
    return np.array(corners)


def plate(outline: Array, half_depth: float) -> Shape:
    """An outline between two planes at even distances from the plane of motion."""
    return Shape("extrude", outline, (-half_depth, half_depth))


def turned(*profile: tuple[float, float]) -> Shape:
    """A profile of (radius, height) points turned about the body's y axis."""
    return Shape("lathe", np.array(profile, dtype=float))


def disc(radius: float, bottom: float, top: float, bore: float = 0.0) -> Shape:
    """A disc about the body's y axis between two heights, with a bore where one is given."""
    return turned((bore, bottom), (radius, bottom), (radius, top), (bore, top), (bore, bottom))
