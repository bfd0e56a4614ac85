"""Cam contours: support function for flat faces, pitch curve for arcs, as periodic tables over the
cam angle.

A convex cam is the envelope of its tangents, so a flat face feels the support function; an arc of
any radius feels the curve of its own centre (pitch curve). Both are smooth functions of one angle,
free of root finding and of the wrap of concave flanks.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array, Flags
from valvetrain.errors import InputError

NODES = 1440
"""Nodes per cam revolution of every table (a quarter of a cam degree); quintic interpolation between
them.
"""
CLOSE = 2 * np.pi / NODES / 50
"""Joints (rad) this close state a jump between them."""
SIDE = 1e-9
"""Angle (rad) next to a joint at which one side of a jump is taken, and within which it is on a node."""


class Lift(Protocol):
    """What is needed of a lift law; its ``joints`` and ``continuity`` are read where it has them."""

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        """Lift (m) or its derivative (m per rad**derivative) at cam angles (rad)."""


def lift_jumps(law: Lift) -> tuple[Array, Array, Array]:
    """Cam angles (rad), sizes (m/rad2) and widths (rad) of the jumps that a lift law states of its
    second derivative: at a joint, of no width, or between joints closer than :data:`CLOSE`.
    """
    joints = np.unique(np.mod(np.asarray(getattr(law, "joints", ()), dtype=float), 2 * np.pi))
    groups = np.split(joints, np.flatnonzero(np.diff(joints) > CLOSE) + 1) if len(joints) else []
    if len(groups) > 1 and joints[0] + 2 * np.pi - joints[-1] <= CLOSE:
        groups = [np.append(groups[-1] - 2 * np.pi, groups[0]), *groups[1:-1]]
    smooth = getattr(law, "continuity", 2) >= 2
    ends = [(group[0], group[-1]) for group in groups if len(group) > 1 or not smooth]
    if not ends:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    first, last = np.array(ends).T
    before, after = (
        np.asarray(law.lift(angle, 2), dtype=float) for angle in (first - SIDE, last + SIDE)
    )
    largest = np.max(np.abs(np.append(before, after)))
    # over a width the second derivative may change much without a jump
    real = np.abs(after - before) > np.where(last > first, 1e-2, 1e-6) * largest
    return ((first + last) / 2)[real], (after - before)[real], (last - first)[real]


def lift_table(law: Lift, nodes: int = NODES) -> Array:
    """(nodes, 3) lift (m) and its first two derivatives (per rad) of a lift law; (nodes, 5) of one
    that jumps, see :func:`with_jumps`.
    """
    angle, (jumps, sizes, widths) = np.arange(nodes) * 2 * np.pi / nodes, lift_jumps(law)
    table = np.column_stack(
        [np.asarray(law.lift(angle, derivative), dtype=float) for derivative in range(3)]
    )
    if not len(jumps):
        return table
    nearest = np.rint(jumps * nodes / (2 * np.pi))
    on = np.abs(jumps - nearest * 2 * np.pi / nodes) <= widths / 2 + SIDE
    jumps = np.where(on, nearest * 2 * np.pi / nodes, jumps)
    table[nearest[on].astype(int) % nodes, 2] = law.lift((jumps + widths + 2 * SIDE)[on], 2)
    return with_jumps(table, jumps, sizes)


def with_jumps(table: Array, jumps: Array, sizes: Array) -> Array:
    """(nodes, 5) of a table (nodes, 3): the share of the cell after each node at which its second
    derivative jumps, and by how much; of two jumps in one cell the larger.

    ``jumps`` (rad); one on a node ends the cell before it (share 1), and the node holds the second
    derivative after it.
    """
    place = np.mod(jumps, 2 * np.pi) * len(table) / (2 * np.pi)
    cell = np.ceil(place - 1e-6).astype(int) - 1
    found = np.tile([1.0, 0.0], (len(table), 1))
    for n in np.argsort(np.abs(sizes)):
        found[cell[n] % len(table)] = min(place[n] - cell[n], 1.0), sizes[n]
    return np.column_stack([table, found])


def table_from_samples(
    chi: Array, value: Array, nodes: int = NODES, jumps: Sequence[int] = ()
) -> Array:
    """(nodes, 3) table of a periodic curve given at increasing angles ``chi`` (one full turn, last
    point left out).

    The second derivative is that of the samples, by divided differences: means of the true one over
    two steps, so that it stays within both sides of a jump, where a spline's would swing beyond
    them and make a cusp of a small radius. ``jumps``: indices of samples at which the second
    derivative is known to jump; the table is then that of :func:`with_jumps`.
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
    table = np.column_stack(
        [spline(inside), spline(inside, 1), np.interp(inside, around, np.append(bend, bend[0]))]
    )
    if not len(jumps):
        return table
    ends = np.zeros((len(jumps), 2))
    for n, (start, stop) in enumerate(pairwise([*jumps, jumps[0] + len(chi)])):
        index, turns = np.arange(start, stop + 1) % len(chi), np.arange(start, stop + 1) // len(chi)
        x = chi[index] + 2 * np.pi * turns
        spline = CubicSpline(x, value[index])
        ends[n] = spline(x[[0, -1]], 2)
        node = x[0] - 1e-9 + np.mod(np.arange(nodes) * 2 * np.pi / nodes - x[0] + 1e-9, 2 * np.pi)
        mine = node < x[-1] - 1e-9
        node = node[mine]
        table[mine] = np.column_stack([spline(node, order) for order in range(3)])
    return with_jumps(table, chi[list(jumps)], ends[:, 0] - np.roll(ends[:, 1], 1))


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


def _turns(value: Array, slope: Array, bend: Array) -> Flags:
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
    found: Flags = np.where(right == value, level, np.any(steps < 0, axis=0))
    return found


def curvature_radius_flat(table: Array) -> Array:
    """Radius of curvature (m) of the cam under a flat face: h + h''."""
    return table[:, 0] + table[:, 2]


def curvature_radius_round(table: Array, follower_radius: float) -> Array:
    """Radius of curvature (m) of the cam under an arc of ``follower_radius``; negative on concave
    flanks, infinite where straight.
    """
    r, r1, r2 = table[:, :3].T
    bend = r**2 + 2 * r1**2 - r * r2
    with np.errstate(divide="ignore"):
        pitch = (r**2 + r1**2) ** 1.5 / bend
    found: Array = pitch - follower_radius
    return found


#: Largest lift over the base radius above which a lift is a slip of its unit rather than a steep cam.
UNUSUAL_LIFT = 1.5


def _unusual_lift(table: Array) -> str:
    """A clause where a face is lifted by more than the base circle lets any cam do."""
    base, lift = float(np.min(table[:, 0])), float(np.ptp(table[:, 0]))
    if lift <= UNUSUAL_LIFT * base:
        return ""
    return (
        f"; a lift of {lift * 1e3:.4g} mm is unusually large for a base circle of {base * 1e3:.4g} mm radius: "
        "is the unit right?"
    )


def check_flat(table: Array) -> None:
    """Raise :class:`InputError` where a flat face would need a cam with a cusp."""
    radius = curvature_radius_flat(table)
    worst = int(np.argmin(radius))
    if radius[worst] <= 0:
        least = float(np.min(table[:, 0]) - radius[worst])
        raise InputError(
            f"a flat follower needs a cam with a cusp near cam angle {worst * 360 / len(table):.1f} deg (radius "
            f"{radius[worst] * 1e3:.2f} mm); set train.cam.base_radius above {least * 1e3:.1f} mm, "
            f"soften that flank or use a roller{_unusual_lift(table)}"
        )


def check_round(table: Array, follower_radius: float) -> None:
    """Raise :class:`InputError` where an arc of this radius would need an undercut cam."""
    r, r1, r2 = table[:, :3].T
    curvature = (r**2 + 2 * r1**2 - r * r2) / (r**2 + r1**2) ** 1.5
    worst = int(np.argmax(curvature))
    if curvature[worst] * follower_radius >= 1:
        raise InputError(
            f"a follower arc of {follower_radius * 1e3:g} mm needs an undercut cam near cam angle {worst * 360 / len(table):.1f} deg; "
            "enlarge the base circle or use a smaller radius"
        )
