"""Compiled evaluation of a lift law in its flat form (`valvetrain.cam.pieces`)."""

from __future__ import annotations

import numpy as np

from valvetrain.compiled import njit


@njit(cache=True, nogil=True)
def evaluate_pieces(cam_angle, breaks, coefficients):
    """Lift, velocity and acceleration (m, m/rad, m/rad2) at one ``cam_angle`` (rad); flat arrays of
    :class:`PeriodicPieces`.
    """
    turn = 2.0 * np.pi
    since = (cam_angle - breaks[0]) % turn
    angle = breaks[0] + since
    low, high = 0, coefficients.shape[0]
    while high - low > 1:
        middle = (low + high) // 2
        if breaks[middle] <= angle:
            low = middle
        else:
            high = middle
    step = angle - breaks[low]
    lift, velocity, acceleration = 0.0, 0.0, 0.0
    for power in range(coefficients.shape[1] - 1, -1, -1):
        acceleration = acceleration * step + 2.0 * velocity
        velocity = velocity * step + lift
        lift = lift * step + coefficients[low, power]
    return lift, velocity, acceleration
