"""Time and memory that a request takes, by the sizes of its arrays, and the refusal of one beyond its bounds."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from valvetrain.errors import InputError

if TYPE_CHECKING:  # commands name limits before anything is computed
    from valvetrain.parameters.case import Case
    from valvetrain.parameters.installed_spring import InstalledSpring
    from valvetrain.springs.spec import SpringModelSpec

SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
BYTES = {"MB": 1e6, "GB": 1e9, "TB": 1e12}
#: What to reduce in a run, in curves and modes, and in a refinement.
FEWER, FEWER_AT_REST, FEWER_REFINED = (
    "speeds, cycles or unknowns",
    "steps, modes or unknowns",
    "speeds, variants or unknowns",
)


@dataclass(frozen=True, slots=True)
class Cost:
    """Estimated wall time (s) and memory (bytes)."""

    seconds: float = 0.0
    bytes: float = 0.0

    def __add__(self, other: Cost) -> Cost:
        return Cost(self.seconds + other.seconds, self.bytes + other.bytes)


@dataclass(frozen=True, slots=True)
class Limits:
    """Largest estimated time (s) and memory (bytes) of a request."""

    seconds: float = 600.0
    bytes: float = 2e9


def read_limits(texts: Sequence[str] | None, where: str = "--limit") -> Limits:
    """Limits from texts such as ``'2 h'`` and ``'8 GB'``. Raises :class:`InputError` for anything
    else.
    """
    limits = Limits()
    for text in (part for whole in texts or () for part in whole.split(",")):
        match = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*([A-Za-z]+)\s*", text)
        if match is None or match[2] not in (*SECONDS, *BYTES) or float(match[1]) == 0:
            raise InputError(
                f"'{text[:40]}' is no bound; write a time such as '2 h' or a memory such as '8 GB'",
                where,
            )
        if match[2] in SECONDS:
            limits = Limits(float(match[1]) * SECONDS[match[2]], limits.bytes)
        else:
            limits = Limits(limits.seconds, float(match[1]) * BYTES[match[2]])
    return limits


def cost_text(cost: Cost) -> str:
    """The cost in suitable units."""
    return f"about {duration_text(cost.seconds)} and {memory_text(cost.bytes)}"


def refuse_cost(cost: Cost, limits: Limits, option: str = "--limit ", fewer: str = FEWER) -> None:
    """Raise :class:`InputError` for a cost that is too large, with what to request ``fewer`` of, and the ``option`` that
    raises the limit.
    """
    over = []
    if cost.seconds > limits.seconds:
        over.append((_rounded_up(cost.seconds, SECONDS), duration_text(limits.seconds)))
    if cost.bytes > limits.bytes:
        over.append((_rounded_up(cost.bytes, BYTES), memory_text(limits.bytes)))
    if over:
        bounds = " and ".join(bound for _, bound in over)
        raised = ", ".join(value for value, _ in over)
        remedy = f"choose fewer {fewer}, or raise the bound with {option}'{raised}'"
        raise InputError(
            f"this request will take {cost_text(cost)}, beyond the bound of {bounds}; {remedy}"
        )


def duration_text(seconds: float) -> str:
    """A time in a suitable unit."""
    for unit, size in (("d", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 1.5 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{max(1.0, seconds):.0f} s"


def memory_text(size: float) -> str:
    """A memory size in a suitable unit."""
    unit, scale = next((one for one in (("TB", 1e12), ("GB", 1e9)) if size >= one[1]), ("MB", 1e6))
    return f"{size / scale:.3g} {unit}" if unit != "MB" else f"{max(1.0, size / scale):.0f} MB"


def _rounded_up(value: float, units: Mapping[str, float]) -> str:
    """``value`` as the next whole number of the largest unit that leaves at least one."""
    unit = [name for name, size in units.items() if value >= size or size == min(units.values())][
        -1
    ]
    return f"{math.ceil(1.05 * value / units[unit])} {unit}"


#: Cam revolutions until a motion repeats, where a case gives no number; time (s) in which a spring alone forgets its start.
CYCLES, FORGOTTEN = 6, 0.1
#: Revolutions of a speed of a march, in the mean of those that settle at once and those that never repeat.
MARCH_TURNS = 60
#: Seconds that a run stored whole takes in addition to its steps.
OVERHEAD = 0.3
#: Search for the critical speeds of one train: distance (rad/s) of the speeds that it scans, runs of its ranges and roots,
#: cam revolutions and seconds of evaluation of each run.
SCANNED, RANGE_RUNS, RUN_TURNS, EVALUATION = 50 * math.pi / 30, 200, 4.3, 0.025
#: Seconds of one core per simulated second of a train beside its springs.
TRAIN_TIME = 0.6
#: Numbers of a run at each instant: of its ends, and of each point along a spring.
AT_ENDS, AT_POINT = 30, 12
#: The chain of masses; points along a wire of a model without a mesh.
CHAIN, POINTS = "multi-mass", 100.0
#: Instants of a cam revolution that are stored; steps of which the forces are, their length (s), seconds that their
#: evaluation takes, bytes of a step while it runs and as it is stored.
INSTANTS, MOST_STEPS, STEP, STEP_TIME, STEP_BYTES, STORED_BYTES = (
    720,
    2**20,
    2e-6,
    1.2e-6,
    128.0,
    16.0,
)
#: Bytes of a process beside its arrays, once it has run.
PROCESS_BYTES = 120e6
#: Spring at rest: seconds and bytes of one finite element at one height, bytes of a height as it is written, seconds of
#: one number of two vectors that are made orthogonal.
HEIGHT_TIME, HEIGHT_BYTES, WRITTEN_BYTES, VECTOR_TIME = 65e-6, 130.0, 2e3, 2.5e-9
#: Heights to which a request is counted; more are beyond every bound.
MOST_HEIGHTS = 10**12
#: A refinement over the runs of its own mesh: time of its variants, memory of its finest mesh.
VARIANTS, FINER = 13.0, 3.0


@dataclass(frozen=True, slots=True)
class RunRequest:
    """A request for a study: engine speeds in rad/s of the crank (None: the case's own), names of
    models and spring sets.
    """

    command: str
    case: Case
    engine_speeds: tuple[float, ...] | None
    models: tuple[str, ...]
    spring_sets: tuple[str, ...]
    workers: int


def planned(request: RunRequest) -> list[tuple[tuple[str, ...], Sequence[InstalledSpring]]]:
    """(spring models, installed springs) of every part of the study, as
    :func:`valvetrain.system.build.build` chooses them.
    """
    from valvetrain.system.build import COMPARED_ALONE, COMPARED_IN_TRAIN, default_models

    case, models = request.case, request.models
    if request.command == "compare" and not models:
        models = COMPARED_ALONE if case.train is None else COMPARED_IN_TRAIN
    if case.train is None:
        return [(models or default_models(case.springs), case.springs)]
    train, sets = case.train, case.train.springs
    if request.command == "sweep" and not request.spring_sets:
        return [(models or (train.model_of(name),), sets[name]) for name in train.swept_sets]
    return [
        (
            (variant.spring_model or train.model_of(variant.spring_set),),
            sets.get(variant.spring_set or train.spring_set, ()),
        )
        for variant in train.requested(request.spring_sets, models)
    ]


def mesh_of(spec: SpringModelSpec, spring: InstalledSpring) -> tuple[float, float]:
    """(points along a spring by a model, their number over that by its default options), from its options that count
    elements, masses or modes.
    """
    options, given = spec.options, spring.options_of(spec.word)
    unused = options.wire_only if spring.wire is None else options.card_only
    defaults = {
        name: field.default
        for name, field in options.model_fields.items()
        if type(field.default) is int and name not in unused
    }
    counts = [float(given.get(name, default)) for name, default in defaults.items()]
    points = math.prod(counts) if counts else POINTS
    coils = spring.wire.total_coils if spring.wire is not None and counts else 1.0
    return points * coils, math.prod(counts) / math.prod(defaults.values())


def request_cost(request: RunRequest, whole: bool = True, searches: bool = False) -> Cost:
    """Cost of a request: :func:`array_cost` and its processes."""
    arrays = array_cost(request, whole, searches)
    speeds = request.engine_speeds or request.case.operation.engine_speeds
    processes = max(1, min(request.workers, len(speeds))) if arrays.bytes else 0
    return arrays + Cost(0.0, PROCESS_BYTES * processes)


def array_cost(request: RunRequest, whole: bool = True, searches: bool = False) -> Cost:
    """Cost of the arrays of a request: every model at every speed, its runs stored ``whole`` or without channels;
    ``searches``: with the critical speeds of a train.
    """
    from valvetrain.springs.spec import spring_model

    case, train = request.case, request.case.train
    engine_speeds = request.engine_speeds
    if engine_speeds is None:
        engine_speeds = case.operation.engine_speeds
    if not engine_speeds or case.lift_law is None:
        return Cost()
    turns = [4 * math.pi / engine_speed for engine_speed in engine_speeds]
    cycles = case.operation.cycles if train is None else train.cycles
    simulated_time = sum(
        turn * (cycles or min(CYCLES, 1 + math.ceil(FORGOTTEN / turn))) for turn in turns
    )
    low, high = min(engine_speeds), max(engine_speeds)
    count = (high - low) / SCANNED + RANGE_RUNS
    searched = RUN_TURNS * (4 * math.pi * math.log(high / low) / SCANNED + RANGE_RUNS * min(turns))
    parts = planned(request)
    trains = max(1, min(request.workers, sum(len(models) for models, _ in parts)))
    at_a_time, stored, total = max(1, min(request.workers, len(turns))), len(turns) * whole, Cost()
    steps = 0.0 if train is not None else min(max(turns) / STEP, MOST_STEPS)
    for models, springs in parts:
        for spec in map(spring_model, models):
            if not springs or spec.no_motion or any(map(spec.why_not, springs)):
                continue  # refused, with its reason, where the parts are built
            meshes = [mesh_of(spec, spring) for spring in springs]
            work = sum(refinement**2 for _, refinement in meshes)  # more unknowns in shorter steps
            stepping = simulated_time * spec.processor_time * work
            seconds = ((OVERHEAD + STEP_TIME * steps) * stored + stepping) / at_a_time
            if searches and train is not None:
                stepping = searched * (spec.processor_time * work + TRAIN_TIME)
                seconds += (stepping + EVALUATION * count) / trains
            run = 8.0 * INSTANTS * (AT_ENDS + AT_POINT * sum(points for points, _ in meshes))
            at_work = (2 * run + STEP_BYTES * steps) * at_a_time
            total += Cost(seconds, (run + STORED_BYTES * steps) * stored + at_work)
    return total


def run_up_cost(request: RunRequest, ramp: tuple[float, float, float]) -> Cost:
    """Cost of a run-up between two crank speeds (rad/s) in a time (s): that of steady runs over as many revolutions."""
    first, last, duration = ramp
    mean = (first + last) / 2
    if not (mean > 0 and duration > 0):
        return Cost()  # refused, with its reason, where it begins
    models, sets = request.models, request.spring_sets
    steady = request_cost(RunRequest("run-up", request.case, (mean,), models, sets, 1), whole=False)
    runs = duration * mean / (4 * math.pi) / CYCLES
    return Cost(steady.seconds * runs, steady.bytes)


def march_cost(request: RunRequest, revolutions: int) -> Cost:
    """Cost of a march up and down the speeds of a request within so many cam ``revolutions``."""
    steady, speeds = request_cost(request, whole=False), len(request.engine_speeds or ())
    turns = min(revolutions, 2 * speeds * MARCH_TURNS)
    return Cost(steady.seconds * turns / (CYCLES * max(speeds, 1)), steady.bytes)


def refine_cost(case: Case, engine_speeds: Sequence[float] | None, workers: int = 1) -> Cost:
    """Cost of the error bars of a case at ``engine_speeds`` (rad/s of the crank; None: its own)."""
    speeds = None if engine_speeds is None else tuple(engine_speeds)
    models = ("finite-element",) if case.train is None else ()
    runs = array_cost(RunRequest("run", case, speeds, models, (), workers), whole=False)
    return Cost(runs.seconds * VARIANTS, runs.bytes * FINER + PROCESS_BYTES * max(1, workers))


def static_cost(
    case: Case,
    models: Sequence[str] = (),
    *,
    spring_sets: Sequence[str] = (),
    heights: int,
    modes: int = 0,
) -> Cost:
    """Cost of :func:`valvetrain.runs.static_study.static_study` at as many ``heights``, those of its curves too."""
    from valvetrain.system.build import default_model

    parts = planned(RunRequest("static", case, None, (), tuple(spring_sets), 1))
    costs = (
        spring_cost(spring, model, heights, modes)
        for spring in dict.fromkeys(spring for _, springs in parts for spring in springs)
        for model in models or (default_model(spring),)
    )
    return sum(costs, Cost())


def spring_cost(spring: InstalledSpring, model: str, heights: int, modes: int = 0) -> Cost:
    """Cost of one spring at rest by one model at as many ``heights``, and of its ``modes``."""
    from valvetrain.springs.spec import spring_model

    spec = spring_model(model, "models")
    points, _ = mesh_of(spec, spring)
    heights = min(heights, MOST_HEIGHTS)
    # a chain has whole matrices, the search for modes of a rod two vectors for each of them
    unknowns = points if model == CHAIN else 6 * points
    vectors = unknowns if model == CHAIN else min(2 * modes, unknowns)
    seconds = HEIGHT_TIME * points * heights + VECTOR_TIME * unknowns * vectors**2
    size = (WRITTEN_BYTES + HEIGHT_BYTES * points) * heights + 16.0 * unknowns * vectors
    return Cost(seconds, size)
