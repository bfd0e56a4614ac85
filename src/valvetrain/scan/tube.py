"""Centre line and section of the wire, fitted to the points as the surface of a tube: robust
Gauss-Newton on penalised splines.

Radius and height of the wire axis over the unwound angle are cubic splines whose second derivatives
are drawn from a random walk; the
data choose how rough each may be (marginal likelihood by the update of Fellner and Schall). The
posterior gives the scatter.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from valvetrain.arrays import Array, Flags
from valvetrain.errors import InputError

DEGREE = 3
#: Tukey's constant: points farther off than this many standard deviations do not count.
TUKEY = 4.685
#: A point does not count where the next coil is nearer to the surface of the wire than this many
#: standard deviations.
TOUCHING = 5.0
#: Rounds of the fit, and movement of the wire axis, in standard deviations of a point, at which it
#: has settled.
ROUNDS, SETTLED = 40, 5e-3
#: Fewest points that a wire is fitted to.
FEWEST = 50
#: Stations a turn from which the nearest place on the wire is looked for, and spline pieces a turn.
TABLE, PER_TURN = 256, 12


@dataclass(frozen=True, eq=False)
class Tube:
    """A wire: splines of radius and height over the turn, section and scatter.

    ``knots``: of the splines over the unwound turn; ``radius``, ``height``: coefficients;
    ``section``: mean radius of the wire, and its
    ellipticity along and across the radius (share); ``cov``: covariance of all of them; ``noise``:
    standard deviation of a point.
    """

    knots: Array
    radius: Array
    height: Array
    section: Array
    cov: Array
    noise: float
    hand: int

    def line(self, turn: Array, derivative: int = 0) -> tuple[Array, Array]:
        """Radius and height (n,) of the wire axis or their derivatives by the turn."""
        curves = _spline(self.knots, np.stack([self.radius, self.height], 1), turn, derivative)
        radius, height = np.moveaxis(curves, -1, 0)
        return radius, height

    def spreads(self, turn: Array, derivative: int = 0) -> tuple[Array, Array]:
        """Standard deviations (n,) of radius and height or their derivatives."""
        count = len(self.radius)
        basis = _spline(self.knots, np.eye(count), turn, derivative)
        radius, height = (
            np.sqrt(np.maximum(np.sum(basis @ self.cov[part, part] * basis, axis=1), 0.0))
            for part in (slice(count), slice(count, 2 * count))
        )
        return radius, height


def _spline(knots: Array, shares: Array, turn: Array, derivative: int = 0) -> Array:
    """Values (n, curves) of splines or of a derivative; beyond the knots the end of the last piece holds."""
    from scipy.interpolate import BSpline

    curves: Any = BSpline(knots, shares, DEGREE)
    return np.asarray(curves(np.clip(turn, knots[DEGREE], knots[-DEGREE - 1]), nu=derivative))


@dataclass(frozen=True, eq=False)
class OnWire:
    """Positions of points on a tube: ``turn``, ``distance`` from the wire axis, ``around`` the section
    (0: outside), all (n,).

    ``left``: distance less the radius of the section there; ``gap``: from the surface there to the
    next coil's.
    """

    turn: Array
    distance: Array
    around: Array
    left: Array
    gap: Array
    outward: Array
    upward: Array


def start_tube(
    turn: Array, radius: Array, height: Array, hand: int, wire: float, reach: tuple[float, float]
) -> Tube:
    """A first tube through sections, on knots over ``reach`` with :data:`PER_TURN` pieces a turn."""
    pieces = int(np.ceil((reach[1] - reach[0]) * PER_TURN))
    step = (reach[1] - reach[0]) / pieces
    knots: Array = np.asarray(reach[0] + step * np.arange(-DEGREE, pieces + DEGREE + 1.0))
    count = len(knots) - DEGREE - 1
    basis = _spline(knots, np.eye(count), turn)
    matrix = basis.T @ basis + 1e-3 * PER_TURN**-3 * roughness(knots) + 1e-10 * np.eye(count)
    shares = np.linalg.solve(matrix, basis.T @ np.column_stack([radius, height])).astype(float)
    cov = np.zeros((2 * count + 3, 2 * count + 3))
    section = np.array([wire, 0.0, 0.0])
    return Tube(knots, shares[:, 0], shares[:, 1], section, cov, 0.1 * wire, hand)


def roughness(knots: Array) -> Array:
    """Integral of the products of second derivatives, (coefficients, coefficients)."""
    inner = knots[DEGREE:-DEGREE]
    nodes, weights = np.polynomial.legendre.leggauss(2)
    places = (inner[:-1] + inner[1:])[:, None] / 2 + np.diff(inner)[:, None] * nodes / 2
    scale = np.diff(inner)[:, None] * weights / 2
    basis = _spline(knots, np.eye(len(knots) - DEGREE - 1), places.ravel(), 2)
    return np.asarray(basis.T @ (scale.ravel()[:, None] * basis))


def place(tube: Tube, points: Array, reach: tuple[float, float]) -> OnWire:
    """Points (n, 3) of the frame on the coil of the tube whose axis is nearest, within ``reach`` of
    its turns: feet of the perpendiculars on the wire axis, and their positions along it.
    """
    from scipy.spatial import KDTree

    turns = np.linspace(*reach, int(np.ceil(TABLE * (reach[1] - reach[0]))) + 1)
    turn = turns[KDTree(_axis_at(tube, turns)[0]).query(points)[1]]
    for _ in range(2):
        centre, tangent, _ = _axis_at(tube, turn)
        step = np.sum((points - centre) * tangent, axis=1) / np.sum(tangent**2, axis=1)
        turn = np.clip(turn + np.clip(step, -0.1, 0.1), *reach)
    centre, tangent, outward = _axis_at(tube, turn)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    away = points - centre
    away -= np.sum(away * tangent, axis=1, keepdims=True) * tangent
    distance = np.linalg.norm(away, axis=1) + 1e-15
    normal = away / distance[:, None]
    first = outward - np.sum(outward * tangent, axis=1, keepdims=True) * tangent
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    upward = np.cross(first, tangent) * tube.hand
    around = np.arctan2(np.sum(away * upward, axis=1), np.sum(away * first, axis=1))
    edge = section_radius(tube.section, around)
    # From the surface to that of the coils one turn above and below, in the half plane.
    x, y, up = (centre + normal * edge[:, None]).T
    table, gap = tube.line(turns), np.full(len(turn), np.inf)
    for other in (turn - 1.0, turn + 1.0):
        radius, height = (np.interp(other, turns, curve, np.inf, np.inf) for curve in table)
        apart = np.hypot(np.hypot(x, y) - radius, up - height) - tube.section[0]
        gap = np.minimum(gap, np.abs(apart))
    # noise across the normal adds its square over twice the radius to the mean distance
    left = distance - edge - tube.noise**2 / (2 * edge)
    facing = np.sum(normal * outward, axis=1)
    return OnWire(turn, distance, around, left, gap, facing, normal[:, 2])


def _axis_at(tube: Tube, turn: Array) -> tuple[Array, Array, Array]:
    """Wire axis (n, 3), its derivative by the turn, and the outward direction there."""
    (radius, height), (growth, rise) = tube.line(turn), tube.line(turn, 1)
    angle = 2 * np.pi * tube.hand * turn
    cosine, sine = np.cos(angle), np.sin(angle)
    outward = np.column_stack([cosine, sine, np.zeros_like(cosine)])
    along = 2 * np.pi * tube.hand * np.column_stack([-sine, cosine, np.zeros_like(cosine)])
    centre = radius[:, None] * outward
    centre[:, 2] = height
    tangent = growth[:, None] * outward + radius[:, None] * along
    tangent[:, 2] = rise
    return centre, tangent, outward


def section_radius(section: Array, around: Array) -> Array:
    """Radius (n,) of an ellipse in directions ``around``; ``section``: mean of its half axes and
    the ellipticity along and across.
    """
    mean, along, across = section
    square = along**2 + across**2
    bulge = 2 * (along * np.cos(2 * around) + across * np.sin(2 * around))
    return np.asarray(mean * (1 - square) / np.sqrt(1 + square - bulge))


def fit_tube(
    tube: Tube,
    points: Array,
    reach: tuple[float, float],
    flat: Flags | None = None,
    ovate: bool = False,
    rounds: int = ROUNDS,
) -> tuple[Tube, OnWire, Array]:
    """The tube through the surface points, their positions on it and their weights (n,).

    ``flat`` (n,): points of ground faces, which are no surface of the tube. Raises
    :class:`InputError` where fewer than :data:`FEWEST` points are on it.
    """
    from scipy.interpolate import BSpline
    from scipy.sparse import csr_array, hstack

    skip = np.zeros(len(points), dtype=bool) if flat is None else flat
    size, knots = len(tube.radius), tube.knots
    curves, free = (slice(size), slice(size, 2 * size)), 2 * size + (3 if ovate else 1)
    rough, penalty = [1e-4, 1e-4], roughness(knots)
    inner = knots[DEGREE], knots[-DEGREE - 1]
    for turn in range(rounds):
        on = place(tube, points, reach)
        wire = float(tube.section[0])
        # Coming from a rough start the scale falls step by step, so that no point is given up too early.
        least = 1e-6 * wire if turn == 0 else max(0.4 * tube.noise, 1e-6 * wire)
        far = min(0.35 * wire, np.inf if turn == 0 else 6 * tube.noise)
        left = np.abs(on.left)
        near = left[(left < far) & (on.gap > 0.1 * wire) & ~skip]
        scale = tube.noise if len(near) < FEWEST else max(1.4826 * float(np.median(near)), least)
        weight = np.clip(1 - (left / (TUKEY * scale)) ** 2, 0.0, None) ** 2
        weight[skip | (on.gap < TOUCHING * scale)] = 0.0
        keep = np.flatnonzero(weight)
        if len(keep) < FEWEST:
            raise InputError(
                "the points are not on the surface of one wire; give the scan of one spring, cleaned of its holder"
            )
        # distance less section: falls as the axis comes nearer along the normal
        basis = BSpline.design_matrix(np.clip(on.turn[keep], *inner), knots, DEGREE)
        around = on.around[keep]
        edge = section_radius(tube.section, around)[:, None]
        bulge = np.column_stack([0 * around + 1 / wire, np.cos(2 * around), np.sin(2 * around)])
        outward, upward = on.outward[keep][:, None], on.upward[keep][:, None]
        columns = [basis.multiply(outward), basis.multiply(upward), csr_array(edge * bulge)]
        model = hstack(columns, format="csr")[:, :free]
        heavy = model.multiply(weight[keep][:, None] / scale**2).tocsr()
        prior = np.zeros((free, free))
        for curve, variance in zip(curves, rough, strict=True):
            prior[curve, curve] = penalty / variance
        matrix = (heavy.T @ model).toarray() + prior
        matrix += 1e-9 * np.diag(np.maximum(np.diag(matrix), 1e-12))
        cov = np.linalg.inv(matrix)
        values = np.concatenate([tube.radius, tube.height, tube.section])
        step = cov @ (heavy.T @ on.left[keep] - prior @ values[:free])
        values[:free] += step
        # Variance of the random walk of each curve by the update of Fellner and Schall.
        for index, curve in enumerate(curves):
            numbers = size - 2 - float(np.sum(cov[curve, curve] * penalty)) / rough[index]
            bent = float(values[curve] @ penalty @ values[curve])
            rough[index] = float(np.clip(bent / max(numbers, 0.5), 1e-16, 1e6))
        moved = _spline(knots, step[: 2 * size].reshape(2, size).T, np.linspace(*reach, 200))
        cov = np.pad(cov, (0, 2 * size + 3 - free))
        radius, height, section = np.split(values, (size, 2 * size))
        tube = Tube(knots, radius, height, section, cov, scale, tube.hand)
        if turn > 2 and float(np.sqrt(np.mean(moved**2))) < SETTLED * scale:
            break
    return tube, on, weight
