"""``valvetrain.optimise``: the case, then rounds of trials, then what to think of the best design.

The result is the same for any executor and after any interruption.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.explore.case_paths import nominal
from valvetrain.explore.engine import Engine, Interrupted
from valvetrain.explore.evaluate import doubts
from valvetrain.explore.execution import Execution, Watch
from valvetrain.explore.limit_speed import CLOSER
from valvetrain.explore.measure import (
    INCOMPLETE,
    RUNS,
    Measure,
    Measured,
    OptimumModel,
    measure_designs,
)
from valvetrain.explore.objective import OptimumPlan, read_optimum
from valvetrain.explore.optimum import Confirmed, Optimum
from valvetrain.explore.search import Trial, best_of, quiet_optuna, search_from
from valvetrain.explore.study import refuse_outputs
from valvetrain.runs.cluster import on_cluster
from valvetrain.runs.cost import Cost
from valvetrain.runs.workers import Progress, workers_here
from valvetrain.solution.uncertainty import Uncertainty

#: Seconds that a trial takes in addition to its points; bytes of one.
AROUND, TRIAL_BYTES = 0.03, 2e4
#: What makes a search large.
FEWER = "trials, speeds or models"


def search_cost(plan: OptimumPlan, workers: int) -> Cost:
    """Estimated cost of a plan: every trial to the end of its scans, and the confirmations."""
    trials = plan.search.trials + 1
    computing = trials * plan.seconds + sum(2 * one.seconds for one in plan.confirmations.values())
    searched = [one.limit for one in plan.measures if one.limit is not None]
    points = sum(len(one.runs) for one in plan.measures)
    points += sum(len(one.engine_speeds) + CLOSER for one in searched)
    memory = trials * (TRIAL_BYTES + 500.0 * points) + 1.2e8 * (workers_here(workers) + 1)
    return Cost(trials * AROUND + computing / max(1, workers), memory)


def run_search(
    plan: OptimumPlan, execution: Execution = Execution(), watch: Watch = Watch()
) -> Optimum:
    """The search of a plan; points that are stored are not computed again.

    Raises :class:`InputError` for a request beyond its limit, and :class:`Interrupted` with
    what was finished when it is stopped.
    """
    for part in (plan, *plan.confirmations.values()):
        refuse_outputs(plan.case, part.tasks)
    with on_cluster(execution.dask, execution.workers) as count:
        work = f"{plan.search.trials + 1} trials at most"
        watch.admit(search_cost(plan, count), execution.limit, work, FEWER)
        with quiet_optuna():
            pass  # a library that is not installed is said before the first run
        with Engine((plan.experiment,), count, execution.output) as points:
            return _Search(plan, points, watch.report).run()


def case_of_plan(plan: OptimumPlan) -> tuple[float, ...]:
    """The design that is the case itself, without values; of a function the middle of the space."""
    return () if plan.case is not None else tuple(one.distribution.middle for one in plan.varied)


class _Search:
    """A running search."""

    def __init__(self, plan: OptimumPlan, points: Engine, progress: Progress) -> None:
        self.plan, self.points, self.progress = plan, points, progress
        self.begun = time.perf_counter()
        self.trials = list[Trial]()

    def run(self) -> Optimum:
        """The case, the search, and what other models say of the best design."""
        try:
            case = self.case(self.plan)
            self.plan = case.plan
            self.trials.append(case)
            search_from(self.plan, case, self.round)
            made = self.optimum()
            return self.optimum(
                confirmed=self.confirmed(made),
                error_bars=self.error_bars(made),
                doubt=self.doubt(made),
            )
        except KeyboardInterrupt:
            if not self.trials:
                raise
            raise Interrupted(self.optimum(finished=False)) from None

    def case(self, plan: OptimumPlan) -> Trial:
        """The case as given, trial 0, with the bounds that are shares of its numbers."""
        (measured,) = self.measure(plan, [case_of_plan(plan)])
        shares = [one.share for one in plan.constraints]
        shares += [one.limit.share for one in plan.measures if one.limit is not None]
        if measured.failure and any(share is not None for share in shares):
            raise InputError(
                f"the case itself cannot be computed, and a bound is a share of its numbers: {measured.failure}"
            )
        if measured.code == INCOMPLETE:
            raise InputError(f"{measured.failure}; no design can be judged without it")
        return Trial(0, _nominal(plan), measured, plan.of_case(measured.values))

    def measure(
        self, plan: OptimumPlan, designs: Sequence[tuple[float, ...]], spare: bool = False
    ) -> list[Measured]:
        """The numbers of designs (d, SI); with ``spare`` no limit speed of one that misses a bound already."""

        def misses(numbers: Mapping[Measure, float]) -> bool:
            return any(
                one.missed(numbers[one.measure]) > 0
                for one in plan.constraints
                if one.measure in numbers
            )

        stop = misses if spare else None
        measures, rest = plan.measures, plan.rest_model
        return measure_designs(self.points, plan.experiment, designs, measures, rest, stop)

    def round(self, shares: Sequence[Array], spare: bool) -> list[Trial]:
        """The trials at points of the unit cube, a few batches of them at a time."""
        values, size, before = [self.plan.values(one) for one in shares], self.plan.search.per_round, len(self.trials)  # fmt: skip
        for first in range(0, len(values), size):
            part = values[first : first + size]
            designs = [tuple(row.tolist()) for row in part]
            for row, measured in zip(part, self.measure(self.plan, designs, spare), strict=True):
                self.trials.append(Trial(len(self.trials), row, measured, self.plan))
            total, best = self.plan.search.trials, best_of(self.trials)
            goal, text = self.plan.objectives[0].measure, "none feasible yet"
            if best is not None:
                text = f"best {goal.shown(float(best.objectives[0])):.5g} {goal.unit}".rstrip()
            done = len(self.trials) - 1
            self.progress(min(0.97, done / total), f"{done} of {total} trials, {text}")
        return self.trials[before:]

    def optimum(self, **more: Any) -> Optimum:
        """The trials so far, and what is known of the best of them."""
        seconds, computed = time.perf_counter() - self.begun, self.points.store.computed
        return Optimum(self.plan, tuple(self.trials), computed=computed, seconds=seconds, **more)

    def confirmed(self, found: Optimum) -> tuple[Confirmed, ...]:
        """The case and the best design by other models, each against the bounds by that model."""
        if found.best is None:
            return ()
        made, best = list[Confirmed](), found.best.trial
        for label, plan in self.plan.confirmations.items():
            self.progress(0.98, f"confirming by {label}")
            case = design = self.case(plan)
            if best.number:
                (measured,) = self.measure(case.plan, [tuple(best.values.tolist())])
                design = replace(best, measured=measured, plan=case.plan)
            made.append(Confirmed(label, case, design))
        return tuple(made)

    def error_bars(self, made: Optimum) -> tuple[Uncertainty, ...]:
        """Error bars of the numbers searched for, of the best design or of the one that comes nearest."""
        plan, trial = self.plan, made.nearest
        runs = dict.fromkeys(run for one in plan.measures if one.stage == RUNS for run in one.runs)
        if trial is None or not runs:
            return ()
        self.progress(0.99, "error bars")
        values = trial.values.tolist() if trial.number else []
        searched = {one.quantity for one in plan.measures}
        every = (row for run in runs for row in plan.experiment.error_bars(values, run))
        bars = {(row.quantity, row.label, row.engine_speed): row for row in every if row.quantity in searched}  # fmt: skip
        return tuple(bars.values())

    def doubt(self, made: Optimum) -> str:
        """What is unusual about the values of the best design and not about the case."""
        best = None if made.best is None else made.best.trial
        values = [best.values.tolist()] if best is not None and best.number else []
        texts = doubts(self.plan.case, self.plan.varied, values).values()
        return next((text.partition(": ")[2] for text in texts), "")


def _nominal(plan: OptimumPlan) -> Array:
    """Values of the case (d,), nan where it has none; of a function the middle of the space."""
    if plan.case is None:
        return np.array(case_of_plan(plan))
    values = []
    for one in plan.varied:
        try:
            values.append(nominal(plan.case, one))
        except InputError:
            values.append(np.nan)
    return np.array(values)


STEPS = OptimumModel, read_optimum, run_search
