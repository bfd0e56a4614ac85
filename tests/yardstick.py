"""Bounds on processor time that hold on slower and busier machines: how long simple work takes there."""

from __future__ import annotations

import time
from collections.abc import Callable


def quickest(work: Callable[[], object], repeats: int = 3) -> float:
    """Processor time of the quickest of some repeats, as seconds of a machine on which two million
    additions take 24 ms; a slower machine's are shortened, a faster one's are as measured.
    """
    times, additions = [], []
    for _ in range(repeats):
        for into, job in ((additions, lambda: sum(range(2_000_000))), (times, work)):
            begun = time.process_time()
            job()
            into.append(time.process_time() - begun)
    return min(times) / max(1.0, min(additions) / 24e-3)
