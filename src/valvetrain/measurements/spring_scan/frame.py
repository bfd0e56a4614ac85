"""The axis of a scanned spring, and its points about that axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: Points that look for the axis, directions that are tried, and those that are followed up.
LOOKED_AT, DIRECTIONS, FOLLOWED = 3000, 120, 5
#: Highest power of the height by which the mean radius may change along the axis.
POWER = 4


@dataclass(frozen=True, eq=False)
class Frame:
    """Axis through ``origin`` (3,) with the rows of ``base`` (3, 3): two directions across, then the axis."""

    origin: Array
    base: Array

    def inside(self, points: Array) -> Array:
        """Points (n, 3) in this frame: across, across, along."""
        found: Array = (points - self.origin) @ self.base.T
        return found

    def outside(self, points: Array) -> Array:
        """Points (n, 3) of this frame where the scan has them."""
        found: Array = points @ self.base + self.origin
        return found

    def moved(self, across: Array, tilt: Array) -> Frame:
        """The frame whose axis passes ``across`` (2,) at height zero and leans by ``tilt`` (2,) per height, both in this frame."""
        axis = np.array([tilt[0], tilt[1], 1.0])
        return Frame(self.outside(np.array([[across[0], across[1], 0.0]]))[0], across_and_along(axis @ self.base, self.base[0]))

    def turned_over(self) -> Frame:
        """The same axis, looked along the other way."""
        return Frame(self.origin, self.base * np.array([[1.0], [-1.0], [-1.0]]))


def across_and_along(direction: Array, near: Array | None = None) -> Array:
    """Right-handed base (3, 3) whose last row is ``direction``, its first row close to ``near``."""
    along = direction / np.linalg.norm(direction)
    first = np.eye(3)[int(np.argmin(np.abs(along)))] if near is None else near
    first = first - (first @ along) * along
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(along, first), along])


def find_axis(points: Array) -> Frame:
    """The axis about which the radii of the points (n, 3), a smooth function of the height, scatter least; points in any order of draw."""
    some = points[:LOOKED_AT]
    middle = np.median(some, axis=0)
    size = float(np.median(np.linalg.norm(some - middle, axis=1))) or 1.0
    near = some[np.linalg.norm(some - middle, axis=1) < 5 * size]
    _, _, principal = np.linalg.svd(near - near.mean(axis=0), full_matrices=False)
    starts = [Frame(middle, across_and_along(one)) for one in (*principal, *_hemisphere(DIRECTIONS))]
    coarse = near[::4]
    first = sorted(((_scatter(coarse, frame, size), place) for place, frame in enumerate(starts)), key=lambda pair: pair)
    best = [_settled(near, starts[place], size) for _, place in first[:FOLLOWED]]
    return min(best, key=lambda pair: pair[0])[1]


def _hemisphere(count: int) -> Array:
    height = (np.arange(count) + 0.5) / count
    turn = np.pi * (1 + 5**0.5) * np.arange(count)
    ring = np.sqrt(1 - height**2)
    return np.column_stack([ring * np.cos(turn), ring * np.sin(turn), height])


def _scatter(points: Array, frame: Frame, size: float) -> float:
    return _step(points, _step(points, frame, size)[1], size)[0]


def _settled(points: Array, frame: Frame, size: float) -> tuple[float, Frame]:
    best = np.inf, frame
    for _ in range(12):
        scatter, after = _step(points, frame, size)
        best = min(best, (scatter, frame), key=lambda pair: pair[0])
        frame = after
    return best


def _least_squares(basis: Array, values: Array, weight: Array) -> Array:
    heavy = basis * weight[:, None]
    matrix = heavy.T @ basis
    found: Array = np.asarray(np.linalg.solve(matrix + 1e-10 * np.diag(np.diag(matrix)) + 1e-30 * np.eye(len(matrix)), heavy.T @ values))
    return found


def _step(points: Array, frame: Frame, size: float) -> tuple[float, Frame]:
    """Scatter of the radii about a smooth function of the height, and the frame that lowers it: one robust Gauss-Newton step."""
    x, y, z = frame.inside(points).T
    radius = np.hypot(x, y) + 1e-9 * size
    cosine, sine = x / radius, y / radius
    height = np.clip(z / (2 * size), -1.5, 1.5)
    smooth = np.column_stack([height**power for power in range(POWER + 1)])
    basis = np.column_stack([smooth, cosine, sine, z * cosine, z * sine])
    weight = np.ones(len(radius))
    for _ in range(3):
        found = _least_squares(basis, radius, weight)
        left = radius - basis @ found
        scale = 1.4826 * float(np.median(np.abs(left))) + 1e-9 * size
        weight = np.clip(1 - (left / (4.685 * scale)) ** 2, 0.0, None) ** 2 + 1e-6
    now = radius - smooth @ _least_squares(smooth, radius, weight)
    scatter = float(np.mean(np.minimum(np.abs(now), 0.5 * size))) / size
    across, tilt = found[POWER + 1 : POWER + 3], found[POWER + 3 :]
    limit = 0.5 * size
    across = across * min(1.0, limit / (float(np.linalg.norm(across)) + 1e-12))
    tilt = tilt * min(1.0, 0.3 / (float(np.linalg.norm(tilt)) + 1e-12))
    return scatter, frame.moved(across, tilt)
