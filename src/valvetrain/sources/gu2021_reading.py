"""How the beehive study (gu2021) read its own results, applied to computed ones: one rule for both.

Its solver stored a value every 0.5 cam degrees (table 2: 72 steps of ten substeps a revolution), and
what it prints are values of that list. A spike of some microseconds falls between such samples or on
one of them, by luck of their phase. So a computed force is read at samples of 0.5 degrees at fifty
phases; a comparison gives the range over them, and a single number is their median.
Nothing that the study prints is said to be filtered, so nothing is filtered here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from valvetrain.quantities.cycle import Array, Cycle
from valvetrain.quantities.signal import fine_series

#: Cam angle (rad) between the values that the source stored.
SAMPLE = np.radians(0.5)
#: Most phases at which the samples are laid; fewer where the run's record is coarser.
PHASES = 50


@dataclass(frozen=True, eq=False)
class Sampled:
    """A force as the source would have stored it, once for each phase of its samples.

    ``cam_angle`` and ``force`` (phase, sample): rad from 0 to 2 pi, ascending, and N.
    """

    cam_angle: Array
    force: Array


def sampled(cycle: Cycle, channel: str = "seat_force") -> Sampled:
    """The force of one cam revolution every :data:`SAMPLE`, at every phase that the run's record allows.

    A run whose record is not finer than the samples of the source has one phase: its own samples.
    """
    record = "finest" if cycle.solution.has(f"{channel}_finest") else "fine"
    _, angle, values = fine_series(cycle.solution, channel, record)
    turn = cycle.solution.cam_angle[cycle.samples][0] - cycle.cam_angle[0]
    angle = angle - turn
    inside = (angle >= cycle.cam_angle[0] - 1e-9) & (angle <= cycle.cam_angle[-1] + 1e-9)
    angle, values = angle[inside], values[inside]
    spacing = float(np.median(np.diff(angle)))
    phases = int(min(round(SAMPLE / spacing), PHASES))
    if phases < 2:
        return Sampled(cycle.cam_angle[None, :], cycle.channel(channel)[None, :])
    count = int(np.floor((angle[-1] - angle[0]) / SAMPLE + 1e-6))
    starts = angle[0] + SAMPLE * np.arange(phases) / phases
    grid = starts[:, None] + SAMPLE * np.arange(count)
    return Sampled(grid, np.interp(grid.ravel(), angle, values).reshape(grid.shape))


def half_height(cam_angle: Array, force: Array, peak: int, reach: float) -> tuple[float, float]:
    """Width (rad) of a spike at half its height, and the area (N rad) of its part above its foot.

    The foot is the median force within ``reach`` (rad) of the sample ``peak``; between samples the
    force is a straight line.

    >>> angle = np.linspace(0.0, 2.0, 2001)
    >>> triangle = np.maximum(0.0, 100.0 - 1000.0 * abs(angle - 1.0))
    >>> width, area = half_height(angle, triangle, 1000, 1.0)
    >>> round(width, 3), round(area, 2)
    (0.1, 10.0)
    """
    near = np.flatnonzero(np.abs(cam_angle - cam_angle[peak]) <= reach)
    foot = float(np.median(force[near]))
    level = foot + (force[peak] - foot) / 2
    sides = []
    for step, last in ((-1, near[0]), (1, near[-1])):
        at = peak
        while at != last and force[at] > level:
            at += step
        if at == peak:  # the record begins or ends at the top
            sides.append(0.0)
            continue
        before, here = at - step, at
        drop = force[before] - force[here]
        share = float(np.clip((force[before] - level) / drop, 0.0, 1.0)) if drop > 0 else 0.0
        sides.append(
            abs(cam_angle[before] - cam_angle[peak])
            + share * abs(cam_angle[here] - cam_angle[before])
        )
    above = np.maximum(force[near] - foot, 0.0)
    # the spike alone: from its top down to where it first meets its foot on either side
    low, high = peak - near[0], peak - near[0]
    while low > 0 and above[low] > 0:
        low -= 1
    while high < len(above) - 1 and above[high] > 0:
        high += 1
    part = slice(low, high + 1)
    return float(sum(sides)), float(np.trapezoid(above[part], cam_angle[near][part]))
