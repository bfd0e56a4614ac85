"""Compiled gap kinematics: penetration of one interaction and its gradient. Geometry only, no force
law.
"""

from __future__ import annotations

import math
from typing import Any

from valvetrain.compiled import njit
from valvetrain.mechanism.gap_kinds import CAM_FLAT, CAM_LIFT, CAM_ROUND, LINEAR, POINT_PLANE

#: No reference counting: nothing is allocated, and counting the arrays passed along would cost more
#: than the geometry.
OPTIONS: dict[str, Any] = {
    "cache": True,
    "error_model": "numpy",
    "_nrt": False,
    "fastmath": {"contract", "nsz"},
}
#: A part of kernels: compiled into each that calls it, and stored with those alone.
PART: dict[str, Any] = {**OPTIONS, "cache": False, "forceinline": True}


@njit(forceinline=True, **OPTIONS)
def table_value(tables, place_of_table, cam_angle):
    """Quintic Hermite value, first and second derivative of one of ``tables`` (m, nodes, 3) over
    one turn, periodic; with a jump of the second derivative inside a cell of (m, nodes, 5).
    """
    nodes, m = tables.shape[1], place_of_table
    spacing, per_spacing = 2.0 * math.pi / nodes, nodes / (2.0 * math.pi)
    place = cam_angle * per_spacing
    cell = math.floor(place)
    t = place - cell
    left = int(cell) % nodes
    right = left + 1
    if right == nodes:
        right = 0
    value, slope, bend = (
        tables[m, left, 0],
        tables[m, left, 1] * spacing,
        tables[m, left, 2] * spacing * spacing,
    )
    rise = tables[m, right, 0] - value - slope - 0.5 * bend
    slope_gap = tables[m, right, 1] * spacing - slope - bend
    bend_gap = tables[m, right, 2] * spacing * spacing - bend
    jump, beyond = 0.0, 0.0
    if tables.shape[2] > 3:
        # what the jump adds up to the right node is left out of the quintic and added behind it
        jump, rest = tables[m, left, 4] * spacing * spacing, 1.0 - tables[m, left, 3]
        rise -= 0.5 * jump * rest * rest
        slope_gap -= jump * rest
        bend_gap -= jump
        beyond = t - tables[m, left, 3]
    c3 = 10.0 * rise - 4.0 * slope_gap + 0.5 * bend_gap
    c4 = -15.0 * rise + 7.0 * slope_gap - bend_gap
    c5 = 6.0 * rise - 3.0 * slope_gap + 0.5 * bend_gap
    level = value + t * (slope + t * (0.5 * bend + t * (c3 + t * (c4 + t * c5))))
    first = slope + t * (bend + t * (3.0 * c3 + t * (4.0 * c4 + t * 5.0 * c5)))
    second = bend + t * (6.0 * c3 + t * (12.0 * c4 + t * 20.0 * c5))
    if beyond > 0.0:
        level += 0.5 * jump * beyond * beyond
        first += jump * beyond
        second += jump
    return level, first * per_spacing, second * per_spacing * per_spacing


@njit(forceinline=True, **OPTIONS)
def penetration_and_gradient(k, kinds, index, geometry, tables, table_of, q, cam_angle, gradients):
    """Penetration (m) and d penetration / d cam_angle (m/rad) of interaction ``k``; row k of
    ``gradients`` (n, 4) is filled.

    Whole arrays and a place travel instead of rows: every row view costs a reference count in the
    loop.
    """
    kind = kinds[k]
    for slot in range(4):
        gradients[k, slot] = 0.0
    if kind == LINEAR:
        pen = geometry[k, 0]
        for slot in range(4):
            if index[k, slot] >= 0:
                pen += geometry[k, 1 + slot] * q[index[k, slot]]
                gradients[k, slot] = geometry[k, 1 + slot]
        return pen, 0.0
    if kind == CAM_LIFT:
        lift, slope, _ = table_value(tables, table_of[k], cam_angle)
        pen = geometry[k, 5] * lift - geometry[k, 0]
        for slot in range(4):
            if index[k, slot] >= 0:
                pen -= geometry[k, 1 + slot] * q[index[k, slot]]
                gradients[k, slot] = -geometry[k, 1 + slot]
        return pen, geometry[k, 5] * slope
    x, y, dx, dy, turn = _planar_point(k, index, geometry, q)
    ex, ey = geometry[k, 6], geometry[k, 7]
    if kind == CAM_FLAT:
        direction = geometry[k, 8] + turn
        nx, ny = math.cos(direction), math.sin(direction)
        height, slope, _ = table_value(
            tables, table_of[k], cam_angle - geometry[k, 10] * (direction - geometry[k, 9])
        )
        gradients[k, 0] = -(dx * nx + dy * ny)
        if geometry[k, 0] != 0.0:
            # the face turns with the body: X . dn/dq = sign (y nx - x ny)
            gradients[k, 0] -= geometry[k, 5] * (geometry[k, 10] * slope + y * nx - x * ny)
        gradients[k, 1] = -(ex * nx + ey * ny)
        return height - x * nx - y * ny, slope
    if kind == CAM_ROUND:
        return _round_follower(k, geometry, tables, table_of, cam_angle, x, y, dx, dy, gradients)
    if kind == POINT_PLANE:
        x0, y0 = geometry[k, 1], geometry[k, 2]
        if geometry[k, 0] != 0.0:
            x0 += geometry[k, 3]
            y0 += geometry[k, 4]
        nx, ny = geometry[k, 8], geometry[k, 9]
        gradients[k, 0] = dx * nx + dy * ny
        gradients[k, 1] = ex * nx + ey * ny
        gradients[k, 2] = -geometry[k, 11]
        counter = q[index[k, 2]] if index[k, 2] >= 0 else 0.0
        return nx * (x - x0) + ny * (y - y0) - geometry[k, 11] * counter - geometry[k, 10], 0.0
    # DISTANCE
    lower = q[index[k, 3]] if index[k, 3] >= 0 else 0.0
    upper = q[index[k, 2]] if index[k, 2] >= 0 else lower
    rx, ry = (
        x - geometry[k, 8] - geometry[k, 10] * lower,
        y - geometry[k, 9] - geometry[k, 11] * lower,
    )
    length = math.sqrt(rx * rx + ry * ry)
    nx, ny = rx / length, ry / length
    gradients[k, 0] = -(dx * nx + dy * ny)
    gradients[k, 1] = -(ex * nx + ey * ny)
    gradients[k, 3] = nx * geometry[k, 10] + ny * geometry[k, 11]
    if index[k, 2] >= 0:
        gradients[k, 2] = 1.0
        gradients[k, 3] -= 1.0
    return upper - lower - (length - geometry[k, 12]) - geometry[k, 13], 0.0


@njit(**OPTIONS)
def gap_rows(
    kinds, index, geometry, tables, table_of, positions, cam_angles, rows, pens, gradients, slopes
):
    """Fill penetrations (S, n), gradients by every coordinate (S, n, N), which begin as zeros, and
    slopes (S, n) at ``positions`` (S, N) and ``cam_angles`` (S,); ``rows`` (n, 4) is working space.
    """
    for s in range(len(cam_angles)):
        for k in range(len(kinds)):
            pens[s, k], slopes[s, k] = penetration_and_gradient(
                k, kinds, index, geometry, tables, table_of, positions[s], cam_angles[s], rows
            )
            for slot in range(4):
                if index[k, slot] >= 0:
                    gradients[s, k, index[k, slot]] += rows[k, slot]


@njit(**PART)
def _planar_point(k, index, geometry, q):
    """Position X, its derivative by the body coordinate, and the angle the body has turned."""
    body = q[index[k, 0]] if index[k, 0] >= 0 else 0.0
    support = q[index[k, 1]] if index[k, 1] >= 0 else 0.0
    x, y = geometry[k, 1] + geometry[k, 6] * support, geometry[k, 2] + geometry[k, 7] * support
    if geometry[k, 0] == 0.0:
        return (
            x + geometry[k, 3] * body,
            y + geometry[k, 4] * body,
            geometry[k, 3],
            geometry[k, 4],
            0.0,
        )
    turn = geometry[k, 5] * body
    c, s = math.cos(turn), math.sin(turn)
    ax, ay = c * geometry[k, 3] - s * geometry[k, 4], s * geometry[k, 3] + c * geometry[k, 4]
    return x + ax, y + ay, -geometry[k, 5] * ay, geometry[k, 5] * ax, turn


@njit(**PART)
def _round_follower(k, geometry, tables, table_of, cam_angle, x, y, dx, dy, gradients):
    distance = math.sqrt(x * x + y * y)
    direction = math.atan2(y, x)
    away = direction - geometry[k, 9]
    away -= 2.0 * math.pi * math.floor(away * (0.5 / math.pi) + 0.5)
    pitch, slope, bend = table_value(tables, table_of[k], cam_angle - geometry[k, 10] * away)
    cosine = pitch / math.sqrt(pitch * pitch + slope * slope)
    per_pitch, per_distance, gap = 1.0 / pitch, 1.0 / distance, pitch - distance
    tangent = slope * per_pitch
    per_chi = (
        cosine * slope
        - gap * tangent * (bend * per_pitch - tangent * tangent) * cosine * cosine * cosine
    )
    ex, ey = x * per_distance, y * per_distance
    around = per_chi * geometry[k, 10] * per_distance
    per_x = -cosine * ex + around * ey
    per_y = -cosine * ey - around * ex
    gradients[k, 0] = per_x * dx + per_y * dy
    gradients[k, 1] = per_x * geometry[k, 6] + per_y * geometry[k, 7]
    return gap * cosine, per_chi
