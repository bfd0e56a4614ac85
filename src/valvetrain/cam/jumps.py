"""A lift table of a lobe whose acceleration jumps (arcs, tangents): a curve that does not swing beyond both sides of a jump."""

from __future__ import annotations

import numpy as np

from valvetrain.cam.contract import Array

#: A change of the acceleration within three steps is a jump where it is this share of the whole range and the two steps on either side
#: change by no more than this share of it.
JUMP_SHARE, CALM_SHARE = 0.2, 0.1


def with_base(cam_angles: Array, lifts: Array) -> tuple[Array, Array]:
    """A table (n,) with one more station of the base circle on either side (n + 2,)."""
    angles = np.concatenate([[2 * cam_angles[0] - cam_angles[1]], cam_angles, [2 * cam_angles[-1] - cam_angles[-2]]])
    return angles, np.concatenate([[0.0], lifts, [0.0]])


def second_differences(cam_angles: Array, lifts: Array) -> Array:
    """Divided second differences (m/rad2) of a table at its inner stations (n - 2,): means of the true second derivative over two steps,
    which never leave its range."""
    steps = np.diff(cam_angles)
    found: Array = 2 * np.diff(np.diff(lifts) / steps) / (steps[1:] + steps[:-1])
    return found


def has_jumps(cam_angles: Array, lifts: Array) -> bool:
    """Whether the acceleration of a table jumps: it changes much within three steps and hardly on either side of them."""
    bend = second_differences(*with_base(cam_angles, lifts))
    if len(bend) < 12:
        return False
    change, calm = np.abs(bend[3:] - bend[:-3]), np.abs(np.diff(bend))
    around = np.max([calm[start : start + len(change) - 4] for start in (0, 1, 5, 6)], axis=0)
    middle = change[2:-2]
    return bool(np.any((middle > JUMP_SHARE * np.ptp(bend)) & (around < CALM_SHARE * middle)))


def bounded_pieces(cam_angles: Array, lifts: Array) -> tuple[Array, Array]:
    """Breaks (n + 2,) and cubics (n + 1, 4; ascending powers) of straight accelerations through the second differences at the stations.

    Integrated twice from rest one station before the table to rest one station after it (Schoenberg's spline). The curve stands beside the
    table by a sixth of the acceleration times the step squared: 1.2 um at steps of one degree and 0.024 m/rad2.
    """
    angles, heights = with_base(cam_angles, lifts)
    bend, steps = np.concatenate([[0.0], second_differences(angles, heights), [0.0]]), np.diff(angles)
    # rest at the end, which steps of unequal length miss by little: the smallest change that meets it, in proportion to the acceleration
    left = angles[-1] - angles
    slope = (np.append(steps, 0.0) + np.append(0.0, steps)) / 2
    lift = np.append(steps * (left[:-1] / 2 - steps / 6), 0.0) + np.append(0.0, steps * (left[1:] / 2 + steps / 6))
    ends, share = np.stack([lift, slope]), np.abs(bend)
    bend = bend - share * (np.linalg.pinv(ends * share) @ (ends @ bend))
    velocity = np.append(0.0, np.cumsum(steps * (bend[1:] + bend[:-1]) / 2))
    height = np.append(0.0, np.cumsum(steps * velocity[:-1] + steps**2 * (bend[:-1] / 3 + bend[1:] / 6)))
    return angles, np.column_stack([height[:-1], velocity[:-1], bend[:-1] / 2, np.diff(bend) / steps / 6])
