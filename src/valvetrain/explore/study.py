"""``valvetrain.study``: a study file, or an experiment with a sampler, to a table of points."""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from pydantic import Field

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.explore.distributions import Values
from valvetrain.explore.engine import Engine, Evaluation, Interrupted
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
from valvetrain.explore.limit_speed import CLOSER
from valvetrain.explore.outputs import Outcome, Outputs, Task
from valvetrain.explore.samplers import SamplerSpec, sampler, sensitivity_of
from valvetrain.explore.space import ENGINE_SPEED, Space
from valvetrain.explore.table import StudyPlan, StudyTable
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.registry import OWN, find, names
from valvetrain.runs.cluster import on_cluster
from valvetrain.runs.cost import Cost, planned, request_cost
from valvetrain.runs.stopping import shows_progress
from valvetrain.runs.workers import Progress, workers_here
from valvetrain.solution.definition import NESTED, definition_of, label_of, not_given, of_pair
from valvetrain.solution.status import COMPLETED, Status

#: What a spring model shows -> beginnings of the names of quantities that need it.
NEEDS = {
    "clash": (
        "clash_", "peak_clash_", "surge_clash_", "largest_clash_", "main_clash_",
    ),
    "stress": (
        "peak_shear_stress", "minimum_shear_stress", "peak_equivalent_stress", "largest_amplitude_",
    ),
}  # fmt: skip
#: Stresses of the force by the dimensions of a wire, which every model gives.
BY_WIRE = ("open_nominal_shear", "closed_nominal_shear", "open_uncorrected_shear")
WHAT = {"clash": "coils that meet", "stress": "stress along the wire"}


def refuse_outputs(case: Case | None, tasks: Iterable[Task]) -> None:
    """Raise :class:`InputError` for an output that no task of a case can give.

    >>> import valvetrain as vt
    >>> space = vt.Space({"spring.precompression": vt.Uniform("6 mm", "8 mm")})
    >>> outputs = vt.Outputs("clash_count", engine_speeds="4000 rpm", spring_models="massless")
    >>> refuse_outputs(vt.load_case("job-c"), vt.Experiment("job-c", space, outputs).tasks)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    valvetrain.errors.InputError: the coil contacts (clash_count) cannot be had by massless, which has no coils that meet; ...
    """
    if case is None:
        return
    kind, reasons = "spring" if case.train is None else "train", dict[str, list[str]]()
    for task in tasks:
        (model, *_), springs = planned(task.run.request(case))[0]
        for name in task.request.outputs:
            row = definition_of(name)
            if row.systems and kind not in row.systems:
                raise InputError(f"a {kind} has no {row.label} ({name}); choose another")
            reasons.setdefault(name, []).append(_reason(name, model, springs))
    if refused := next((every for every in reasons.values() if all(every)), None):
        raise InputError(refused[0])


def _reason(name: str, model: str, springs: Sequence[InstalledSpring]) -> str:
    """Why a run does not give a quantity; empty where it may."""
    first, _, rest = name.partition("_")
    own = rest if first in NESTED and len(springs) > 1 else name
    need = next((one for one, starts in NEEDS.items() if own.startswith(starts)), "")
    if not need and not own.startswith(BY_WIRE):
        return ""
    text = f"the {label_of(name)} ({name}) cannot be had"
    cards = [f"'{one.name}'" for one in springs if one.wire is None]
    if len(cards) == len(springs):
        known = "springs {} are" if len(cards) > 1 else "spring {} is"
        return (
            f"{text}: {known.format(' and '.join(cards))} known by card alone, and it needs the wire, "
            "which 'valvetrain spring-card' makes; leave it out"
        )
    # a model given in Python may show coils without saying so
    if need and model not in OWN and need not in find("springs", model).shows:
        able = ", ".join(one for one in names("springs") if need in find("springs", one).shows)
        return f"{text} by {model}, which has no {WHAT[need]}; choose {able}, or leave it out"
    if need == "stress" and own == name and len(springs) > 1:
        return not_given(name, of_pair(name))
    return ""


def refuse_limits(experiment: Evaluation) -> None:
    """Raise :class:`InputError` for a limit speed that no point of the experiment can have."""
    for limit in experiment.outputs.limit_speeds:
        if experiment.case is None:
            raise InputError("a function has no limit speed; give a case")
        if limit.share is not None:
            raise InputError("a bound as a share of the case belongs to a search; give a number")
        if any(one.key == ENGINE_SPEED for one in experiment.space):
            raise InputError(
                "the engine speed is varied, and a limit speed is one; remove one of them"
            )


def refuse_missing(engine: Engine, experiment: Evaluation) -> None:
    """Raise :class:`InputError` where the middle of the space runs at the lowest speed and has not
    the quantity of a limit.
    """
    middle = tuple(one.distribution.middle for one in experiment.space)
    for task in experiment.tasks:
        if task.limit is not None:
            lowest = task.run._replace(engine_speed=task.limit.engine_speeds[0])
            (outcome,) = engine.outcomes([(experiment, middle, Task(lowest, task.request))])
            if outcome.status.completed and task.limit.quantity not in outcome.values:
                by = f" by {lowest.spring_model}" if lowest.spring_model else ""
                raise InputError(
                    f"{not_given(task.limit.quantity, outcome.values)}{by}", "limit_speed"
                )


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
    title, read = f"{experiment.name}: {sampler.shown_name}", sampler.read_options(dict(options))
    plan = StudyPlan(experiment=experiment, title=title, sampler=sampler, options=read)
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
        draws, experiment = plan.draws(), plan.experiment
        cost, total = estimate_study(plan, count), len(draws) * len(experiment.tasks)
        watch.admit(cost, execution.limit, f"{total} points")

        def finished() -> None:
            reached = engine.store.computed + engine.read
            watch.report(min(1.0, reached / total), f"{reached} of {total} points")

        together = 1 if cost.seconds * max(1, count) > SHORT * total else TOGETHER
        with Engine((experiment,), count, execution.output, together, finished) as engine:
            stopped = False
            try:
                refuse_missing(engine, experiment)
                engine.compute(
                    (experiment, tuple(row.tolist()), task)
                    for row in draws
                    for task in experiment.tasks
                )
            except KeyboardInterrupt:
                stopped = True
            table = _table(plan, engine, draws)
    table = replace(table, seconds=time.perf_counter() - begun)
    if stopped:
        raise Interrupted(table)
    return analysed(table)


def _table(plan: StudyPlan, engine: Engine, draws: Array) -> StudyTable:
    experiment, statuses = plan.experiment, list[Status]()
    values = np.full((len(draws) * len(plan.runs), len(plan.outputs)), np.nan)
    for row, run in itertools.product(draws, plan.runs):
        status = COMPLETED
        for task in (one for one in experiment.tasks if one.gives(run)):
            key = experiment.digest(row, task)
            outcome = engine.store.outcome(key) if key in engine.store else Outcome(INTERRUPTED)
            status = outcome.status if status.completed else status
            for name in outcome.values.keys() & set(plan.outputs):
                values[len(statuses), plan.outputs.index(name)] = outcome.values[name]
        statuses.append(status)
    inputs = np.repeat(draws, len(plan.runs), axis=0)
    return StudyTable(
        plan,
        inputs,
        plan.runs * len(draws),
        values,
        tuple(statuses),
        computed=engine.store.computed,
    )


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


def estimate_study(plan: StudyPlan, workers: int) -> Cost:
    """Estimated cost of a plan, from its request alone; of a limit speed with its whole grid and
    the speeds between.
    """
    draws, experiment = len(plan.draws()), plan.experiment
    refuse_limits(experiment)
    refuse_outputs(experiment.case, experiment.tasks)
    seconds = sum(seconds_of(experiment, task) for task in experiment.tasks)
    points, numbers = draws * len(experiment.tasks), len(plan.varied) + len(plan.outputs)
    memory = points * (STORED + 8.0 * numbers) + 3e7 * workers_here(workers)
    return Cost(draws * seconds / max(1, workers), memory)


def seconds_of(experiment: Evaluation, task: Task) -> float:
    """Estimated seconds of one core for a task of one point."""
    run, request, limit = task
    if limit is not None:
        at_speeds = (run._replace(engine_speed=one) for one in limit.engine_speeds)
        grid = sum(seconds_of(experiment, Task(one, request)) for one in at_speeds)
        return grid * (1 + CLOSER / len(limit.engine_speeds))
    if experiment.case is None:
        return AROUND
    if run.engine_speed is None and request.motion:  # it is varied: the slowest takes longest
        varied = [one for one in experiment.space if one.key == ENGINE_SPEED]
        slowest = (float(np.min(one.distribution.at([0.01, 0.99]))) for one in varied)
        run = run._replace(engine_speed=min(slowest, default=None))
    seconds = 0.0
    if run.engine_speed is not None:
        seconds = request_cost(run.request(experiment.case), whole=not request.light).seconds
    by_rod = request.rest and not request.rest_model and not request.sizes_alone
    if by_rod and (run.engine_speed is None or request.light):
        seconds += 0.6 * max(1, len(experiment.case.springs))
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
    text.guarded(("limit_speed",), lambda: refuse_limits(experiment))
    tasks = text.guarded(("engine_speeds",), lambda: experiment.tasks)
    for key, limits in (("outputs", False), ("limit_speed", True)):
        some = [one for one in tasks if (one.limit is not None) == limits]
        text.guarded((key,), lambda some=some: refuse_outputs(case, some))
    title = model.title or f"{case.name}: {spec.shown_name}"
    plan = StudyPlan(experiment=experiment, title=title, description=model.description, sampler=spec, options=options)  # fmt: skip
    if spec.word == "posterior":
        text.guarded(("points",), plan.draws)
    return plan


STEPS = StudyModel, read_plan, run_plan
