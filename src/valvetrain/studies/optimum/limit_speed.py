"""The engine speed up to which a quantity stays within a bound: from below over a grid, closer
where it nears the bound, then bisection.

What it can miss: a stretch narrower than the grid over which the quantity leaves the bound, where
no neighbour on the grid shows a rise
towards it. A finer grid finds it.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

#: How a search ended: a bracket was found; the bound is left at the lowest speed already; it is
#: kept up to the highest one.
FOUND, BELOW, BEYOND = "found", "below", "beyond"
#: A rise over its neighbours this many times what a parabola through the three tells is thought
#: possible between them.
CAUTION = 2.0
Scan = Generator[list[float], list[float], "LimitFound"]


@dataclass(frozen=True, slots=True)
class LimitSearch:
    """Keep ``quantity`` at or below (``upper``), or at or above, ``bound`` (SI), over
    ``engine_speeds`` (rad/s, rising).

    ``resolution`` (rad/s): width of the bracket at the end. ``share``: the bound is this share of
    what the case has at the lowest speed.
    """

    quantity: str
    upper: bool
    bound: float
    engine_speeds: tuple[float, ...]
    resolution: float
    share: float | None = None


@dataclass(frozen=True, slots=True)
class LimitFound:
    """The bracket: the bound is kept up to ``low`` and left at ``high`` (rad/s); ``kind`` says
    whether there is one.

    ``missed``: where the bound is left at the lowest speed already, by which share of it.
    """

    kind: str
    low: float
    high: float
    missed: float = 0.0

    @property
    def value(self) -> float:
        """The limit speed (rad/s): the highest one at which the bound was seen kept; the lowest
        looked at where there is none.
        """
        return self.high if self.kind == BELOW else self.low


def find_limit(limit: LimitSearch) -> Scan:
    """Ask for values at engine speeds (rad/s), batch by batch; a value that is not there (nan)
    counts as beyond the bound.
    """
    sign = 1.0 if limit.upper else -1.0
    known: dict[float, float] = {}

    def excess(engine_speed: float) -> float:
        value = known[engine_speed]
        return sign * (value - limit.bound) if np.isfinite(value) else np.inf

    for engine_speed in limit.engine_speeds:
        known[engine_speed] = (yield [engine_speed])[0]
        if excess(engine_speed) > 0:
            break
    while True:
        order = sorted(known)
        beyond = next((place for place, one in enumerate(order) if excess(one) > 0), None)
        if beyond == 0:
            return LimitFound(BELOW, 0.0, order[0], excess(order[0]) / (abs(limit.bound) or 1.0))
        near = _nearing(order[:beyond], [excess(one) for one in order[:beyond]], limit.resolution)
        if near:  # a peak between the points of the grid that may leave the bound
            known |= dict(zip(near, (yield near), strict=True))
            continue
        if beyond is None:
            return LimitFound(BEYOND, order[-1], np.inf)
        low, high = order[beyond - 1], order[beyond]
        if high - low <= limit.resolution * (1 + 1e-9):
            return LimitFound(FOUND, low, high)
        middle = 0.5 * (low + high)
        known[middle] = (yield [middle])[0]


def _nearing(engine_speeds: list[float], excess: list[float], resolution: float) -> list[float]:
    """Speeds about the lowest peak inside the bound whose top, as a parabola with some caution
    tells it, may lie beyond the bound.
    """
    for place in range(1, len(engine_speeds) - 1):
        before, top, after = excess[place - 1 : place + 2]
        if not (top >= before and top >= after and (top > before or top > after)):
            continue
        left, here, right = engine_speeds[place - 1 : place + 2]
        if (
            top + CAUTION * _rise(np.array([left, here, right]), np.array([before, top, after]))
            <= 0
        ):
            continue
        middles = [
            0.5 * (one + two)
            for one, two in ((left, here), (here, right))
            if two - one > 2 * resolution
        ]
        if middles:
            return middles
    return []


def _rise(
    x: np.ndarray[tuple[int], np.dtype[np.float64]], y: np.ndarray[tuple[int], np.dtype[np.float64]]
) -> float:
    """How far the top of the parabola through three points lies above the middle one."""
    first, second = np.diff(y) / np.diff(x)
    curvature = (second - first) / (x[2] - x[0])
    if curvature >= 0:
        return 0.0
    slope = first + curvature * (x[1] - x[0])
    return float(-(slope**2) / (4 * curvature))
