"""Run-ups: a train whose cam accelerates through its speeds, one point of the envelope per cam
revolution.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.integrate.run_up import turns_of_run_up
from valvetrain.integrate.train_leapfrog import FINER_STEPS, SAMPLES
from valvetrain.integrate.train_record import CycleRecord, TrainOptions
from valvetrain.integrate.train_run import runner
from valvetrain.integrate.train_steady import steady_train
from valvetrain.parameters.loading import AnyCase
from valvetrain.quantities.forces import bind_clearances
from valvetrain.quantities.train_numbers import OpenWindow, turn_quantities
from valvetrain.runs.cost import refuse_cost
from valvetrain.runs.critical_speeds import CriticalOptions
from valvetrain.runs.prepared import (
    FAILURES,
    Plan,
    PreparedRun,
    prepare,
    provenance_of,
    unfinished,
    without_channels,
)
from valvetrain.runs.refusals import refuse_implausible
from valvetrain.runs.requests import RunUp, Watch
from valvetrain.runs.stopping import PointsStopped, StudyStopped, shows_progress
from valvetrain.runs.train_runs import STOPPED, WORKER_LOST, member_statics, preloads
from valvetrain.runs.workers import Progress, map_points
from valvetrain.solution.force_peak import bandwidth_of
from valvetrain.solution.provenance import Provenance, collect_provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Fact, Status, reason
from valvetrain.solution.study import Study
from valvetrain.system.build import build
from valvetrain.system.contract import TRAIN
from valvetrain.system.problem import Problem
from valvetrain.system.train_system import TrainSystem
from valvetrain.units import Given

#: Speeds of the crank (rad/s), first and last, and time (s) between them.
Ramp = tuple[float, float, float]
#: Least number of cam revolutions of a run-up; the last one ends beyond the last speed.
MIN_REVOLUTIONS = 1


@shows_progress("run-up")
def run_up(
    case: AnyCase,
    first_engine_speed: Given,
    last_engine_speed: Given,
    duration: Given,
    *,
    progress: Progress | None = None,
    **options: Any,
) -> Study:
    """A train from one engine speed to another at constant acceleration, from the steady motion of
    the first.

    Parameters
    ----------
    case : Case, name of a library case, or path of a case file; it holds a train
    first_engine_speed, last_engine_speed : of the crank, "1000 rpm", rad/s or a pint quantity; a
        last one below the first runs down
    duration : time between them, "2 s", s or a pint quantity
    progress : called with the share done and a text
    options : ``models``, ``spring_sets``, ``workers``, ``limit`` and ``implausible`` as for :func:`valvetrain.simulate`

    Returns
    -------
    Study with one solution per cam revolution, at its mean speed, without channels:
    ``series(label, name)`` is an envelope

    Raises
    ------
    InputError : a case without a train, invalid speeds or duration, what cannot be built, is too large or implausible

    Examples
    --------
    >>> import valvetrain as vt
    >>> study = vt.run_up("tdi-pushrod", "2000 rpm", "2400 rpm", "0.2 s", models="massless", spring_sets="stock")
    >>> force = study.series("massless", "peak_cam_contact_force")
    >>> len(force), [round(float(speed)) for speed in force.engine_speed[:2]], force.attrs["units"]
    (4, [2058, 2172], 'N')
    """
    ends = {"first_engine_speed": first_engine_speed, "last_engine_speed": last_engine_speed}
    request = RunUp.read({"case": case, **ends, "duration": duration, **options})
    refuse_cost(request.cost(), request.limit, "limit=")
    return run_up_study(request, Watch(progress))


def run_up_study(request: RunUp, watch: Watch = Watch()) -> Study:
    """The study of a run-up; see :func:`run_up`."""
    begun = time.perf_counter()
    first, last, duration = ramp = request.ramp
    progress, created_at = watch.progress, watch.created_at
    if first == last:
        raise InputError(
            "a run-up goes from one engine speed to another; correct them", "last_engine_speed"
        )
    if (revolutions := (first + last) / 2 * duration / (4 * np.pi)) < MIN_REVOLUTIONS:
        raise InputError(
            f"this run-up holds {revolutions:.2g} cam revolutions, and its values are of whole ones; take a longer time",
            "duration",
        )
    problem = build(
        request.case, spring_models=request.models, spring_set=request.spring_sets
    ).settled()
    if problem.kind != TRAIN:
        raise InputError(
            f"case '{problem.record.name}' holds no train, and a run-up is of a train; sweep a spring instead"
        )
    problem.must_run()
    if any(member.driven for member in problem.members):
        raise InputError(
            "solid finite elements follow a train whose motion repeats, and that of a run-up does not; use finite-element",
            "models",
        )
    if not request.implausible:
        refuse_implausible(problem, (max(first, last),))
    ready = tuple(
        prepare(problem, member, member_statics(problem, member), problem.record.study)
        for member in problem.members
    )

    def tell(count: int, total: int) -> None:
        if progress is not None:
            progress(count / total, ready[count - 1].member.label)

    def without(index: int, status: Status) -> tuple[Solution, ...]:
        member, plan = ready[index].member, Plan(created_at=created_at)
        return (unfinished(problem, member, first, plan, status),)

    stopped, shared = False, (problem, ready, ramp, created_at)
    try:
        runs = map_points(
            member_revolutions,
            shared,
            range(len(ready)),
            request.workers,
            processes=True,
            tell=tell,
            lost=lambda index: without(index, WORKER_LOST),
        )
    except PointsStopped as stop:
        if not stop.results:
            raise
        done, stopped = stop.results, True
        runs = tuple(done.get(index) or without(index, STOPPED) for index in range(len(ready)))
    provenance = collect_provenance(
        problem.record.name,
        ", ".join(dict.fromkeys(member.model.word for member in problem.members)),
        case_digest=problem.record.digest,
        created_at=created_at,
        citations=problem.record.citations,
    )
    revolutions_of_all = tuple(solution for run in runs for solution in run)
    ends = {"first_engine_speed": first, "last_engine_speed": last}
    study = Study(
        problem.record,
        "run-up",
        revolutions_of_all,
        facts=(Fact("run-up", ends | {"duration": duration}),),
        lift_event=problem.lift_event,
        provenance=provenance,
        wall_time=time.perf_counter() - begun,
    )
    still = preloads(ready)
    for label in study.labels:
        if found := _lost(study, label):
            still[label] = {**still.get(label, {}), **found}
    study = replace(study, still=still)
    if stopped:
        raise StudyStopped(study)
    return study


def member_revolutions(
    shared: tuple[Problem, tuple[PreparedRun, ...], Ramp, str], index: int
) -> tuple[Solution, ...]:
    """The revolutions of one member; the status of the last says why it ended early or cannot run."""
    problem, ready, ramp, created_at = shared
    one = ready[index]
    origin = provenance_of(problem, one.member, ramp[0], created_at)
    if not isinstance(one.system, TrainSystem):
        status = Status("refused", one.refusal, remedy="choose another model")
        return (without_channels(status, origin),)
    try:
        found = _revolutions(one, ramp, origin)
    except FAILURES as error:
        status = Status("diverged", reason(error), remedy="look at its first speed alone")
        return (without_channels(status, origin),)
    acceleration = (ramp[1] - ramp[0]) / 2 / ramp[2]
    solutions = []
    for record, values, interval in found:
        speed = 2 * record.cam_speed + acceleration * interval
        status = record.status
        if status.completed and (clearance := values.get("coil_bind_clearance", 1.0)) <= 0:
            message = f"the retainer passes the lift at which a spring is solid by {-clearance * 1e3:.4g} mm"
            remedy = "later results are not valid; fit a spring with more travel, or end sooner"
            status = Status("coil-bind", message, remedy=remedy)
        solutions.append(without_channels(status, replace(origin, engine_speed=speed), values))
    return tuple(solutions)


def _revolutions(
    one: PreparedRun, ramp: Ramp, origin: Provenance
) -> list[tuple[CycleRecord, dict[str, float], float]]:
    """Record, numbers and time (s) of every revolution; with a finer step where a contact becomes
    too stiff for the step.
    """
    assert isinstance(one.system, TrainSystem) and one.rest is not None
    first, last, cam_acceleration = ramp[0] / 2, ramp[1] / 2, (ramp[1] - ramp[0]) / 2 / ramp[2]
    window = OpenWindow.of(one.system.mechanism.kinematics)
    options = TrainOptions(
        SAMPLES, window=(window.begin, window.end), force_bandwidth=bandwidth_of(origin)
    )
    found: list[tuple[CycleRecord, dict[str, float], float]] = []
    for _ in range(FINER_STEPS + 1):
        steady = runner(one.system, first, options, rest=one.rest)
        start = steady_train(steady).start
        ready = replace(steady, cam_acceleration=cam_acceleration)
        each = ready.time_step * (ready.steps // options.samples)
        found = []
        for record in turns_of_run_up(ready, last, start):
            values = turn_quantities(ready.system, record, window)
            highest = float(record.q[:, ready.system.arrays.retainer].max())
            values |= bind_clearances(one.member.springs, highest)
            values = {} if record.status.code == "out-of-range" else values
            found.append((record, values, each * len(record.q)))
        if found and found[-1][0].status.code != "diverged":
            break
        options = replace(options, step_fraction=options.step_fraction / 3)
    return found


def _lost(study: Study, label: str) -> dict[str, float]:
    """Engine speeds (rad/s) of the first revolution that loses contact while the valve is open, and
    of the first of two that float.
    """
    runs = study.runs(label)
    least, excess = (
        study.series(label, name).values
        for name in ("minimum_cam_contact_force", "float_excess_lift")
    )
    floats = excess > CriticalOptions().float_lift  # False for a revolution without numbers
    indices = {
        "contact_loss_engine_speed": np.flatnonzero(least <= 0),
        "float_engine_speed": np.flatnonzero(floats[:-1] & floats[1:]),
    }
    return {name: runs[found[0]].engine_speed for name, found in indices.items() if len(found)}
