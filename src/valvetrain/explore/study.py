"""``valvetrain.study``: a study file, or an experiment with a sampler, to a table of points."""

from __future__ import annotations

import itertools
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from pydantic import Field

from valvetrain.explore.engine import Array, Engine, Evaluation, Interrupted, PointJob
from valvetrain.explore.execution import Execution, Watch, silent
from valvetrain.explore.files import (
    MAX_VARIED,
    CaseModel,
    FileText,
    Limit,
    Names,
    RunsModel,
    VaryModel,
)
from valvetrain.explore.limit_speed import CLOSER, LimitEvaluation
from valvetrain.explore.outputs import Outcome, Outputs, Run
from valvetrain.explore.refusals import refuse_limits, refuse_missing, refuse_outputs
from valvetrain.explore.samplers import SamplerSpec, sampler, sensitivity_of
from valvetrain.explore.space import ENGINE_SPEED, Space, Values
from valvetrain.explore.table import StudyPlan, StudyTable
from valvetrain.runs.cluster import on_cluster
from valvetrain.runs.cost import Cost, request_cost
from valvetrain.runs.stopping import shows_progress
from valvetrain.runs.workers import Progress, workers_here
from valvetrain.solution.status import COMPLETED, Status

#: Seconds of one point below which :data:`TOGETHER` points form a job.
SHORT, TOGETHER = 0.15, 8
#: Seconds around a point: building the case, sending it and its outcome.
AROUND = 0.012
#: Bytes of a stored point, in addition to 8 for each of its numbers.
STORED = 400.0
#: Limit speeds of a file: more are taken for a mistake.
MAX_LIMITS = 16
INTERRUPTED = Status(
    "interrupted",
    "the study was stopped before this point was finished",
    remedy="start it again to continue",
)


@dataclass(frozen=True, slots=True)
class Estimate:
    """Estimated cost of a study: its points, time and memory of all, seconds of each. The search for a
    limit speed is one of the points.
    """

    points: int
    cost: Cost
    seconds_each: float


@shows_progress("study")
def run_experiment(
    experiment: Evaluation,
    sampler: SamplerSpec,
    options: Mapping[str, Any],
    *,
    progress: Progress | None = None,
    **execution: Any,
) -> StudyTable:
    """The table of an experiment by a sampler; see the verbs of :class:`valvetrain.Experiment`."""
    plan = StudyPlan(experiment, sampler, sampler.read_options(dict(options)))
    plan = replace(plan, title=f"{plan.case_name}: {sampler.shown_name}")
    return run_plan(plan, Execution.read(execution), Watch(progress or silent))


def run_plan(
    plan: StudyPlan, execution: Execution = Execution(), watch: Watch = Watch()
) -> StudyTable:
    """The table of a plan, by a sampler for them with Sobol indices. Points that are stored are not computed again.

    Raises :class:`InputError` for a request beyond its limit, :class:`Interrupted` with the
    table when it is stopped.
    """
    begun = time.perf_counter()
    with on_cluster(execution.dask, execution.workers) as count:
        estimate = estimate_study(plan, count)
        watch.admit(estimate.cost, execution.limit, f"{estimate.points} points")
        draws, searches = plan.draws(), searches_of(plan.experiment)

        def finished() -> None:
            total, reached = max(estimate.points, 1), engine.computed + engine.read
            watch.report(min(1.0, reached / total), f"{reached} of {total} points")

        together = 1 if estimate.seconds_each > SHORT else TOGETHER
        computations = (plan.experiment, *searches)
        with Engine(computations, count, execution.output, together, finished) as engine:
            stopped = False
            try:
                refuse_missing(engine, searches)
                engine.compute(
                    job
                    for row, run in plan.experiment.rows(draws)
                    for job in _jobs(plan, searches, row, run)
                )
            except KeyboardInterrupt:
                stopped = True
            table = _table(plan, engine, searches, draws)
    table = replace(table, seconds=time.perf_counter() - begun)
    if stopped:
        raise Interrupted(table)
    return analysed(table)


def _jobs(
    plan: StudyPlan, searches: Sequence[LimitEvaluation], row: Array, run: Run
) -> list[PointJob]:
    """What a row of the table is computed by: its run, and the search for each limit speed."""
    values, experiment = tuple(row.tolist()), plan.experiment
    own = [(experiment, values, run)] if experiment.outputs.quantities else []
    return [*own, *((search, values, run._replace(engine_speed=None)) for search in searches)]


def _table(
    plan: StudyPlan, engine: Engine, searches: Sequence[LimitEvaluation], draws: Array
) -> StudyTable:
    values = np.full((len(draws) * len(plan.runs), len(plan.outputs)), np.nan)
    statuses: list[Status] = []
    for place, (row, run) in enumerate(plan.experiment.rows(draws)):
        status = COMPLETED
        for evaluation, point, at in _jobs(plan, searches, row, run):
            key = evaluation.digest(point, at)
            outcome = engine.store.outcome(key) if key in engine.store else Outcome(INTERRUPTED)
            status = outcome.status if status.completed else status
            for name in outcome.values.keys() & set(plan.outputs):
                values[place, plan.outputs.index(name)] = outcome.values[name]
        statuses.append(status)
    inputs = np.repeat(draws, len(plan.runs), axis=0)
    return StudyTable(
        plan, inputs, plan.runs * len(draws), values, tuple(statuses), computed=engine.computed
    )


def searches_of(experiment: Evaluation) -> tuple[LimitEvaluation, ...]:
    """The searches for the limit speeds of an experiment."""
    return tuple(LimitEvaluation(experiment, one) for one in experiment.outputs.limit_speeds)


def analysed(table: StudyTable) -> StudyTable:
    """The table with Sobol indices, where its sampler is one for them."""
    plan = table.plan
    if plan.sampler.word != "saltelli":
        return table
    names = [one.shown_name for one in plan.varied]
    indices = [
        sensitivity_of(name, run, names, np.where(table.completed, table.column(name), np.nan)[table.rows_of(run)])
        for run, name in itertools.product(plan.runs, table.outputs)
    ]  # fmt: skip
    return replace(table, sensitivities=tuple(filter(None, indices)))


def estimate_study(plan: StudyPlan, workers: int) -> Estimate:
    """Estimated cost of a plan, from its request alone; of a limit speed with its whole grid and
    the speeds between.
    """
    draws, experiment = len(plan.draws()), plan.experiment
    refuse_outputs(experiment)
    refuse_limits(experiment)
    seconds = [seconds_of(experiment, run) for run in plan.runs if experiment.outputs.quantities]
    for search, kind in itertools.product(
        searches_of(experiment), dict.fromkeys(run[1:] for run in plan.runs)
    ):
        speeds = search.limit.engine_speeds
        grid = sum(seconds_of(search, Run(speed, *kind)) for speed in speeds)
        seconds.append(grid * (1 + CLOSER / len(speeds)))
    points, numbers = draws * len(seconds), len(plan.varied) + len(plan.outputs)
    memory = points * (STORED + 8.0 * numbers) + 3e7 * workers_here(workers)
    cost = Cost(draws * sum(seconds) / max(1, workers), memory)
    return Estimate(points, cost, sum(seconds) / len(seconds))


def seconds_of(plan: Evaluation, run: Run) -> float:
    """Estimated seconds of one core for one point of ``run``."""
    if plan.case is None:
        return AROUND
    request, springs = plan.outputs.request, max(1, len(plan.case.springs))
    engine_speed = run.engine_speed
    if engine_speed is None and request.motion:  # it is varied: the slowest takes longest
        varied = [one for one in plan.space if one.key == ENGINE_SPEED]
        engine_speed = min(
            (float(np.min(one.distribution.at([0.01, 0.99]))) for one in varied), default=None
        )
    seconds = 0.0
    if engine_speed is not None:
        single = run._replace(engine_speed=engine_speed).request(plan.case)
        seconds = request_cost(single, whole=not request.light).seconds
    by_rod = request.rest and not request.rest_model and not request.sizes_alone
    if by_rod and (engine_speed is None or request.light):
        seconds += 0.6 * springs
    return seconds + AROUND


class StudyModel(CaseModel, RunsModel):
    """The whole file; ``points`` holds the sampler, and its options, which it checks itself."""

    what = "study file"
    outputs: Names = Field(default_factory=list)
    limit_speed: list[Limit] = Field(default_factory=list, max_length=MAX_LIMITS)
    points: dict[str, Any] = Field(default_factory=dict)
    vary: list[VaryModel] = Field(min_length=1, max_length=MAX_VARIED)


def _default_sampler(text: FileText[StudyModel], space: Space) -> str:
    """The sampler of a file that names none: values listed one by one are run as they are listed,
    unless draws are counted. Raises :class:`InputError` where they can be combined in two ways.
    """
    listed = all(isinstance(one.distribution, Values) for one in space)
    if not listed or text.model.points:
        return "sobol"
    if len(space) == 1:
        return "list"
    raise text.located(
        ("vary",),
        "several quantities list values and no sampler says how they meet; give points = "
        '{ sampler = "grid" } for every combination, or "list" for the first of all together, then the second',
    )


def read_plan(text: FileText[StudyModel]) -> StudyPlan:
    """The plan of a study file. Raises :class:`InputError`, one sentence with file, line and key."""
    model, case, space = text.model, text.case, text.space
    given = dict(model.points)
    word = str(given.pop("sampler", "") or _default_sampler(text, space))[:40]
    spec = text.guarded(("points", "sampler"), lambda: sampler(word, ""))
    if isinstance(file := given.get("file"), str):  # of draws, next to this file
        given["file"] = str(text.folder / file)
    options = text.guarded(("points",), lambda: spec.read_options(given))
    outputs = text.guarded(
        ("outputs",),
        lambda: Outputs(
            model.outputs,
            engine_speeds=model.engine_speeds,
            spring_models=model.spring_models,
            spring_set=model.spring_sets,
            rest_model=model.rest_model,
            limit_speeds=model.limit_speed,
        ),
    )
    experiment = text.guarded(("engine_speeds",), lambda: Evaluation(case, space, outputs))
    text.guarded(("outputs",), lambda: refuse_outputs(experiment))
    text.guarded(("limit_speed",), lambda: refuse_limits(experiment))
    title = model.title or f"{case.name}: {spec.shown_name}"
    plan = StudyPlan(experiment, spec, options, title, model.description)
    if spec.word == "posterior":
        text.guarded(("points",), plan.draws)
    return plan
