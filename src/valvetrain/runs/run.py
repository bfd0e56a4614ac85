"""Studies in time: a case at its engine speeds and models (:func:`run_study`), and over engine
speed (:func:`sweep_study`).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, Future
from dataclasses import replace

import numpy as np

from valvetrain.errors import InputError, RunFailedError
from valvetrain.integrate.contract import Keep
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.steel_contacts import default_contacts
from valvetrain.quantities.statics import buckling_quantities, closing_quantities, rest_quantities
from valvetrain.runs.cost import Limits
from valvetrain.runs.critical_speeds import CriticalOptions, find_critical_speeds
from valvetrain.runs.notes import (
    buckling_notes,
    pulling_end_notes,
    refuse_implausible,
    refuse_speeds,
    ringing_note,
    undamped_notes,
)
from valvetrain.runs.prepared import (
    FAILURES,
    Plan,
    PreparedRun,
    integrate_point,
    law_lift,
    prepare,
    provenance_of,
    unfinished,
    with_quantities,
)
from valvetrain.runs.stopping import PointsStopped, StudyStopped
from valvetrain.runs.stored_error_bars import spread_sentences, uncertainty_sentences
from valvetrain.runs.train_runs import (
    STOPPED,
    Finished,
    prepare_trains,
    rigid_numbers,
    run_trains,
)
from valvetrain.runs.workers import Progress, as_they_come, result_of, threads, worker_count
from valvetrain.solution.critical import CriticalSpeeds
from valvetrain.solution.partial_failures import PartialFailures, reason
from valvetrain.solution.provenance import collect_provenance
from valvetrain.solution.quantity import same_speed
from valvetrain.solution.result import Solution
from valvetrain.solution.static import SpringAtRest
from valvetrain.solution.study import Study
from valvetrain.sources.contract import against_source
from valvetrain.system.build import build
from valvetrain.system.contract import TRAIN
from valvetrain.system.problem import Member, Problem

#: Note on the wire of a card.
CARD_WIRE_NOTE = (
    "The finite-element spring of a card is a wire made up for it: rate, preload and mass are the card's, five active coils with "
    "wide gaps are assumed. Its clashes and stresses are not those of the real spring."
)
#: Share of a sweep's progress for its own speeds; the rest is the search for critical speeds.
GRID_SHARE = 0.5


def run_study(
    case: Case,
    *,
    engine_speeds: Sequence[float] | None = None,
    spring_models: Sequence[str] = (),
    spring_sets: Sequence[str] = (),
    workers: int | None = None,
    progress: Progress | None = None,
    created_at: str = "",
    command: str = "run",
    whole: bool = True,
    limits: Limits = Limits(),
    implausible: bool = False,
    finished: Finished | None = None,
) -> Study:
    """A case at ``engine_speeds`` (rad/s of the crank; None: its own) by its variants, or by given
    models and spring sets.

    ``whole``: solutions keep their channels. Results do not depend on ``workers`` (None: all
    cores). Raises :class:`InputError` for what cannot be built, for a speed that is not positive
    and when no model can run; a run that fails is a status.
    """
    problem = build(case, spring_models=spring_models, spring_sets=spring_sets)
    speeds = problem.engine_speeds if engine_speeds is None else tuple(engine_speeds)
    return run_problem(
        problem,
        speeds,
        workers=workers,
        progress=progress,
        created_at=created_at,
        command=command,
        whole=whole,
        finished=finished,
        limits=limits,
        implausible=implausible,
    )


def sweep_study(
    case: Case,
    engine_speeds: Sequence[float],
    *,
    spring_models: Sequence[str] = (),
    spring_sets: Sequence[str] = (),
    whole: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
    created_at: str = "",
    critical: CriticalOptions | None = CriticalOptions(),
    finished: Finished | None = None,
    limits: Limits = Limits(),
    implausible: bool = False,
) -> Study:
    """A case over ``engine_speeds`` (rad/s of the crank): solutions, reduced unless ``whole``, and
    the critical speeds of a train between the lowest and the highest of them (``critical`` None:
    not searched).

    By default every spring set of a train by its own model, a spring alone by its default models.
    Raises :class:`InputError` for no speed at all and for what cannot be built.
    """
    speeds = tuple(sorted({float(speed) for speed in engine_speeds}))
    if not speeds:
        raise InputError(
            "a sweep needs at least one engine speed; write such as '1000:9000:100 rpm'",
            "--engine-speed",
        )
    sets = tuple(spring_sets) or (tuple(case.train.springs) if case.train is not None else ())
    problem = build(case, spring_models=spring_models, spring_sets=sets)
    try:
        return _with_critical(
            run_problem(
                problem,
                speeds,
                workers=workers,
                progress=progress,
                created_at=created_at,
                command="sweep",
                whole=whole,
                critical=critical,
                finished=finished,
                limits=limits,
                implausible=implausible,
            )
        )
    except StudyStopped as stop:
        raise StudyStopped(_with_critical(stop.study)) from None


def _with_critical(study: Study) -> Study:
    """The study with its critical speeds among the numbers of no single run."""
    still = {**study.still}
    for label in study.critical_speeds.labels:
        still[label] = {**still.get(label, {}), **study.critical_speeds.quantities(label)}
    return replace(study, still=still)


def run_problem(
    problem: Problem,
    engine_speeds: Sequence[float],
    *,
    workers: int | None = None,
    progress: Progress | None = None,
    created_at: str = "",
    command: str = "run",
    whole: bool = True,
    critical: CriticalOptions | None = None,
    finished: Finished | None = None,
    limits: Limits = Limits(),
    implausible: bool = False,
) -> Study:
    """The study of a problem at ``engine_speeds`` (rad/s of the crank); see :func:`run_study`.

    ``critical``: search a train's critical speeds between the lowest and the highest of them;
    ``finished``: called with index and solution of each run as it arrives; ``limits`` of one run;
    ``implausible``: do not apply the limits of :mod:`valvetrain.quantities.plausible`. Raises
    :class:`StudyStopped`, a KeyboardInterrupt, with what is finished when it is stopped.
    """
    begun, failures = time.perf_counter(), PartialFailures()
    speeds = tuple(float(speed) for speed in engine_speeds)
    refuse_speeds(problem, speeds)
    problem.must_run()
    if not implausible:
        refuse_implausible(problem, speeds)
    if problem.kind == TRAIN:
        samples = 720 if command == "sweep" else None
    else:
        samples = round(2 * np.pi / problem.output_step)
    keep: Keep = "all" if whole else "ends" if problem.kind == TRAIN else "contacts"
    plan = Plan(
        keep,
        samples,
        whole,
        problem.cycles,
        problem.cycles_to_settle,
        created_at,
        limits.bytes,
        implausible,
    )
    count = worker_count(workers)
    found, stopped = CriticalSpeeds(), False
    if problem.kind == TRAIN:
        ready, rest = prepare_trains(problem, speeds, failures)
        part, tell = progress, None
        if progress is not None and critical is not None:
            part, tell = _shares(progress)
        solutions, stopped = run_trains(problem, ready, speeds, plan, count, part, finished)
        still = failures.part("numbers of rigid theory", {}, rigid_numbers, problem, ready, speeds)
        if critical is not None and not stopped:
            if tell is not None:
                tell(0, 1)
            try:
                found = find_critical_speeds(problem, ready, plan, solutions, critical, count, tell)
            except PointsStopped as stop:
                rows = tuple(row for rows in stop.results.values() for row in rows)
                found, stopped = CriticalSpeeds(rows), True
            except RunFailedError as error:
                failures.add(f"critical speeds: {reason(error)}")
    else:
        solutions, rest, still, stopped = _run_springs(
            problem, speeds, plan, count, progress, finished, failures
        )
    provenance = collect_provenance(
        problem.record.name,
        ", ".join(dict.fromkeys(member.model.word for member in problem.members)),
        case_digest=problem.record.digest,
        created_at=created_at,
        citations=problem.record.citations,
    )
    study = Study(
        problem.record,
        command,
        solutions,
        rest,
        still,
        notes=failures.part("notes", (), _notes, problem)
        + failures.part("notes", (), pulling_end_notes, solutions),
        lift_event=problem.lift_event,
        provenance=provenance,
        wall_time=time.perf_counter() - begun,
        critical_speeds=found,
    )
    study = failures.part("published values", study, next_to_published, study, problem)
    study = replace(study, gaps=failures.sentences)
    if stopped:
        raise StudyStopped(study)
    return study


def _shares(progress: Progress) -> tuple[Progress, Callable[[int, int], None]]:
    """Progress of the speeds of a sweep, and of the search for critical speeds after them."""

    def tell(count: int, total: int) -> None:
        progress(GRID_SHARE + (1 - GRID_SHARE) * count / total, "critical speeds")

    return lambda done, text: progress(GRID_SHARE * done, text), tell


def _notes(problem: Problem) -> tuple[str, ...]:
    members = problem.members
    assumed_wire = any(
        m.model.word == "finite-element" and any(s.card for s in m.springs) for m in members
    )
    contacts = (default_contacts(m.gear.parameters.contacts) for m in members if m.gear)
    notes = (
        CARD_WIRE_NOTE if assumed_wire else "",
        *dict.fromkeys(contacts),
        ringing_note(members),
    )
    return (*filter(None, notes), *undamped_notes(members), *buckling_notes(problem))


def next_to_published(study: Study, problem: Problem) -> Study:
    """The study with comparisons to published values of its case; none at other speeds, of a
    changed case or of a sweep.
    """
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
        for row in compared.comparisons
        if row.engine_speed is None or any(same_speed(row.engine_speed, s) for s in ran)
    )
    notes = compared.notes
    if rows or compared.findings:
        record, found = study.record, compared.quantities
        notes += record.remarks
        notes += uncertainty_sentences(record, ran, found) + spread_sentences(record, ran, found)
    return replace(compared, comparisons=rows, notes=notes)


def _run_springs(
    problem: Problem,
    speeds: tuple[float, ...],
    plan: Plan,
    workers: int,
    progress: Progress | None,
    finished: Finished | None,
    failures: PartialFailures,
) -> tuple[tuple[Solution, ...], tuple[SpringAtRest, ...], dict[str, dict[str, float]], bool]:
    """Prescribed motion, over threads; the statics of the springs are computed during the first
    runs. Last: whether stopped.
    """
    from valvetrain.runs.statics import spring_statics  # which a train does not need

    source, lift = problem.record.study, law_lift(problem)
    points = [(member, speed) for member in problem.members for speed in speeds]
    done: dict[int, Solution] = {}
    rest: dict[InstalledSpring, SpringAtRest] = {}
    refused: list[InputError] = []

    def tell(text: str) -> None:
        if progress is not None:
            progress(min(1.0, (1 + len(done)) / (1 + len(points))), text)

    def integrate(ready: PreparedRun, speed: float) -> Solution:
        provenance = provenance_of(problem, ready.member, speed, plan.created_at)
        return integrate_point(ready, speed, plan, provenance)

    def start(pool: Executor, members: Mapping[Member, PreparedRun]) -> dict[Future[Solution], int]:
        return {
            pool.submit(integrate, members[member], speed): index
            for index, (member, speed) in enumerate(points)
            if member in members
        }

    ready: dict[Member, PreparedRun] = {
        m: prepare(problem, m, {}, source) for m in problem.members if not m.model.needs_rest
    }
    try:
        with threads(workers) as pool:
            jobs = start(pool, ready)
            statics = {
                spring: pool.submit(spring_statics, problem, spring, lift)
                for spring in problem.springs
            }
            for spring, job in statics.items():
                try:
                    rest[spring] = result_of(job)
                except FAILURES as error:
                    refused += [error] if isinstance(error, InputError) else []
                    failures.add(f"spring '{spring.name}' at rest: {reason(error)}")
            tell("springs at rest")
            late = {
                member: prepare(problem, member, rest, source)
                for member in problem.members
                if member not in ready
            }
            ready |= late
            jobs |= start(pool, late)
            results = as_they_come(jobs)
            del jobs
            for index, solution in results:
                member, speed = points[index]
                done[index] = with_quantities(ready[member], solution, plan, rest)
                if finished is not None:
                    finished(index, done[index])
                tell(f"{member.label} at {speed * 30 / np.pi:.6g} rpm")
        stopped = False
    except KeyboardInterrupt:
        stopped = True
        if not done and not rest:
            raise
    if refused and not rest and not any(one.status.code != "refused" for one in done.values()):
        raise refused[0]  # nothing came out at all: the case cannot be run
    names = ("",) if len(problem.springs) == 1 else ("outer", "inner")
    still: dict[str, dict[str, float]] = {
        name: failures.part(
            f"numbers of spring '{spring.name}'", {}, _still, problem, spring, rest[spring], lift
        )
        for name, spring in zip(names, problem.springs, strict=True)
        if spring in rest
    }
    solutions = (
        done.get(index) or unfinished(problem, *point, plan, STOPPED)
        for index, point in enumerate(points)
    )
    return tuple(solutions), tuple(rest.values()), still, stopped


def _still(
    problem: Problem, spring: InstalledSpring, rest: SpringAtRest, lift: float
) -> dict[str, float]:
    """Numbers of one spring that belong to no run."""
    names = [value.quantity for value in problem.record.published]
    return (
        closing_quantities(spring)
        | rest_quantities(rest, names)
        | buckling_quantities(spring, rest, lift)
    )
