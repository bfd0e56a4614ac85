"""The engine of studies: points out to a crew, outcomes into the store as they come, round after
round of the sampler.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.explore.evaluate import evaluate
from valvetrain.explore.executors import Executor
from valvetrain.explore.plan import Array, Run, StudyPlan
from valvetrain.explore.point import Outcome
from valvetrain.explore.store import PointStore
from valvetrain.explore.table import StudyTable
from valvetrain.runs.cost import Cost, Limits, refuse_cost
from valvetrain.runs.request_cost import REST, RunRequest, request_cost
from valvetrain.runs.stopping import Stopped
from valvetrain.runs.workers import LOST, LOST_REMEDY, Lost, Progress
from valvetrain.solution.status import Status

#: Jobs that are handed out at a time, so that neither memory nor the wait for any of them grows
#: with the study; points of a job where
#: each is short.
JOBS, TOGETHER = 512, 8
#: Seconds of one point below which several go together.
SHORT = 0.15
#: Seconds around a point: building the case anew, handing it on and back.
AROUND = 0.012
#: Bytes of a point that is kept, besides 8 for each of its numbers.
KEPT = 400.0
INTERRUPTED = Status(
    "interrupted",
    "the study was stopped before this point was finished",
    remedy="start it again to go on",
)


class PointsInterrupted(Stopped):
    """A study of points was stopped; ``table`` holds all rows, those that were not finished as
    ``interrupted``.
    """

    def __init__(self, table: StudyTable) -> None:
        super().__init__("stopped")
        self.table = table


@dataclass(frozen=True, slots=True)
class Estimate:
    """What a study will cost before it starts: points, wall time and memory of all of them, seconds
    of one.
    """

    points: int
    cost: Cost
    seconds_each: float


def estimate_study(plan: StudyPlan, workers: int) -> Estimate:
    """Estimated cost of a plan, from its request alone; of an adaptive one at its bound."""
    draws = len(plan.sampler.first(plan.varied, plan.options))
    draws = (
        max(draws, int(getattr(plan.options, "count", draws)))
        if plan.sampler.more.__name__ != "no_more"
        else draws
    )
    seconds = [seconds_of(plan, run) for run in plan.runs]
    each = sum(seconds) / len(seconds)
    memory = (
        draws * len(plan.runs) * (KEPT + 8.0 * (len(plan.varied) + len(plan.wanted.outputs)))
        + 3e7 * workers
    )
    return Estimate(
        draws * len(plan.runs), Cost(draws * sum(seconds) / max(1, workers), memory), each
    )


def seconds_of(plan: StudyPlan, run: Run) -> float:
    """Estimated seconds of one core for one point of ``run``."""
    engine_speed, model, spring_set = run
    speeds: tuple[float, ...] = (engine_speed,) if engine_speed is not None else ()
    if not speeds and plan.wanted.motion:  # the engine speed is varied: the slowest takes longest
        ends = [
            one.distribution.at([0.01, 0.99]) for one in plan.varied if one.key == "engine_speed"
        ]
        speeds = tuple(float(np.min(one)) for one in ends)
    asked = RunRequest(
        "run",
        plan.case,
        speeds,
        tuple(filter(None, (model,))),
        tuple(filter(None, (spring_set,))),
        1,
    )
    found = request_cost(asked, whole=not plan.wanted.light).seconds if speeds else 0.0
    springs = max(1, len(plan.case.springs))
    if speeds and plan.case.train is None and plan.wanted.light:
        found -= REST * springs
    by_rod = plan.wanted.rest and not plan.wanted.rest_model and not plan.wanted.sizes_alone
    return (
        max(found, 0.0)
        + AROUND
        + (0.6 * springs if by_rod and (not speeds or plan.wanted.light) else 0.0)
    )


def run_points(
    plan: StudyPlan,
    executor: Executor,
    folder: Path | None = None,
    limits: Limits = Limits(),
    progress: Progress | None = None,
    told: Callable[[str], None] | None = None,
) -> StudyTable:
    """The table of a plan; points that the store in ``folder`` holds are not computed again.

    ``told``: the estimate in words, before the start. Raises :class:`InputError` for a request
    beyond ``limits`` and where every point of
    the middle of the distributions is refused, :class:`PointsInterrupted` with the table when it is
    stopped.
    """
    begun, estimate = time.perf_counter(), estimate_study(plan, executor.workers)
    words = refuse_cost(estimate.cost, limits)
    if told is not None:
        told(f"{estimate.points} points, {words}")
    store = PointStore(folder, plan.wanted.outputs)
    try:
        return _Engine(plan, executor, store, estimate, progress, begun).run()
    finally:
        store.close()


class _Engine:
    """One study while it goes on."""

    def __init__(
        self,
        plan: StudyPlan,
        executor: Executor,
        store: PointStore,
        estimate: Estimate,
        progress: Progress | None,
        begun: float,
    ) -> None:
        self.plan, self.executor, self.store, self.estimate, self.progress, self.begun = (
            plan,
            executor,
            store,
            estimate,
            progress,
            begun,
        )
        self.computed, self.found_there, self.stopped = 0, 0, False
        self.together = 1 if estimate.seconds_each > SHORT else TOGETHER

    def run(self) -> StudyTable:
        plan = self.plan
        draws = plan.sampler.first(plan.varied, plan.options)
        if not len(draws):
            raise InputError("the sampler gives no point; ask for more", "points")
        try:
            new = draws
            while len(new):
                self._compute(new)
                new = plan.sampler.more(plan.varied, plan.options, draws, self._first_output(draws))
                draws = np.concatenate([draws, new])
        except KeyboardInterrupt:
            self.stopped = True
        table = self._table(draws)
        if self.stopped:
            raise PointsInterrupted(table)
        return table

    def _compute(self, draws: Array) -> None:
        """All rows of ``draws`` that the store lacks, a bounded number at a time."""
        waiting: list[tuple[bytes, tuple[float, ...], int]] = []
        places = {run: place for place, run in enumerate(self.plan.runs)}
        seen: set[bytes] = set()
        for values, run in self.plan.rows(draws):
            key = self.plan.digest(values, run)
            if key in self.store:
                self.found_there += 1
            elif key not in seen:
                seen.add(key)
                waiting.append((key, tuple(map(float, values)), places[run]))
            if len(waiting) >= JOBS * self.together:
                self._submit(waiting)
                waiting, seen = [], set()
        self._submit(waiting)

    def _submit(self, waiting: Sequence[tuple[bytes, tuple[float, ...], int]]) -> None:
        together = max(
            1, min(self.together, math.ceil(len(waiting) / max(1, self.executor.workers)))
        )
        groups = [waiting[first : first + together] for first in range(0, len(waiting), together)]
        jobs = [[(values, run) for _, values, run in group] for group in groups]
        for place, result in self.executor.run(evaluate_group, self.plan, jobs):
            lost = Outcome(Status("worker-lost", LOST, remedy=LOST_REMEDY))
            outcomes = [lost] * len(groups[place]) if isinstance(result, Lost) else result
            for (key, _, _), outcome in zip(groups[place], outcomes, strict=True):
                self.store.add(key, outcome)
            self._tell(len(outcomes))

    def _tell(self, done: int) -> None:
        self.computed += done
        if self.progress is not None:
            reached, total = self.computed + self.found_there, max(self.estimate.points, 1)
            self.progress(min(1.0, reached / total), f"{reached} of {total} points")

    def _first_output(self, draws: Array) -> Array:
        """The first output of every draw by the first run, nan where there is none."""
        run = self.plan.runs[0]
        return np.array([self.store.row(self.plan.digest(values, run))[0] for values in draws])

    def _table(self, draws: Array) -> StudyTable:
        inputs, runs, values, statuses = [], [], [], []
        nothing = np.full(len(self.plan.wanted.outputs), np.nan)
        for row, run in self.plan.rows(draws):
            key = self.plan.digest(row, run)
            there = key in self.store
            inputs.append(row)
            runs.append(run)
            values.append(self.store.row(key) if there else nothing)
            statuses.append(self.store.status(key) if there else INTERRUPTED)
        seconds = time.perf_counter() - self.begun
        return StudyTable(
            self.plan,
            np.array(inputs),
            tuple(runs),
            np.array(values),
            tuple(statuses),
            computed=self.computed,
            seconds=seconds,
        )


def evaluate_group(plan: StudyPlan, jobs: Sequence[tuple[tuple[float, ...], int]]) -> list[Any]:
    """Outcomes of a few points of a plan, in a worker."""
    return [evaluate(plan.point(values, plan.runs[run])) for values, run in jobs]
