"""How long the sweep of a train takes here: by the time of a run of each member at its middle and at its
highest speed.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.runs.run import run_problem
from valvetrain.runs.workers import on_this_machine
from valvetrain.solution.result import Solution
from valvetrain.system.build import build

#: Search for critical speeds and their ranges over a run that settles: 55 (rigid parts) to 225 (a reduced rod) measured.
SEARCH = 120.0
#: The same where the run at the highest speed keeps control, so that nothing is to be found.
SEARCH_IN_VAIN = 20.0
#: Cycles in which a measured run is searched to repeat, and how much longer the sweep takes over one that does not.
MEASURED_CYCLES, UNSETTLED = 24, 1.5
#: Time of a run and its repeat with springs divided 1.5 times finer, over the run.
REPEATED = 3.25


def sweep_seconds(
    case: Case,
    engine_speeds: Sequence[float],
    *,
    spring_models: Sequence[str] = (),
    spring_sets: Sequence[str] = (),
    workers: int = 1,
    searches: bool = True,
) -> float | None:
    """Seconds that a sweep of a train at ``engine_speeds`` (rad/s of the crank) will take; None where
    a run alone cannot say.
    """
    assert case.train is not None
    top = max(engine_speeds)
    middle = min(engine_speeds, key=lambda speed: abs(speed - (min(engine_speeds) + top) / 2))
    sets = tuple(spring_sets) or case.train.swept_sets
    swept, searched = list[float](), list[float]()
    for chosen in sets:
        each, lost = dict[float, float](), dict[float, bool]()
        try:
            problem = build(case, spring_models=spring_models, spring_set=(chosen,))
        except InputError:
            return None
        cycles = min(problem.cycles_to_settle or MEASURED_CYCLES, MEASURED_CYCLES)
        short = replace(problem, cycles_to_settle=cycles)
        for speed in (middle, middle, top):  # the first builds and loads what later runs share
            begun = time.process_time()  # of this process: what else runs here does not last
            try:
                with on_this_machine():
                    study = run_problem(short, (speed,), workers=1, whole=False, rest=False)
            except InputError:
                return None
            longer = UNSETTLED if any(map(_unsettled, study.solutions)) else 1.0
            each[speed] = longer * (time.process_time() - begun)
            lost[speed] = any(map(_lost, study.solutions))
        # A slower engine takes longer for a cycle, one out of control more cycles.
        span = max(top - middle, 1e-9)
        swept.append(
            REPEATED
            * sum(
                each[middle] * middle / speed
                if speed <= middle
                else each[middle] + (each[top] - each[middle]) * (speed - middle) / span
                for speed in engine_speeds
            )
        )
        settled = min(each.values())  # one that never settles takes some times as long
        searched.append((SEARCH if lost[top] else SEARCH_IN_VAIN) * settled if searches else 0.0)
    return sum(swept) / workers + max(max(searched), sum(searched) / workers)


def _unsettled(run: Solution) -> bool:
    """Whether the motion did not repeat in the cycles that it had."""
    return run.statistics.get("motion_period_count") != 1


def _lost(run: Solution) -> bool:
    """Whether a run lost contact or bounced, or did not settle."""
    signs = ("loss_of_contact_duration", "bounce_count")
    return not run.status.completed or any(run.quantities.get(name, 0.0) > 0 for name in signs)
