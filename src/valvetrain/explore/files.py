"""What the files of studies, searches and identifications share: reading, vocabulary, case and
varied quantities.

TOML in, typed tables out, or one sentence with file, line and key.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from typing import Annotated, Any, ClassVar, Generic, Literal, Self, TypeVar

from pydantic import AfterValidator, BeforeValidator, Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from valvetrain.errors import InputError
from valvetrain.explore.case_paths import nominal, unit_in_case, unit_of, vary
from valvetrain.explore.distributions import (
    SIGMAS,
    Distribution,
    LogNormal,
    Normal,
    Prior,
    Uniform,
    Values,
)
from valvetrain.explore.outputs import LimitSearch, limit_search
from valvetrain.explore.samplers import MAX_POINTS
from valvetrain.explore.space import ENGINE_SPEED, Operation, Space, Varied
from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import library_names, load_case, parse_toml, read_text
from valvetrain.parameters.overrides import REMOVED
from valvetrain.parameters.schema_types import (
    Line,
    StrictModel,
    first_problem,
    guarded,
    problem,
    validate_as,
)
from valvetrain.parameters.toml_text import find_line
from valvetrain.registry import find
from valvetrain.units import dimension_of, parse_quantities, parse_quantity, si_speeds

#: Most quantities that a study varies.
MAX_VARIED = 64
#: Other name of a key -> the standard one, in all three kinds of file.
ALIASES = {"set": "changes", "prior": "distribution", "quantities": "vary"}
#: Key that says in which way values are given -> the key that it needs with it, and the names of the
#: distributions that this makes.
WAYS: dict[str, tuple[str, tuple[str, ...]]] = {
    "values": ("values", ("values",)),
    "tolerance": ("tolerance", ("tolerance",)),
    "mean": ("standard_deviation", ("normal", "truncated-normal")),
    "median": ("factor", ("lognormal",)),
    "low": ("high", ("uniform", "log-uniform")),
}
#: Keys that say values, and those that may stand beside a way.
SAYING = {*WAYS, "high", "standard_deviation", "factor", "shape"}
BESIDE = {"mean": {"low", "high"}, "median": {"low", "high"}, "tolerance": {"shape"}}


def _amount(raw: Any) -> Any:
    if isinstance(raw, bool) or not isinstance(raw, (str, int, float)):
        raise problem(
            "is no number; write such as '3.77 mm', or a plain number where there is no unit"
        )
    return raw


def _amounts(raw: Any) -> Any:
    if not isinstance(raw, (str, list)) or not all(
        isinstance(one, (str, int, float)) for one in raw
    ):
        raise problem("is no row of numbers; write such as '3.7, 3.8 mm' or [1, 2, 4]")
    return raw


def _plain_name(raw: Any) -> Any:
    return [word.strip() for word in raw.split(",")] if isinstance(raw, str) else raw


def _speeds(raw: Any) -> tuple[float, ...]:
    if not isinstance(raw, (str, list)):
        raise problem(
            "holds no engine speeds; write such as '4000, 6000 rpm' or '4000:9000:250 rpm'"
        )
    speeds: tuple[float, ...] = guarded(si_speeds, raw)
    return speeds


def _model(raw: str) -> str:
    if raw:
        guarded(find, "springs", raw)
    return raw


Amount = Annotated[str | int | float, BeforeValidator(_amount)]
Amounts = Annotated[str | list[Any], BeforeValidator(_amounts)]
Names = Annotated[list[str], BeforeValidator(_plain_name)]
#: Engine speeds, read as rad/s; name of a spring model; several of them.
Speeds = Annotated[tuple[float, ...], BeforeValidator(_speeds)]
ModelName = Annotated[str, AfterValidator(_model)]
ModelNames = Annotated[list[ModelName], BeforeValidator(_plain_name)]


class VaryModel(StrictModel):
    """One ``[[vary]]`` table: a key of the case and the values it takes, in exactly one of the ways
    below.

    ``values`` one by one; ``low`` and ``high``; ``mean`` and ``standard_deviation``, cut at ``low``
    and ``high`` where they are given;
    ``median`` and ``factor`` of a lognormal one; ``tolerance`` either way of the case's own value,
    by ``shape``. ``distribution`` names what these say, and makes a range logarithmic.
    """

    key: str | list[str] = ""
    varied: Annotated[Operation, Field(alias="as")] = "value"
    unit: str = ""
    label: Line = ""
    values: Amounts | None = None
    low: Amount | None = None
    high: Amount | None = None
    mean: Amount | None = None
    standard_deviation: Amount | None = None
    median: Amount | None = None
    factor: float | int | None = None
    tolerance: Amount | None = None
    shape: Literal["normal", "uniform"] = "normal"
    distribution: str = ""
    source: Line = ""

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        assert self.way
        return self

    @cached_property
    def way(self) -> str:
        """The key of :data:`WAYS` by which values are given. Raises a located problem for none, for
        several, or for a key that would be left unread.
        """
        given = [key for key in WAYS if getattr(self, key) is not None]
        ways = [key for key in given if key != "low"] or given  # others may have bounds
        if len(ways) != 1:
            raise problem(
                f"gives its values in {'several ways' if ways else 'no way'}; give one of values, "
                "low and high, mean and standard_deviation, median and factor, tolerance"
            )
        partner, names = WAYS[ways[0]]
        if getattr(self, partner) is None:
            raise problem(f"'{partner}' is missing; add it", (partner,))
        fitting = {ways[0], partner} | BESIDE.get(ways[0], set())
        if stray := (SAYING & self.model_fields_set) - fitting:
            raise problem(f"does not go with '{ways[0]}'; leave one of them out", (min(stray),))
        if self.distribution not in ("", *names):
            raise problem(
                f"does not fit the other keys, which give {' or '.join(names)}", ("distribution",)
            )
        return ways[0]


class LimitSpeedModel(StrictModel):
    """``limit_speed``: the engine speed up to which a quantity stays within a bound, or control is maintained
    (``kind``), searched over ``engine_speeds`` from below.
    """

    kind: str = ""
    quantity: str = ""
    at_most: Amount | None = None
    at_least: Amount | None = None
    engine_speeds: Speeds
    resolution: Amount = "10 rpm"


def _limit(raw: Any) -> LimitSearch:
    table = validate_as(LimitSpeedModel, raw)
    found: LimitSearch = guarded(partial(limit_search, **table.model_dump()))
    return found


#: A table of :class:`LimitSpeedModel`, read as the search that it asks for.
Limit = Annotated[LimitSearch, BeforeValidator(_limit)]


class CaseModel(StrictModel):
    """What every file says: its case with ``changes``. ``what``: the kind of file."""

    what: ClassVar[str]

    title: Line = ""
    description: Line = ""
    case: str
    changes: dict[str, Any] = Field(default_factory=dict)


class RunsModel(StrictModel):
    """The runs of every point."""

    engine_speeds: Speeds | None = None
    spring_models: ModelNames = Field(default_factory=list)
    spring_sets: Names = Field(default_factory=list)
    rest_model: ModelName = ""


def standard_names(tree: Mapping[str, Any]) -> dict[str, Any]:
    """A file with its keys by their standard names: ``[quantities.NAME]`` tables become ``[[vary]]``
    tables with the name as label.
    """
    found = {ALIASES.get(key, key): value for key, value in tree.items()}
    tables = found.get("vary")
    if isinstance(tables, dict):
        tables = [
            {"label": name, **table} if isinstance(table, dict) else table
            for name, table in tables.items()
        ]
    if isinstance(tables, list):
        found["vary"] = [
            {ALIASES.get(key, key): value for key, value in one.items()}
            if isinstance(one, dict)
            else one
            for one in tables
        ]
    return found


FileModel = TypeVar("FileModel", bound=StrictModel)


class FileText(Generic[FileModel]):
    """A TOML file read: its ``model``, folder and text; ``located`` places a problem in it. ``text`` is the content,
    or tables of a program.
    """

    def __init__(
        self, text: str | Mapping[str, Any], where: str, folder: Path, model: type[FileModel]
    ) -> None:
        what = getattr(model, "what", "")
        tree = parse_toml(text, where, what) if isinstance(text, str) else text
        self.text, self.where, self.folder = text if isinstance(text, str) else "", where, folder
        named = tree.get("quantities")
        self.names = list(named) if isinstance(named, dict) else []
        try:
            self.model = model.model_validate(standard_names(tree))
        except ValidationError as error:
            raise self.located(*first_problem(error)) from None

    @classmethod
    def read(cls, source: str | os.PathLike[str], model: type[FileModel]) -> FileText[FileModel]:
        """The file at a path, or of a text with several lines. Raises :class:`InputError`, one sentence with file,
        line and key.
        """
        what = getattr(model, "what", "")
        if isinstance(source, str) and "=" in source and "\n" in source:
            return cls(source, what.removesuffix(" file"), Path(), model)
        path = Path(source)
        return cls(read_text(path, what), path.name[:60], path.parent, model)

    @cached_property
    def case(self) -> Case:
        """The case of the library or next to the file, with its changes; an empty text removes a key."""
        model: Any = self.model
        changes = {key: REMOVED if one == "" else one for key, one in model.changes.items()}
        found: Case = self.guarded(("case",), lambda: load_case(self.case_place, changes or None))
        return found

    @property
    def case_place(self) -> str:
        """The name of the case in the library, or the path of its file."""
        model: Any = self.model
        path = self.folder / model.case
        there = model.case not in library_names() and path.is_file()
        return str(path) if there else str(model.case)

    @cached_property
    def space(self) -> Space:
        """What the file varies, each quantity once."""
        model: Any = self.model
        case = None if getattr(model, "evaluator", "") else self.case
        varied = [
            self.guarded(("vary", index), lambda one=one: varied_of_table(one, case))
            for index, one in enumerate(model.vary)
        ]
        space: Space = self.guarded(("vary",), lambda: Space(varied))
        return space

    def located(self, path: tuple[str | int, ...], reason: str) -> InputError:
        """The refusal of the value at ``path``, with its line."""
        if self.names and path[:1] == ("vary",) and len(path) > 1:
            path = ("quantities", self.names[int(path[1])], *path[2:])
        line = find_line(self.text, path)
        place = self.where if line is None else f"{self.where}, line {line}"
        key = ".".join(map(str, path))
        return InputError(reason, f"{place}, {key}" if key else place)

    def guarded(self, path: tuple[str | int, ...], compute: Any) -> Any:
        """``compute()``, its refusals placed under ``path``."""
        try:
            return compute()
        except InputError as error:
            raise self.located(path, str(error)) from None
        except PydanticCustomError as error:
            context = error.context or {}
            raise self.located(
                (*path, *context.get("path", ())), str(context.get("reason", error))
            ) from None


def case_words(text: FileText[Any]) -> list[str]:
    """What a command line takes for the case of a file with its changes: its name or path, then ``--set`` for each."""
    words = [text.case_place]
    rows = [("", text.model.changes)]
    for head, value in rows:  # a table adds its own rows
        if isinstance(value, dict):
            rows += [(f"{head}.{key}".lstrip("."), one) for key, one in value.items()]
        else:
            words += ["--set", f"{head}={value if isinstance(value, str) else json.dumps(value)}"]
    return words


def varied_of_table(one: VaryModel, case: Case | None) -> Varied:
    """A varied quantity with its distribution; units of its numbers must agree with each other and
    with the case. Without a case, for an evaluator, it has a label alone.
    """
    way, keys = one.way, [one.key] if isinstance(one.key, str) else one.key
    if case is None:
        if any(keys):
            raise problem("is no key of an evaluator; give a label alone", ("key",))
        keys = [one.label]
    if not keys or not all(keys):
        reason = (
            'is missing; say which value of the case it is, such as key = "spring.wire_diameter"'
        )
        raise problem(reason, ("key",))
    key, *also = keys
    if case is None and way == "tolerance":
        raise InputError("is about a value of a case, and there is none; give the distribution")
    listed = [one.values] if isinstance(one.values, str) else one.values or []
    given = (
        one.low,
        one.high,
        one.mean,
        one.standard_deviation,
        one.median,
        one.tolerance,
        *listed,
    )
    unit = one.unit or next(
        filter(None, (unit_of(str(raw)) for raw in given if raw is not None)), ""
    )
    share = way == "tolerance" and unit_of(str(one.tolerance)) == "%"  # of the case's own value
    if share:
        unit = unit_in_case(case, key) if case and one.varied == "value" else ""
    bare = Varied(key, unit, one.varied, label=one.label, also=tuple(also))
    dimension = dimension_of(unit) if unit else "ratio"
    if key == ENGINE_SPEED and (dimension != "angular speed" or one.varied != "value"):
        raise InputError(
            "is an engine speed, which is varied by its value in rpm; write such as low = '4000 rpm'",
            key,
        )

    def number(raw: Any, otherwise: float = math.nan) -> float:
        return otherwise if raw is None else parse_quantity(raw, dimension, key)

    distribution: Distribution
    low, high = number(one.low, -math.inf), number(one.high, math.inf)
    if way == "values":
        distribution = Values(parse_quantities(one.values, dimension, key))
        if len(distribution.values) > MAX_POINTS:
            raise InputError("has too many values; give fewer", key)
    elif way == "low":
        distribution = Prior(
            "log-uniform" if one.distribution == "log-uniform" else "uniform", low, high
        )
    elif way == "mean":
        distribution = Normal(number(one.mean), number(one.standard_deviation), low, high)
    elif way == "median":
        distribution = LogNormal(number(one.median), float(one.factor or 0.0))
        distribution = replace(distribution, low=low, high=high)
    else:
        assert case is not None
        middle = nominal(case, bare)
        reach = (
            abs(middle) * parse_quantity(one.tolerance, "ratio", key)
            if share
            else number(one.tolerance)
        )
        if not reach > 0:
            raise InputError(
                "has a tolerance of zero or less, or a share of a value that is zero in the case; give "
                "how far it goes either way, with its unit",
                key,
            )
        low, high = middle - reach, middle + reach
        distribution = (
            Uniform(low, high)
            if one.shape == "uniform"
            else Normal(middle, reach / SIGMAS, low, high)
        )
    distribution = replace(distribution, dimension=bare.dimension)
    if isinstance(distribution, Prior):
        distribution = replace(distribution, source=one.source)
    varied = replace(bare, distribution=distribution)
    if case is not None:
        _refuse_impossible(case, varied)
    return varied


def _refuse_impossible(case: Case, varied: Varied) -> None:
    """Raise :class:`InputError` for a quantity that no case can have at either end or in the
    middle: a slip of key or unit.
    """
    refusals = []
    for value in varied.distribution.at([0.02, 0.5, 0.98]).tolist():
        try:
            vary(case, {varied: value})
        except InputError as error:
            refusals.append(error)
    if len(refusals) == 3:
        raise refusals[1]
