"""What a case gives at the places where something was measured: quantities, forces over
compression, events, channels.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError, RunFailedError
from valvetrain.explore.case_paths import vary
from valvetrain.explore.evaluate import MODES, Point, evaluate_case
from valvetrain.explore.measurements import Station, Target
from valvetrain.explore.posterior import Outcome
from valvetrain.explore.space import Varied
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.request import PointRequest
from valvetrain.runs.prepared import FAILURES
from valvetrain.runs.run import run_study
from valvetrain.runs.statics import axial_frequencies, force_of
from valvetrain.runs.workers import LOST, LOST_REMEDY, Lost, StandingPool
from valvetrain.solution.result import Solution
from valvetrain.springs.spec import spring_model
from valvetrain.system.build import build
from valvetrain.system.problem import Problem

Array = NDArray[np.float64]
#: What computes a spring at rest where no model is named: of a wire, of a card.
WIRE, CARD = "finite-element", "massless"
_MODE = re.compile(r"mode_(\d+)_frequency")


@dataclass(frozen=True)
class Observed:
    """A ``case``, what of it is ``varied`` (one row of keys per quantity, moved alike) and the
    ``targets`` to compute.
    """

    case: Case
    varied: tuple[tuple[Varied, ...], ...]
    targets: tuple[Target, ...]

    @property
    def stations(self) -> tuple[Station, ...]:
        """Conditions of the targets, each once."""
        return tuple(dict.fromkeys(one.station for one in self.targets))

    def case_at(self, values: Sequence[float]) -> Case:
        """The case with its quantities at ``values`` (SI). Raises :class:`InputError` for a key
        that is not there, an impossible case.
        """
        return vary(
            self.case,
            {one: value for row, value in zip(self.varied, values, strict=True) for one in row},
        )


#: Values (SI), place of what is observed among all that is, and places of conditions.
Job = tuple[tuple[float, ...], int, tuple[int, ...]]


def observe(every: tuple[Observed, ...], job: Job) -> Outcome:
    """Values of the targets under some conditions, by key; None where the case is impossible or does not
    run.
    """
    values, which, places = job
    observed = every[which]
    with suppress(*FAILURES):
        return numbers_of(
            observed.case_at(values),
            [observed.stations[place] for place in places],
            observed.targets,
        )
    return None


def groups_of(observed: Observed) -> tuple[tuple[int, ...], ...]:
    """Places of conditions parted into those that one study of a case gives together: speeds by one
    model, the static rod with them.
    """
    found: dict[object, list[int]] = {}
    places = range(len(observed.stations))
    whole = [place for place in places if _needs_run(observed.stations[place], observed.targets)]
    for place in whole:
        station = observed.stations[place]
        found.setdefault((station.spring_model, station.spring_set), []).append(place)
    for place in (one for one in places if one not in whole):
        rod = observed.stations[place] == Station() and (WIRE, "") in found
        found.setdefault((WIRE, "") if rod else place, []).append(place)
    return tuple(map(tuple, found.values()))


def _needs_run(station: Station, targets: Sequence[Target]) -> bool:
    """Whether the targets in motion need a whole solution."""
    here = [one for one in targets if one.station == station]
    names = tuple(one.name for one in here if one.kind == "quantity")
    return station.engine_speed is not None and (
        any(one.kind in ("event", "channel") for one in here) or not PointRequest(names).light
    )


def numbers_of(case: Case, stations: Sequence[Station], targets: Sequence[Target]) -> Outcome:
    """Values of the ``targets`` of a case under several conditions, by key; None where one does not run.
    Raises as building and running do.
    """
    moving = [station for station in stations if _needs_run(station, targets)]
    runs, still = (
        _runs(case, moving) if len(moving) > 1 or (moving and Station() in stations) else ({}, {})
    )
    found: dict[str, float] = {}
    for station in stations:
        here = [one for one in targets if one.station == station]
        if station in runs:
            reported: Outcome = _of_run(runs[station], still, here)
        elif (
            runs
            and station == Station()
            and all(one.kind == "quantity" and one.name in still for one in here)
        ):
            reported = {one.key: still[one.name] for one in here}
        else:
            reported = numbers_at(case, station, targets)
        if reported is None:
            return None
        found |= reported
    return found


def numbers_at(case: Case, station: Station, targets: Sequence[Target]) -> Outcome:
    """Values of the ``targets`` of a case under one condition, by key; None where it does not run. Raises
    what building and running raises.
    """
    here = [one for one in targets if one.station == station]
    quantities = [one for one in here if one.kind == "quantity"]
    moving = [one for one in here if one.kind in ("event", "channel")]
    found: dict[str, float] = {}
    if moving:
        runs, still = _runs(case, (station,))
        reported = _of_run(runs[station], still, [*moving, *quantities])
        if reported is None:
            return None
        found |= reported
    elif quantities and station.engine_speed is None and all(_is_quick(one) for one in quantities):
        found |= _quick(case, station, quantities)
    elif quantities:
        rest = station.spring_model if station.engine_speed is None else ""
        request = PointRequest(tuple(dict.fromkeys(one.name for one in quantities)), rest)
        point = Point(
            case, (), station.engine_speed, station.spring_model, station.spring_set, request
        )
        outcome = evaluate_case(case, point)
        if not outcome.status.completed:
            return None
        found |= {one.key: outcome.values.get(one.name, np.nan) for one in quantities}
    forces = [one for one in here if one.kind in ("force", "load")]
    if forces:
        problem = build(case, spring_set=tuple(filter(None, (station.spring_set,))))
        found |= {one.key: _force(problem, station, one) for one in forces}
    return found


def _is_quick(one: Target) -> bool:
    """Whether a number at rest needs neither the whole static curve nor, by a spring model, the
    rod.
    """
    return one.station.spring_model not in ("", WIRE) and (
        one.name == "preload" or _MODE.fullmatch(one.name) is not None
    )


def _quick(case: Case, station: Station, quantities: Sequence[Target]) -> dict[str, float]:
    """Preload and frequencies of the only spring by its model alone, a hundredth of the time that
    all its numbers take.
    """
    spring = _spring(
        problem := build(case, spring_set=tuple(filter(None, (station.spring_set,)))), ""
    )
    if reason := spring_model(station.spring_model).why_not(spring):
        raise InputError(reason, "spring_model")
    model = problem.model_of(station.spring_model, spring)
    frequencies = axial_frequencies(model, MODES)
    found = {}
    for one in quantities:
        mode = _MODE.fullmatch(one.name)
        number = int(mode[1]) - 1 if mode else 0
        reported = float(frequencies[number]) if 0 <= number < len(frequencies) else np.nan
        found[one.key] = reported if mode else float(force_of(spring, model, spring.precompression))
    return found


def _runs(
    case: Case, stations: Sequence[Station]
) -> tuple[dict[Station, Solution], dict[str, float]]:
    """One study of a case at the speeds of ``stations`` that share model and set: the run of each,
    and its numbers at rest.
    """
    models, sets = (
        tuple(filter(None, (word,))) for word in (stations[0].spring_model, stations[0].spring_set)
    )
    speeds = tuple(one.engine_speed for one in stations if one.engine_speed is not None)
    study = run_study(case, engine_speeds=speeds, spring_models=models, spring_sets=sets, workers=1)
    still = {name: value for values in study.still.values() for name, value in values.items()}
    label = study.labels[0]
    return {one: study.solution(label, one.engine_speed) for one in stations}, still


def _of_run(
    run: Solution, still: Mapping[str, float], targets: Sequence[Target]
) -> dict[str, float] | None:
    if not run.status.completed:
        return None
    named = {**still, **run.quantities}
    return {
        one.key: named.get(one.name, np.nan) if one.kind == "quantity" else _in_run(run, one)
        for one in targets
    }


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


def _force(problem: Problem, station: Station, one: Target) -> float:
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


class CaseEvaluator:
    """Points of a case, computed side by side by the ``pool``; a batch is every point under every
    condition of what the pool
    observes at the place ``which``."""

    def __init__(self, pool: StandingPool, which: int) -> None:
        self.pool, self.which, self.groups = pool, which, groups_of(pool.shared[which])

    def __call__(self, points: Array) -> list[Outcome]:
        groups = len(self.groups)
        jobs = [
            (tuple(float(value) for value in point), self.which, group)
            for point in points
            for group in self.groups
        ]
        found = self.pool.map(jobs)
        if any(isinstance(one, Lost) for one in found):
            raise RunFailedError(f"a point is lost: {LOST}; {LOST_REMEDY}")
        outcomes: list[Outcome] = []
        for first in range(0, len(found), groups):
            parts = found[first : first + groups]
            outcomes.append(
                None
                if any(part is None for part in parts)
                else {key: value for part in parts for key, value in part.items()}
            )
        return outcomes
