"""The runs that a request plans: models and springs of each, counted before anything is computed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.registry import words
from valvetrain.springs.spec import SpringModelSpec
from valvetrain.system.build import default_models

#: Options of spring models that set the number of unknowns.
REFINES = ("elements_per_coil", "masses_per_coil", "elements", "modes")


#: Chain of masses: its word, masses of a usual wire's (whose time
#: :attr:`SpringModelSpec.processor_time` tells) and of a card's.
CARD_CHAIN, CHAIN, MASSES = "multi-mass", 96.0, 5.0


#: Points along the wire that a model of a wave shows, whatever its options.
POINTS = 100.0


#: Coils of a wire that a case does not tell.
TYPICAL_COILS = 8.0


class Request(Protocol):
    """What a study was asked for: engine speeds in rad/s of the crank (None: the case's own), words
    of models and spring sets.
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
    :func:`valvetrain.system.build.build` will choose them.
    """
    case, models = request.case, request.spring_models
    if case.train is None:
        return [
            (
                models
                or (
                    words("springs")
                    if request.command == "compare"
                    else default_models(case.springs)
                ),
                case.springs,
            )
        ]
    train, sets = case.train, case.train.springs
    if request.command == "compare":
        models = models or words("springs")
    if request.command == "sweep" and not request.spring_sets:
        return [(models or (train.spring_model,), springs) for springs in sets.values()]
    if models or request.spring_sets or not train.variants:
        chosen = request.spring_sets or (train.spring_set or next(iter(sets), ""),)
        return [(models or (train.spring_model,), sets.get(name, ())) for name in chosen]
    return [
        (
            (one.spring_model or train.spring_model,),
            sets.get(one.spring_set or train.spring_set, ()),
        )
        for one in train.variants
    ]


def unknowns_of(spec: SpringModelSpec, spring: InstalledSpring) -> tuple[float, float]:
    """(unknowns over those of a usual spring by the default options, unknowns) of one installed
    spring by one model.
    """
    coils = spring.wire.total_coils if spring.wire is not None else TYPICAL_COILS
    options = spring.options_of(spec.word)
    default_points = (
        1.0
        if any(name in REFINES for name in spec.options.model_fields)
        or "sections" not in spec.shows
        else POINTS
    )
    ratio, unknowns = (
        (MASSES / CHAIN, MASSES)
        if spec.word == CARD_CHAIN and spring.wire is None
        else (1.0, default_points)
    )
    ratios = [ratio] if ratio < 1.0 else []
    for name, model_field in spec.options.model_fields.items():
        if name not in REFINES or not isinstance(model_field.default, int):
            continue
        value = float(options.get(name, model_field.default))
        if spec.word == CARD_CHAIN and (name == "elements") == (spring.wire is not None):
            continue  # a wire's chain has masses per coil, a card's has elements
        usual = CHAIN if name == "elements" else float(model_field.default)
        ratios.append(value / usual)
        unknowns = max(unknowns, value * (coils if name.endswith("per_coil") else 1.0))
    return max(ratios, default=1.0), unknowns
