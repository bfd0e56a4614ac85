"""Peaks of a profile that stand out; written here, for loading scipy.signal costs half a second."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def find_peaks(row: Array, least: float) -> tuple[NDArray[np.int64], Array]:
    """Places of the local maxima of ``row`` (stations,) inside it and their prominences, those of at least ``least``.

    The prominence is the height above the higher of the two lowest levels that lie between the peak and higher ground (or the end).
    """
    rises, falls = row[1:-1] > row[:-2], row[1:-1] >= row[2:]
    places = np.flatnonzero(rises & falls) + 1
    places = places[row[places] >= row.min() + least]
    kept, heights = [], []
    for place in places:
        top = row[place]
        higher = row > top
        before, after = np.flatnonzero(higher[:place]), np.flatnonzero(higher[place + 1 :])
        left = row[before[-1] + 1 if len(before) else 0 : place + 1].min()
        right = row[place : place + 1 + (after[0] if len(after) else len(row))].min()
        if top - max(left, right) >= least:
            kept.append(int(place))
            heights.append(float(top - max(left, right)))
    return np.array(kept, dtype=np.int64), np.array(heights)


def half_width(row: Array, place: int, prominence: float) -> float:
    """Width (stations) of a peak at half its prominence, by straight lines between stations."""
    level = row[place] - 0.5 * prominence
    edges = []
    for step in (-1, 1):
        at = place
        while 0 <= at + step < len(row) and row[at + step] > level:
            at += step
        end = at + step
        edges.append(at + step * (row[at] - level) / (row[at] - row[end]) if 0 <= end < len(row) else float(at))
    return float(edges[1] - edges[0])
