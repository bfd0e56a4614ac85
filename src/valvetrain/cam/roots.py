"""One root of a function of one number."""

from __future__ import annotations

from collections.abc import Callable


def solve(error: Callable[[float], float], bounds: tuple[float, float], within: float = 0.0) -> float | None:
    """Where ``error`` crosses zero between ``bounds``, by regula falsi (Illinois) until a step is no more than ``within`` (0: to rounding);
    None where it has one sign at both."""
    (before, now), (at_before, at_now) = bounds, (error(bounds[0]), error(bounds[1]))
    if at_before * at_now > 0:
        return None
    for _ in range(200):
        if at_now == 0 or at_before == at_now or abs(now - before) < 1e-15 * (abs(now) + abs(before)):
            break
        found = (before * at_now - now * at_before) / (at_now - at_before)
        at_found = error(found)
        if at_found * at_now < 0:
            before, at_before = now, at_now
        else:
            at_before /= 2
        close = abs(found - now) <= within
        now, at_now = found, at_found
        if close:
            break
    return now
