"""Run-ups: a train whose cam accelerates through its speeds, one point of the envelope per cam
turn.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from valvetrain.errors import InputError
from valvetrain.integrate.run_up import turns_of_run_up
from valvetrain.integrate.train_leapfrog import FINER_STEPS, SAMPLES
from valvetrain.integrate.train_run import CycleRecord, TrainOptions, runner
from valvetrain.integrate.train_steady import steady_train
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.loading import AnyCase, case_of
from valvetrain.quantities.train_numbers import OpenWindow, turn_quantities
from valvetrain.runs.cost import limits_of, refuse_cost
from valvetrain.runs.critical_speeds import CriticalOptions
from valvetrain.runs.engine import Progress, map_points, worker_count
from valvetrain.runs.notes import refuse_implausible
from valvetrain.runs.planned import RunRequest
from valvetrain.runs.prepared import FAILURES, Plan, PreparedRun, prepare, provenance_of, unfinished
from valvetrain.runs.request_cost import run_up_cost
from valvetrain.runs.run import STOPPED, WORKER_LOST, member_rest
from valvetrain.runs.stopping import PointsStopped, StudyStopped
from valvetrain.solution.channels import empty_channels
from valvetrain.solution.partial_failures import reason
from valvetrain.solution.provenance import collect_provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Status
from valvetrain.solution.study import Study
from valvetrain.system.build import build
from valvetrain.system.contract import TRAIN
from valvetrain.system.problem import Problem
from valvetrain.system.train_system import TrainSystem
from valvetrain.units import Given, si

#: Speeds of the crank (rad/s), first and last, and time (s) between them.
Ramp = tuple[float, float, float]
#: Cam turns that a run-up must hold; its last one is finished beyond the last speed.
MIN_TURNS = 1


def run_up(
    case: AnyCase,
    first_engine_speed: Given,
    last_engine_speed: Given,
    duration: Given,
    *,
    spring_models: Sequence[str] = (),
    spring_sets: Sequence[str] = (),
    workers: int | None = None,
    progress: Progress | None = None,
    limit: str = "",
    implausible: bool = False,
) -> Study:
    """A train from one engine speed to another at constant acceleration, from the steady motion of
    the first; the envelope over speed.

    Parameters
    ----------
    case : Case, name of a library case, or path of a case file; it holds a train
    first_engine_speed, last_engine_speed : of the crank, "1000 rpm", rad/s or a pint quantity; a
        last one below the first runs down
    duration : time between them, "2 s", s or a pint quantity
    spring_models : words of spring models, such as "multi-mass"; the case's own by default
    spring_sets : names of spring sets of the train
    workers : variants at a time; results do not depend on it
    progress : told the share done and what was done
    limit : largest estimated time and memory, such as "2 h, 8 GB"; 10 min and 2 GB by default
    implausible : let values pass that no valvetrain can have (docs/plausible.md)

    Returns
    -------
    Study with one solution per cam turn, at the mean speed of the turn, without channels:
    ``series(label, name)`` is an envelope

    Raises
    ------
    InputError : a case without a train, speeds or a duration that lead nowhere, what cannot be
        built, is too large or implausible

    Examples
    --------
    >>> import valvetrain as vt
    >>> study = vt.run_up("tdi-pushrod", "2000 rpm", "2400 rpm", "0.2 s", spring_models=["massless"], spring_sets=["stock"])
    >>> speeds, force = study.series("massless", "peak_cam_contact_force")
    >>> len(speeds), [round(float(speed) * 30 / 3.14159) for speed in speeds[:2]]
    (4, [2058, 2172])
    """
    ramp = (
        si(first_engine_speed, "engine_speed", "first_engine_speed"), si(last_engine_speed, "engine_speed", "last_engine_speed"),
        si(duration, "time", "duration"),
    )  # fmt: skip
    asked = RunRequest(
        "run-up",
        case_of(case),
        None,
        tuple(spring_models),
        tuple(spring_sets),
        worker_count(workers),
    )
    refuse_cost(run_up_cost(asked, ramp), limits_of(limit), "limit=")
    return run_up_study(
        asked.case,
        ramp,
        spring_models=spring_models,
        spring_sets=spring_sets,
        workers=workers,
        progress=progress,
        implausible=implausible,
    )


def run_up_study(
    case: AnyCase,
    ramp: Ramp,
    *,
    spring_models: Sequence[str] = (),
    spring_sets: Sequence[str] = (),
    workers: int | None = None,
    progress: Progress | None = None,
    created_at: str = "",
    implausible: bool = False,
) -> Study:
    """See :func:`run_up`; ``ramp``: first and last crank speed (rad/s) and time (s) between them;
    ``implausible``: nonsense passes.
    """
    begun = time.perf_counter()
    first, last, duration = ramp
    if not (min(first, last, duration) > 0 and first != last and np.isfinite(sum(ramp))):
        raise InputError(
            "a run-up goes from one positive engine speed to another in a positive time; correct them",
            "--from",
        )
    if (turns_count := (first + last) / 2 * duration / (4 * np.pi)) < MIN_TURNS:
        raise InputError(
            f"this run-up holds {turns_count:.2g} cam turns, and its values are of whole ones; take a longer time",
            "--duration",
        )
    problem = build(case, spring_models=spring_models, spring_sets=spring_sets)
    if problem.kind != TRAIN:
        raise InputError(
            f"case '{problem.record.name}' holds no train, and a run-up is of a train; sweep a spring instead"
        )
    problem.must_run()
    if not implausible:
        refuse_implausible(problem, (max(first, last),))
    ready = tuple(
        prepare(problem, member, member_rest(problem, member), problem.record.study)
        for member in problem.members
    )

    def tell(count: int, total: int) -> None:
        if progress is not None:
            progress(count / total, ready[count - 1].member.label)

    def without(place: int, status: Status) -> tuple[Solution, ...]:
        return (
            unfinished(problem, ready[place].member, first, Plan(created_at=created_at), status),
        )

    stopped, shared = False, (problem, ready, ramp, created_at)
    try:
        runs = map_points(
            member_turns,
            shared,
            range(len(ready)),
            workers,
            processes=True,
            tell=tell,
            lost=lambda place: without(place, WORKER_LOST),
        )
    except PointsStopped as cut:
        if not cut.results:
            raise
        stopped, runs = (
            True,
            tuple(cut.results.get(place) or without(place, STOPPED) for place in range(len(ready))),
        )
    provenance = collect_provenance(
        problem.record.name,
        ", ".join(dict.fromkeys(member.model.word for member in problem.members)),
        case_digest=problem.record.digest,
        created_at=created_at,
        citations=problem.record.citations,
    )
    turns = tuple(turn for run in runs for turn in run)
    notes = (
        f"Run-up from {first * 30 / np.pi:.6g} to {last * 30 / np.pi:.6g} rpm in {duration:.6g} s, one value per cam turn.",
    )
    study = Study(
        problem.record,
        "run-up",
        turns,
        notes=notes,
        lift_event=problem.lift_event,
        provenance=provenance,
        wall_time=time.perf_counter() - begun,
    )
    study = replace(
        study, still={label: found for label in study.labels if (found := _lost(study, label))}
    )
    if stopped:
        raise StudyStopped(study)
    return study


def member_turns(
    shared: tuple[Problem, tuple[PreparedRun, ...], Ramp, str], place: int
) -> tuple[Solution, ...]:
    """The turns of one member; one that cannot run, or ends early, tells so in the status of its
    last.
    """
    problem, ready, ramp, created_at = shared
    one = ready[place]
    origin = provenance_of(problem, one.member, ramp[0], created_at)
    if not isinstance(one.system, TrainSystem):
        return (
            Solution(
                empty_channels(),
                (),
                Status("refused", one.refusal, remedy="choose another model"),
                {},
                origin,
            ),
        )
    try:
        found = _turns(one, ramp)
    except FAILURES as error:
        return (
            Solution(
                empty_channels(),
                (),
                Status("diverged", reason(error), remedy="look at its first speed alone"),
                {},
                origin,
            ),
        )
    acceleration = (ramp[1] - ramp[0]) / 2 / ramp[2]
    solutions = []
    for record, values, interval in found:
        speed = 2 * record.cam_speed + acceleration * interval
        status = record.status
        if status.completed and (clearance := values.get("coil_bind_clearance", 1.0)) <= 0:
            words = f"the retainer passes the lift at which a spring is solid by {-clearance * 1e3:.4g} mm"
            status = Status(
                "coil-bind",
                words,
                remedy="what follows is not to be believed; fit a spring with more room, or end sooner",
            )
        solutions.append(
            Solution(empty_channels(), (), status, {}, replace(origin, engine_speed=speed), values)
        )
    return tuple(solutions)


def _turns(one: PreparedRun, ramp: Ramp) -> list[tuple[CycleRecord, dict[str, float], float]]:
    """Record, numbers and time (s) of every turn; again with a finer step where a contact hardens
    beyond what the step resolves.
    """
    assert isinstance(one.system, TrainSystem) and one.rest is not None
    first, last, cam_acceleration = ramp[0] / 2, ramp[1] / 2, (ramp[1] - ramp[0]) / 2 / ramp[2]
    window = OpenWindow.of(one.system.mechanism.kinematics)
    options = TrainOptions(SAMPLES, window=(window.begin, window.end))
    found: list[tuple[CycleRecord, dict[str, float], float]] = []
    for _ in range(FINER_STEPS + 1):
        steady = runner(one.system, first, options, rest=one.rest)
        start = steady_train(steady).start
        ready = replace(steady, cam_acceleration=cam_acceleration)
        each = ready.time_step * (ready.steps // options.samples)
        found = []
        for record in turns_of_run_up(ready, last, start):
            values = turn_quantities(ready.system, record, window) | bind_clearance(
                record, ready.system, one.member.springs
            )
            found.append((record, values, each * len(record.q)))
        if found and found[-1][0].status.completed:
            break
        options = replace(options, step_fraction=options.step_fraction / 3)
    return found


def bind_clearance(
    record: CycleRecord, system: TrainSystem, springs: Sequence[InstalledSpring]
) -> dict[str, float]:
    """Length (m) left to coil bind at the largest lift of a turn, of the spring with the least;
    none where none is told.
    """
    rooms = [spring.room for spring in springs if spring.room is not None]
    return (
        {"coil_bind_clearance": min(rooms) - float(record.q[:, system.arrays.retainer].max())}
        if rooms
        else {}
    )


def _lost(study: Study, label: str) -> dict[str, float]:
    """Engine speeds (rad/s) of the first turn that lets the cam go while the valve is open, and of
    the first of two that float.
    """
    speeds, least = study.series(label, "minimum_cam_contact_force")
    _, excess = study.series(label, "float_excess_lift")
    floats = excess > CriticalOptions().float_lift  # a turn without numbers tells nothing
    places = {
        "contact_loss_engine_speed": np.flatnonzero(least <= 0),
        "float_engine_speed": np.flatnonzero(floats[:-1] & floats[1:]),
    }
    return {name: float(speeds[found[0]]) for name, found in places.items() if len(found)}
