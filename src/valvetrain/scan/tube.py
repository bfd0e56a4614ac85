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
from numpy.typing import NDArray

from valvetrain.errors import InputError

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
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
#: Entries a turn of the table from point to nearest coil.
TABLE = 256


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

    def design(self, turn: Array, derivative: int = 0) -> Array:
        """Values (n, coefficients) of the splines or of a derivative; beyond the knots the last
        piece continues.
        """
        return _design(self.knots, np.asarray(turn, dtype=float), derivative)

    def line(self, turn: Array, derivative: int = 0) -> tuple[Array, Array]:
        """Radius and height (n,) of the wire axis or their derivatives by the turn."""
        from scipy.interpolate import BSpline

        both: Any = BSpline(self.knots, np.column_stack([self.radius, self.height]), DEGREE)
        found: Array = both(
            np.clip(turn, self.knots[DEGREE], self.knots[-DEGREE - 1]), nu=derivative
        )
        return found[..., 0], found[..., 1]

    def spreads(self, turn: Array, derivative: int = 0) -> tuple[Array, Array]:
        """Standard deviations (n,) of radius and height or their derivatives."""
        basis, count = self.design(turn, derivative), len(self.radius)
        both = (self.cov[:count, :count], self.cov[count : 2 * count, count : 2 * count])
        found = [
            np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", basis, block, basis), 0.0))
            for block in both
        ]
        return found[0], found[1]


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
    turn: Array,
    radius: Array,
    height: Array,
    hand: int,
    wire: float,
    reach: tuple[float, float],
    per_turn: int,
) -> Tube:
    """A first tube through sections, on knots over ``reach`` with ``per_turn`` pieces a turn."""
    pieces = int(np.ceil((reach[1] - reach[0]) * per_turn))
    inner = np.linspace(reach[0], reach[1], pieces + 1)
    step = inner[1] - inner[0]
    knots = np.concatenate(
        [
            inner[0] - step * np.arange(DEGREE, 0, -1),
            inner,
            inner[-1] + step * np.arange(1, DEGREE + 1),
        ]
    )
    basis, penalty = _design(knots, turn), roughness(knots)
    inverse = np.linalg.inv(
        basis.T @ basis + 1e-3 * per_turn**-3 * penalty + 1e-10 * np.eye(len(penalty))
    )
    size = 2 * len(penalty) + 3
    return Tube(
        knots,
        inverse @ (basis.T @ radius),
        inverse @ (basis.T @ height),
        np.array([wire, 0.0, 0.0]),
        np.zeros((size, size)),
        0.1 * wire,
        hand,
    )


def roughness(knots: Array) -> Array:
    """Integral of the products of second derivatives, (coefficients, coefficients)."""
    inner = knots[DEGREE:-DEGREE]
    nodes, weights = np.polynomial.legendre.leggauss(3)
    places = ((inner[:-1] + inner[1:])[:, None] / 2 + np.diff(inner)[:, None] * nodes / 2).ravel()
    scale = (np.diff(inner)[:, None] * weights / 2).ravel()
    basis = _design(knots, places, 2)
    found: Array = basis.T @ (scale[:, None] * basis)
    return found


class _Table:
    """Radius and height of the wire axis at :data:`TABLE` places a turn."""

    def __init__(self, tube: Tube, first: int, last: int, reach: tuple[float, float]) -> None:
        self.first = first
        turn = np.linspace(first, last + 1, TABLE * (last + 1 - first) + 1)
        self.radius, self.height = tube.line(np.clip(turn, *reach))

    def at(self, turn: Array) -> tuple[Array, Array]:
        """Radius and height (n,), straight between the entries."""
        exact = np.clip((turn - self.first) * TABLE, 0.0, len(self.radius) - 1.001)
        below = exact.astype(int)
        share = exact - below
        found = [
            values[below] + share * (values[below + 1] - values[below])
            for values in (self.radius, self.height)
        ]
        return found[0], found[1]


def place(tube: Tube, points: Array, reach: tuple[float, float]) -> OnWire:
    """Points (n, 3) of the frame on the coil of the tube whose surface is nearest, within ``reach``
    of its turns.
    """
    own = np.mod(tube.hand * np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi), 1.0)
    first, last = int(np.floor(reach[0])), int(np.ceil(reach[1]))
    table = _Table(tube, first, last, reach)
    nearest = np.minimum(np.round(own * TABLE).astype(int), TABLE)
    across, up = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
    best, found = np.full(len(own), np.inf), np.zeros(len(own))
    for whole in range(first, last + 1):
        turn, row = own + whole, nearest + (whole - first) * TABLE
        apart = np.hypot(across - table.radius[row], up - table.height[row])
        left = np.where(
            (turn >= reach[0]) & (turn <= reach[1]), np.abs(apart - tube.section[0]), np.inf
        )
        better = left < best
        best[better], found[better] = left[better], turn[better]
    return _foot(tube, points, found, reach, table)


def _foot(
    tube: Tube, points: Array, turn: Array, reach: tuple[float, float], table: _Table
) -> OnWire:
    """Feet of the perpendiculars on the wire axis, and their positions along it."""
    for _ in range(2):
        centre, tangent, _, _ = _axis_at(tube, turn)
        speed = np.linalg.norm(tangent, axis=1)
        turn = np.clip(
            turn + np.clip(np.sum((points - centre) * tangent, axis=1) / speed**2, -0.1, 0.1),
            *reach,
        )
    centre, tangent, outward, _ = _axis_at(tube, turn)
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
    foot = centre + normal * edge[:, None]
    # noise across the normal adds its square over twice the radius to the mean distance
    return OnWire(
        turn,
        distance,
        around,
        distance - edge - tube.noise**2 / (2 * edge),
        _next_coil(tube, foot, turn, reach, table),
        np.sum(normal * outward, axis=1),
        normal[:, 2],
    )


def _axis_at(tube: Tube, turn: Array) -> tuple[Array, Array, Array, Array]:
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
    return centre, tangent, outward, height


def _next_coil(
    tube: Tube, foot: Array, turn: Array, reach: tuple[float, float], table: _Table
) -> Array:
    """Distance from points of the surface to the surface of the coils one turn above and below, in
    the half plane.
    """
    across, up = np.hypot(foot[:, 0], foot[:, 1]), foot[:, 2]
    gap = np.full(len(turn), np.inf)
    for away in (-1.0, 1.0):
        other = turn + away
        radius, height = table.at(other)
        apart = np.hypot(across - radius, up - height) - tube.section[0]
        gap = np.minimum(
            gap, np.where((other >= reach[0]) & (other <= reach[1]), np.abs(apart), np.inf)
        )
    return gap


def section_radius(section: Array, around: Array) -> Array:
    """Radius (n,) of an ellipse in directions ``around``; ``section``: mean of its half axes and
    the ellipticity along and across.
    """
    mean, along, across = section
    square = along**2 + across**2
    bulge = 2 * (along * np.cos(2 * around) + across * np.sin(2 * around))
    found: Array = mean * (1 - square) / np.sqrt(1 + square - bulge)
    return found


def fit_tube(
    tube: Tube,
    points: Array,
    reach: tuple[float, float],
    ovate: bool,
    flats: Any = None,
    rounds: int = ROUNDS,
) -> tuple[Tube, OnWire, Array]:
    """The tube through the surface points, their positions on it and their weights (n,).

    ``flats``: function of the points that is true for those of ground faces, which are no surface
    of the tube. Raises :class:`InputError` where fewer than :data:`FEWEST` points are on it.
    """
    skip = np.zeros(len(points), dtype=bool) if flats is None else flats(points)
    rough, size = [np.array([1e-4, 1e-4]), len(tube.radius)]
    penalty = roughness(tube.knots)
    rank = size - 2
    for turn in range(rounds):
        on = place(tube, points, reach)
        scale = _scale(on, skip, tube, first=turn == 0)
        weight = np.where(
            skip | (on.gap < TOUCHING * scale),
            0.0,
            np.clip(1 - (on.left / (TUKEY * scale)) ** 2, 0.0, None) ** 2,
        )
        if np.count_nonzero(weight) < FEWEST:
            raise InputError(
                "the points are not on the surface of one wire; give the scan of one spring, cleaned of its holder"
            )
        matrix, side = _normal_equations(tube, on, weight, ovate)
        matrix, side = matrix / scale**2, side / scale**2
        prior = np.zeros_like(matrix)
        prior[:size, :size], prior[size : 2 * size, size : 2 * size] = (
            penalty / rough[0],
            penalty / rough[1],
        )
        inner = matrix + prior + 1e-9 * np.diag(np.maximum(np.diag(matrix + prior), 1e-12))
        if not ovate:
            inner[2 * size + 1 :, :] = 0.0
            inner[:, 2 * size + 1 :] = 0.0
            inner[range(2 * size + 1, 2 * size + 3), range(2 * size + 1, 2 * size + 3)] = 1.0
        cov: Array = np.asarray(np.linalg.inv(inner))
        values = np.concatenate([tube.radius, tube.height, tube.section])
        step = cov @ (side - prior @ values)
        values = values + step
        if not ovate:
            cov[2 * size + 1 :, 2 * size + 1 :] = 0.0
        rough = _rougher(rough, values, cov, penalty, rank, size)
        moved = _design(tube.knots, np.linspace(*reach, 200)) @ step[: 2 * size].reshape(2, size).T
        tube = Tube(
            tube.knots,
            values[:size],
            values[size : 2 * size],
            values[2 * size :],
            cov,
            scale,
            tube.hand,
        )
        if turn > 2 and float(np.sqrt(np.mean(moved**2))) < SETTLED * scale:
            break
    return tube, on, weight


def _scale(on: OnWire, skip: Mask, tube: Tube, first: bool) -> float:
    """Scatter of the points that can belong to the surface, by the median of their distances from
    it.
    """
    wire = float(tube.section[0])
    near = (
        (np.abs(on.left) < min(0.35 * wire, np.inf if first else 6 * tube.noise))
        & (on.gap > 0.1 * wire)
        & ~skip
    )
    if np.count_nonzero(near) < FEWEST:
        return tube.noise
    found = 1.4826 * float(np.median(np.abs(on.left[near])))
    # coming from a rough start the scale falls step by step, so that no point is given up too early
    return max(found, 1e-6 * wire) if first else max(found, 0.4 * tube.noise, 1e-6 * wire)


def _normal_equations(tube: Tube, on: OnWire, weight: Array, ovate: bool) -> tuple[Array, Array]:
    from scipy.sparse import csr_array, hstack

    keep = weight > 0
    basis = _sparse_design(tube.knots, on.turn[keep])
    edge = section_radius(tube.section, on.around[keep])
    across = np.column_stack(
        [
            edge / tube.section[0],
            edge * np.cos(2 * on.around[keep]),
            edge * np.sin(2 * on.around[keep]),
        ]
    )
    if not ovate:
        across[:, 1:] = 0.0
    # distance less section: falls as the axis comes nearer along the normal
    model = hstack(
        [
            basis.multiply(on.outward[keep][:, None]),
            basis.multiply(on.upward[keep][:, None]),
            csr_array(across),
        ],
        format="csr",
    )
    heavy = model.multiply(weight[keep][:, None]).tocsr()
    return (heavy.T @ model).toarray(), np.asarray(heavy.T @ on.left[keep]).ravel()


def _rougher(
    rough: Array, values: Array, cov: Array, penalty: Array, rank: int, size: int
) -> Array:
    """Variance of the random walk of each curve by the update of Fellner and Schall."""
    after = rough.copy()
    for place_, first in enumerate((0, size)):
        own, block = values[first : first + size], cov[first : first + size, first : first + size]
        known = max(rank - float(np.sum(block * penalty)) / rough[place_], 0.5)
        after[place_] = np.clip(float(own @ penalty @ own) / known, 1e-16, 1e6)
    return after


def _design(knots: Array, turn: Array, derivative: int = 0) -> Array:
    from scipy.interpolate import BSpline

    basis: Any = BSpline(knots, np.eye(len(knots) - DEGREE - 1), DEGREE)
    found: Array = basis(np.clip(turn, knots[DEGREE], knots[-DEGREE - 1]), nu=derivative)
    return found


def _sparse_design(knots: Array, turn: Array) -> Any:
    from scipy.interpolate import BSpline

    return BSpline.design_matrix(np.clip(turn, knots[DEGREE], knots[-DEGREE - 1]), knots, DEGREE)
