"""Studies in time: a case at its engine speeds and models (:func:`run_study`), and over engine
speed (:func:`sweep_study`).
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from valvetrain.errors import RunFailedError
from valvetrain.integrate.contract import Keep
from valvetrain.measured.speed_table import read_speed_table
from valvetrain.runs.critical_speeds import find_critical_speeds
from valvetrain.runs.facts import run_between, study_facts, with_facts
from valvetrain.runs.own_error_bars import own_error_bars
from valvetrain.runs.prepared import Plan, PreparedRun
from valvetrain.runs.refusals import refuse_implausible, refuse_speeds
from valvetrain.runs.requests import SpeedRequest, Sweep, Watch
from valvetrain.runs.spring_runs import numbers_at_rest, run_springs
from valvetrain.runs.stopping import PointsStopped, StudyStopped
from valvetrain.runs.stored_error_bars import (
    load_uncertainty,
    spread_facts,
    stored_rows,
    with_blind,
)
from valvetrain.runs.train_runs import (
    Finished,
    preloads,
    prepare_trains,
    rigid_numbers,
    run_trains,
)
from valvetrain.runs.workers import (
    Progress,
)
from valvetrain.solution.critical import CriticalSpeeds
from valvetrain.solution.provenance import collect_provenance
from valvetrain.solution.quantity import same_speed
from valvetrain.solution.result import Solution
from valvetrain.solution.status import PartialFailures, reason
from valvetrain.solution.study import INTERRUPTED, Study
from valvetrain.solution.uncertainty import ErrorBars
from valvetrain.sources.contract import against_source, published_by
from valvetrain.system.build import build
from valvetrain.system.contract import TRAIN
from valvetrain.system.problem import Problem, Rest

#: Time of the search for critical speeds, and of the further runs for error bars, over that of the runs themselves.
SEARCH_SHARE, BAR_SHARE = 1.0, 2.25


def run_study(request: SpeedRequest, watch: Watch = Watch()) -> Study:
    """A case at its engine speeds, or at given ones, by its variants or by given models and spring sets.

    Results do not depend on the workers. Raises :class:`InputError` for what cannot be built, for a speed that is not
    positive and when no model can run; a run that fails is a status.
    """
    problem = build(request.case, spring_models=request.models, spring_set=request.spring_sets)
    speeds = request.engine_speeds
    speeds = problem.engine_speeds if speeds is None else speeds
    study = run_problem(problem, speeds, request, watch)
    return study if request.requested is None else request.requested.of_study(study)


def sweep_study(request: Sweep, watch: Watch = Watch()) -> Study:
    """A case over engine speed: solutions, reduced unless channels are requested, and the critical speeds of a train between
    the lowest and the highest speed.

    By default the spring set that a train names, every one where it names none, each by its own
    model; a spring alone by its default models. Raises :class:`InputError` for what cannot be built.
    """
    measured = None if request.measured is None else read_speed_table(request.measured)
    case, speeds = request.case, tuple(sorted(request.with_speeds().engine_speeds or ()))
    sets = request.spring_sets or (case.train.swept_sets if case.train is not None else ())
    problem = build(case, spring_models=request.models, spring_set=sets)
    try:
        study = _with_critical(run_problem(problem, speeds, request, watch))
    except StudyStopped as stop:
        raise StudyStopped(_with_critical(stop.study)) from None
    study = replace(study, measured=measured)
    return study if request.requested is None else request.requested.of_study(study)


def _with_critical(study: Study) -> Study:
    """The study with its critical speeds among the numbers of no single run."""
    if not study.critical_speeds.labels:
        return study
    still = {**study.still}
    for label in study.critical_speeds.labels:
        still[label] = {**still.get(label, {}), **study.critical_speeds.quantities(label)}
    return replace(study, still=still)


@dataclass(frozen=True)
class _Work:
    """What the runs of a study share: the problem and its speeds (rad/s of the crank), the request and how its runs are made,
    and where failures, progress (from 0 to 1 over the runs) and finished runs go.
    """

    problem: Problem
    engine_speeds: tuple[float, ...]
    request: SpeedRequest
    plan: Plan
    tell: Progress
    failures: PartialFailures
    finished: Finished | None

    @property
    def searches(self) -> bool:
        """Whether critical speeds are searched for."""
        return self.problem.kind == TRAIN and self.request.critical_options is not None


@dataclass(frozen=True)
class _Computed:
    """Finished runs, springs at rest, numbers of no single run, and of a train runs between the speeds and critical speeds;
    ``stopped``: before all was finished.
    """

    solutions: tuple[Solution, ...]
    at_rest: Rest
    still: dict[str, dict[str, float]]
    between: tuple[Solution, ...] = ()
    critical: CriticalSpeeds = field(default_factory=CriticalSpeeds)
    stopped: bool = False


def run_problem(
    problem: Problem,
    engine_speeds: Sequence[float],
    request: SpeedRequest,
    watch: Watch = Watch(),
) -> Study:
    """The study of a problem at ``engine_speeds`` (rad/s of the crank), as a request wants it computed.

    Raises :class:`StudyStopped`, a KeyboardInterrupt, with what is finished when it is stopped.
    """
    begun, failures = time.perf_counter(), PartialFailures()
    problem, speeds = problem.settled(), tuple(float(speed) for speed in engine_speeds)
    refuse_speeds(problem, speeds)
    problem.must_run()
    if not request.implausible:
        refuse_implausible(problem, speeds)
    searches = problem.kind == TRAIN and request.critical_options is not None
    before_bars = 1.0 + SEARCH_SHARE * searches
    whole_time = before_bars + BAR_SHARE * bool(request.compute)
    progress = watch.progress
    tell: Progress = (
        (lambda time, text: progress(time / whole_time, text)) if progress else (lambda *_: None)
    )
    requested = request.requested
    samples: int | None = round(2 * np.pi / problem.output_step)
    whole = request.whole or (requested is not None and bool(requested.channels))
    keep: Keep = "all" if whole else "contacts"
    if problem.kind == TRAIN:
        samples = 720 if isinstance(request, Sweep) else None
        keep = "all" if whole else "ends"
    elif requested is not None and requested.ends_alone:
        keep = "ends"
    plan = Plan(
        keep,
        samples,
        whole,
        problem.cycles,
        problem.cycles_to_settle,
        watch.created_at,
        request.limit.seconds,
        request.implausible,
    )
    work = _Work(problem, speeds, request, plan, tell, failures, watch.finished)
    computed = _run_trains(work) if problem.kind == TRAIN else _run_springs(work)
    solutions = failures.part(
        "facts of runs", computed.solutions, with_facts, problem, computed.solutions
    )
    provenance = collect_provenance(
        problem.record.name,
        ", ".join(dict.fromkeys(member.model.word for member in problem.members)),
        case_digest=problem.record.digest,
        created_at=watch.created_at,
        citations=problem.record.citations,
    )
    study = Study(
        problem.record,
        request.command,
        solutions,
        tuple(computed.at_rest.values()),
        computed.still,
        facts=failures.part("facts", (), study_facts, problem, solutions, computed.between),
        lift_event=problem.lift_event,
        provenance=provenance,
        wall_time=time.perf_counter() - begun,
        critical_speeds=computed.critical,
        between=computed.between,
    )
    study = failures.part("published values", study, next_to_published, study, problem)
    study = replace(study, gaps=failures.sentences)
    if computed.stopped:
        raise StudyStopped(study)
    return _with_error_bars(study, work, computed.at_rest, before_bars)


def _run_springs(work: _Work) -> _Computed:
    """Springs under prescribed motion, and their numbers at rest."""
    problem, request, failures = work.problem, work.request, work.failures
    rest = request.requested is None or request.requested.rest
    solutions, at_rest, gaps, stopped = run_springs(
        problem, work.engine_speeds, work.plan, request.worker_count, work.tell, work.finished, rest or bool(request.compute),
    )  # fmt: skip
    for gap in gaps:
        failures.add(gap)
    names = ("",) if len(problem.springs) == 1 else ("outer", "inner")
    still = {
        name: failures.part(f"numbers of spring '{spring.name}'", {}, numbers_at_rest, problem, spring, at_rest[spring])
        for name, spring in zip(names, problem.springs, strict=True)
        if spring in at_rest
    }  # fmt: skip
    return _Computed(solutions, at_rest, still, stopped=stopped)


def _run_trains(work: _Work) -> _Computed:
    """Trains, numbers of rigid theory, and where asked runs between the speeds and critical speeds."""
    problem, speeds, plan, failures = work.problem, work.engine_speeds, work.plan, work.failures
    count = work.request.worker_count
    ready, at_rest = prepare_trains(problem, speeds, failures)
    solutions, stopped = run_trains(problem, ready, speeds, plan, count, work.tell, work.finished)
    still = failures.part("numbers of rigid theory", {}, rigid_numbers, ready, speeds)
    for name, values in failures.part("preloads", {}, preloads, ready).items():
        still[name] = {**still.get(name, {}), **values}
    computed = _Computed(solutions, at_rest, still, stopped=stopped)
    if isinstance(work.request, Sweep) and not stopped:
        name = "runs between the swept speeds"
        try:
            between = failures.part(name, (), run_between, problem, ready, plan, speeds, count)
            computed = replace(computed, between=between)
        except PointsStopped:
            computed = replace(computed, stopped=True)
    return _searched(work, ready, computed) if work.searches else computed


def _searched(work: _Work, ready: tuple[PreparedRun, ...], computed: _Computed) -> _Computed:
    """With the critical speeds of the trains, unless the study was stopped before."""
    begun, critical = not computed.stopped, work.request.critical_options
    assert critical is not None
    # a member that is driven has the train of those that are not
    trains = tuple(one for one in ready if not one.member.driven)
    if begun and trains:
        work.tell(1.0, "critical speeds")
        try:
            found = find_critical_speeds(
                work.problem, trains, work.plan, (*computed.solutions, *computed.between), critical, work.request.worker_count,
                lambda done, total: work.tell(1.0 + SEARCH_SHARE * done / total, "critical speeds"),
            )  # fmt: skip
            computed = replace(computed, critical=found)
        except PointsStopped as stop:
            rows = tuple(row for rows in stop.results.values() for row in rows)
            computed = replace(computed, critical=CriticalSpeeds(rows), stopped=True)
        except RunFailedError as error:
            work.failures.add(f"critical speeds: {reason(error)}")
    if computed.stopped:
        members = work.problem.members
        labels = [one.label for one in members if one.label not in computed.critical.labels]
        whose = f" of {' and '.join(labels)}" if begun and len(members) > 1 else ""
        work.failures.add(f"{INTERRUPTED}: critical speeds{whose} not computed")
    return computed


def _with_error_bars(study: Study, work: _Work, at_rest: Rest, share_before: float) -> Study:
    """With the error bars that are stored with its case, and those of the other runs where they are asked for."""
    stored = stored_rows(work.problem.record, study.solutions)
    rows = tuple(row for group in stored.values() for row in group)
    if stored:
        statics = (one for one in load_uncertainty(work.problem.record) if one.engine_speed is None)
        rows = (*statics, *rows)
    study = replace(study, error_bars=ErrorBars(rows))
    barred = tuple(run for run in study.solutions if (run.label, run.engine_speed) not in stored)
    if not barred or not work.request.compute:
        return study
    labels = {run.label for run in barred}
    members = tuple(one for one in work.problem.members if one.label in labels)
    try:
        fresh = own_error_bars(
            replace(work.problem, members=members), barred, work.plan, at_rest, work.request.worker_count,
            lambda done, total: work.tell(share_before + BAR_SHARE * done / total, "error bars"),
        )  # fmt: skip
    except PointsStopped:
        raise StudyStopped(replace(study, error_bars=ErrorBars())) from None
    return replace(study, error_bars=fresh._replace(rows=(*rows, *fresh.rows)))


def next_to_published(study: Study, problem: Problem) -> Study:
    """The study with comparisons to published values of its case; none at other speeds, of a
    changed case or of a sweep.

    A case of one's own that names a published study is compared with what that study publishes.
    """
    if study.record.study and not study.record.published:
        values = published_by(study.record.study)
        study = replace(study, record=replace(study.record, published=values))
    published = study.record.published
    given = {value.engine_speed for value in published if value.engine_speed is not None}
    ran = study.engine_speeds
    if (
        study.command == "sweep"
        or study.record.changed
        or (ran and not all(any(same_speed(s, own) for own in problem.engine_speeds) for s in ran))
    ):
        return study
    if given and ran and not any(same_speed(one, other) for one in given for other in ran):
        return study
    compared = against_source(study)
    rows = tuple(
        row
        for row in with_blind(compared.comparisons, study.record)
        if row.engine_speed is None or any(same_speed(row.engine_speed, s) for s in ran)
    )
    notes = compared.notes
    if rows or compared.findings:
        notes += study.record.remarks
        facts = compared.facts + spread_facts(study.record, study.solutions)
        compared = replace(compared, facts=facts)
    return replace(compared, comparisons=rows, notes=notes)
