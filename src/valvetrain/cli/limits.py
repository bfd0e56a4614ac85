"""Large requests: what they will cost is said before they begin, and beyond a bound they are refused with the numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from valvetrain.cli.bounds import BYTES, SECONDS
from valvetrain.cli.outcome import tell
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from valvetrain.cli.study_command import StudyRequest
    from valvetrain.parameters.case import Case
    from valvetrain.parameters.installed_spring import InstalledSpring
    from valvetrain.springs.spec import SpringModelSpec
    from valvetrain.studies.cost import Cost

#: Estimates above this are printed (s).
WORTH_SAYING = 20.0
#: Options of spring models that set the number of unknowns.
REFINES = ("elements_per_coil", "masses_per_coil", "elements", "modes")
#: Runs that the search for a train's critical speeds takes besides those of its sweep, of each member (20 to 115 seen).
SEARCH_RUNS = 60
#: Chain of masses: its word, masses of a usual wire's (whose time :attr:`SpringModelSpec.processor_time` tells) and of a card's.
CARD_CHAIN, CHAIN, MASSES = "multi-mass", 96.0, 5.0
#: Seconds of one core per simulated second that a train takes besides its springs.
TRAIN_TIME = 0.06
#: Cam turns until a train repeats itself, where fewer are not asked for; coils and samples where a case does not tell.
USUAL_CYCLES, USUAL_COILS, USUAL_STEP = 20, 8.0, math.radians(0.5)


def refuse_beyond(request: StudyRequest, whole: bool = True, searches: bool = False) -> None:
    """Say what the request will cost where it takes a while; raise :class:`InputError` with the numbers where it is too large.

    ``whole``: whether every run is kept with its channels; ``searches``: whether a train's critical speeds are searched as well.
    """
    cost, limits = request_cost(request, whole, searches), request.limits
    words = f"about {time_words(cost.seconds)} and {memory_words(cost.bytes)}"
    over = []
    if cost.seconds > limits.seconds:
        over.append((f"--limit '{_rounded_up(cost.seconds, SECONDS)}'", time_words(limits.seconds)))
    if cost.bytes > limits.bytes:
        over.append((f"--limit '{_rounded_up(cost.bytes, BYTES)}'", memory_words(limits.bytes)))
    if over:
        bounds, options = " and ".join(bound for _, bound in over), " ".join(option for option, _ in over)
        remedy = f"ask for fewer speeds, cycles or unknowns, or raise the bound with {options}"
        raise InputError(f"this request will take {words}, beyond the bound of {bounds}; {remedy}")
    if cost.seconds > WORTH_SAYING:
        tell(f"this will take {words}")


def request_cost(request: StudyRequest, whole: bool = True, searches: bool = False) -> Cost:
    """Estimated cost of a request: every model at every speed, and :data:`SEARCH_RUNS` of each where critical speeds are searched."""
    from valvetrain.springs.spec import spring_model
    from valvetrain.studies.cost import Cost, estimate

    case = request.case
    engine_speeds = case.operation.engine_speeds if request.engine_speeds is None else request.engine_speeds
    total, chains = Cost(), list[float]()
    if not engine_speeds or case.lift_law is None:
        return total
    cycles = _cycles(case)
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
            total += estimate(
                runs=len(engine_speeds), simulated_time=simulated_time, processor_time=spec.processor_time, refinement=refinement,
                own_time=own_time, samples=samples * (cycles if case.train is None else 1), channels=channels,
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


def time_words(seconds: float) -> str:
    """A time as people say it."""
    for unit, size in (("d", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 1.5 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{max(1.0, seconds):.0f} s"


def memory_words(size: float) -> str:
    """A memory as people say it."""
    return f"{size / 1e9:.3g} GB" if size >= 1e9 else f"{max(1.0, size / 1e6):.0f} MB"


def _rounded_up(value: float, units: Mapping[str, float]) -> str:
    """``value`` as the next whole number of the largest unit that leaves at least one."""
    unit = [name for name, size in units.items() if value >= size or size == min(units.values())][-1]
    return f"{math.ceil(1.05 * value / units[unit])} {unit}"


def _cycles(case: Case) -> int:
    if case.train is None:
        return case.operation.cycles
    asked = case.train.cycles
    return USUAL_CYCLES if asked is None else asked if asked > 60 else min(asked, USUAL_CYCLES)


def _planned(request: StudyRequest) -> list[tuple[tuple[str, ...], Sequence[InstalledSpring]]]:
    """(spring models, installed springs) of every part of the study, as :func:`valvetrain.system.build.build` will choose them."""
    from valvetrain.registry import words
    from valvetrain.system.build import usual_models

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
    ratio, unknowns = (MASSES / CHAIN, MASSES) if spec.word == CARD_CHAIN and spring.wire is None else (1.0, 1.0)
    for name, model_field in spec.options.model_fields.items():
        if name not in REFINES or not isinstance(model_field.default, int):
            continue
        value = float(options.get(name, model_field.default))
        if spec.word == CARD_CHAIN and (name == "elements") == (spring.wire is not None):
            continue  # a wire's chain has masses per coil, a card's has elements
        usual = CHAIN if name == "elements" else float(model_field.default)
        ratio, unknowns = max(ratio, value / usual), max(unknowns, value * (coils if name.endswith("per_coil") else 1.0))
    return ratio, unknowns
