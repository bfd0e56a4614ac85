"""How long the sweep of a train takes here: by the time of one run of each member at its highest speed."""

from __future__ import annotations

import time
from collections.abc import Sequence

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.runs.run import run_study
from valvetrain.solution.result import Solution

#: Runs of the search for critical speeds and of its ranges, most of them at the upper speeds, some with
#: springs divided more finely (90 to 300 times the run at the highest speed measured).
SEARCH = 180.0
#: The same where the run at the highest speed keeps control, so that nothing is to be found.
SEARCH_IN_VAIN = 25.0
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
    sets = tuple(spring_sets) or case.train.swept_sets
    each, runs = list[float](), list[float]()
    for chosen in sets:
        seconds = []
        for _ in range(2):  # the first builds and loads what later runs share
            begun = time.perf_counter()
            try:
                study = run_study(
                    case,
                    engine_speeds=(top,),
                    spring_models=spring_models,
                    spring_sets=(chosen,),
                    workers=1,
                    whole=False,
                    later=True,
                )
            except InputError:
                return None
            seconds.append(time.perf_counter() - begun)
        each.append(min(seconds))
        runs.append(SEARCH if any(map(_lost, study.solutions)) else SEARCH_IN_VAIN)
    # A slower engine takes longer for a cycle.
    swept = REPEATED * sum(each) * sum(top / speed for speed in engine_speeds)
    searched = [count * one if searches else 0.0 for one, count in zip(each, runs, strict=True)]
    return swept / workers + max(max(searched), sum(searched) / workers)


def _lost(run: Solution) -> bool:
    """Whether a run lost contact or bounced, or did not settle."""
    signs = ("loss_of_contact_duration", "bounce_count")
    return not run.status.completed or any(run.quantities.get(name, 0.0) > 0 for name in signs)
