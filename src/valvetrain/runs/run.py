"""Every study: points times models to solutions, quantities and, where something was published,
comparisons.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace

import numpy as np

from valvetrain.errors import InputError, RunFailedError
from valvetrain.integrate.contract import Keep
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.steel_contacts import default_contacts
from valvetrain.quantities.forces import surge_engine_speeds
from valvetrain.quantities.statics import buckling_quantities, closing_quantities, rest_quantities
from valvetrain.quantities.valve_events import rigid_events
from valvetrain.runs.cost import Limits
from valvetrain.runs.critical_speeds import CriticalOptions, find_critical_speeds
from valvetrain.runs.engine import LOST, LOST_REMEDY, Progress, map_points, threads, worker_count
from valvetrain.runs.notes import (
    buckling_notes,
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
    judge,
    prepare,
    provenance_of,
    unfinished,
)
from valvetrain.runs.stopping import PointsStopped, StudyStopped
from valvetrain.runs.uncertainty_file import spread_sentences, uncertainty_sentences
from valvetrain.runs.workers import as_they_come, result_of
from valvetrain.solution.critical import CriticalSpeeds
from valvetrain.solution.partial_failures import PartialFailures, reason
from valvetrain.solution.provenance import collect_provenance
from valvetrain.solution.quantity import same_speed
from valvetrain.solution.result import Solution
from valvetrain.solution.static import SpringAtRest
from valvetrain.solution.status import Status
from valvetrain.solution.study import Study
from valvetrain.sources.contract import against_source
from valvetrain.springs.spec import spring_model
from valvetrain.system.build import build
from valvetrain.system.contract import TRAIN
from valvetrain.system.problem import Member, Problem, Rest

CARD_WIRE_NOTE = (
    "The finite-element spring of a card is a wire made up for it: rate, preload and mass are the card's, five active coils with "
    "wide gaps are assumed. Its clashes and stresses are not those of the real spring."
)
ReadyPoint = tuple[int, float]
#: Told the place among the runs of a study, and the solution, as each is finished.
Finished = Callable[[int, Solution], None]
STOPPED = Status(
    "interrupted", "the study was stopped before this run was finished", remedy="start it again"
)
WORKER_LOST = Status("worker-lost", LOST, remedy=LOST_REMEDY)
#: Share of the work of a sweep, as progress shows it, that its own speeds are; the search for
#: critical speeds is the rest.
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
    """A case at its engine speeds (rad/s of the crank; those given instead) by its variants, or by
    the models and spring sets asked for.

    ``whole``: solutions keep their channels. Results do not depend on ``workers`` (None: the cores
    there are). Raises :class:`InputError`
    for what cannot be built, for a speed that is not positive and when no model asked for can run;
    a run that fails is a status.
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
    ``critical``: search a train's critical
    speeds between the lowest and the highest of them; ``finished``: told place and solution of each
    run as it comes; ``limits`` of
    one run; ``implausible``: let pass what :mod:`valvetrain.quantities.plausible` calls nonsense.

    Raises :class:`StudyStopped`, a KeyboardInterrupt, with what is finished when it is stopped.
    """
    begun, gaps = time.perf_counter(), PartialFailures()
    speeds = tuple(float(speed) for speed in engine_speeds)
    refuse_speeds(problem, speeds)
    problem.must_run()
    if not implausible:
        refuse_implausible(problem, speeds)
    samples = None if problem.kind == TRAIN else round(2 * np.pi / problem.output_step)
    if command == "sweep" and problem.kind == TRAIN:
        samples = 720
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
        ready, rest = ready_trains(problem, speeds, gaps)
        part = (
            (lambda done, text: progress(GRID_SHARE * done, text))
            if progress is not None and critical is not None
            else progress
        )
        solutions, stopped = _run_trains(problem, ready, speeds, plan, count, part, finished)
        still = gaps.part("numbers of rigid theory", {}, rigid_numbers, problem, ready, speeds)
        if critical is not None and not stopped:
            try:
                found = find_critical_speeds(
                    problem, ready, plan, solutions, critical, count, _search_progress(progress)
                )
            except PointsStopped as cut:
                found, stopped = (
                    CriticalSpeeds(tuple(row for rows in cut.results.values() for row in rows)),
                    True,
                )
            except RunFailedError as error:
                gaps.add(f"critical speeds: {reason(error)}")
    else:
        solutions, rest, still, stopped = _run_springs(
            problem, speeds, plan, count, progress, finished, gaps
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
        notes=gaps.part("notes", (), _notes, problem),
        lift_event=problem.lift_event,
        provenance=provenance,
        wall_time=time.perf_counter() - begun,
        critical_speeds=found,
    )
    study = gaps.part("published values", study, next_to_published, study, problem)
    study = replace(study, gaps=gaps.sentences)
    if stopped:
        raise StudyStopped(study)
    return study


def _notes(problem: Problem) -> tuple[str, ...]:
    made_up = any(
        m.model.word == "finite-element" and any(s.card for s in m.springs) for m in problem.members
    )
    notes: tuple[str, ...] = (CARD_WIRE_NOTE,) if made_up else ()
    notes += tuple(
        dict.fromkeys(
            said
            for m in problem.members
            if m.gear and (said := default_contacts(m.gear.parameters.contacts))
        )
    )
    notes += (ringing,) if (ringing := ringing_note(problem.members)) else ()
    return (*notes, *undamped_notes(problem.members), *buckling_notes(problem))


def next_to_published(study: Study, problem: Problem) -> Study:
    """The study beside what was published of its case; a run at other speeds, by other variants, or
    a sweep, speaks of none of it.
    """
    published = study.record.published
    spoken = {value.engine_speed for value in published if value.engine_speed is not None}
    ran = study.engine_speeds
    if (
        study.command == "sweep"
        or study.record.changed
        or (ran and not all(any(same_speed(s, own) for own in problem.engine_speeds) for s in ran))
    ):
        return study
    if spoken and ran and not any(same_speed(one, other) for one in spoken for other in ran):
        return study
    compared = against_source(study)
    rows = tuple(
        row
        for row in compared.comparisons
        if row.engine_speed is None or any(same_speed(row.engine_speed, s) for s in ran)
    )
    found = compared.quantities
    firm = (
        *uncertainty_sentences(study.record, ran, found),
        *spread_sentences(study.record, ran, found),
    )
    notes = (
        (*compared.notes, *study.record.remarks, *firm)
        if rows or compared.findings
        else compared.notes
    )
    return replace(compared, comparisons=rows, notes=notes)


def _run_springs(
    problem: Problem,
    speeds: tuple[float, ...],
    plan: Plan,
    workers: int,
    progress: Progress | None,
    finished: Finished | None,
    gaps: PartialFailures,
) -> tuple[tuple[Solution, ...], tuple[SpringAtRest, ...], dict[str, dict[str, float]], bool]:
    """Prescribed motion, over threads; the springs' states at rest are found while the first runs
    go on. Last: whether it was stopped.
    """
    source, points = (
        problem.record.study,
        [(member, speed) for member in problem.members for speed in speeds],
    )
    lift = float(np.max(problem.valve_lift.lift(np.linspace(0.0, 2 * np.pi, 721))))
    done: dict[int, Solution] = {}
    rest: dict[InstalledSpring, SpringAtRest] = {}
    refused: list[InputError] = []

    def tell(text: str) -> None:
        if progress is not None:
            progress(min(1.0, (1 + len(done)) / (1 + len(points))), text)

    def one(ready: PreparedRun, speed: float) -> Solution:
        return integrate_point(
            ready, speed, plan, provenance_of(problem, ready.member, speed, plan.created_at)
        )

    ready: dict[Member, PreparedRun] = {
        m: prepare(problem, m, {}, source) for m in problem.members if not m.model.needs_rest
    }
    try:
        with threads(workers) as pool:
            raw = {
                pool.submit(one, ready[point[0]], point[1]): place
                for place, point in enumerate(points)
                if point[0] in ready
            }
            for spring, job in {
                spring: pool.submit(rest_of_spring, problem, spring, lift)
                for spring in problem.springs
            }.items():
                try:
                    rest[spring] = result_of(job)
                except FAILURES as error:
                    refused += [error] if isinstance(error, InputError) else []
                    gaps.add(f"spring '{spring.name}' at rest: {reason(error)}")
            tell("springs at rest")
            late = {
                member: prepare(problem, member, rest, source)
                for member in problem.members
                if member not in ready
            }
            ready |= late
            raw |= {
                pool.submit(one, ready[point[0]], point[1]): place
                for place, point in enumerate(points)
                if point[0] in late
            }
            results = as_they_come(raw)
            del raw
            for place, solution in results:
                member, speed = points[place]
                done[place] = judge(ready[member], solution, plan, rest)
                if finished is not None:
                    finished(place, done[place])
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
        name: gaps.part(
            f"numbers of spring '{spring.name}'", {}, _still, problem, spring, rest[spring], lift
        )
        for name, spring in zip(names, problem.springs, strict=True)
        if spring in rest
    }
    solutions = (
        done.get(place) or unfinished(problem, *point, plan, STOPPED)
        for place, point in enumerate(points)
    )
    return tuple(solutions), tuple(rest.values()), still, stopped


def _still(
    problem: Problem, spring: InstalledSpring, rest: SpringAtRest, lift: float
) -> dict[str, float]:
    """Numbers of one spring that belong to no run."""
    wanted = [value.quantity for value in problem.record.published]
    return (
        closing_quantities(spring)
        | rest_quantities(rest, wanted)
        | buckling_quantities(spring, rest, lift)
    )


def rest_of_spring(problem: Problem, spring: InstalledSpring, maximum_lift: float) -> SpringAtRest:
    """A spring at rest by the finite-element rod (the one that runs, where one does), or from its
    card.
    """
    from valvetrain.runs.statics import at_rest, reach_of, rest_by_model
    from valvetrain.springs.finite_element import FiniteElementRod

    if spring.wire is None:
        assert spring.card is not None
        word = "modal-uniform" if spring.card.mass is not None else "massless"
        reach = spring.precompression + max(1.06 * maximum_lift, 0.2 * spring.precompression)
        return rest_by_model(
            spring, word, problem.model_of(word, spring), np.linspace(0.0, reach, 33)
        )
    rod = problem.model_of("finite-element", spring)
    assert isinstance(rod, FiniteElementRod)
    return at_rest(rod, reach_of(spring, maximum_lift))


def ready_trains(
    problem: Problem, engine_speeds: Sequence[float], gaps: PartialFailures
) -> tuple[tuple[PreparedRun, ...], tuple[SpringAtRest, ...]]:
    """Every member of a train made ready, what their runs share found once, with the springs at
    rest that their models need.

    Raises :class:`InputError` where there is no engine speed.
    """
    if not engine_speeds:
        raise InputError(
            f"case '{problem.record.name}' names no engine speed; add engine_speeds or cam_speeds to [operation]"
        )
    lift = float(np.max(problem.valve_lift.lift(np.linspace(0.0, 2 * np.pi, 721))))
    needed = [
        spring
        for member in problem.members
        if member.model.needs_rest
        for spring in member.springs
        if spring.wire is not None
    ]
    rest: dict[InstalledSpring, SpringAtRest] = {}
    for spring in dict.fromkeys(needed):
        found = gaps.part(
            f"spring '{spring.name}' at rest",
            None,
            rest_of_spring,
            problem,
            spring,
            1.05 * _largest_lift(problem, lift),
        )
        rest |= {spring: found} if found is not None else {}
    made: dict[Hashable, PreparedRun] = {}
    return tuple(_prepared(problem, member, rest, made) for member in problem.members), tuple(
        rest.values()
    )


def _prepared(
    problem: Problem, member: Member, rest: Rest, made: dict[Hashable, PreparedRun]
) -> PreparedRun:
    """Members whose train and springs agree share system, rest and rigid motion."""
    key = (member.gear, member.model.word, member.springs, member.rubbing)
    if key not in made:
        made[key] = prepare(problem, member, rest, problem.record.study)
    return replace(made[key], member=member)


def _run_trains(
    problem: Problem,
    ready: tuple[PreparedRun, ...],
    speeds: tuple[float, ...],
    plan: Plan,
    workers: int,
    progress: Progress | None,
    finished: Finished | None,
) -> tuple[tuple[Solution, ...], bool]:
    """Trains to their periodic state, over processes; every worker is handed once what they share.
    Last: whether it was stopped.
    """
    points = [(place, speed) for speed in speeds for place in range(len(ready))]
    shared = (problem, ready, plan)

    def tell(count: int, total: int) -> None:
        if progress is not None:
            place, speed = points[count - 1]
            progress(count / total, f"{ready[place].member.label} at {speed * 30 / np.pi:.6g} rpm")

    def without(point: ReadyPoint, status: Status) -> Solution:
        return unfinished(problem, ready[point[0]].member, point[1], plan, status)

    try:
        found = map_points(
            train_point,
            shared,
            points,
            workers,
            processes=True,
            tell=tell,
            lost=lambda point: without(point, WORKER_LOST),
            finished=finished,
        )
    except PointsStopped as cut:
        if not cut.results:
            raise
        return tuple(
            cut.results.get(place) or without(point, STOPPED) for place, point in enumerate(points)
        ), True
    return found, False


def _surge_speeds(frequency: float | None, speeds: tuple[float, ...]) -> dict[str, float]:
    """Engine speeds (rad/s) at which the surge (Hz) meets a cam order, a quarter around those that
    were run.
    """
    return (
        surge_engine_speeds(frequency, 0.8 * min(speeds), 1.25 * max(speeds))
        if frequency is not None and speeds
        else {}
    )


def rigid_numbers(
    problem: Problem, ready: tuple[PreparedRun, ...], engine_speeds: tuple[float, ...]
) -> dict[str, dict[str, float]]:
    """What rigid theory says of each spring set, its valve events, and where its surge meets the
    lift around the ``engine_speeds`` run.
    """
    still: dict[str, dict[str, float]] = {}
    made: dict[Hashable, PreparedRun] = {
        (m.gear, m.model.word, m.springs, m.rubbing): one for one in ready for m in (one.member,)
    }
    for one in ready:
        if one.motion is not None and one.member.spring_set not in still:
            # rigid theory knows no surge: the springs count with the Rayleigh share of their mass,
            # whatever model runs
            plain = _prepared(
                problem, replace(one.member, model=spring_model("massless"), rubbing=None), {}, made
            )
            cam_speed, angle = (plain.motion or one.motion).contact_loss()
            values = {
                "rigid_contact_loss_engine_speed": 2 * cam_speed,
                "rigid_contact_loss_cam_angle": angle,
            }
            values["rigid_maximum_valve_lift"] = float(np.max(one.motion.derivatives[0]))
            values |= rigid_events(one.motion.kinematics) | _surge_speeds(
                one.frame.surge_frequency, engine_speeds
            )
            still[one.member.spring_set] = {
                name: float(value) for name, value in values.items() if np.isfinite(value)
            }
    return still


def _search_progress(progress: Progress | None) -> Callable[[int, int], None] | None:
    if progress is None:
        return None
    progress(GRID_SHARE, "critical speeds")
    return lambda count, total: progress(
        GRID_SHARE + (1 - GRID_SHARE) * count / total, "critical speeds"
    )


def member_rest(problem: Problem, member: Member) -> Rest:
    """Springs at rest where the model of a member of a train needs them."""
    lift = 1.05 * _largest_lift(problem, 0.0)
    needed = [
        spring for spring in member.springs if member.model.needs_rest and spring.wire is not None
    ]
    return {spring: rest_of_spring(problem, spring, lift) for spring in needed}


def _largest_lift(problem: Problem, cam_lift: float) -> float:
    lifts = [
        float(m.gear.mechanism.kinematics.maximum_lift)
        for m in problem.members
        if m.gear is not None
    ]
    return max(lifts, default=cam_lift)


def train_point(
    shared: tuple[Problem, tuple[PreparedRun, ...], Plan], point: ReadyPoint
) -> Solution:
    """One run of one member at one engine speed (rad/s)."""
    problem, ready, plan = shared
    place, engine_speed = point
    one = ready[place]
    solution = integrate_point(
        one, engine_speed, plan, provenance_of(problem, one.member, engine_speed, plan.created_at)
    )
    return judge(one, solution, plan, {})
