"""Wire sections in half planes through the axis: circles found by votes, at a radius that the votes choose."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: Half planes per turn; those that choose the radius of the wire, and the radii they try as shares of the coil radius.
WEDGES, CHOOSING, RADII = 64, 8, np.geomspace(0.035, 0.36, 32)
#: Size of a cell of votes as a share of the coil radius; least distance between two sections, in radii of the wire.
CELL, APART = 0.012, 1.4
#: Radii of the wire that are followed up.
TRIED = 4
#: Share of the usual number of votes from which a section counts.
LEAST = 0.3
#: Most points of a half plane that vote.
MOST_VOTING = 600


@dataclass(frozen=True, eq=False)
class Sections:
    """Centres of wire sections: ``turn`` of the half plane (0 to 1), ``radius`` and ``height`` (k,), ``votes`` as shares."""

    turn: Array
    radius: Array
    height: Array
    votes: Array
    wire_radius: float


def find_sections(points: Array, wedges: int = WEDGES) -> list[Sections]:
    """Sections of the wire in ``wedges`` half planes by the radii with the most votes, the best first; ``points`` (n, 3) in the frame
    of the axis. Empty for points that show no round wire."""
    turn = np.mod(np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi), 1.0)
    plane = np.column_stack([np.hypot(points[:, 0], points[:, 1]), points[:, 2]])
    low, high = np.quantile(plane, 0.005, axis=0), np.quantile(plane, 0.995, axis=0)
    margin = 0.05 * float(np.max(high - low))
    inside = np.all((plane > low - margin) & (plane < high + margin), axis=1)
    turn, plane = turn[inside], plane[inside]
    order = np.argsort(turn, kind="stable")
    turn, plane = turn[order], plane[order]
    edges = np.searchsorted(turn, np.linspace(0.0, 1.0, wedges + 1))
    parts = [plane[first:last][:: max(1, (last - first) // MOST_VOTING)] for first, last in itertools.pairwise(edges)]
    coil = float(high[0])
    chosen = parts[:: max(1, wedges // CHOOSING)]
    scores = [float(np.mean([_votes(part, share * coil, CELL * coil)[0].max(initial=0.0) for part in chosen])) for share in RADII]
    answers = (_with_radius(parts, share * coil, CELL * coil) for share in _best_radii(np.array(scores)))
    return [one for one in answers if one is not None]


def _best_radii(scores: Array) -> list[float]:
    """Shares of the coil radius at which the votes peak, the highest peak first."""
    rising = np.concatenate([[True], np.diff(scores) > 0])
    peaks = np.flatnonzero(rising & ~np.concatenate([rising[1:], [False]]))
    order = peaks[np.lexsort((peaks, -scores[peaks]))][:TRIED]
    return [_peak_place(RADII, scores, int(place)) for place in order]


def _with_radius(parts: list[Array], wire: float, cell: float) -> Sections | None:
    """Sections of a wire of that radius in the points (n, 2) of each half plane; None for too few."""
    wedges = len(parts)
    found: list[tuple[float, float, float, float]] = []
    for place, part in enumerate(parts):
        votes, corner = _votes(part, wire, cell)
        for row, column, strength in _peaks(votes, int(APART * wire / cell)):
            found.append(((place + 0.5) / wedges, corner[0] + row * cell, corner[1] + column * cell, strength))
    if len(found) < wedges:
        return None
    turns, radii, heights, strengths = np.array(found).T
    usual = float(np.quantile(strengths, 0.8))
    keep = strengths > LEAST * usual
    return Sections(turns[keep], radii[keep], heights[keep], strengths[keep] / usual, wire)


def _peak_place(shares: Array, scores: Array, place: int) -> float:
    """Where a parabola through the score at ``place`` and its neighbours is highest, in logarithms of the share."""
    top = int(np.clip(place, 1, len(scores) - 2))
    before, at, after = scores[top - 1 : top + 2]
    bend = before - 2 * at + after
    away = 0.5 * (before - after) / bend if bend < 0 else 0.0
    return float(shares[top] * (shares[top + 1] / shares[top]) ** np.clip(away, -0.5, 0.5))


def _votes(plane: Array, wire: float, cell: float) -> tuple[Array, Array]:
    """Smoothed votes for centres that lie one wire radius from the points, and the corner of the cells."""
    if len(plane) < 3:
        return np.zeros((1, 1)), np.zeros(2)
    around = np.linspace(0, 2 * np.pi, int(np.ceil(2 * np.pi * wire / (0.7 * cell))), endpoint=False)
    circle = wire * np.column_stack([np.cos(around), np.sin(around)])
    corner = plane.min(axis=0) - wire - 2 * cell
    shape = np.ceil((plane.max(axis=0) - corner + wire) / cell).astype(int) + 3
    if shape[0] * shape[1] > 4_000_000:
        return np.zeros((1, 1)), corner
    rows, columns = np.floor((plane[:, None, :] + circle - corner) / cell).astype(int).reshape(-1, 2).T
    votes = np.bincount(rows * shape[1] + columns, minlength=shape[0] * shape[1]).reshape(shape).astype(float)
    for _ in range(2):  # neighbours share their votes, so that the place of the cells does not tell
        votes[1:-1] = 0.25 * votes[:-2] + 0.5 * votes[1:-1] + 0.25 * votes[2:]
        votes = votes.T
    # the votes of a point on its own circle are the same number for every radius; a share of the points is what is compared
    return votes / len(plane), corner + 0.5 * cell


def _peaks(votes: Array, apart: int) -> list[tuple[int, int, float]]:
    """Cells with the most votes within ``apart`` cells about them, the highest first."""
    from scipy.ndimage import maximum_filter

    apart = max(apart, 1)
    tops = (votes == maximum_filter(votes, size=2 * apart + 1)) & (votes > 0)
    rows, columns = np.nonzero(tops)
    strength = votes[rows, columns]
    order = np.lexsort((columns, rows, -strength))[:60]
    return [(int(rows[k]), int(columns[k]), float(strength[k])) for k in order]
