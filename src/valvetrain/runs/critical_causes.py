"""Causes of critical speeds, each from one run at the critical speed itself: the speeds of a sweep,
which are chosen by its user, decide nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

from valvetrain.quantities.loss_cause import least_force_sample, loss_cause
from valvetrain.quantities.train_events import rigid_cycle
from valvetrain.runs.prepared import PreparedRun
from valvetrain.solution.critical import CriticalSpeed
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Cause, Detail

#: Kinds whose events have a cause; a bounce has none.
CAUSED = ("contact-loss", "float")
#: Quantity of the cam order of the largest surge.
SURGE_ORDER = "surge_amplitude_cam_order"
#: Share of a critical speed beyond it at which a cause is looked for where none shows at the speed itself.
BEYOND = 0.005


def with_cause(
    row: CriticalSpeed, ready: PreparedRun, run: Callable[[float], Solution]
) -> CriticalSpeed:
    """The critical speed with its cause. ``run``: the train with channels and events at an engine
    speed (rad/s).
    """
    if row.kind not in CAUSED or not row.found or ready.motion is None or ready.window is None:
        return row
    beyond = (row.engine_speed + row.ranges[0].upper_engine_speed) / 2
    solution = run(row.engine_speed)
    found = _cause(row, ready, solution)
    if found.get("cause") == Cause.VIBRATION:
        # it is what is left where nothing else shows yet, so a little further on another may
        further = _cause(row, ready, run(min((1 + BEYOND) * row.engine_speed, beyond)))
        found = further if further.get("cause") else found
    places = row.places
    opens = (
        least_force_sample(solution, places, ready.window)
        if row.kind == "contact-loss" and len(solution.time)
        else None
    )
    order = solution.quantities.get(SURGE_ORDER, math.nan)
    return replace(
        row,
        cause=str(found.get("cause", "")),
        spring_force_loss=float(found.get("spring_force_loss", 0.0)),
        surge_order=round(order) if math.isfinite(order) else 0,
        cam_angle=math.nan if opens is None else float(solution.cam_angle[opens]) % math.tau,
    )


def _cause(row: CriticalSpeed, ready: PreparedRun, solution: Solution) -> Mapping[str, Detail]:
    """Details of the cause in a run; none of one without channels."""
    if not len(solution.time) or ready.motion is None or ready.window is None:
        return {}
    rigid = rigid_cycle(solution, ready.motion.table(solution.engine_speed / 2))
    return loss_cause(solution, rigid, row.kind, row.places, ready.window)
