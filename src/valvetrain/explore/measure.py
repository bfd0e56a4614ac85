"""Measures of a design, objectives and constraints on them; and a design of a search with its numbers: feasible ones come first."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.engine import Engine, Evaluation, PointJob
from valvetrain.explore.limit_speed import BELOW, LimitFound, limit_of
from valvetrain.explore.outputs import LimitSearch, Outcome, Run, has_pair
from valvetrain.solution.critical import RPM
from valvetrain.solution.definition import definition_of, not_given, of_pair, shown

if TYPE_CHECKING:
    from valvetrain.explore.objective import OptimumPlan

#: Where a number comes from: springs at rest, runs at the speeds of the file, runs of a search for
#: a limit speed.
REST, RUNS, LIMIT = "rest", "runs", "limit"
#: Status of a design whose points lack a number that was requested.
INCOMPLETE = "incomplete"
Array = NDArray[np.float64]
#: Penalty of a bound without a number, as a share of the bound: beyond any that is
#: computed.
UNKNOWN = 1e6


@dataclass(frozen=True)
class Measure:
    """One number of a design: ``quantity`` over ``runs``, the ``over`` (worst, mean) of several, or
    a limit speed where ``limit`` is given.

    ``largest_is_worst`` gives which of several is the worst. ``label``: plain words. ``optional``: a
    run need not give it.
    """

    source: str
    quantity: str
    runs: tuple[Run, ...]
    label: str
    largest_is_worst: bool = True
    over: str = "worst"
    limit: LimitSearch | None = None
    optional: bool = False

    @property
    def output(self) -> str:
        """Name of the number in the outcome of a run."""
        return self.quantity if self.limit is None else self.limit.name

    @property
    def is_contact_force(self) -> bool:
        """Whether it is a least force of a contact, which is zero however much the contact is lost."""
        name = self.quantity
        return (
            name.startswith("minimum_") and name.endswith("_contact_force") and self.limit is None
        )

    @property
    def si_unit(self) -> str:
        """SI unit of its values."""
        return "rad/s" if self.limit is not None else definition_of(self.quantity).si_unit

    @property
    def unit(self) -> str:
        """Unit in which tables show it."""
        return "rpm" if self.limit is not None else definition_of(self.quantity).unit_word

    def shown(self, value: float) -> float:
        """A value (SI) in the unit of tables."""
        return value / RPM if self.limit is not None else float(shown(self.quantity, value)[0])

    def of(self, values: Sequence[float]) -> float:
        """The number of several runs; nan where one is missing."""
        if not len(values) or not all(map(np.isfinite, values)):
            return float("nan")
        if self.over == "mean":
            return float(np.mean(values))
        return float(max(values) if self.largest_is_worst else min(values))


@dataclass(frozen=True)
class Objective:
    """A measure to be made small or, where ``maximise``, large."""

    measure: Measure
    maximise: bool

    @property
    def sign(self) -> float:
        """Factor that makes smaller better."""
        return -1.0 if self.maximise else 1.0


@dataclass(frozen=True)
class Constraint:
    """A measure to be at or below (``upper``), or at or above, ``bound`` (SI), ``share`` of what the
    case has where that is given.
    """

    measure: Measure
    upper: bool
    bound: float
    share: float | None = None
    scale: float = 1.0

    def missed(self, value: float) -> float:
        """How far a value (SI) is beyond the bound, in shares of its size; negative inside."""
        return float((value - self.bound) * (1.0 if self.upper else -1.0) / self.scale)


@dataclass(frozen=True)
class Measured:
    """Numbers (SI) of measures of one design, nan where there is none; brackets of its limit
    speeds; ``failure`` in words, else empty.
    """

    values: Mapping[Measure, float]
    limits: Mapping[Measure, tuple[LimitFound, ...]]
    failure: str = ""
    code: str = "completed"


#: Evaluations of a plan by source or limit; values (SI) of a design, none for the case as it is.
Evaluations = Mapping[str | LimitSearch, Evaluation]
Values = tuple[float, ...]
Stop = Callable[[Mapping[Measure, float]], bool]


def measure_designs(
    engine: Engine,
    sources: Evaluations,
    designs: Sequence[Values],
    measures: Sequence[Measure],
    stop: Stop | None = None,
) -> list[Measured]:
    """The numbers of every design, in order: at rest first, then of the runs, then limit speeds.

    A design that fails is not computed any further. ``stop(values)`` may spare it the search for
    limit speeds.
    """
    results = [Measured({}, {}) for _ in designs]
    for stage in (REST, RUNS, LIMIT):
        here = [one for one in measures if one.source == stage]
        going = [
            place
            for place, one in enumerate(results)
            if not one.failure and not (stage == LIMIT and stop is not None and stop(one.values))
        ]
        asks = list(dict.fromkeys((one.limit or stage, run) for one in here for run in one.runs))
        jobs: list[PointJob] = [
            (sources[key], designs[place], run) for place in going for key, run in asks
        ]
        outcomes = iter(engine.outcomes(jobs))
        for place in going:
            answers = {ask: next(outcomes) for ask in asks}
            results[place] = _with_answers(results[place], here, answers, sources)
    return results


def _with_answers(
    before: Measured,
    measures: Sequence[Measure],
    answers: Mapping[tuple[str | LimitSearch, Run], Outcome],
    sources: Evaluations,
) -> Measured:
    """What was measured so far and the numbers of one stage, or why one is missing."""
    values, limits = dict(before.values), dict(before.limits)
    for one in measures:
        outcomes = [answers[one.limit or one.source, run] for run in one.runs]
        values[one] = one.of([outcome.values.get(one.output, np.nan) for outcome in outcomes])
        if one.limit is not None and np.isfinite(values[one]):
            limits[one] = tuple(map(limit_of, outcomes))
    for (_, run), outcome in answers.items():
        if not outcome.status.completed:
            at = "" if run[0] is None else f"at {run[0] / RPM:.6g} rpm: "
            return Measured(values, limits, at + outcome.status.sentence(), outcome.status.code)
    lacking = [one for one in measures if not np.isfinite(values[one]) and not one.optional]
    if lacking:
        name, pair = lacking[0].quantity, any(map(_has_pair, sources.values()))
        return Measured(values, limits, not_given(name, of_pair(name) if pair else ()), INCOMPLETE)
    return Measured(values, limits)


def _has_pair(one: Evaluation) -> bool:
    return one.case is not None and has_pair(one.case, one.runs)


@dataclass(frozen=True, eq=False)
class Trial:
    """``number`` counts from 0, the case itself; ``values`` (d, SI) of the varied quantities;
    ``measured``: its numbers. ``plan`` holds bounds and directions.
    """

    number: int
    values: Array
    measured: Measured
    plan: OptimumPlan

    def to_dict(self) -> dict[str, Any]:
        """Its numbers (SI), its end in a word, and the brackets of its limit speeds."""
        names = (
            "number",
            "values",
            "objectives",
            "constraints",
            "missed",
            "state",
            "failure",
        )
        limits = [one for every in self.measured.limits.values() for one in every]
        return {name: getattr(self, name) for name in names} | {"limits": limits}

    @property
    def failure(self) -> str:
        """Why it could not be computed, empty where it was."""
        return self.measured.failure

    @cached_property
    def objectives(self) -> Array:
        """Objectives (m,) in SI, nan where they were not computed."""
        return np.array(
            [self.measured.values.get(one.measure, np.nan) for one in self.plan.objectives]
        )

    @cached_property
    def costs(self) -> Array:
        """Objectives (m,) with the sign that makes less better."""
        return self.objectives * [one.sign for one in self.plan.objectives]

    @cached_property
    def constraints(self) -> Array:
        """Values (c,) in SI of what is bounded."""
        return np.array(
            [self.measured.values.get(one.measure, np.nan) for one in self.plan.constraints]
        )

    @cached_property
    def missed(self) -> Array:
        """By how much (c + m,) each bound is missed, in shares of it, negative inside.

        A contact force of zero misses its bound by the share of the cycle without contact in addition. The last
        m are of the objectives: 0, or more where a limit speed is below the lowest one searched.
        """
        missed = [
            one.missed(value) + (self.lost if one.measure.is_contact_force and value <= 0 else 0.0)
            for one, value in zip(self.plan.constraints, self.constraints, strict=True)
        ]
        for goal in self.plan.objectives:
            brackets = self.measured.limits.get(goal.measure, ())
            below = [1e-9 + one.missed for one in brackets if one.kind == BELOW]
            missed.append(max(below, default=0.0))
        return np.array(missed)

    @cached_property
    def losses(self) -> tuple[float, ...]:
        """Time without contact (s), loft (m) and negative rigid margin (N), 0 where they were not computed."""
        values = ((one, self.measured.values.get(one, 0.0)) for one in self.plan.losses)
        return tuple(
            float(np.nan_to_num(value if one.largest_is_worst else -value)) for one, value in values
        )

    @property
    def lost(self) -> float:
        """Share of the cycle without contact, at the highest speed."""
        speeds = [run[0] or 0.0 for one in self.plan.losses for run in one.runs]
        return self.losses[0] * max(speeds) / (4 * np.pi) if speeds else 0.0

    @cached_property
    def feasible(self) -> bool:
        """Whether it was computed, all bounds are met and all objectives are there."""
        met = bool(np.all(self.missed <= 0.0)) and bool(np.all(np.isfinite(self.objectives)))
        return met and not self.failure

    @cached_property
    def rank(self) -> tuple[float, ...]:
        """Order of designs: feasible ones by the first objective, then by what is missed, then those that failed.

        Of equals the one that loses contact least goes first, then the first.
        """
        if self.feasible:
            return (0.0, float(self.costs[0]), *self.losses, self.number)
        if self.failure:
            return (2.0, self.number)
        missed = sum(max(0.0, one) for one in self.penalties)
        return (1.0, missed, *self.losses[1:], self.number)

    @property
    def penalties(self) -> list[float]:
        """Missed shares (c + m) of the bounds, large where there is no number."""
        missed = np.full(len(self.missed), UNKNOWN) if self.failure else self.missed
        return [float(one) for one in np.nan_to_num(missed, nan=UNKNOWN)]

    @property
    def state(self) -> str:
        """Its end in a word."""
        return self.measured.code if self.failure else "feasible" if self.feasible else "infeasible"

    def beats(self, other: Trial) -> bool:
        """Whether it is no worse in any objective, and better in one (both feasible)."""
        return bool(np.all(self.costs <= other.costs) and np.any(self.costs < other.costs))


def best_of(trials: Sequence[Trial]) -> Trial | None:
    """The first of the feasible trials by their rank; None where there is none."""
    first = min(trials, key=lambda one: one.rank)
    return first if first.feasible else None


def front_of(trials: Sequence[Trial]) -> list[Trial]:
    """Feasible trials that no other beats, each set of objectives once, by the first objective."""
    by_costs = dict[bytes, Trial]()
    for one in trials:
        if one.feasible:
            by_costs.setdefault(one.costs.tobytes(), one)
    costs = np.array([one.costs for one in by_costs.values()])
    front = [
        one
        for one in by_costs.values()
        if not np.any(np.all(costs <= one.costs, axis=1) & np.any(costs < one.costs, axis=1))
    ]
    return sorted(front, key=lambda one: (*one.costs, one.number))
