"""Cam contours: support function for flat faces, pitch curve for arcs, as periodic tables over the cam angle.

A convex cam is the envelope of its tangents, so a flat face feels the support function; an arc of any radius feels the curve of its
own centre (pitch curve). Both are smooth functions of one angle, free of root finding and of the wrap of concave flanks.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from valvetrain.errors import InputError

Array = NDArray[np.float64]
NODES = 1440
"""Nodes per cam turn of every table (a quarter of a cam degree); quintic interpolation between them."""


class Lift(Protocol):
    """What is needed of a lift law."""

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        """Lift (m) or its derivative (m per rad**derivative) at cam angles (rad)."""


def lift_table(law: Lift, nodes: int = NODES) -> Array:
    """(nodes, 3) lift (m) and its first two derivatives (per rad) of a lift law."""
    angle = np.arange(nodes) * 2 * np.pi / nodes
    return np.column_stack([np.asarray(law.lift(angle, derivative), dtype=float) for derivative in range(3)])


def table_from_samples(chi: Array, value: Array, nodes: int = NODES) -> Array:
    """(nodes, 3) table of a periodic curve given at increasing angles ``chi`` (one full turn, last point left out)."""
    from scipy.interpolate import CubicSpline

    if np.any(np.diff(chi) <= 0) or chi[-1] - chi[0] >= 2 * np.pi:
        raise InputError("the cam contour folds back on itself; enlarge the base circle or flatten the lift law")
    spline = CubicSpline(np.append(chi, chi[0] + 2 * np.pi), np.append(value, value[0]), bc_type="periodic")
    angle = np.arange(nodes) * 2 * np.pi / nodes
    inside = chi[0] + np.mod(angle - chi[0], 2 * np.pi)
    return np.column_stack([spline(inside, derivative) for derivative in range(3)])


def curvature_radius_flat(table: Array) -> Array:
    """Radius of curvature (m) of the cam under a flat face: h + h''."""
    return table[:, 0] + table[:, 2]


def curvature_radius_round(table: Array, follower_radius: float) -> Array:
    """Radius of curvature (m) of the cam under an arc of ``follower_radius``; negative on concave flanks, infinite where straight."""
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
