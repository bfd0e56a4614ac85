"""Measures of a design: one number from the runs of a quantity, or a limit speed; objectives and constraints on them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from valvetrain.explore.engine import Engine, Evaluation
from valvetrain.explore.files import (
    MAX_VARIED,
    Amount,
    CaseModel,
    Limit,
    ModelNames,
    RunsModel,
    Speeds,
    VaryModel,
)
from valvetrain.explore.limit_speed import LimitFound, limit_of
from valvetrain.explore.outputs import LimitSearch, Outcome, Run, Task, missing_text
from valvetrain.parameters.case import Case
from valvetrain.parameters.schema_types import Line, StrictModel, problem
from valvetrain.quantities.request import PointRequest
from valvetrain.solution.critical import RPM
from valvetrain.solution.definition import definition_of, shown

#: Order in which numbers are computed: of springs at rest, of runs, limit speeds.
REST, RUNS, LIMIT = range(3)
#: Status of a design whose points lack a number that was requested.
INCOMPLETE = "incomplete"


@dataclass(frozen=True)
class Measure:
    """One number of a design: ``quantity`` over ``runs``, the ``over`` (worst, mean) of several, or
    a limit speed where ``limit`` is given.

    ``largest_is_worst`` gives which of several is the worst. ``label``: plain words. ``optional``: a
    run need not give it.
    """

    quantity: str
    runs: tuple[Run, ...]
    label: str
    largest_is_worst: bool = True
    over: str = "worst"
    limit: LimitSearch | None = None
    optional: bool = False

    @property
    def stage(self) -> int:
        """When it is computed: :data:`REST`, :data:`RUNS` or :data:`LIMIT`."""
        return LIMIT if self.limit is not None else REST if self.runs[0][0] is None else RUNS

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
        return definition_of(self.output).si_unit

    @property
    def unit(self) -> str:
        """Unit in which tables show it."""
        return definition_of(self.output).unit_word

    def shown(self, value: float) -> float:
        """A value (SI) in the unit of tables."""
        return float(shown(self.output, value)[0])

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


#: Values (SI) of a design, none for the case as it is; the run of a measure with its limit.
Values = tuple[float, ...]
Place = tuple[LimitSearch | None, Run]
Stop = Callable[[Mapping[Measure, float]], bool]


def tasks_of(measures: Sequence[Measure], rest_model: str) -> dict[Place, Task]:
    """What is computed for measures, each run with its quantities once."""
    names: dict[Place, dict[str, None]] = {}
    for one in measures:
        for run in one.runs:
            names.setdefault((one.limit, run), {})[one.quantity] = None
    return {
        (limit, run): Task(run, PointRequest(tuple(each), rest_model), limit)
        for (limit, run), each in names.items()
    }


def measure_designs(
    engine: Engine,
    experiment: Evaluation,
    designs: Sequence[Values],
    measures: Sequence[Measure],
    rest_model: str = "",
    stop: Stop | None = None,
) -> list[Measured]:
    """The numbers of every design, in order: at rest first, then of the runs, then limit speeds.

    A design that fails is not computed any further. ``stop(values)`` may spare it the search for
    limit speeds.
    """
    results = [Measured({}, {}) for _ in designs]
    for stage in (REST, RUNS, LIMIT):
        here = [one for one in measures if one.stage == stage]
        going = [
            place
            for place, one in enumerate(results)
            if not one.failure and not (stage == LIMIT and stop is not None and stop(one.values))
        ]
        tasks = tasks_of(here, rest_model)
        jobs = [(experiment, designs[place], task) for place in going for task in tasks.values()]
        outcomes = iter(engine.outcomes(jobs))
        for place in going:
            answers = {key: next(outcomes) for key in tasks}
            results[place] = _with_answers(results[place], here, answers, experiment.case)
    return results


def _with_answers(
    before: Measured,
    measures: Sequence[Measure],
    answers: Mapping[Place, Outcome],
    case: Case | None,
) -> Measured:
    """What was measured so far and the numbers of one stage, or why one is missing."""
    values, limits = dict(before.values), dict(before.limits)
    for one in measures:
        outcomes = [answers[one.limit, run] for run in one.runs]
        values[one] = one.of([outcome.values.get(one.output, np.nan) for outcome in outcomes])
        if one.limit is not None and np.isfinite(values[one]):
            limits[one] = tuple(map(limit_of, outcomes))
    for (_, run), outcome in answers.items():
        if not outcome.status.completed:
            at = "" if run[0] is None else f"at {run[0] / RPM:.6g} rpm: "
            return Measured(values, limits, at + outcome.status.sentence(), outcome.status.code)
    lacking = [one for one in measures if not np.isfinite(values[one]) and not one.optional]
    if lacking:
        text = missing_text(lacking[0].quantity, case, lacking[0].runs)
        return Measured(values, limits, text, INCOMPLETE)
    return Measured(values, limits)


#: Most objectives and constraints of a file and trials of a search: more are taken for a mistake.
MAX_OBJECTIVES, MAX_CONSTRAINTS, MAX_TRIALS, MAX_PER_ROUND = 4, 32, 20_000, 256


class MeasureModel(StrictModel):
    """What objectives and constraints share: a ``quantity`` or a ``limit_speed``, at which engine
    speeds, which of several counts.
    """

    quantity: str = ""
    limit_speed: Limit | None = None
    engine_speeds: Speeds | None = None
    over: Literal["worst", "mean"] = "worst"
    label: Line = ""

    @model_validator(mode="after")
    def _one_measure(self) -> Self:
        if bool(self.quantity) == (self.limit_speed is not None):
            both = "both a quantity and a limit_speed" if self.quantity else "nothing"
            raise problem(f"names {both}; give one of the two")
        if self.limit_speed is not None and self.engine_speeds is not None:
            reason = "a limit_speed has engine_speeds of its own; give them there"
            raise problem(reason, ("engine_speeds",))
        return self


class ObjectiveModel(MeasureModel):
    """One ``[[objective]]`` table."""

    direction: Literal["minimise", "maximise"]


class ConstraintModel(MeasureModel):
    """One ``[[constraint]]`` table: bounds with unit, or ``"1.0 x case"``, that share of what the
    case itself has.
    """

    at_most: Amount | None = None
    at_least: Amount | None = None

    @model_validator(mode="after")
    def _some_bound(self) -> Self:
        if self.at_most is None and self.at_least is None:
            raise problem(
                "has no bound; give at_most, at_least or both, such as at_most = '900 MPa' or '1.0 x case'"
            )
        return self


class SearchModel(StrictModel):
    """The ``[search]`` table. ``per_round`` trials are requested together, whatever the workers. ``local``: share of the
    trials that a local search about the best has at the end, of one objective.
    """

    method: Literal["tpe", "nsga2"] = "tpe"
    trials: Annotated[int, Field(ge=1, le=MAX_TRIALS)] = 100
    per_round: Annotated[int, Field(ge=1, le=MAX_PER_ROUND)] = 8
    seed: Annotated[int, Field(ge=0, le=2**31)] = 1
    local: Annotated[float, Field(ge=0.0, le=0.9)] = 0.4

    @model_validator(mode="after")
    def _whole_generations(self) -> Self:
        if self.method == "nsga2" and self.per_round < 4:
            raise problem(
                "a generation of nsga2 has 4 trials or more; raise per_round, 16 to 40 are typical",
                ("per_round",),
            )
        return self


class GoalsModel(RunsModel):
    """What a search looks for: objectives within constraints."""

    title: Line = ""
    description: Line = ""
    objective: list[ObjectiveModel] = Field(min_length=1, max_length=MAX_OBJECTIVES)
    constraint: list[ConstraintModel] = Field(default_factory=list, max_length=MAX_CONSTRAINTS)
    search: SearchModel = SearchModel()


class OptimumModel(GoalsModel, CaseModel):
    """The whole file."""

    what = "optimisation file"
    vary: list[VaryModel] = Field(min_length=1, max_length=MAX_VARIED)
    confirm: ModelNames = Field(default_factory=list, max_length=8)
