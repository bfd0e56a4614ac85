"""Compiled gap kinematics: penetration of one interaction and its gradient. Geometry only, no force law."""

from __future__ import annotations

import math

from numba import njit

from valvetrain.mechanism.gap_kinds import CAM_FLAT, CAM_LIFT, CAM_ROUND, DISTANCE, LINEAR, POINT_PLANE


@njit(cache=True, error_model="numpy", inline="never")
def table_value(table, cam_angle):
    """Quintic Hermite value, first and second derivative of a table (nodes, 3) over one turn, periodic."""
    nodes = table.shape[0]
    spacing = 2.0 * math.pi / nodes
    place = cam_angle / spacing
    cell = math.floor(place)
    t = place - cell
    left = int(cell) % nodes
    right = left + 1
    if right == nodes:
        right = 0
    value, slope, bend = table[left, 0], table[left, 1] * spacing, table[left, 2] * spacing * spacing
    rise = table[right, 0] - value - slope - 0.5 * bend
    slope_gap = table[right, 1] * spacing - slope - bend
    bend_gap = table[right, 2] * spacing * spacing - bend
    c3 = 10.0 * rise - 4.0 * slope_gap + 0.5 * bend_gap
    c4 = -15.0 * rise + 7.0 * slope_gap - bend_gap
    c5 = 6.0 * rise - 3.0 * slope_gap + 0.5 * bend_gap
    level = value + t * (slope + t * (0.5 * bend + t * (c3 + t * (c4 + t * c5))))
    first = slope + t * (bend + t * (3.0 * c3 + t * (4.0 * c4 + t * 5.0 * c5)))
    second = bend + t * (6.0 * c3 + t * (12.0 * c4 + t * 20.0 * c5))
    return level, first / spacing, second / (spacing * spacing)


@njit(cache=True, error_model="numpy")
def penetration_and_gradient(kind, index, geometry, table, q, cam_angle, gradient):
    """Penetration (m) and d penetration / d cam_angle (m/rad); ``gradient`` (4,) is filled for the coordinates in ``index``."""
    for slot in range(4):
        gradient[slot] = 0.0
    if kind == LINEAR:
        pen = geometry[0]
        for slot in range(4):
            if index[slot] >= 0:
                pen += geometry[1 + slot] * q[index[slot]]
                gradient[slot] = geometry[1 + slot]
        return pen, 0.0
    if kind == CAM_LIFT:
        lift, slope, _ = table_value(table, cam_angle)
        pen = geometry[5] * lift - geometry[0]
        for slot in range(4):
            if index[slot] >= 0:
                pen -= geometry[1 + slot] * q[index[slot]]
                gradient[slot] = -geometry[1 + slot]
        return pen, geometry[5] * slope
    x, y, dx, dy, turn = _planar_point(index, geometry, q)
    ex, ey = geometry[6], geometry[7]
    if kind == CAM_FLAT:
        direction = geometry[8] + turn
        nx, ny = math.cos(direction), math.sin(direction)
        height, slope, _ = table_value(table, cam_angle - geometry[10] * (direction - geometry[9]))
        gradient[0] = -(dx * nx + dy * ny)
        if geometry[0] != 0.0:
            # the face turns with the body: X . dn/dq = sign (y nx - x ny)
            gradient[0] -= geometry[5] * (geometry[10] * slope + y * nx - x * ny)
        gradient[1] = -(ex * nx + ey * ny)
        return height - x * nx - y * ny, slope
    if kind == CAM_ROUND:
        return _round_follower(geometry, table, cam_angle, x, y, dx, dy, gradient)
    if kind == POINT_PLANE:
        x0, y0 = geometry[1], geometry[2]
        if geometry[0] != 0.0:
            x0 += geometry[3]
            y0 += geometry[4]
        nx, ny = geometry[8], geometry[9]
        gradient[0] = dx * nx + dy * ny
        gradient[1] = ex * nx + ey * ny
        gradient[2] = -geometry[11]
        counter = q[index[2]] if index[2] >= 0 else 0.0
        return nx * (x - x0) + ny * (y - y0) - geometry[11] * counter - geometry[10], 0.0
    # DISTANCE
    lower = q[index[3]] if index[3] >= 0 else 0.0
    upper = q[index[2]] if index[2] >= 0 else lower
    rx, ry = x - geometry[8] - geometry[10] * lower, y - geometry[9] - geometry[11] * lower
    length = math.sqrt(rx * rx + ry * ry)
    nx, ny = rx / length, ry / length
    gradient[0] = -(dx * nx + dy * ny)
    gradient[1] = -(ex * nx + ey * ny)
    gradient[3] = nx * geometry[10] + ny * geometry[11]
    if index[2] >= 0:
        gradient[2] = 1.0
        gradient[3] -= 1.0
    return upper - lower - (length - geometry[12]) - geometry[13], 0.0


@njit(cache=True, error_model="numpy")
def _planar_point(index, geometry, q):
    """Position X, its derivative by the body coordinate, and the angle the body has turned."""
    body = q[index[0]] if index[0] >= 0 else 0.0
    support = q[index[1]] if index[1] >= 0 else 0.0
    x, y = geometry[1] + geometry[6] * support, geometry[2] + geometry[7] * support
    if geometry[0] == 0.0:
        return x + geometry[3] * body, y + geometry[4] * body, geometry[3], geometry[4], 0.0
    turn = geometry[5] * body
    c, s = math.cos(turn), math.sin(turn)
    ax, ay = c * geometry[3] - s * geometry[4], s * geometry[3] + c * geometry[4]
    return x + ax, y + ay, -geometry[5] * ay, geometry[5] * ax, turn


@njit(cache=True, error_model="numpy")
def _round_follower(geometry, table, cam_angle, x, y, dx, dy, gradient):
    distance = math.sqrt(x * x + y * y)
    direction = math.atan2(y, x)
    away = direction - geometry[9]
    away -= 2.0 * math.pi * math.floor(away / (2.0 * math.pi) + 0.5)
    pitch, slope, bend = table_value(table, cam_angle - geometry[10] * away)
    tangent = slope / pitch
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    gap = pitch - distance
    per_chi = cosine * slope - gap * tangent * (bend / pitch - tangent * tangent) * cosine * cosine * cosine
    per_x = -cosine * x / distance + per_chi * geometry[10] * y / (distance * distance)
    per_y = -cosine * y / distance - per_chi * geometry[10] * x / (distance * distance)
    gradient[0] = per_x * dx + per_y * dy
    gradient[1] = per_x * geometry[6] + per_y * geometry[7]
    return gap * cosine, per_chi
