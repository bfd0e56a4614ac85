"""What a case gives at the places where something was measured: quantities, forces over
compression, events, channels.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.explore.case_paths import vary
from valvetrain.explore.engine import Computation
from valvetrain.explore.evaluate import MODES, Point, evaluate_case
from valvetrain.explore.measurements import Target
from valvetrain.explore.outputs import Outcome, Run
from valvetrain.explore.posterior import Numbers
from valvetrain.explore.space import Varied
from valvetrain.explore.store import versions_digest
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.request import PointRequest
from valvetrain.runs.prepared import FAILURES
from valvetrain.runs.requests import Run as RunOfCase
from valvetrain.runs.run import run_study
from valvetrain.runs.statics import axial_frequencies, force_of
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Status, reason
from valvetrain.springs.spec import spring_model
from valvetrain.system.build import build
from valvetrain.system.problem import Problem

#: Status of a point of which a run does not complete.
IMPOSSIBLE = Status("refused", "the point cannot be computed")
#: What computes a spring at rest where no model is named: of a wire, of a card.
WIRE, CARD = "finite-element", "massless"
#: Kinds of targets that are read from a solution in motion.
IN_RUN = ("event", "channel")
_MODE = re.compile(r"mode_(\d+)_frequency")


@dataclass(frozen=True, eq=False)
class Observed(Computation):
    """A ``case``, what of it is ``varied`` (one row of keys per quantity, moved alike) and the
    ``targets`` to compute. A run is a row of places of conditions.
    """

    case: Case
    varied: tuple[tuple[Varied, ...], ...]
    targets: tuple[Target, ...]

    @property
    def stations(self) -> tuple[Run, ...]:
        """Conditions of the targets, each once."""
        return tuple(dict.fromkeys(one.station for one in self.targets))

    @cached_property
    def runs(self) -> tuple[tuple[int, ...], ...]:
        """Places of conditions parted into those that one study of a case gives together: speeds by one
        model, the static rod with them.
        """
        groups: dict[object, list[int]] = {}
        for place, station in enumerate(self.stations):
            alone = not _needs_run(station, self.targets)
            key = place if alone else station[1:]
            groups.setdefault(key, []).append(place)
        still = next((k for k, one in enumerate(self.stations) if one == Run()), None)
        if still is not None and (WIRE, "") in groups:
            groups[WIRE, ""] += groups.pop(still)
        return tuple(map(tuple, groups.values()))

    @property
    def subject(self) -> Any:
        """Case, keys, targets and versions."""
        return [self.case.record().digest, self.varied, self.targets, versions_digest()]

    def case_at(self, values: Iterable[float]) -> Case:
        """The case with its quantities at ``values`` (SI). Raises :class:`InputError` for a key
        that is not there, an impossible case.
        """
        pairs = zip(self.varied, values, strict=True)
        return vary(self.case, {one: value for row, value in pairs for one in row})

    def evaluate(self, values: Iterable[float], run: Sequence[int]) -> Outcome:
        """Values of the targets under some conditions, by key."""
        stations = [self.stations[place] for place in run]
        try:
            numbers = numbers_of(self.case_at(values), stations, self.targets)
        except FAILURES as error:
            return Outcome(Status("refused", reason(error)))
        return Outcome(IMPOSSIBLE) if numbers is None else Outcome(values=numbers)


def _needs_run(station: Run, targets: Sequence[Target]) -> bool:
    """Whether the targets in motion need a whole solution."""
    here = [one for one in targets if one.station == station]
    names = tuple(one.name for one in here if one.kind == "quantity")
    return station.engine_speed is not None and (
        any(one.kind in IN_RUN for one in here) or not PointRequest(names).light
    )


def numbers_of(case: Case, stations: Sequence[Run], targets: Sequence[Target]) -> Numbers:
    """Values of the ``targets`` of a case under several conditions, by key; None where one does not run.
    Raises as building and running do.
    """
    moving = [station for station in stations if _needs_run(station, targets)]
    here = [one for one in targets if one.station in stations]
    runs, still = dict[Run, Solution](), dict[str, float]()
    if len(moving) > 1 or (moving and Run() in stations) or any(one.kind in IN_RUN for one in here):
        runs, still = _runs(case, moving)
    if not all(run.status.completed for run in runs.values()):
        return None
    numbers: dict[str, float] = {}
    for station in stations:
        asked = [one for one in here if one.station == station]
        if station in runs:
            named: Numbers = {**still, **runs[station].quantities}
        else:
            names = [one.name for one in asked if one.kind == "quantity"]
            rests = station == Run() and set(names) <= still.keys()
            named = still if rests or not names else _named(case, station, names)
        if named is None:
            return None
        for one in asked:
            if one.kind == "quantity":
                numbers[one.key] = named.get(one.name, np.nan)
            elif one.kind in IN_RUN:
                numbers[one.key] = _in_run(runs[station], one)
        if forces := [one for one in asked if one.kind in ("force", "load")]:
            problem = _built(case, station)
            numbers |= {one.key: _force(problem, station, one) for one in forces}
    return numbers


def _built(case: Case, station: Run) -> Problem:
    return build(case, spring_set=station.spring_sets)


def _named(case: Case, station: Run, names: Sequence[str]) -> Numbers:
    """Quantities of a case under a condition, None where it does not run. Preload and frequencies of
    the only spring come from a model alone, in a hundredth of the time that all its numbers take.
    """
    modes = {name: _MODE.fullmatch(name) for name in names}
    word = station.spring_model
    quick = all(name == "preload" or mode for name, mode in modes.items())
    if station.engine_speed is not None or word in ("", WIRE) or not quick:
        rest = word if station.engine_speed is None else ""
        request = PointRequest(tuple(modes), rest)
        outcome = evaluate_case(case, Point(case, (), station, request))
        return outcome.values if outcome.status.completed else None
    problem = _built(case, station)
    spring = _spring(problem, "")
    if reason := spring_model(word).why_not(spring):
        raise InputError(reason, "spring_model")
    model = problem.model_of(word, spring)
    frequencies = dict(enumerate(axial_frequencies(model, MODES), 1))
    return {
        name: float(
            frequencies.get(int(mode[1]), np.nan)
            if mode
            else force_of(spring, model, spring.precompression)
        )
        for name, mode in modes.items()
    }


def _runs(case: Case, stations: Sequence[Run]) -> tuple[dict[Run, Solution], dict[str, float]]:
    """One study of a case at the speeds of ``stations`` that share model and set: the run of each,
    and its numbers at rest.
    """
    models, sets = stations[0].models, stations[0].spring_sets
    speeds = tuple(one.engine_speed for one in stations if one.engine_speed is not None)
    study = run_study(
        RunOfCase(case=case, engine_speeds=speeds, models=models, spring_sets=sets, workers=1)
    )
    still = {name: value for values in study.still.values() for name, value in values.items()}
    label = study.labels[0]
    return {one: study.solution(label, one.engine_speed) for one in stations}, still


def _in_run(run: Solution, one: Target) -> float:
    if one.kind == "event":
        angles = sorted(
            event.cam_angle % (2 * np.pi) for event in run.events if event.kind == one.name
        )
        return angles[round(one.at) - 1] if len(angles) >= one.at else np.nan
    angle = run.cam_angle
    last = angle >= angle[-1] - 2 * np.pi
    turned, values = angle[last] % (2 * np.pi), np.asarray(run.channel(one.name), dtype=float)[last]
    if values.ndim != 1:
        return np.nan
    order = np.argsort(turned, kind="stable")
    return float(np.interp(one.at % (2 * np.pi), turned[order], values[order], period=2 * np.pi))


def _force(problem: Problem, station: Run, one: Target) -> float:
    spring = _spring(problem, one.name)
    model = problem.model_of(
        station.spring_model or (WIRE if spring.wire is not None else CARD), spring
    )
    if one.kind == "force":
        return float(force_of(spring, model, one.at))
    if spring.installed_height is None:
        raise InputError(
            f"the card of spring '{spring.name}' has no installed_height, so heights are not known; give compressions",
            "heights",
        )
    return float(force_of(spring, model, spring.installed_height + spring.precompression - one.at))


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
