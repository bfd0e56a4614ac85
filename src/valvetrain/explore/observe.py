"""What a case gives at the places where something was measured: quantities, and forces over compression."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.explore.case_paths import vary
from valvetrain.explore.engine import Computation, Place
from valvetrain.explore.evaluate import MODES, Point, evaluate_case
from valvetrain.explore.measurements import Target
from valvetrain.explore.outputs import Outcome, Run
from valvetrain.explore.posterior import Evaluate, Numbers
from valvetrain.explore.space import Space
from valvetrain.explore.store import versions_digest
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.request import PointRequest
from valvetrain.runs.prepared import FAILURES
from valvetrain.runs.statics import axial_frequencies, force_of
from valvetrain.solution.status import Status, reason
from valvetrain.springs.spec import spring_model
from valvetrain.system.build import build
from valvetrain.system.problem import Problem

#: Status of a point of which a run does not complete.
IMPOSSIBLE = Status("refused", "the point cannot be computed")
#: What computes a spring at rest where no model is named: of a wire, of a card.
WIRE, CARD = "finite-element", "massless"
#: Preload and frequencies of the only spring, which a model alone gives in a fraction of the time that all numbers take.
_BY_MODEL = re.compile(r"preload|mode_(\d+)_frequency")


@dataclass(frozen=True, eq=False)
class Observed(Computation):
    """A ``case``, the ``space`` of what is varied and the ``targets`` to compute."""

    case: Case
    space: Space
    targets: tuple[Target, ...]

    @cached_property
    def tasks(self) -> tuple[Run, ...]:
        """Conditions of the targets, each once."""
        return tuple(dict.fromkeys(one.station for one in self.targets))

    @property
    def subject(self) -> Any:
        """Case, keys, targets and versions."""
        return [self.case.record().digest, self.space.identity, self.targets, versions_digest()]

    def evaluate(self, values: Iterable[float], task: Sequence[Any]) -> Outcome:
        """Values of the targets under the conditions of a task, by key."""
        try:
            case = vary(self.case, dict(zip(self.space, values, strict=True)))
            numbers = numbers_of(case, Run(*task), self.targets)
        except FAILURES as error:
            return Outcome(Status("refused", reason(error)))
        return Outcome(IMPOSSIBLE) if numbers is None else Outcome(values=numbers)


@dataclass(frozen=True, eq=False)
class FunctionPoints(Computation):
    """Points that a ``function`` computes, ``together`` at a time; ``subject``: all that they depend on besides their values."""

    function: Evaluate
    subject: Any = ""
    together: int = 1

    def evaluate(self, values: Iterable[float], task: Any) -> Outcome:
        """The outcome of one point."""
        return self.outcomes([(tuple(values), task)])[0]

    def outcomes(self, places: Sequence[Place]) -> list[Outcome]:
        """The outcomes of a batch."""
        numbers = self.function(np.array([values for values, _ in places]))
        return [Outcome(IMPOSSIBLE) if one is None else Outcome(values=one) for one in numbers]


def numbers_of(case: Case, station: Run, targets: Sequence[Target]) -> Numbers:
    """Values of those of the ``targets`` that belong to a ``station``, by key; None where it does not run. Raises as building
    and running do.
    """
    rest = station.spring_model if station.engine_speed is None else ""
    alone = rest not in ("", WIRE)
    here = [one for one in targets if one.station == station]
    whole = [
        one for one in here if one.kind == "quantity" and not (alone and _BY_MODEL.fullmatch(one.name))
    ]  # fmt: skip
    numbers = dict[str, float]()
    if whole:
        request = PointRequest(tuple(one.name for one in whole), rest)
        outcome = evaluate_case(case, Point(case, (), station, request))
        if not outcome.status.completed:
            return None
        numbers = {one.key: outcome.values.get(one.name, np.nan) for one in whole}
    if len(whole) < len(here):
        problem = build(case, spring_set=station.spring_sets)
        rows = {one.key: _at_rest(problem, station, one) for one in here if one not in whole}
        numbers |= rows
    return numbers


def _at_rest(problem: Problem, station: Run, one: Target) -> float:
    """The number of a target that a spring model gives by itself."""
    spring = _spring(problem, "" if one.kind == "quantity" else one.name)
    word = station.spring_model or (WIRE if spring.wire is not None else CARD)
    if reason := spring_model(word).why_not(spring):
        raise InputError(reason, "spring_model")
    model, at = problem.model_of(word, spring), one.at
    if one.kind == "quantity":
        mode = _BY_MODEL.fullmatch(one.name)
        if mode is not None and mode[1]:
            frequencies = axial_frequencies(model, MODES).tolist()
            return float(dict(enumerate(frequencies, 1)).get(int(mode[1]), np.nan))
        at = spring.precompression
    if one.kind == "load":
        if spring.installed_height is None:
            raise InputError(
                f"the card of spring '{spring.name}' has no installed_height, so heights are not known; give compressions",
                "heights",
            )
        at = spring.installed_height + spring.precompression - at
    return float(force_of(spring, model, at))


def _spring(problem: Problem, name: str) -> InstalledSpring:
    springs = tuple(dict.fromkeys(problem.springs))  # variants of a train share them
    fits = [spring for spring in springs if name in ("", spring.name)]
    if len(fits) != 1:
        names = ", ".join(dict.fromkeys(f"'{spring.name}'" for spring in springs))
        called = f"are called '{name[:40]}'" if name else "could be meant"
        raise InputError(
            f"{len(fits) or 'no'} springs of the case {called}; give spring, one of {names}, and spring_set of a train",
            "spring",
        )
    return fits[0]
