"""Cost of a request in time and memory, from its plain numbers and before anything is built."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

from valvetrain.coil_contact.record import MAX_BYTES as RECORD_BYTES
from valvetrain.parameters.case import Case
from valvetrain.parameters.curves import Constant
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.runs.cost import Cost, estimate
from valvetrain.springs.spec import SpringModelSpec, spring_model
from valvetrain.system.build import default_models

#: Options of spring models that set the number of unknowns.
REFINES = ("elements_per_coil", "masses_per_coil", "elements", "modes")
#: Chain of masses: its name, masses of a typical wire (to which ``SpringModelSpec.processor_time``
#: refers) and of a card.
CARD_CHAIN, CHAIN, MASSES = "multi-mass", 96.0, 5.0
#: The rod, which every model of a wire at rest starts from.
ROD = "finite-element"
#: The model of tables made from the rod, and the seconds that they take for each spring.
REDUCED, TABLES = "reduced-rod", 1.5
#: Points along the wire that a wave model outputs; coils of a wire for which a case gives none.
POINTS, TYPICAL_COILS = 100.0, 8.0
#: Runs of the search for the critical speeds of a member, in addition to its sweep (20 to 115 measured, as many
#: again in its ranges).
SEARCH_RUNS = 120
#: Seconds of one core per simulated second that a train takes in addition to its springs.
TRAIN_TIME = 0.06
#: Seconds for the statics of a spring alone; typical step (s); bytes of a step during the run, and
#: as stored; steps of a revolution that are stored at most.
REST, STEP, STEP_BYTES, STORED_BYTES, MAX_STEPS = 0.3, 2e-6, 128.0, 16.0, 2**20
#: Spring alone with coil contact: seconds per stored step that its clashes take, bytes of the record
#: per step and unknown, and copies of that record.
CLASH_TIME, CLASH_BYTES, CLASH_COPIES = 2e-6, 16.0, 1.2
#: Time (s) in which the start of a spring alone is forgotten; two revolutions are computed at least.
FORGOTTEN = 0.1
#: Time of a model alone as a share of that in a train, whose steps are shorter.
ALONE = {ROD: 0.6, "wave-rod": 0.4, "wave-rod-clash": 0.4}
#: Runs on the own mesh that take as long as all variants of a refinement, of a spring and of a
#: train; bytes over those of a run.
SPRING_VARIANTS, TRAIN_VARIANTS, FINER_BYTES = 8.0, 13.0, 3.0
SOLID = "solid"
#: Solids in motion: time step (s) over the size of a brick (m) in the section, seconds per brick and
#: step, and for the statics of a brick (s); the coarser mesh of the error bar adds two thirds.
BRICK_STEP, BRICK_TIME, BRICK_REST, COARSER_BRICKS = 1.8e-4, 1e-7, 4e-3, 1 + 2 / 3
#: Upper bounds to which runs of a run-up and steps of a static curve are counted; more are beyond
#: every limit.
MAX_RUNS, MAX_COUNTED = 1_000_000, 10**12
#: Cycles until a train is periodic, where a case gives no fewer; output step (rad) where it gives
#: none.
TYPICAL_CYCLES, SETTLING_CYCLES, TYPICAL_STEP = 20, 6, math.radians(0.5)
#: Solutions that the search for a load takes.
SEARCH = 12
#: Seconds per point and finite element where coils are apart, and where they close one by one;
#: bytes of either.
APART, CLOSING, POINT_BYTES = 22e-6, 65e-6, 130.0
#: Modes of a rod: seconds per unknown and square of the vectors of the search, of which there are
#: two per mode.
MODE, VECTORS = 2.5e-9, 2.0
#: Seconds per finite element that the modes of a train take for its two equilibria.
TRAIN_ROD = 0.03
#: Chain of masses: seconds per point and mass, seconds per cube and bytes per square of the masses
#: for all its frequencies.
CHAIN_POINT, CHAIN_CUBE, CHAIN_BYTES = 3e-6, 2.5e-10, 16.0
#: Seconds of overhead for a spring by one model; seconds and bytes of a point of any curve in the
#: output.
OVERHEAD, OUTPUT, OUTPUT_BYTES = 0.1, 1e-4, 2e3


class Request(Protocol):
    """A request for a study: engine speeds in rad/s of the crank (None: the case's own), names of
    models and spring sets.
    """

    @property
    def command(self) -> str: ...
    @property
    def case(self) -> Case: ...
    @property
    def engine_speeds(self) -> tuple[float, ...] | None: ...
    @property
    def spring_models(self) -> tuple[str, ...]: ...
    @property
    def spring_sets(self) -> tuple[str, ...]: ...
    @property
    def workers(self) -> int: ...


@dataclass(frozen=True, slots=True)
class RunRequest:
    """A request of a program."""

    command: str
    case: Case
    engine_speeds: tuple[float, ...] | None
    spring_models: tuple[str, ...]
    spring_sets: tuple[str, ...]
    workers: int


def planned(request: Request) -> list[tuple[tuple[str, ...], Sequence[InstalledSpring]]]:
    """(spring models, installed springs) of every part of the study, as
    :func:`valvetrain.system.build.build` chooses them.
    """
    case, models = request.case, request.spring_models
    if request.command == "compare" and not models:
        from valvetrain.runs.compare import SPRING_MODELS, TRAIN_MODELS  # as for _compared_cost

        models = SPRING_MODELS if case.train is None else TRAIN_MODELS
    if case.train is None:
        return [(models or default_models(case.springs), case.springs)]
    train, sets = case.train, case.train.springs
    if request.command == "sweep" and not request.spring_sets:
        return [(models or (train.model_of(name),), sets[name]) for name in train.swept_sets]
    return [
        (
            (one.spring_model or train.model_of(one.spring_set),),
            sets.get(one.spring_set or train.spring_set, ()),
        )
        for one in train.requested(request.spring_sets, models)
    ]


def unknowns_of(spec: SpringModelSpec, spring: InstalledSpring) -> tuple[float, float]:
    """(unknowns over those of a typical spring by the default options, unknowns) of one installed
    spring by one model.
    """
    coils = spring.wire.total_coils if spring.wire is not None else TYPICAL_COILS
    options, fields = spring.options_of(spec.word), spec.options.model_fields
    ratios, unknowns = list[float](), 1.0
    if spec.word == CARD_CHAIN and spring.wire is None:
        ratios, unknowns = [MASSES / CHAIN], MASSES
    elif "sections" in spec.shows and not any(name in REFINES for name in fields):
        unknowns = POINTS
    for name, field in fields.items():
        if name not in REFINES or not isinstance(field.default, int):
            continue
        value = float(options.get(name, field.default))
        if spec.word == CARD_CHAIN and (name == "elements") == (spring.wire is not None):
            continue  # a wire's chain has masses per coil, a card's has elements
        ratios.append(value / (CHAIN if name == "elements" else float(field.default)))
        unknowns = max(unknowns, value * (coils if name.endswith("per_coil") else 1.0))
    return max(ratios, default=1.0), unknowns


def request_cost(request: Request, whole: bool = True, searches: bool = False) -> Cost:
    """Cost of a request: every model at every speed, and :data:`SEARCH_RUNS` of each where critical
    speeds are searched.
    """
    case, train = request.case, request.case.train
    engine_speeds = (
        case.operation.engine_speeds if request.engine_speeds is None else request.engine_speeds
    )
    total, chains = _compared_cost(request), list[float]()
    if not engine_speeds or case.lift_law is None:
        return total
    if train is None:
        cycles = case.operation.cycles or SETTLING_CYCLES
        total += Cost(REST * max(1, len(case.springs)))
    else:
        cycles = train.cycles if train.cycles is not None else TYPICAL_CYCLES
        cycles = cycles if cycles > 60 else min(cycles, TYPICAL_CYCLES)
    turns = [4 * math.pi / engine_speed for engine_speed in engine_speeds]
    simulated_time = cycles * sum(turns)
    if train is None and not case.operation.cycles:
        simulated_time = sum(turn * min(cycles, 1 + math.ceil(FORGOTTEN / turn)) for turn in turns)
    samples = 2 * math.pi / (getattr(case.operation, "output_step", None) or TYPICAL_STEP)
    for models, springs in planned(request):
        for model in models:
            spec = spring_model(model)
            if spec.no_motion or any(map(spec.why_not, springs)) or not springs:
                continue  # refused, with its reason, where the parts are built
            ratios, counts = zip(*(unknowns_of(spec, spring) for spring in springs), strict=True)
            refinement = math.hypot(*ratios)  # each spring takes its own time
            own_time = 0.0 if train is None else TRAIN_TIME
            processor_time = spec.processor_time
            if model == SOLID:
                if request.command == "compare" and request.engine_speeds is None:
                    continue  # at rest alone
                alone = sum(
                    turn * min(SETTLING_CYCLES, 1 + math.ceil(FORGOTTEN / turn)) for turn in turns
                )
                total += _solid_motion(
                    springs,
                    alone if train is not None else simulated_time,
                    samples,
                    request.workers,
                )
                if train is None:
                    continue
                spec = spring_model(spec.driver)
                processor_time = spec.processor_time
            if model == REDUCED:
                total += Cost(TABLES * sum(ratios))
            if train is None:
                # Forces of every step are stored, and one run at a time per worker holds its motion too.
                steps = [min(turn / STEP * refinement, MAX_STEPS) for turn in turns]
                at_a_time = max(1, min(request.workers, len(steps)))
                stored = STORED_BYTES * sum(steps) if whole else 0.0
                clash = [0.0] * len(turns)
                if "clash" in spec.shows:
                    entries = CLASH_BYTES * sum(counts)
                    clash = [min(turn / STEP * entries, RECORD_BYTES) for turn in turns]
                    total += Cost(CLASH_TIME * sum(steps) / at_a_time)
                running = STEP_BYTES * max(steps) + CLASH_COPIES * max(clash)
                total += Cost(0.0, running * at_a_time + stored)
                processor_time *= ALONE.get(model, 1.0)
            total += estimate(
                runs=len(engine_speeds),
                simulated_time=simulated_time,
                processor_time=processor_time,
                refinement=refinement,
                own_time=own_time,
                samples=samples,
                channels=30 + sum(counts) * (12 if "stress" in spec.shows else 3),
                workers=request.workers,
                whole=whole,
            )
            if searches and train is not None and model != SOLID:
                # One member is one chain of runs, most of them at the upper speeds.
                found = estimate(
                    runs=SEARCH_RUNS,
                    simulated_time=SEARCH_RUNS * cycles * 4 * math.pi / max(engine_speeds),
                    processor_time=spec.processor_time,
                    refinement=refinement,
                    own_time=own_time,
                )
                chains.append(found.seconds)
    if chains:
        total += Cost(max(max(chains), sum(chains) / max(1, request.workers)))
    return total


def _solid_motion(
    springs: Sequence[InstalledSpring], simulated_time: float, samples: float, workers: int
) -> Cost:
    """Cost of solids in motion over a simulated time (s), with a coarser mesh for their error bars:
    bricks times steps, whose length follows the size of a brick in the section.
    """
    total = Cost()
    for spring in springs:
        options = spring_model(SOLID).read_options(spring.options_of(SOLID)).model_dump()
        coils = spring.wire.total_coils if spring.wire is not None else TYPICAL_COILS
        core, rings = options["brick_core"], options["brick_rings"]
        bricks = coils * options["bricks_per_coil"] * (core**2 + 4 * core * rings)
        wire = 4e-3 if spring.wire is None else float(spring.wire.wire_diameter.value(0.0))
        steps = simulated_time / (BRICK_STEP * wire / (core + rings))
        seconds = BRICK_TIME * bricks * steps * COARSER_BRICKS / min(workers, 2)
        stored = 24.0 * 1.4 * bricks * samples
        total += Cost(seconds + COARSER_BRICKS * BRICK_REST * bricks, 2.0 * stored)
    return total


def _compared_cost(request: Request) -> Cost:
    """Cost of the springs at rest by every model of a comparison."""
    if request.command != "compare" or request.case.train is not None:
        return Cost()
    # This imports the finite-element spring, which a sweep of a train never needs.
    from valvetrain.runs.compare import STEPS

    return _sum(
        spring_cost(spring, model, STEPS)
        for models, springs in planned(request)
        for spring in springs
        for model in models
        if not spring_model(model).no_statics
    )


def run_up_cost(request: Request, ramp: tuple[float, float, float]) -> Cost:
    """Cost of a run-up between two crank speeds (rad/s) in a time (s): that of steady runs over the
    same simulated time.
    """
    first, last, duration = ramp
    mean = (first + last) / 2
    if not (mean > 0 and duration > 0):
        return Cost()  # refused, with its reason, where it begins
    runs = max(1, math.ceil(min(duration * mean / (4 * math.pi) / TYPICAL_CYCLES, MAX_RUNS)))
    models, sets = request.spring_models, request.spring_sets
    steady = RunRequest("run-up", request.case, (mean,) * runs, models, sets, request.workers)
    return request_cost(steady, whole=False)


def refine_cost(case: Case, engine_speeds: Sequence[float] | None, workers: int = 1) -> Cost:
    """Cost of the error bars of a case at ``engine_speeds`` (rad/s of the crank; None: its own)."""
    speeds = None if engine_speeds is None else tuple(engine_speeds)
    models, variants = ((ROD,), SPRING_VARIANTS) if case.train is None else ((), TRAIN_VARIANTS)
    runs = request_cost(RunRequest("run", case, speeds, models, (), workers), whole=False)
    return Cost(runs.seconds * variants, runs.bytes * FINER_BYTES)


def static_cost(
    case: Case,
    spring_models: Sequence[str] = (),
    *,
    spring_sets: Sequence[str] = (),
    steps: int,
    modes: int = 0,
    heights: int = 0,
    loads: int = 0,
) -> Cost:
    """Cost of :func:`valvetrain.runs.statics.static_study` with as many ``heights`` and ``loads``."""
    from valvetrain.runs.statics import default_model

    parts = planned(RunRequest("static", case, None, (), tuple(spring_sets), 1))
    points = heights + SEARCH * loads
    total = _sum(
        spring_cost(spring, model, steps, modes, points)
        for spring in dict.fromkeys(spring for _, springs in parts for spring in springs)
        for model in spring_models or (default_model(spring),)
    )
    if not modes or case.train is None:
        return total
    return total + _sum(
        _train_modes(spring, model)
        for models, springs in parts
        for spring in springs
        for model in spring_models or models
    )


def spring_cost(
    spring: InstalledSpring, model: str, steps: int, modes: int = 0, points: int = 0
) -> Cost:
    """Cost of one spring at rest by one model: a curve of ``steps``, ``modes`` and as many other
    ``points``.
    """
    from valvetrain.runs.statics import APPROACH, BEYOND

    path = APPROACH + BEYOND + 1
    spec = spring_model(model, "spring_models")
    steps = min(steps, MAX_COUNTED)
    total = Cost(OVERHEAD + OUTPUT * steps, OUTPUT_BYTES * steps)
    if spec.no_motion or spec.why_not(spring):
        return total
    unknowns = unknowns_of(spec, spring)[1]
    if model == ROD:
        return total + _rod(spring, unknowns, path + steps + 1 + points, modes)
    if spec.needs_rest:
        total += _rod(spring, unknowns_of(spring_model(ROD), spring)[1], path, max(modes, 8))
    if model == CARD_CHAIN:
        total += Cost(CHAIN_POINT * unknowns * (path + steps + 1 + points)) + _chain_modes(spring)
    return total


def _rod(spring: InstalledSpring, elements: float, points: float, modes: int) -> Cost:
    each = APART if spring.wire is None or isinstance(spring.wire.pitch, Constant) else CLOSING
    size = 6.0 * elements
    vectors = min(VECTORS * modes, size)
    statics = Cost(each * elements * points, POINT_BYTES * elements * points)
    return statics + Cost(MODE * size * vectors**2, 16.0 * size * vectors)


def _chain_modes(spring: InstalledSpring) -> Cost:
    masses = unknowns_of(spring_model(CARD_CHAIN), spring)[1]
    return Cost(CHAIN_CUBE * masses**3, CHAIN_BYTES * masses**2)


def _train_modes(spring: InstalledSpring, model: str) -> Cost:
    if model == CARD_CHAIN:
        return _chain_modes(spring)
    return Cost(TRAIN_ROD * unknowns_of(spring_model(ROD), spring)[1]) if model == ROD else Cost()


def _sum(costs: Iterable[Cost]) -> Cost:
    return sum(costs, Cost())
