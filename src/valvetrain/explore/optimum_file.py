"""An optimisation file: case, what is varied, objectives, constraints, search. TOML in, one typed
table out, or one sentence.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from valvetrain.explore.files import (
    MAX_VARIED,
    Amount,
    FileText,
    Names,
    VaryModel,
    text_of_file,
)
from valvetrain.parameters.schema_types import Line, StrictModel, problem

#: Most objectives and constraints of a file, trials of a search and searches of other seeds: more
#: are taken for a mistake.
MAX_OBJECTIVES, MAX_CONSTRAINTS, MAX_TRIALS, MAX_SEEDS, MAX_PER_ROUND = 4, 32, 20_000, 20, 256
#: Default width of the bracket of a limit speed.
RESOLUTION = "10 rpm"
Direction = Literal["minimise", "maximise"]
Method = Literal["tpe", "nsga2"]


def _speeds(raw: Any) -> Any:
    if not isinstance(raw, (str, list)):
        raise problem(
            "holds no engine speeds; write such as '4000, 6000 rpm' or '4000:9000:250 rpm'"
        )
    return raw


def _confirmations(raw: Any) -> Any:
    if isinstance(raw, str):
        raw = [word.strip() for word in raw.split(",")]
    if not isinstance(raw, list):
        raise problem(
            "is no row of models; write such as confirm = ['wave-rod-clash'], or [[confirm]] tables"
        )
    return [{"spring_model": one} if isinstance(one, str) else one for one in raw]


Speeds = Annotated[str | list[Any], BeforeValidator(_speeds)]


class LimitSpeedModel(StrictModel):
    """``limit_speed``: the engine speed up to which a quantity stays within a bound, or control is maintained
    (``kind``), searched over ``engine_speeds`` from below.
    """

    kind: str = ""
    quantity: str = ""
    at_most: Amount | None = None
    at_least: Amount | None = None
    engine_speeds: Speeds
    resolution: Amount = RESOLUTION


class MeasureModel(StrictModel):
    """What objectives and constraints share: a ``quantity`` or a ``limit_speed``, at which engine
    speeds, which of several counts.
    """

    quantity: str = ""
    limit_speed: LimitSpeedModel | None = None
    engine_speeds: Speeds | None = None
    over: Literal["worst", "mean"] = "worst"
    label: Line = ""


class ObjectiveModel(MeasureModel):
    """One ``[[objective]]`` table."""

    direction: Direction


class ConstraintModel(MeasureModel):
    """One ``[[constraint]]`` table: bounds with unit, or ``"1.0 x case"``, that share of what the
    case itself has.
    """

    at_most: Amount | None = None
    at_least: Amount | None = None


class SearchModel(StrictModel):
    """The ``[search]`` table. ``per_round`` trials are requested together, whatever the workers;
    ``seeds`` searches show their scatter;
    ``local``: share of the trials that a local search about the best has at the end, of one
    objective.
    """

    method: Method = "tpe"
    trials: Annotated[int, Field(ge=1, le=MAX_TRIALS)] = 100
    per_round: Annotated[int, Field(ge=1, le=MAX_PER_ROUND)] = 8
    seed: Annotated[int, Field(ge=0, le=2**31)] = 1
    seeds: Annotated[int, Field(ge=1, le=MAX_SEEDS)] = 1
    local: Annotated[float, Field(ge=0.0, le=0.9)] = 0.4


class ConfirmModel(StrictModel):
    """One ``[[confirm]]`` table: another spring model, or the case with ``changes`` such as a finer
    mesh, for the best design.
    """

    spring_model: str = ""
    changes: dict[str, Any] = Field(default_factory=dict)
    label: Line = ""


class OptimumModel(StrictModel):
    """The whole file."""

    title: Line = ""
    description: Line = ""
    case: str
    changes: dict[str, Any] = Field(default_factory=dict)
    engine_speeds: Speeds | None = None
    spring_models: Names = Field(default_factory=list)
    spring_sets: Names = Field(default_factory=list)
    rest_model: str = ""
    objective: list[ObjectiveModel] = Field(min_length=1, max_length=MAX_OBJECTIVES)
    constraint: list[ConstraintModel] = Field(default_factory=list, max_length=MAX_CONSTRAINTS)
    vary: list[VaryModel] = Field(min_length=1, max_length=MAX_VARIED)
    search: SearchModel = SearchModel()
    confirm: Annotated[list[ConfirmModel], BeforeValidator(_confirmations)] = Field(
        default_factory=list, max_length=8
    )


class OptimumText(FileText[OptimumModel]):
    """An optimisation file read."""

    def __init__(self, text: str, where: str, folder: Path) -> None:
        super().__init__(text, where, folder, OptimumModel, "optimisation file")

    @classmethod
    def of_tables(cls, tables: dict[str, Any], where: str) -> OptimumText:
        """The same from the tables of a program."""
        made = cls.__new__(cls)
        made.text, made.where, made.folder = "", where, Path()
        made._read(tables, OptimumModel)
        return made


def read_optimum_file(path: Path) -> OptimumText:
    """The optimisation file at ``path``. Raises :class:`InputError`, one sentence with file, line
    and key.
    """
    return OptimumText(text_of_file(path, "optimisation file"), path.name[:60], path.parent)
