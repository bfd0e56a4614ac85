"""What a study will cost in time and memory, from its request alone: before anything is built, for
the command line and for programs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.runs.cost import Cost, estimate
from valvetrain.runs.planned import TYPICAL_COILS, Request, RunRequest, planned, unknowns_of
from valvetrain.springs.spec import spring_model

#: Runs that the search for a train's critical speeds takes besides those of its sweep, of each
#: member (20 to 115 seen).
SEARCH_RUNS = 60
#: Seconds of one core per simulated second that a train takes besides its springs.
TRAIN_TIME = 0.06
#: Seconds that the states at rest of a spring alone take; usual step of a spring (s); bytes of a
#: step while it is run, and as kept.
REST, STEP, STEP_BYTES, STORED_BYTES = 0.3, 2e-6, 128.0, 16.0
#: Runs of a usual mesh and step that take as long as all variants of a refinement, of a spring and
#: of a train; bytes over those of a run.
SPRING_VARIANTS, TRAIN_VARIANTS, FINER_BYTES = 8.0, 13.0, 4.0
#: Solid finite elements: their word, unknowns per element, bytes per unknown, and solver runs of a
#: spring at rest (its error bar is one).
SOLID, SOLID_UNKNOWNS, SOLID_BYTES, SOLID_RUNS = "solid", 15.0, 1e4, 2
#: Runs to which a run-up is counted; so many lie beyond every bound.
MAX_RUNS = 1_000_000
#: Cam turns until a train repeats itself, where fewer are not asked for; coils and samples where a
#: case does not tell.
TYPICAL_CYCLES, TYPICAL_STEP = 20, math.radians(0.5)


def request_cost(request: Request, whole: bool = True, searches: bool = False) -> Cost:
    """Estimated cost of a request: every model at every speed, and :data:`SEARCH_RUNS` of each
    where critical speeds are searched.
    """
    case = request.case
    engine_speeds = (
        case.operation.engine_speeds if request.engine_speeds is None else request.engine_speeds
    )
    total, chains = _compared_cost(request), list[float]()
    if not engine_speeds or case.lift_law is None:
        return total
    cycles = _cycles(case)
    total += Cost(REST * max(1, len(case.springs)) * (case.train is None))
    simulated_time = cycles * sum(4 * math.pi / engine_speed for engine_speed in engine_speeds)
    samples = 2 * math.pi / (getattr(case.operation, "output_step", None) or TYPICAL_STEP)
    for models, springs in planned(request):
        for model in models:
            spec = spring_model(model)
            if spec.no_motion or any(map(spec.why_not, springs)) or not springs:
                continue  # refused, with its reason, where the parts are built
            ratios, counts = zip(*(unknowns_of(spec, spring) for spring in springs), strict=True)
            refinement, unknowns = (
                math.hypot(*ratios),
                sum(counts),
            )  # each spring takes its own time
            channels = 30 + unknowns * (12 if "stress" in spec.shows else 3)
            own_time = 0.0 if case.train is None else TRAIN_TIME
            if (
                case.train is None
            ):  # forces are kept at every step, and one run at a time per worker holds its motion too
                steps = [4 * math.pi / speed / STEP * refinement for speed in engine_speeds]
                at_a_time = max(1, min(request.workers, len(steps)))
                total += Cost(
                    0.0,
                    STEP_BYTES * max(steps) * at_a_time
                    + (STORED_BYTES * sum(steps) if whole else 0.0),
                )
            total += estimate(
                runs=len(engine_speeds),
                simulated_time=simulated_time,
                processor_time=spec.processor_time,
                refinement=refinement,
                own_time=own_time,
                samples=samples,
                channels=channels,
                workers=request.workers,
                whole=whole,
            )
            if (
                searches and case.train is not None
            ):  # one member is one chain of runs, most of them at the upper speeds
                time = SEARCH_RUNS * cycles * 4 * math.pi / max(engine_speeds)
                found = estimate(
                    runs=SEARCH_RUNS,
                    simulated_time=time,
                    processor_time=spec.processor_time,
                    refinement=refinement,
                    own_time=own_time,
                )
                chains.append(found.seconds)
    if chains:
        total += Cost(max(max(chains), sum(chains) / max(1, request.workers)))
    return total


def _compared_cost(request: Request) -> Cost:
    """Of springs at rest by every model that a comparison sets side by side."""
    total = Cost()
    if request.command == "compare" and request.case.train is None:
        # These bring the finite-element spring, which a sweep of a train never needs.
        from valvetrain.runs.compare import FINE_STEPS
        from valvetrain.runs.static_cost import spring_cost

        for models, springs in planned(request):
            for spring in springs:
                for model in models:
                    total += (
                        solid_rest_cost(spring)
                        if model == SOLID
                        else spring_cost(spring, model, FINE_STEPS)
                    )
    return total


def _cycles(case: Case) -> int:
    if case.train is None:
        return case.operation.cycles
    asked = case.train.cycles
    return TYPICAL_CYCLES if asked is None else asked if asked > 60 else min(asked, TYPICAL_CYCLES)


def run_up_cost(request: Request, ramp: tuple[float, float, float]) -> Cost:
    """Estimated cost of a run-up between two crank speeds (rad/s) in a time (s): of as many steady
    runs as take the same simulated time.
    """
    first, last, duration = ramp
    mean = (first + last) / 2
    if not (mean > 0 and duration > 0):
        return Cost()  # refused, with its reason, where it begins
    runs = max(1, math.ceil(min(duration * mean / (4 * math.pi) / TYPICAL_CYCLES, MAX_RUNS)))
    asked = RunRequest(
        "run-up",
        request.case,
        (mean,) * runs,
        request.spring_models,
        request.spring_sets,
        request.workers,
    )
    return request_cost(asked, whole=False)


def refine_cost(case: Case, engine_speeds: Sequence[float] | None, workers: int = 1) -> Cost:
    """Estimated cost of the error bars of a case at ``engine_speeds`` (rad/s of the crank; None:
    its own).
    """
    alone = case.train is None
    asked = RunRequest(
        "run",
        case,
        None if engine_speeds is None else tuple(engine_speeds),
        ("finite-element",) if alone else (),
        (),
        workers,
    )
    runs = request_cost(asked, whole=False)
    return Cost(
        runs.seconds * (SPRING_VARIANTS if alone else TRAIN_VARIANTS), runs.bytes * FINER_BYTES
    )


def solid_rest_cost(spring: InstalledSpring) -> Cost:
    """Estimated cost of one installed wire at rest by solids: curve, modes and the coarser mesh of
    the error bar.
    """
    from valvetrain.springs.solid.installed import COARSER_MESH, statics_seconds

    options = spring_model(SOLID).read_options(spring.options_of(SOLID)).model_dump()
    coils = spring.wire.total_coils if spring.wire is not None else TYPICAL_COILS
    elements = (
        coils
        * options["elements_per_coil"]
        * (options["core"] ** 2 + 4 * options["core"] * options["rings"])
    )
    unknowns = SOLID_UNKNOWNS * elements
    return Cost(
        min(COARSER_MESH * statics_seconds(unknowns), SOLID_RUNS * options["time_limit"]),
        SOLID_BYTES * unknowns,
    )
