"""An even draw of bounded size from a stream of points, the same whatever their order."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError

Array = NDArray[np.float64]
#: Points that are drawn, fewest that tell a spring, and share of rows without numbers from which a file is taken to be damaged.
DRAWN, FEWEST, DAMAGED = 100_000, 1500, 0.1


@dataclass(frozen=True, eq=False)
class Drawn:
    """Points (n, 3) in an order that their coordinates decide, how many were ``read``, and how many of those held no numbers."""

    points: Array
    read: int
    broken: int


def draw_points(blocks: Iterable[Array], most: int, name: str) -> Drawn:
    """At most ``most`` different points of all ``blocks``: those whose coordinates, mixed to one number each, come first.

    Raises :class:`InputError` for fewer than :data:`FEWEST`, and where many rows hold no numbers.
    """
    kept, marks = np.zeros((0, 3)), np.zeros(0, dtype=np.uint64)
    limit = np.uint64(2**64 - 1)
    read = broken = 0
    for block in blocks:
        read += len(block)
        finite = block[np.all(np.isfinite(block) & (np.abs(block) < 1e12), axis=1)]
        broken += len(block) - len(finite)
        own = _mixed(finite)
        low = own <= limit
        kept, marks = np.concatenate([kept, finite[low]]), np.concatenate([marks, own[low]])
        if len(marks) > 2 * most:
            kept, marks = _first(kept, marks, most)
            limit = marks[-1] if len(marks) == most else limit
    kept, _ = _first(kept, marks, most)
    if broken > DAMAGED * max(read, 1):
        raise InputError(f"{broken} of the {read} points of '{name}' are no numbers; export the scan again")
    if len(kept) < FEWEST:
        raise InputError(f"'{name}' holds {len(kept)} different points; {FEWEST} or more are needed, so scan it finer")
    return Drawn(kept, read, broken)


def _first(points: Array, marks: NDArray[np.uint64], most: int) -> tuple[Array, NDArray[np.uint64]]:
    """Different points by rising mark, ``most`` of them."""
    marks, place = np.unique(marks, return_index=True)
    return points[place[:most]], marks[:most]


def _mixed(points: Array) -> NDArray[np.uint64]:
    """One number a point from the bits of its coordinates (the finaliser of splitmix64 after each)."""
    bits = np.ascontiguousarray(points + 0.0).view(np.uint64).reshape(-1, 3)
    found = np.full(len(bits), 0x9E3779B97F4A7C15, dtype=np.uint64)
    with np.errstate(over="ignore"):
        for column in range(3):
            found = found ^ bits[:, column]
            found = (found ^ (found >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
            found = (found ^ (found >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
            found = found ^ (found >> np.uint64(31))
    return found
