"""Where a lift passes a height: opening and closing at lash, at 1 mm and at 0.050 in, of the lobe, of the rigid valve and of a run.

Curves are solved, not read off their samples: a lift law by bisection of itself, a run by the cubic of lift and velocity between samples.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_TURN = 2 * np.pi
#: Word of a height in names of quantities -> the height (m).
HEIGHTS = {"1_mm": 1e-3, "50_thou": 0.050 * 25.4e-3}
#: Angles at which a lift law is looked at before its crossings are solved.
GRID = 1440


def lift_crossings(lift: Callable[[Array], Array], height: float) -> tuple[float, float] | None:
    """Cam angles (rad) at which ``lift`` (m over cam rad, periodic) rises through ``height`` (m) before its largest value and falls through
    it after; the first in one turn from zero, the second after it. None where it never stands above, or always."""
    angle = np.arange(GRID) * _TURN / GRID
    above = np.asarray(lift(angle)) > height
    if not np.any(above) or np.all(above):
        return None
    top = int(np.argmax(np.asarray(lift(angle))))
    down = np.flatnonzero(~above)
    before, after = int(down[np.argmin((top - down) % GRID)]), int(down[np.argmin((down - top) % GRID)])
    step = _TURN / GRID
    opens = _between(lift, height, before * step, (before + 1) * step)
    closes = _between(lift, height, after * step, (after - 1) * step)
    return opens % _TURN, opens % _TURN + (closes - opens) % _TURN


def _between(lift: Callable[[Array], Array], height: float, low: float, high: float) -> float:
    """Where ``lift`` passes ``height`` between an angle at which it is at most that and one at which it is more."""
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if float(lift(np.array(middle))) > height else (middle, high)
    return low


def event_numbers(subject: str, word: str, crossings: tuple[float, float] | None) -> dict[str, float]:
    """Quantities of one pair of crossings: cam angles of opening and closing, crank angle between them; none where it never opens."""
    if crossings is None:
        return {}
    opens, closes = crossings
    return {
        f"{subject}_{word}_opening_cam_angle": opens % _TURN, f"{subject}_{word}_closing_cam_angle": closes % _TURN,
        f"{subject}_{word}_open_crank_angle_range": 2 * (closes - opens),
    }  # fmt: skip


def law_events(subject: str, lift: Callable[[Array], Array], at_lash: bool = False) -> dict[str, float]:
    """Events of a lift (m over cam rad) at every height of :data:`HEIGHTS`, ``at_lash`` at zero too, where a rigid valve leaves its seat."""
    found = event_numbers(subject, "lash", lift_crossings(lift, 0.0)) if at_lash else {}
    for word, height in HEIGHTS.items():
        found |= event_numbers(subject, word, lift_crossings(lift, height))
    return found


def sampled_crossings(cam_angle: Array, valve_lift: Array, rate: Array, height: float) -> tuple[float, float] | None:
    """As :func:`lift_crossings`, of one closed turn of samples (S,) evenly over ``cam_angle`` (rad); ``rate``: m per cam rad.

    Between samples stands the cubic of both lifts and rates, so that the crossings are right to the fourth power of the interval.
    """
    count, above = len(valve_lift), valve_lift > height
    if not np.any(above) or np.all(above):
        return None
    top, down = int(np.argmax(valve_lift)), np.flatnonzero(~above)
    before, after = int(down[np.argmin((top - down) % count)]), int(down[np.argmin((down - top) % count)])
    step = _TURN / count

    def crossing(first: int) -> float:
        second = (first + 1) % count
        low, high, slope, end = (float(value) for value in (valve_lift[first], valve_lift[second], rate[first], rate[second]))
        rise, slope, end = high - low, slope * step, end * step
        cubic = np.array([slope + end - 2 * rise, 3 * rise - 2 * slope - end, slope, low - height])
        roots = np.roots(cubic) if np.any(cubic[:-1]) else np.zeros(0)
        real = roots[np.abs(roots.imag) < 1e-9].real
        inside = real[(real >= -1e-9) & (real <= 1 + 1e-9)]
        share = float(inside[0]) if len(inside) else (height - low) / rise
        return float(cam_angle[first]) + share * step

    opens, closes = crossing(before), crossing((after - 1) % count)
    return opens % _TURN, opens % _TURN + (closes - opens) % _TURN
