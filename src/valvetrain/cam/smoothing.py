"""Calms a measured lift table: the spline of least jerk within a given distance of the table."""

from __future__ import annotations

from typing import Any

import numpy as np

from valvetrain.cam.contract import Array
from valvetrain.errors import InputError

#: Knots at first, and at last; where stations stand closer they share them, and only a deviation that cannot be met so asks for more.
FIRST_KNOTS, MOST_KNOTS = 400, 1600


def smoothed_spline(cam_angles: Array, lifts: Array, degree: int, deviation: float) -> Any:
    """B-spline (scipy) of least squared jerk at a root-mean-square distance ``deviation`` (m) from the table.

    Its lift and first (degree - 1) / 2 derivatives are zero at both ends. Penalised regression; the weight of the jerk
    is found by bisection. Raises :class:`InputError` when no curve between the table and a straight base circle is that far away, or none
    of :data:`MOST_KNOTS` knots that near.
    """
    most, nearest = FIRST_KNOTS, 0.0
    while most <= MOST_KNOTS:
        found, nearest = _with_knots(cam_angles, lifts, degree, deviation, most)
        if found is not None:
            return found
        most *= 2
    raise InputError(
        f"smoothing of {deviation * 1e3:g} mm is less than the {len(lifts)} stations scatter: {nearest * 1e3:.2g} mm about the nearest "
        "curve; give the noise of the table, or fewer stations"
    )


def _with_knots(cam_angles: Array, lifts: Array, degree: int, deviation: float, most: int) -> tuple[Any, float]:
    """The spline with at most so many knots, and 0; None and how near these come where that is not enough and there are more stations."""
    from scipy.interpolate import BSpline

    stations = len(cam_angles)
    angles = cam_angles if stations <= most else cam_angles[np.round(np.linspace(0, stations - 1, most)).astype(int)]
    knots = np.concatenate([np.full(degree, angles[0]), angles, np.full(degree, angles[-1])])
    held = (degree + 1) // 2
    count = len(knots) - degree - 1
    free = slice(held, count - held)
    design = BSpline.design_matrix(cam_angles, knots, degree).toarray()[:, free]
    nodes, weights = np.polynomial.legendre.leggauss(4)
    points = (angles[:-1, None] + np.diff(angles)[:, None] * (nodes + 1) / 2).ravel()
    scale = np.sqrt((np.diff(angles)[:, None] * weights / 2).ravel())
    jerk = BSpline(knots, np.eye(count), degree).derivative(3)(points)[:, free] * scale[:, None]
    normal, penalty, right = design.T @ design, jerk.T @ jerk, design.T @ lifts
    unit = np.trace(normal) / np.trace(penalty)

    def fit(weight: float) -> tuple[Array, float]:
        inner = np.linalg.lstsq(normal + weight * unit * penalty, right, rcond=None)[0]
        return inner, float(np.sqrt(np.mean((design @ inner - lifts) ** 2)))

    low, high = 1e-16, 1e8
    if fit(high)[1] < deviation:
        raise InputError(f"smoothing of {deviation * 1e3:g} mm would flatten the lift; give the noise of the table, such as 0.002 mm")
    if len(angles) < stations and (nearest := fit(low)[1]) > deviation:
        return None, nearest
    for _ in range(60):
        weight = np.sqrt(low * high)
        low, high = (weight, high) if fit(weight)[1] < deviation else (low, weight)
    coefficients = np.zeros(count)
    coefficients[free] = fit(low)[0]
    return BSpline(knots, coefficients, degree), 0.0
