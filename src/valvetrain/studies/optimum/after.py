"""What is looked at once a search has ended: which designs to show, and what small steps do to the
best one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from valvetrain.studies.optimum.measure import Measured
from valvetrain.studies.optimum.plan import OptimumPlan
from valvetrain.studies.optimum.result import Design, Optimum, Step
from valvetrain.studies.optimum.space import neighbours
from valvetrain.studies.optimum.trial import Array, Trial, beats, best_of

#: A small step, as a share of the range of a quantity.
STEP = 0.01


def chosen_designs(found: Optimum) -> tuple[Design, ...]:
    """The best design; of several objectives the balanced one of the front, then the best one by
    each objective.
    """
    if len(found.plan.objectives) == 1:
        best = best_of(list(found.trials))
        return () if best is None else (Design(best, "the best"),)
    front = list(found.front)
    if not front:
        return ()
    signs = np.array([one.sign for one in found.plan.objectives])
    costs = np.array([signs * one.objectives for one in front])
    width = np.ptp(costs, axis=0)
    away = np.sum(((costs - costs.min(axis=0)) / np.where(width > 0, width, 1.0)) ** 2, axis=1)
    designs = [
        Design(
            front[int(np.argmin(away))],
            "balanced: nearest to the best of every objective, each over its span on the front",
        )
    ]
    for place, goal in enumerate(found.plan.objectives):
        one = front[int(np.argmin(costs[:, place]))]
        if all(one is not other.trial for other in designs):
            designs.append(Design(one, f"best {goal.measure.label}"))
    return tuple(designs)


def steps_of(
    plan: OptimumPlan, trial: Trial, measure: Callable[[Sequence[Array]], list[Measured]]
) -> tuple[Step, ...]:
    """What a step of a hundredth of its range, or to the next value, of each varied quantity alone
    does to a design.
    """
    rows = [
        (place, row)
        for place in range(len(plan.varied))
        for row in neighbours(plan, trial.values, place, STEP)
    ]
    if not rows:
        return ()
    found = []
    for (place, row), measured in zip(rows, measure([row for _, row in rows]), strict=True):
        one = Trial(-1, trial.seed, row, measured, plan)
        better = one.feasible and beats(one, trial)
        found.append(
            Step(
                place,
                float(row[place] - trial.values[place]),
                one.objectives,
                one.feasible,
                better,
                one.failure,
            )
        )
    return tuple(found)
