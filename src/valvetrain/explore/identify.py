"""``valvetrain.identify`` and the calibration of an experiment: from a file, or of a computation of
one's own.
"""

from __future__ import annotations

import re
import timeit
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError, RunFailedError
from valvetrain.explore.case_paths import nominal, vary
from valvetrain.explore.engine import Computation, Engine, Place
from valvetrain.explore.evaluate import MODES, Point, evaluate_case
from valvetrain.explore.execution import Execution, Watch
from valvetrain.explore.identification_file import IdentificationPlan, Search, evaluator_of
from valvetrain.explore.identified import Identified
from valvetrain.explore.measurements import Target
from valvetrain.explore.outputs import Outcome, Run
from valvetrain.explore.posterior import Datum, Evaluate, Numbers, Posterior, Unknown
from valvetrain.explore.solve import solve
from valvetrain.explore.space import Prior, Varied
from valvetrain.explore.store import versions_digest
from valvetrain.parameters.case import Case
from valvetrain.parameters.case_changes import tables_of
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.toml_text import toml_text
from valvetrain.quantities.request import PointRequest
from valvetrain.runs.cluster import on_cluster
from valvetrain.runs.cost import Cost
from valvetrain.runs.prepared import FAILURES
from valvetrain.runs.statics import axial_frequencies, force_of
from valvetrain.runs.workers import LOST, LOST_REMEDY
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
    """A ``case``, what of it is ``varied`` (one row of keys per quantity, moved alike) and the
    ``targets`` to compute.
    """

    case: Case
    varied: tuple[tuple[Varied, ...], ...]
    targets: tuple[Target, ...]

    @cached_property
    def tasks(self) -> tuple[Run, ...]:
        """Conditions of the targets, each once."""
        return tuple(dict.fromkeys(one.station for one in self.targets))

    @property
    def subject(self) -> Any:
        """Case, keys, targets and versions."""
        return [self.case.record().digest, self.varied, self.targets, versions_digest()]

    def evaluate(self, values: Iterable[float], task: Sequence[Any]) -> Outcome:
        """Values of the targets under the conditions of a task, by key."""
        pairs = zip(self.varied, values, strict=True)
        try:
            case = vary(self.case, {one: value for row, value in pairs for one in row})
            numbers = numbers_of(case, Run(*task), self.targets)
        except FAILURES as error:
            return Outcome(Status("refused", reason(error)))
        return Outcome(IMPOSSIBLE) if numbers is None else Outcome(values=numbers)


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


#: Points of the priors that are tried until one can be computed; bytes of a stored point and
#: of each of its numbers.
TRIED, POINT_BYTES, NUMBER_BYTES = 40, 1000.0, 150.0
#: Times a point is timed, for the first may wait for kernels; points that a computation of one's own gets at once, at most.
ROUNDS, TOGETHER = 3, 1_000_000


@dataclass(frozen=True, eq=False)
class FunctionPoints(Computation):
    """Points that a ``function`` computes, many at a time; ``subject``: all that they depend on besides their values."""

    function: Evaluate
    subject: Any = ""

    def evaluate(self, values: Iterable[float], task: Any) -> Outcome:
        """The outcome of one point."""
        return self.outcomes([(tuple(values), task)])[0]

    def outcomes(self, places: Sequence[Place]) -> list[Outcome]:
        """The outcomes of a batch."""
        numbers = self.function(np.array([values for values, _ in places]))
        return [Outcome(IMPOSSIBLE) if one is None else Outcome(values=one) for one in numbers]


def identify_points(
    priors: Mapping[str, Prior],
    measurements: Sequence[Datum],
    evaluate: Evaluate,
    search: Search | None,
    folder: Path | None,
    watch: Watch,
) -> Identified:
    """The identification of a computation of one's own, as :func:`valvetrain.identify` takes it."""
    unknowns = tuple(Unknown(name, prior) for name, prior in priors.items())
    points = FunctionPoints(evaluate, repr((unknowns, tuple(measurements))))
    with Engine((points,), 1, folder, TOGETHER) as engine:
        posterior = Posterior(unknowns, tuple(measurements), numbers_by(engine, points))
        return solve(posterior, search or Search(), engine.store, report=watch.report)


def numbers_by(engine: Engine, computation: Computation) -> Evaluate:
    """What gives the numbers of points by the key of each output: those of all tasks, None where one did not complete.

    It raises :class:`RunFailedError` where a point is lost with its worker.
    """
    tasks = computation.tasks

    def numbers_of_point(outcomes: Sequence[Outcome]) -> Numbers:
        if not all(one.status.completed for one in outcomes):
            return None
        return {
            computation.key_of_output(name, task): value
            for task, one in zip(tasks, outcomes, strict=True)
            for name, value in one.values.items()
        }

    def evaluate(points: Array) -> list[Numbers]:
        rows = [tuple(row) for row in np.asarray(points, dtype=float).tolist()]
        outcomes = engine.outcomes([(computation, row, task) for row in rows for task in tasks])
        if any(one.status.code == "worker-lost" for one in outcomes):
            raise RunFailedError(f"a point is lost: {LOST}; {LOST_REMEDY}")
        count = len(tasks)
        return [numbers_of_point(outcomes[count * k : count * (k + 1)]) for k in range(len(rows))]

    return evaluate


def run_identification(
    plan: IdentificationPlan, execution: Execution = Execution(), watch: Watch = Watch()
) -> Identified:
    """The identification of a plan; points that are stored are not computed again.

    Raises :class:`InputError` for a request beyond its limit, and where nothing can be computed.
    """
    fitted, compared = computations_of(plan)
    start = None
    try:
        start = np.array(values_of_case(plan))
    except InputError:  # it has no single ones
        if plan.search.from_case:
            raise
    units = {one.key: one.unit for one in plan.targets}
    sought = Sought(plan.unknowns, plan.data, fitted, compared, start, units)
    result = identify_sought(sought, plan.search, execution, watch)
    result = replace(result, text=plan.text, name=plan.title)
    return replace(result, case_file=identified_case(plan, result.best))


@dataclass(frozen=True, eq=False)
class Sought:
    """What is identified: ``unknowns``, ``data``, what computes points of both and, for the draws alone, what is
    ``compared``; values ``start`` (SI) of the case, and ``units`` of computed numbers.
    """

    unknowns: tuple[Unknown, ...]
    data: tuple[Datum, ...]
    fitted: Computation
    compared: Computation | None = None
    start: Array | None = None
    units: Mapping[str, str] = field(default_factory=dict)


def identify_sought(
    sought: Sought, search: Search, execution: Execution, watch: Watch
) -> Identified:
    """The answer of a search whose cost, by the time of one point, is within its limit."""
    fitted, compared = sought.fitted, sought.compared
    computations = (fitted, *filter(None, [compared]))
    with (
        on_cluster(execution.dask, execution.workers) as workers,
        Engine(computations, workers, execution.output) as engine,
    ):
        posterior = Posterior(sought.unknowns, sought.data, numbers_by(engine, fitted))
        seconds = _seconds(fitted, possible_point(fitted, posterior, search.seed))
        points = search.evaluations_of(len(sought.unknowns))
        left = max(points - engine.store.before // len(fitted.tasks), 0)
        total = left * seconds
        if compared is not None:
            total += (search.draws + 2) * _seconds(compared, posterior.middle)
        size = points * (POINT_BYTES + NUMBER_BYTES * len(sought.data))
        work = f"{left} points of {1e3 * seconds:.3g} ms"
        watch.admit(Cost(total / workers, size), execution.limit, work)
        others = None if compared is None else numbers_by(engine, compared)
        return solve(
            posterior, search, engine.store, start=sought.start, report=watch.report, compare=others, units=sought.units
        )  # fmt: skip


def computations_of(plan: IdentificationPlan) -> tuple[Computation, Computation | None]:
    """What computes the points of a plan: its case under the conditions of which something is fitted, or the evaluator it
    names; and what computes it under the others, for the draws alone (None where there are none).
    """
    if plan.evaluator:
        names = tuple(one.name for one in plan.unknowns)
        function = evaluator_of(plan.evaluator).points(names, dict(plan.options))
        subject = [plan.evaluator, names, plan.options, versions_digest()]
        return FunctionPoints(partial(_one_by_one, function), subject), None
    fitted, measured = {one.key for one in plan.data if one.used}, {one.key for one in plan.data}
    stations = {one.station for one in plan.targets if one.key in fitted}
    first = tuple(one for one in plan.targets if one.station in stations and one.key in measured)
    later = tuple(one for one in plan.targets if one not in first)
    both = (Observed(plan.case, plan.varied, first), Observed(plan.case, plan.varied, later))
    return both if later else (both[0], None)


def _one_by_one(function: Callable[[Sequence[float]], Numbers], points: Array) -> list[Numbers]:
    return [function(row) for row in points.tolist()]


def identified_case(plan: IdentificationPlan, best: Mapping[str, float]) -> str:
    """Text of the case of a plan with the values ``best`` (SI); empty of an evaluator of points, and for
    values that no file of the case can hold.
    """
    if plan.evaluator:
        return ""
    pairs = zip(plan.unknowns, plan.varied, strict=True)
    try:
        case = vary(plan.case, {one: best[unknown.name] for unknown, row in pairs for one in row})
    except InputError:
        return ""
    tree = dict(tables_of(case).bare) | {"title": f"{plan.title}: identified"}
    return toml_text({key: one for key, one in tree.items() if key not in ("study", "description")})


def values_of_case(plan: IdentificationPlan) -> tuple[float, ...]:
    """The values (SI) that the case itself holds of the quantities; a factor is one, an offset
    zero. Raises :class:`InputError` for one that cannot be read from it.
    """
    if plan.evaluator:
        names = tuple(one.name for one in plan.unknowns)
        return tuple(evaluator_of(plan.evaluator).values(names))
    try:
        return tuple(nominal(plan.case, row[0]) for row in plan.varied)
    except InputError as error:
        raise InputError(f"{error.where} {error.reason}", "search.from_case") from None


def possible_point(computation: Computation, posterior: Posterior, seed: int) -> Array:
    """Values (SI) of a point that gives every measured number: the middle of the priors or one drawn
    from them. Raises :class:`InputError` where none of several does.
    """
    shares = np.random.default_rng(seed).random((TRIED, len(posterior.unknowns)))
    lacking = ""
    for work in np.vstack([posterior.centre, posterior.from_shares(shares)])[:, None, :]:
        (numbers,) = posterior.outcomes(work)
        given = tuple(key for key, value in (numbers or {}).items() if np.isfinite(value))
        missing = next((one.key for one in posterior.used if one.key not in given), None)
        if missing is None:
            return np.asarray(posterior.values(work)[0])
        if numbers is not None and not lacking:
            lacking = f"no point gives '{missing[:80]}'; {nearest(missing, given)}"
    if lacking:
        raise InputError(lacking, "measurements")
    outcomes = (computation.evaluate(posterior.middle.tolist(), task) for task in computation.tasks)
    why = next(
        (one.status.message for one in outcomes if not one.status.completed), "a number is missing"
    )
    raise InputError(
        f"none of {TRIED + 1} points of the priors can be computed, at their middle because: {why}"
    )


def _seconds(computation: Computation, values: Array) -> float:
    """Shortest time (s) of a point."""
    at = values.tolist()
    return min(
        timeit.repeat(
            lambda: [computation.evaluate(at, task) for task in computation.tasks],
            number=1,
            repeat=ROUNDS,
        )
    )
