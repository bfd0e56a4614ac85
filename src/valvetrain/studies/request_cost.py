"""What a study will cost in time and memory, from its request alone: before anything is built, for the command line and for programs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.registry import words
from valvetrain.springs.spec import SpringModelSpec, spring_model
from valvetrain.studies.cost import Cost, estimate
from valvetrain.system.build import usual_models

#: Options of spring models that set the number of unknowns.
REFINES = ("elements_per_coil", "masses_per_coil", "elements", "modes")
#: Runs that the search for a train's critical speeds takes besides those of its sweep, of each member (20 to 115 seen).
SEARCH_RUNS = 60
#: Chain of masses: its word, masses of a usual wire's (whose time :attr:`SpringModelSpec.processor_time` tells) and of a card's.
CARD_CHAIN, CHAIN, MASSES = "multi-mass", 96.0, 5.0
#: Seconds of one core per simulated second that a train takes besides its springs.
TRAIN_TIME = 0.06
#: Seconds that the states at rest of a spring alone take; usual step of a spring (s); bytes of a step while it is run, and as kept.
REST, STEP, STEP_BYTES, KEPT_BYTES = 0.3, 2e-6, 128.0, 16.0
#: Points along the wire that a model of a wave shows, whatever its options.
POINTS = 100.0
#: Cam turns until a train repeats itself, where fewer are not asked for; coils and samples where a case does not tell.
USUAL_CYCLES, USUAL_COILS, USUAL_STEP = 20, 8.0, math.radians(0.5)


class Request(Protocol):
    """What a study was asked for: engine speeds in rad/s of the crank (None: the case's own), words of models and spring sets."""

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
class Asked:
    """A request of a program."""

    command: str
    case: Case
    engine_speeds: tuple[float, ...] | None
    spring_models: tuple[str, ...]
    spring_sets: tuple[str, ...]
    workers: int


def request_cost(request: Request, whole: bool = True, searches: bool = False) -> Cost:
    """Estimated cost of a request: every model at every speed, and :data:`SEARCH_RUNS` of each where critical speeds are searched."""
    case = request.case
    engine_speeds = case.operation.engine_speeds if request.engine_speeds is None else request.engine_speeds
    total, chains = Cost(), list[float]()
    if not engine_speeds or case.lift_law is None:
        return total
    cycles = _cycles(case)
    total += Cost(REST * max(1, len(case.springs)) * (case.train is None))
    simulated_time = cycles * sum(4 * math.pi / engine_speed for engine_speed in engine_speeds)
    samples = 2 * math.pi / (getattr(case.operation, "output_step", None) or USUAL_STEP)
    for models, springs in _planned(request):
        for model in models:
            spec = spring_model(model)
            if spec.no_motion or any(map(spec.why_not, springs)) or not springs:
                continue  # refused, with its reason, where the parts are built
            refinement, unknowns = (sum(found) for found in zip(*(_unknowns(spec, spring) for spring in springs), strict=True))
            channels = 30 + unknowns * (12 if "stress" in spec.shows else 3)
            own_time = 0.0 if case.train is None else TRAIN_TIME
            if case.train is None:  # forces are kept at every step, and one run at a time per worker holds its motion too
                steps = [4 * math.pi / speed / STEP * refinement for speed in engine_speeds]
                at_a_time = max(1, min(request.workers, len(steps)))
                total += Cost(0.0, STEP_BYTES * max(steps) * at_a_time + (KEPT_BYTES * sum(steps) if whole else 0.0))
            total += estimate(
                runs=len(engine_speeds), simulated_time=simulated_time, processor_time=spec.processor_time, refinement=refinement,
                own_time=own_time, samples=samples, channels=channels,
                workers=request.workers, whole=whole,
            )  # fmt: skip
            if searches and case.train is not None:  # one member is one chain of runs, most of them at the upper speeds
                time = SEARCH_RUNS * cycles * 4 * math.pi / max(engine_speeds)
                found = estimate(
                    runs=SEARCH_RUNS, simulated_time=time, processor_time=spec.processor_time, refinement=refinement, own_time=own_time
                )
                chains.append(found.seconds)
    if chains:
        total += Cost(max(max(chains), sum(chains) / max(1, request.workers)))
    return total


def _cycles(case: Case) -> int:
    if case.train is None:
        return case.operation.cycles
    asked = case.train.cycles
    return USUAL_CYCLES if asked is None else asked if asked > 60 else min(asked, USUAL_CYCLES)


def _planned(request: Request) -> list[tuple[tuple[str, ...], Sequence[InstalledSpring]]]:
    """(spring models, installed springs) of every part of the study, as :func:`valvetrain.system.build.build` will choose them."""
    case, models = request.case, request.spring_models
    if case.train is None:
        return [(models or (words("springs") if request.command == "compare" else usual_models(case.springs)), case.springs)]
    train, sets = case.train, case.train.springs
    if request.command == "compare":
        models = models or words("springs")
    if request.command == "sweep" and not request.spring_sets:
        return [(models or (train.spring_model,), springs) for springs in sets.values()]
    if models or request.spring_sets or not train.variants:
        chosen = request.spring_sets or (train.spring_set or next(iter(sets), ""),)
        return [(models or (train.spring_model,), sets.get(name, ())) for name in chosen]
    return [((one.spring_model or train.spring_model,), sets.get(one.spring_set or train.spring_set, ())) for one in train.variants]


def _unknowns(spec: SpringModelSpec, spring: InstalledSpring) -> tuple[float, float]:
    """(unknowns over those of a usual spring by the default options, unknowns) of one installed spring by one model."""
    coils = spring.wire.total_coils if spring.wire is not None else USUAL_COILS
    options = spring.options_of(spec.word)
    usual_points = 1.0 if any(name in REFINES for name in spec.options.model_fields) or "sections" not in spec.shows else POINTS
    ratio, unknowns = (MASSES / CHAIN, MASSES) if spec.word == CARD_CHAIN and spring.wire is None else (1.0, usual_points)
    for name, model_field in spec.options.model_fields.items():
        if name not in REFINES or not isinstance(model_field.default, int):
            continue
        value = float(options.get(name, model_field.default))
        if spec.word == CARD_CHAIN and (name == "elements") == (spring.wire is not None):
            continue  # a wire's chain has masses per coil, a card's has elements
        usual = CHAIN if name == "elements" else float(model_field.default)
        ratio, unknowns = max(ratio, value / usual), max(unknowns, value * (coils if name.endswith("per_coil") else 1.0))
    return ratio, unknowns
