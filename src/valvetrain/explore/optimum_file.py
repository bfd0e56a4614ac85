"""An optimisation file: case, what is varied, objectives, constraints, search. TOML in, one typed
table out, or one sentence.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

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
from valvetrain.parameters.schema_types import Line, StrictModel, problem

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
