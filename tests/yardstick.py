"""Bounds on processor time that hold on slower and busier machines: how long simple work takes there."""

from __future__ import annotations

import time
from collections.abc import Callable


def slowness(repeats: int = 3) -> float:
    """How many times longer simple work takes here than on a machine on which eight million additions
    take 96 ms, as long as what is measured against it; 1 on a faster one.
    """
    return max(1.0, min(_spent(_additions) for _ in range(repeats)) / 96e-3)


def quickest(work: Callable[[], object], repeats: int = 3, enough: float = 0.0) -> float:
    """Processor time of the quickest of some repeats, as seconds of that machine; no more of them are
    made once it is below ``enough``.
    """
    times, slow = [], []
    for _ in range(repeats):
        slow.append(slowness(1))
        times.append(_spent(work))
        if min(times) / min(slow) < enough:
            break
    return min(times) / min(slow)


def _additions() -> int:
    return sum(range(8_000_000))


def _spent(work: Callable[[], object]) -> float:
    begun = time.process_time()
    work()
    return time.process_time() - begun
