"""Trains of a problem: preparation, runs to the periodic state, numbers of rigid theory, natural
modes.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace

import numpy as np

from valvetrain.errors import InputError
from valvetrain.integrate.contract import Orbit
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.loading import AnyCase
from valvetrain.quantities.forces import surge_engine_speeds
from valvetrain.quantities.kinematics import rigid_quantities
from valvetrain.quantities.valve_events import closing_ramp, nose_ends, rigid_events
from valvetrain.runs.critical_causes import without_false_surge
from valvetrain.runs.prepared import (
    Plan,
    PreparedRun,
    integrate_from,
    largest_lift,
    prepare,
    provenance_of,
    unfinished,
    with_quantities,
)
from valvetrain.runs.stopping import PointsStopped
from valvetrain.runs.workers import LOST, LOST_REMEDY, Progress, map_points
from valvetrain.solution.modes import TrainModes
from valvetrain.solution.result import Solution
from valvetrain.solution.static import SpringAtRest
from valvetrain.solution.status import PartialFailures, Status
from valvetrain.system.build import build
from valvetrain.system.driven import DrivenSprings
from valvetrain.system.mode_tracking import modes_to_full_lift
from valvetrain.system.problem import Member, Problem, Rest
from valvetrain.system.train_system import TrainSystem
from valvetrain.units import known_arguments

#: Called with the index among the runs of a study, and the solution, as each is finished.
Finished = Callable[[int, Solution], None]
STOPPED = Status(
    "interrupted", "the study was stopped before this run was finished", remedy="start it again"
)
WORKER_LOST = Status("worker-lost", LOST, remedy=LOST_REMEDY)
#: Speeds of a block of a sweep, and share of a speed up to which the next one starts from its motion.
BLOCK, CLOSE = 5, 0.05


def member_statics(problem: Problem, member: Member) -> Rest:
    """Springs at rest where the model of a member of a train needs them."""
    springs = member.springs if member.model.needs_rest else ()
    return {spring: train_statics(problem, spring) for spring in springs if spring.wire is not None}


def train_statics(problem: Problem, spring: InstalledSpring) -> SpringAtRest:
    """A spring of a train at rest, to a little beyond the largest lift."""
    from valvetrain.runs.statics import spring_statics  # which most models do not need

    return spring_statics(problem, spring, 1.05 * largest_lift(problem))


def prepare_trains(
    problem: Problem, engine_speeds: Sequence[float], failures: PartialFailures
) -> tuple[tuple[PreparedRun, ...], dict[InstalledSpring, SpringAtRest]]:
    """Every member of a train prepared, shared parts computed once, and the springs at rest that
    their models need.

    Raises :class:`InputError` where there is no engine speed.
    """
    if not engine_speeds:
        raise InputError(
            f"case '{problem.record.name}' names no engine speed; add engine_speeds or cam_speeds to [operation]"
        )
    needed = (member.springs for member in problem.members if member.model.needs_rest)
    rest: dict[InstalledSpring, SpringAtRest] = {}
    for spring in dict.fromkeys(spring for springs in needed for spring in springs if spring.wire):
        name = f"spring '{spring.name}' at rest"
        found = failures.part(name, None, train_statics, problem, spring)
        rest |= {spring: found} if found is not None else {}
    prepared: dict[Hashable, PreparedRun] = {}
    members = tuple(_prepared(problem, member, rest, prepared) for member in problem.members)
    return members, rest


def _prepared(
    problem: Problem, member: Member, rest: Rest, prepared: dict[Hashable, PreparedRun]
) -> PreparedRun:
    """Members whose train and springs agree share system, equilibrium and rigid motion."""
    key = (member.gear, member.model.word, member.springs, member.rubbing)
    if key not in prepared:
        prepared[key] = prepare(problem, member, rest, problem.record.study)
    return replace(prepared[key], member=member)


def run_trains(
    problem: Problem,
    ready: tuple[PreparedRun, ...],
    engine_speeds: tuple[float, ...],
    plan: Plan,
    workers: int,
    progress: Progress | None,
    finished: Finished | None,
) -> tuple[tuple[Solution, ...], bool]:
    """Solutions of trains in their periodic state, over processes, and whether they were stopped."""
    points = [(index, speed) for speed in engine_speeds for index in range(len(ready))]
    numbers = {point: number for number, point in enumerate(points)}
    blocks = [
        tuple((index, speed) for speed in speeds)
        for index, one in enumerate(ready)
        for speeds in speed_blocks(engine_speeds, BLOCK if _quick(one) else 1)
    ]
    solutions: dict[int, Solution] = {}

    def arrived(block: int, runs: Sequence[Solution | None]) -> None:
        for point, run in zip(blocks[block], runs, strict=True):
            if run is not None:
                solutions[numbers[point]] = run
                if finished is not None:
                    finished(numbers[point], run)

    def tell(count: int, total: int) -> None:
        if progress is not None:
            index, speed = blocks[count - 1][-1]
            progress(count / total, f"{ready[index].member.label} at {speed * 30 / np.pi:.6g} rpm")

    def without(point: tuple[int, float], status: Status) -> Solution:
        return unfinished(problem, ready[point[0]].member, point[1], plan, status)

    def lost(block: Sequence[tuple[int, float]]) -> tuple[Solution | None, ...]:
        """Of several speeds each is tried alone afterwards."""
        return tuple(None if block[1:] else without(one, WORKER_LOST) for one in block)

    stopped = False
    shared, left = (problem, ready, plan), blocks
    try:
        while left:
            blocks = left
            map_points(
                train_block,
                shared,
                blocks,
                workers,
                processes=True,
                tell=tell,
                lost=lost,
                finished=arrived,
            )
            left = [(one,) for block in blocks for one in block if numbers[one] not in solutions]
    except PointsStopped:
        if not solutions:
            raise
        stopped = True
    runs = (solutions.get(number) or without(one, STOPPED) for one, number in numbers.items())
    return tuple(runs), stopped


def _quick(one: PreparedRun) -> bool:
    return isinstance(one.system, TrainSystem) and not one.system.has_large_springs


def speed_blocks(engine_speeds: Sequence[float], most: int) -> tuple[tuple[float, ...], ...]:
    """The speeds of a sweep in blocks of at most ``most`` that rise by less than :data:`CLOSE` each: within a
    block each run starts from the motion before, so that results do not depend on the number of workers.
    """
    blocks: list[tuple[float, ...]] = []
    for speed in engine_speeds:
        last = blocks[-1] if blocks else ()
        if last and len(last) < most and 0 < speed - last[-1] < CLOSE * last[-1]:
            blocks[-1] = *last, speed
        else:
            blocks.append((speed,))
    return tuple(blocks)


def train_block(
    shared: tuple[Problem, tuple[PreparedRun, ...], Plan], block: Sequence[tuple[int, float]]
) -> tuple[Solution, ...]:
    """Runs of one member at rising engine speeds, each from the motion of the one before where that repeats and is not
    that of large springs.
    """
    problem, ready, plan = shared
    start: Orbit | None = None
    runs = []
    for index, engine_speed in block:
        one = ready[index]
        provenance = provenance_of(problem, one.member, engine_speed, plan.created_at)
        run, orbit = integrate_from(one, engine_speed, plan, provenance, start)
        start = orbit if orbit is not None and orbit.motion is not None else None
        runs.append(without_false_surge(problem, one, with_quantities(one, run, plan, {}), plan))
    return tuple(runs)


def train_point(
    shared: tuple[Problem, tuple[PreparedRun, ...], Plan], point: tuple[int, float]
) -> Solution:
    """One run of one member (index) at one engine speed (rad/s)."""
    return train_block(shared, (point,))[0]


def rigid_numbers(
    ready: tuple[PreparedRun, ...], engine_speeds: tuple[float, ...]
) -> dict[str, dict[str, float]]:
    """Rigid theory of each spring set: loss of contact, valve events, and where its surge meets the
    lift near the ``engine_speeds`` run.
    """
    still: dict[str, dict[str, float]] = {}
    for one in ready:
        if one.motion is None or one.member.spring_set in still:
            continue
        values = (
            rigid_quantities(one.motion)
            | rigid_events(one.motion.kinematics)
            | closing_ramp(one.motion.kinematics.law)
            | nose_ends(one.motion)
        )
        surge = one.frame.surge_frequency
        if surge is not None and engine_speeds:
            values |= surge_engine_speeds(
                surge, 0.8 * min(engine_speeds), 1.25 * max(engine_speeds)
            )
        still[one.member.spring_set] = {
            name: float(value) for name, value in values.items() if np.isfinite(value)
        }
    return still


def preloads(ready: tuple[PreparedRun, ...]) -> dict[str, dict[str, float]]:
    """Force (N) of all springs of each spring set at rest, valve closed, by the first of its models."""
    return {
        one.member.spring_set: {"preload": float(one.rest.static_spring_force(np.zeros(1))[0])}
        for one in reversed(ready)
        if one.rest is not None
    }


@known_arguments
def train_modes(
    case: AnyCase,
    models: Sequence[str] | str = (),
    *,
    spring_sets: Sequence[str] | str = (),
) -> tuple[TrainModes, ...]:
    """Undamped natural frequencies and modes of a train with its springs, about equilibrium, valve
    closed and at full lift.

    Closed contacts have their stiffness under the static load; open ones (the lash, valve closed)
    none. A multi-mass spring has its own masses, a massless one its share of mass, any other the
    modes of the uniform spring of equal rate, mass and first frequency.

    Parameters
    ----------
    case : Case, name of a library case, or path of a case file; it holds a train
    models : a name of a spring model, such as "multi-mass", or several; the case's own by default
    spring_sets : name of a spring set, or several; the one in use by default

    Returns
    -------
    tuple of TrainModes, two per variant: ``state`` closed and full_lift, frequencies (Hz), shapes
    and shares of kinetic energy; at full lift which mode of the closed valve each continues

    Raises
    ------
    InputError : a case without a train, an unknown word, what parts refuse

    Examples
    --------
    >>> import valvetrain as vt
    >>> closed, lifted = vt.runs.train_modes("tdi-pushrod", "massless", spring_sets="stock")
    >>> closed.state, lifted.moving(0)
    ('closed', 'valve 53 %, pushrod 24 %, lever 23 %')
    """
    problem = build(case, spring_models=models, spring_set=spring_sets)
    return problem_modes(problem.settled())


def problem_modes(problem: Problem) -> tuple[TrainModes, ...]:
    """Modes of every distinct train of a problem; see :func:`train_modes`."""
    angle = np.linspace(0.0, 2 * np.pi, 1441)
    closed = float(angle[np.argmin(problem.valve_lift.lift(angle))])
    found: dict[Hashable, tuple[TrainModes, TrainModes]] = {}
    for member in problem.members:
        if member.gear is None:
            raise InputError(
                f"case '{problem.record.name}' holds no train, only springs; its modes are those of the springs"
            )
        key = (member.gear, member.model.word, member.springs)
        if key in found:
            continue
        free = replace(member, rubbing=None)  # friction is no stiffness
        system = free.system(member_statics(problem, member), problem.built)
        if isinstance(system, DrivenSprings):
            system = system.train
        assert isinstance(system, TrainSystem)
        full_lift = float(angle[np.argmax(system.mechanism.kinematics.valve_lift(angle))])
        found[key] = modes_to_full_lift(system, member.springs, closed, full_lift, member.label)
    return tuple(one for pair in found.values() for one in pair)
