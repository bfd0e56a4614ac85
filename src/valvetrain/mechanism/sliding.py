"""Compiled sliding kinematics of the contacts: geometry only, no friction law.

The sliding velocity of a contact is (material of the cam or lever at the contact point less
material of its partner) along the tangent t = (-n_y, n_x), linear in the velocities like the gap's
rate: ``per_angle * cam_speed + row . v``. Travel of the contact point itself does not enter. Gaps
without a tangent (LINEAR, CAM_LIFT) and ball joints (DISTANCE) slide nowhere:
:data:`SLIDING_KINDS`.
"""

from __future__ import annotations

import math

from valvetrain.compiled import njit
from valvetrain.mechanism.gap_kinds import ARC_RADIUS, CAM_FLAT, CAM_ROUND, POINT_PLANE
from valvetrain.mechanism.gaps import PART, _planar_point, table_value

SLIDING_KINDS = (CAM_FLAT, CAM_ROUND, POINT_PLANE)
SLIDING_SLOTS = 2
"""A contact slides with its body and the support alone: the partner of a plane moves along the
normal, a bar's ends slide nowhere.
"""


@njit(**PART)
def sliding_gradient(k, kinds, index, geometry, tables, table_of, q, cam_angle, slides):
    """Sliding velocity of interaction ``k`` per cam speed (m/rad); row k of ``slides`` (n, 2) is
    filled with that per coordinate.
    """
    kind, sense = kinds[k], geometry[k, 10]
    x, y, dx, dy, turn = _planar_point(k, index, geometry, q)
    if kind == POINT_PLANE:
        nx, ny = geometry[k, 8], geometry[k, 9]
        px, py = x + geometry[k, ARC_RADIUS] * nx, y + geometry[k, ARC_RADIUS] * ny
        _body_row(k, index, geometry, q, px, py, nx, ny, dx, dy, 1.0, slides)
        return 0.0
    if kind == CAM_FLAT:
        direction = geometry[k, 8] + turn
        nx, ny = math.cos(direction), math.sin(direction)
        height, slope, _ = table_value(
            tables, table_of[k], cam_angle - sense * (direction - geometry[k, 9])
        )
        px, py = height * nx + sense * slope * ny, height * ny - sense * slope * nx
    else:
        distance, direction = math.sqrt(x * x + y * y), math.atan2(y, x)
        pitch, slope, _ = table_value(
            tables, table_of[k], cam_angle - sense * (direction - geometry[k, 9])
        )
        scale = 1.0 / (math.sqrt(pitch * pitch + slope * slope) * distance)
        nx, ny = (pitch * x - sense * slope * y) * scale, (pitch * y + sense * slope * x) * scale
        px, py = x - geometry[k, ARC_RADIUS] * nx, y - geometry[k, ARC_RADIUS] * ny
    _body_row(k, index, geometry, q, px, py, nx, ny, dx, dy, -1.0, slides)
    return sense * (px * nx + py * ny)


@njit(**PART)
def _body_row(k, index, geometry, q, px, py, nx, ny, dx, dy, side, slides):
    """Tangential velocity of the body's material at (px, py) per body and support coordinate, times
    ``side``.
    """
    support = q[index[k, 1]] if index[k, 1] >= 0 else 0.0
    ex, ey = geometry[k, 6], geometry[k, 7]
    if geometry[k, 0] == 0.0:
        slides[k, 0] = side * (ny * -dx + nx * dy)
    else:
        # spin x (p - pivot), along t: (p - pivot) . n
        across = (px - geometry[k, 1] - ex * support) * nx + (
            py - geometry[k, 2] - ey * support
        ) * ny
        slides[k, 0] = side * geometry[k, 5] * across
    slides[k, 1] = side * (ny * -ex + nx * ey)
