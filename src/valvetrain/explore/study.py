"""``valvetrain.study``: a study file, or an experiment with a sampler, to a table of points."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field, model_validator

from valvetrain.explore.engine import Array, Engine, Evaluation
from valvetrain.explore.executors import Executor, LocalExecutor
from valvetrain.explore.files import (
    MAX_VARIED,
    CorrelationModel,
    FileText,
    Names,
    VaryModel,
    case_of_file,
    space_of_file,
    text_of_file,
)
from valvetrain.explore.limit_speed import CLOSER
from valvetrain.explore.optimum_file import LimitSpeedModel
from valvetrain.explore.outputs import LimitSearch, Outputs, Run, limit_search, refuse_limit_name
from valvetrain.explore.samplers import SamplerSpec, sampler
from valvetrain.explore.sensitivity import sensitivity_of
from valvetrain.explore.space import Space, Values
from valvetrain.explore.study_limits import (
    LimitColumns,
    LimitColumnsSearch,
    limit_runs,
    refuse_limits,
)
from valvetrain.explore.surrogate import surrogate_of
from valvetrain.explore.table import StudyPlan, StudyTable
from valvetrain.explore.unavailable import refuse_outputs
from valvetrain.parameters.schema_types import Line, StrictModel, problem
from valvetrain.registry import find
from valvetrain.runs.cluster import on_cluster
from valvetrain.runs.cost import Cost, Limits, limits_of, refuse_cost
from valvetrain.runs.request_cost import REST, RunRequest, request_cost
from valvetrain.runs.stopping import Stopped
from valvetrain.runs.watch import shows_progress
from valvetrain.runs.workers import Progress, workers_here
from valvetrain.solution.definition import is_defined, no_quantity
from valvetrain.solution.status import COMPLETED, Status
from valvetrain.units import known_arguments, si_speeds

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


class PointsInterrupted(Stopped):
    """A study was stopped; ``table`` holds all rows, unfinished ones as ``interrupted``."""

    def __init__(self, table: StudyTable) -> None:
        super().__init__("stopped")
        self.table = table


@dataclass(frozen=True, slots=True)
class Estimate:
    """Estimated cost of a study: runs, time and memory of all, seconds of one; ``searches`` for limit
    speeds among them, whose runs are counted at most.
    """

    points: int
    cost: Cost
    seconds_each: float
    searches: int = 0

    @property
    def sentence(self) -> str:
        """What will be computed."""
        if not self.searches:
            return f"{self.points} points"
        return f"{self.points} runs at most, {self.searches} searches for limit speeds with them"


@known_arguments
@shows_progress("study")
def study(
    file: str | os.PathLike[str],
    *,
    workers: int | None = None,
    dask: str = "",
    output: str | os.PathLike[str] | None = None,
    limit: str = "",
    progress: Progress | None = None,
) -> StudyTable:
    """Points of a study over any quantities of a case: how outputs scatter, what makes them
    scatter, what values between the points are.

    Parameters
    ----------
    file : path of a study file (docs/studies.md), or its text
    workers : points at a time; results do not depend on it
    dask : "local", the address of a Dask scheduler or the name of a queue ("slurm", "pbs"); empty
        for processes of this machine
    output : folder of the finished points, where a study that was stopped or killed continues;
        none by default
    limit : largest estimated time and memory, such as "2 h, 8 GB"; 10 min and 2 GB by default
    progress : called with the share done and a text

    Returns
    -------
    StudyTable with a row per point: inputs (n, d) and outputs (n, m) in SI, their status, Sobol
    indices and surrogates where requested

    Raises
    ------
    InputError : one sentence on what is wrong in the file and where, or on a request that is too
        large
    MissingExtraError : Dask or scikit-learn is needed and not installed

    Examples
    --------
    >>> import valvetrain as vt
    >>> table = vt.study('''
    ... case = "job-c"
    ... engine_speeds = "4000 rpm"
    ... spring_models = "massless"
    ... outputs = "peak_spring_force"
    ... points = { sampler = "list" }
    ... vary = [{ key = "spring.precompression", values = "6, 8 mm" }]
    ... ''', workers=1)
    >>> bool(table.column("peak_spring_force")[1] > table.column("peak_spring_force")[0])
    True
    """
    if isinstance(file, str) and "=" in file and "\n" in file:
        text = StudyText(file, "study", Path())
    else:
        text = read_study_file(Path(file))
    return run_plan(read_plan(text), workers, dask, output, limits_of(limit), progress)


@known_arguments
@shows_progress("study")
def run_experiment(
    experiment: Evaluation,
    sampler: SamplerSpec,
    kind: str,
    options: Mapping[str, Any],
    *,
    workers: int | None = None,
    dask: str = "",
    output: str | os.PathLike[str] | None = None,
    limit: str = "",
    progress: Progress | None = None,
) -> StudyTable:
    """The table of an experiment by a sampler; see the verbs of :class:`valvetrain.Experiment`."""
    plan = StudyPlan(experiment, sampler, sampler.read_options(dict(options)), kind=kind)
    plan = replace(plan, title=f"{plan.case_name}: {sampler.shown_name}")
    return run_plan(plan, workers, dask, output, limits_of(limit), progress)


def run_plan(
    plan: StudyPlan,
    workers: int | None = None,
    dask: str = "",
    folder: str | os.PathLike[str] | None = None,
    limits: Limits = Limits(),
    progress: Progress | None = None,
) -> StudyTable:
    """The table of a plan with what its kind adds: Sobol indices, surrogates."""
    place = None if folder is None else Path(folder)
    with on_cluster(dask, workers) as count:
        return analysed(run_points(plan, LocalExecutor(count), place, limits, progress))


def run_points(
    plan: StudyPlan,
    executor: Executor,
    folder: Path | None = None,
    limits: Limits = Limits(),
    progress: Progress | None = None,
) -> StudyTable:
    """The table of a plan; points that the store in ``folder`` holds are not computed again. The
    executor is closed at the end.

    Raises :class:`InputError` for a request beyond ``limits``, :class:`PointsInterrupted` with the
    table when it is stopped.
    """
    begun = time.perf_counter()
    try:
        estimate = estimate_study(plan, executor.workers)
        refuse_cost(estimate.cost, limits)
        draws = plan.draws()
    except BaseException:
        executor.close()
        raise
    experiment, total = plan.experiment, max(estimate.points, 1)

    def finished() -> None:
        if progress is not None:
            reached = engine.computed + engine.read
            progress(min(1.0, reached / total), f"{reached} of {total} points")

    together = 1 if estimate.seconds_each > SHORT else TOGETHER
    with Engine((experiment,), executor, folder, together, finished) as engine:
        stopped, limits_found = False, None
        try:
            search = LimitColumnsSearch(engine, experiment)
            search.probe()
            new = draws if experiment.outputs.quantities else draws[:0]
            while len(new):
                engine.compute(
                    (experiment, tuple(row.tolist()), run) for row, run in experiment.rows(new)
                )
                first = _column(engine, experiment, draws)
                new = plan.sampler.more(plan.varied, plan.options, draws, first)
                draws = np.concatenate([draws, new])
            limits_found = search.columns(draws)
        except KeyboardInterrupt:
            stopped = True
        table = _table(plan, engine, draws, limits_found)
        table = replace(table, seconds=time.perf_counter() - begun)
    if stopped:
        raise PointsInterrupted(table)
    return table


def _column(engine: Engine, experiment: Evaluation, draws: Array) -> Array:
    """The first output of every draw by the first run, nan where there is none."""
    run, names = experiment.runs[0], experiment.outputs.quantities
    if not names:
        return np.full(len(draws), np.nan)
    outcomes = (engine.store.outcome(experiment.digest(row, run)) for row in draws)
    return np.array([one.values.get(names[0], np.nan) for one in outcomes])


def _table(
    plan: StudyPlan, engine: Engine, draws: Array, limits: LimitColumns | None
) -> StudyTable:
    experiment, count = plan.experiment, len(plan.runs)
    names = experiment.outputs.quantities
    values = np.full((len(draws) * count, len(plan.outputs)), np.nan)
    statuses: list[Status] = []
    if limits is not None:
        values[:, len(names) :] = limits.values.reshape(len(values), -1)
    for row, (draw, run) in enumerate(experiment.rows(draws)):
        failure = None if limits is None else limits.failures.get(divmod(row, count))
        if not names:
            statuses.append(INTERRUPTED if limits is None else failure or COMPLETED)
            continue
        key = experiment.digest(draw, run)
        if key not in engine.store:
            statuses.append(INTERRUPTED)
            continue
        outcome = engine.store.outcome(key)
        values[row, : len(names)] = [outcome.values.get(name, np.nan) for name in names]
        statuses.append(failure if failure and outcome.status.completed else outcome.status)
    inputs = np.repeat(draws, len(plan.runs), axis=0)
    runs = plan.runs * len(draws)
    ends = () if limits is None else limits.ends
    return StudyTable(
        plan, inputs, runs, values, tuple(statuses), computed=engine.computed, limit_ends=ends
    )


def analysed(table: StudyTable) -> StudyTable:
    """The table with what its kind adds: Sobol indices, surrogates."""
    plan = table.plan
    pairs = [(run, table.rows_of(run), name) for run in plan.runs for name in table.outputs]
    names = [one.shown_name for one in plan.varied]
    if plan.kind == "tolerance":
        indices = [
            sensitivity_of(name, run, names, _completed(table, name)[rows])
            for run, rows, name in pairs
        ]
        return replace(table, sensitivities=tuple(one for one in indices if one is not None))
    if plan.kind == "surrogate":
        fits = [
            surrogate_of(name, run, names, table.inputs[rows], _completed(table, name)[rows])
            for run, rows, name in pairs
        ]
        return replace(table, surrogates=tuple(one for one in fits if one is not None))
    return table


def _completed(table: StudyTable, name: str) -> Array:
    """An output with nan where the point did not complete."""
    return np.where(table.completed, table.column(name), np.nan)


def estimate_study(plan: StudyPlan, workers: int) -> Estimate:
    """Estimated cost of a plan, from its request alone; of an adaptive one at its bound."""
    draws = len(plan.draws())
    if plan.sampler.more.__name__ != "no_more":
        draws = max(draws, int(getattr(plan.options, "count", draws)))
    experiment = plan.experiment
    refuse_outputs(experiment)
    refuse_limits(experiment)
    runs = plan.runs if experiment.outputs.quantities else ()
    seconds = [seconds_of(experiment, run) for run in runs]
    numbers = len(plan.varied) + len(plan.outputs)
    searched = limit_runs(experiment)
    seconds += [_seconds_of_limit(experiment, one) for one in experiment.outputs.limit_speeds]
    points = draws * (len(runs) + searched)
    memory = points * (STORED + 8.0 * numbers) + 3e7 * workers_here(workers)
    time_needed = draws * sum(seconds) / max(1, workers)
    each = sum(seconds) / (len(runs) + searched)
    searches = draws * len(experiment.outputs.limit_speeds)
    return Estimate(points, Cost(time_needed, memory), each, searches)


def _seconds_of_limit(experiment: Evaluation, limit: LimitSearch) -> float:
    """Estimated seconds of one core for a limit speed of one draw, by every model, at most: its whole grid
    and the speeds between.
    """
    outputs = experiment.outputs.of(limit.quantity)
    own = Evaluation(experiment.case, experiment.space, outputs, experiment.runs)
    speeds = limit.engine_speeds
    kinds = dict.fromkeys(run[1:] for run in experiment.runs)
    grid = sum(seconds_of(own, (speed, *kind)) for kind in kinds for speed in speeds)
    return grid * (1 + CLOSER / len(speeds))


def seconds_of(plan: Evaluation, run: Run) -> float:
    """Estimated seconds of one core for one point of ``run``."""
    if plan.case is None:
        return AROUND
    request = plan.outputs.request
    engine_speed, model, spring_set = run
    speeds: tuple[float, ...] = (engine_speed,) if engine_speed is not None else ()
    if not speeds and request.motion:  # the engine speed is varied: the slowest takes longest
        ends = [
            one.distribution.at([0.01, 0.99]) for one in plan.space if one.key == "engine_speed"
        ]
        speeds = tuple(float(np.min(one)) for one in ends)
    single = RunRequest(
        "run",
        plan.case,
        speeds,
        tuple(filter(None, (model,))),
        tuple(filter(None, (spring_set,))),
        1,
    )
    found = request_cost(single, whole=not request.light).seconds if speeds else 0.0
    springs = max(1, len(plan.case.springs))
    if speeds and plan.case.train is None and request.light:
        found -= REST * springs
    by_rod = request.rest and not request.rest_model and not request.sizes_alone
    return (
        max(found, 0.0)
        + AROUND
        + (0.6 * springs if by_rod and (not speeds or request.light) else 0.0)
    )


#: What is computed from the points in addition to their own numbers.
Kind = Literal["points", "tolerance", "surrogate"]


class PointsModel(StrictModel):
    """The ``[points]`` table: the sampler, and its options, which it checks itself."""

    sampler: str = ""

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, raw: Any) -> Any:
        if not isinstance(raw, dict):
            raise problem("a table with sampler and its options is needed here")
        return {key: value for key, value in raw.items() if key == "sampler"}


class StudyModel(StrictModel):
    """The whole file."""

    kind: Kind = "points"
    title: Line = ""
    description: Line = ""
    case: str
    changes: dict[str, Any] = Field(default_factory=dict)
    engine_speeds: str | list[Any] | None = None
    spring_models: Names = Field(default_factory=list)
    spring_sets: Names = Field(default_factory=list)
    outputs: Names = Field(default_factory=list)
    limit_speed: list[LimitSpeedModel] = Field(default_factory=list, max_length=MAX_LIMITS)
    rest_model: str = ""
    points: PointsModel = PointsModel()
    vary: list[VaryModel] = Field(min_length=1, max_length=MAX_VARIED)
    correlation: list[CorrelationModel] = Field(default_factory=list, max_length=MAX_VARIED)


class StudyText(FileText[StudyModel]):
    """A study file read, with the options of its sampler."""

    def __init__(self, text: str, where: str, folder: Path) -> None:
        super().__init__(text, where, folder, StudyModel, "study file")
        points = self.tree.get("points", {})
        self.sampler_options = {key: value for key, value in points.items() if key != "sampler"}


def read_study_file(path: Path) -> StudyText:
    """The study file at ``path``. Raises :class:`InputError`, one sentence with file, line and key."""
    return StudyText(text_of_file(path, "study file"), path.name[:60], path.parent)


def _default_sampler(text: StudyText, space: Space) -> str:
    """The sampler of a file that names none: values listed one by one are run as they are listed,
    unless draws are counted. Raises :class:`InputError` where they can be combined in two ways.
    """
    listed = all(isinstance(one.distribution, Values) for one in space)
    if not listed or text.sampler_options or space.correlation is not None:
        return "sobol"
    if len(space) == 1:
        return "list"
    raise text.located(
        ("vary",),
        "several quantities list values and no sampler says how they meet; give points = "
        '{ sampler = "grid" } for every combination, or "list" for the first of all together, then the second',
    )


def read_plan(text: StudyText) -> StudyPlan:
    """The plan of a study file. Raises :class:`InputError`, one sentence with file, line and key."""
    model = text.model
    case = text.guarded(("case",), lambda: case_of_file(model.case, model.changes, text.folder))
    space = space_of_file(text, model.vary, case, model.correlation)
    word = model.points.sampler or _default_sampler(text, space)
    spec = text.guarded(("points", "sampler"), lambda: sampler(word, ""))
    given = dict(text.sampler_options)
    if isinstance(file := given.get("file"), str):  # of draws, next to this file
        given["file"] = str(text.folder / file)
    options = text.guarded(("points",), lambda: spec.read_options(given))
    if model.kind == "tolerance" and spec.word != "saltelli":
        raise text.located(
            ("points", "sampler"),
            "a study of kind 'tolerance' needs the sampler saltelli; choose it",
        )
    for index, name in enumerate(model.outputs):
        if not is_defined(name):
            raise text.located(("outputs", index), no_quantity(name))
        text.guarded(("outputs", index), lambda name=name: refuse_limit_name(name))
    if not model.outputs and not model.limit_speed:
        raise text.located(
            ("outputs",), "names no quantity; name one or more of docs/quantities.md"
        )
    for key, word in (
        ("rest_model", model.rest_model),
        *(("spring_models", one) for one in model.spring_models),
    ):
        if word:
            text.guarded((key,), lambda word=word: find("springs", word))
    limits = [
        text.guarded(("limit_speed", index), lambda one=one: limit_search(**one.model_dump()))
        for index, one in enumerate(model.limit_speed)
    ]
    speeds = model.engine_speeds
    experiment = text.guarded(
        ("engine_speeds",),
        lambda: Evaluation(
            case,
            space,
            Outputs(
                model.outputs,
                engine_speeds=None if speeds is None else si_speeds(speeds),
                spring_models=model.spring_models,
                spring_set=model.spring_sets,
                rest_model=model.rest_model,
                limit_speeds=limits,
            ),
        ),
    )
    text.guarded(("outputs",), lambda: refuse_outputs(experiment))
    text.guarded(("limit_speed",), lambda: refuse_limits(experiment))
    title = model.title or f"{case.name}: {spec.shown_name}"
    plan = StudyPlan(experiment, spec, options, title, model.kind, model.description)
    if space.correlation is not None or spec.word == "posterior":
        text.guarded(("points",), plan.draws)
    return plan
