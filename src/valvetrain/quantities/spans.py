"""Stretches of cam angle on the ring of one turn: where a curve stands above a level, what two sets
share, how long they last.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: Cam angles (rad) of begin, within the first turn, and end, which may pass it.
Span = tuple[float, float]
TURN = 2 * np.pi


def spans_above(cam_angle: Array, values: Array, level: float = 0.0) -> list[Span]:
    """Where one closed turn of even samples stands above ``level``, straight between samples; the
    whole turn where it always does.
    """
    above = values > level
    if np.all(above):
        return [(0.0, TURN)]
    step = TURN / len(values)
    rises, falls = (
        np.flatnonzero(change)
        for change in (~above & np.roll(above, -1), above & ~np.roll(above, -1))
    )

    def crossing(place: int) -> float:
        low, high = float(values[place]), float(values[(place + 1) % len(values)])
        return float(cam_angle[place]) + step * (level - low) / (high - low)

    found = []
    for rise in rises.tolist():
        fall = int(falls[np.argmin((falls - rise) % len(values))])
        begin = crossing(rise)
        found.append(span_of(begin, begin + (crossing(fall) - begin) % TURN))
    return found


def span_of(begin: float, end: float) -> Span:
    """A span whose begin lies within the first turn, at most a turn long."""
    first = begin % TURN
    return first, first + min(end - begin, TURN)


def shared(first: Iterable[Span], second: Sequence[Span]) -> list[Span]:
    """Parts that lie in both sets."""
    found = []
    for begin, end in first:
        for low, high in second:
            for turn in (-TURN, 0.0, TURN):
                left, right = max(begin, low + turn), min(end, high + turn)
                if right > left:
                    found.append(span_of(left, right))
    return found


def covered(spans: Sequence[Span]) -> float:
    """Angle (rad) that the spans cover together, what several cover counted once."""
    cut = sorted(
        part
        for begin, end in spans
        for part in ((begin, min(end, TURN)), (0.0, max(end - TURN, 0.0)))
    )
    total, reached = 0.0, 0.0
    for begin, end in cut:
        total += max(0.0, end - max(begin, reached))
        reached = max(reached, end)
    return total
