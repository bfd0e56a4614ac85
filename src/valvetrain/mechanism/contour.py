"""Cam contours: support function for flat faces, pitch curve for arcs, as periodic tables over the
cam angle.

A convex cam is the envelope of its tangents, so a flat face feels the support function; an arc of
any radius feels the curve of its own centre (pitch curve). Both are smooth functions of one angle,
free of root finding and of the wrap of concave flanks.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from valvetrain.errors import InputError

Array = NDArray[np.float64]
NODES = 1440
"""Nodes per cam revolution of every table (a quarter of a cam degree); quintic interpolation between
them.
"""


class Lift(Protocol):
    """What is needed of a lift law."""

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        """Lift (m) or its derivative (m per rad**derivative) at cam angles (rad)."""


def lift_table(law: Lift, nodes: int = NODES) -> Array:
    """(nodes, 3) lift (m) and its first two derivatives (per rad) of a lift law."""
    angle = np.arange(nodes) * 2 * np.pi / nodes
    return np.column_stack(
        [np.asarray(law.lift(angle, derivative), dtype=float) for derivative in range(3)]
    )


def table_from_samples(chi: Array, value: Array, nodes: int = NODES) -> Array:
    """(nodes, 3) table of a periodic curve given at increasing angles ``chi`` (one full turn, last
    point left out).

    The second derivative is that of the samples, by divided differences: means of the true one over
    two steps, so that it stays within both sides of a jump, where a spline's would swing beyond
    them and make a cusp of a small radius.
    """
    from scipy.interpolate import CubicSpline

    if np.any(np.diff(chi) <= 0) or chi[-1] - chi[0] >= 2 * np.pi:
        raise InputError(
            "the cam contour folds back on itself; enlarge the base circle or flatten the lift law"
        )
    around, closed = np.append(chi, chi[0] + 2 * np.pi), np.append(value, value[0])
    spline = CubicSpline(around, closed, bc_type="periodic")
    steps = np.diff(around)
    bend = (
        2
        * (np.diff(closed) / steps - np.roll(np.diff(closed) / steps, 1))
        / (steps + np.roll(steps, 1))
    )
    inside = chi[0] + np.mod(np.arange(nodes) * 2 * np.pi / nodes - chi[0], 2 * np.pi)
    return np.column_stack(
        [spline(inside), spline(inside, 1), np.interp(inside, around, np.append(bend, bend[0]))]
    )


def monotone_table(cam_angles: Array, values: Array, nodes: int = NODES) -> Array:
    """(nodes, 3) table of a periodic curve through ``values`` at increasing ``cam_angles`` (rad,
    less than one turn) that never leaves the range of two neighbouring values.

    Monotone cubics (Fritsch and Carlson 1980). Their second derivative jumps at the given angles;
    what the table holds of it is the lesser of both sides, and nothing, with a limited slope,
    next to nodes between which the quintic would turn.
    """
    from scipy.interpolate import PchipInterpolator

    turn = 2 * np.pi
    curve = PchipInterpolator(
        np.concatenate([cam_angles - turn, cam_angles, cam_angles + turn]), np.tile(values, 3)
    )
    inside = cam_angles[0] + np.mod(np.arange(nodes) * turn / nodes - cam_angles[0], turn)
    step, value, slope = turn / nodes, curve(inside), curve(inside, 1)
    before, after = (curve(inside + side, 2) for side in (-1e-9, 1e-9))
    bend = np.where(
        before * after > 0, np.where(np.abs(before) < np.abs(after), before, after), 0.0
    )
    rise = np.roll(value, -1) - value
    same = rise * np.roll(rise, 1) > 0
    calm = np.where(
        same,
        np.sign(rise)
        * np.minimum(
            np.abs(slope) * step, 1.25 * np.minimum(np.abs(rise), np.abs(np.roll(rise, 1)))
        ),
        0.0,
    )
    limited = np.zeros(nodes, dtype=bool)
    while np.any(
        turning := _turns(value, slope * step, bend * step**2) & ~(limited & np.roll(limited, -1))
    ):
        limited |= turning | np.roll(turning, 1)
        slope, bend = np.where(limited, calm / step, slope), np.where(limited, 0.0, bend)
    return np.column_stack([value, slope, bend])


def _turns(value: Array, slope: Array, bend: Array) -> NDArray[np.bool_]:
    """Cells (nodes,) whose quintic may turn: its Bernstein control values do not rise or fall
    throughout (slope and bend per step).
    """
    right, steep, bent = (np.roll(item, -1) for item in (value, slope, bend))
    control = [
        value,
        value + slope / 5,
        value + 2 * slope / 5 + bend / 20,
        right - 2 * steep / 5 + bent / 20,
        right - steep / 5,
        right,
    ]
    steps = np.diff(control, axis=0) * np.sign(right - value)
    level = np.sum(np.abs(np.diff(control, axis=0)), axis=0) > 1e-12 * (1 + np.abs(value))
    found: NDArray[np.bool_] = np.where(right == value, level, np.any(steps < 0, axis=0))
    return found


def curvature_radius_flat(table: Array) -> Array:
    """Radius of curvature (m) of the cam under a flat face: h + h''."""
    return table[:, 0] + table[:, 2]


def curvature_radius_round(table: Array, follower_radius: float) -> Array:
    """Radius of curvature (m) of the cam under an arc of ``follower_radius``; negative on concave
    flanks, infinite where straight.
    """
    r, r1, r2 = table.T
    bend = r**2 + 2 * r1**2 - r * r2
    with np.errstate(divide="ignore"):
        pitch = (r**2 + r1**2) ** 1.5 / bend
    found: Array = pitch - follower_radius
    return found


def check_flat(table: Array) -> None:
    """Raise :class:`InputError` where a flat face would need a cam with a cusp."""
    radius = curvature_radius_flat(table)
    worst = int(np.argmin(radius))
    if radius[worst] <= 0:
        raise InputError(
            f"a flat follower needs a cam with a cusp near cam angle {worst * 360 / len(table):.1f} deg (radius "
            f"{radius[worst] * 1e3:.2f} mm); "
            "enlarge the base circle, soften the opening flank or use a roller"
        )


def check_round(table: Array, follower_radius: float) -> None:
    """Raise :class:`InputError` where an arc of this radius would need an undercut cam."""
    r, r1, r2 = table.T
    curvature = (r**2 + 2 * r1**2 - r * r2) / (r**2 + r1**2) ** 1.5
    worst = int(np.argmax(curvature))
    if curvature[worst] * follower_radius >= 1:
        raise InputError(
            f"a follower arc of {follower_radius * 1e3:g} mm needs an undercut cam near cam angle {worst * 360 / len(table):.1f} deg; "
            "enlarge the base circle or use a smaller radius"
        )
