"""The main lift event of a cam and the three windows of a cycle: before the event, event, after the
event.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from valvetrain.quantities.cycle import Cycle
from valvetrain.solution.study import LiftEvent

Window = Literal["before the event", "event", "after the event"]
#: The windows in order of cam angle.
WINDOWS: tuple[Window, ...] = ("before the event", "event", "after the event")
_TURN = 2 * math.pi


def window_bounds(event: LiftEvent, window: Window) -> tuple[float, float]:
    """First and last cam angle (rad) of a window; the first begins at the cam's zero, the last ends
    after a whole turn.
    """
    return {
        WINDOWS[0]: (0.0, event.start),
        WINDOWS[1]: (event.start, event.end),
        WINDOWS[2]: (event.end, _TURN),
    }[window]


def is_covered(cycle: Cycle, event: LiftEvent, window: Window) -> bool:
    """Whether the cycle covers a window with three samples or more."""
    bounds = window_bounds(event, window)
    return int(np.sum(cycle.window(*bounds))) > 2 and cycle.covers(*bounds)
