"""What the files of studies, searches and identifications share: reading, vocabulary, case and
varied quantities.

TOML in, typed tables out, or one sentence with file, line and key.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Generic, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from valvetrain.errors import InputError
from valvetrain.explore.case_paths import nominal, unit_in_case, unit_of, vary
from valvetrain.explore.samplers import MAX_POINTS
from valvetrain.explore.space import (
    ENGINE_SPEED,
    KINDS,
    SIGMAS,
    Distribution,
    LogNormal,
    Normal,
    Operation,
    Prior,
    Space,
    Uniform,
    Values,
    Varied,
)
from valvetrain.parameters.bounded_file import bounded_bytes
from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import library_names, load_case, parse_toml
from valvetrain.parameters.overrides import REMOVED
from valvetrain.parameters.schema_types import Line, StrictModel, first_problem, problem
from valvetrain.parameters.toml_text import find_line
from valvetrain.units import dimension_of, parse_quantities, parse_quantity

#: Most quantities that a study varies.
MAX_VARIED = 64
#: Other name of a key -> the standard one, in all three kinds of file.
ALIASES = {"set": "changes", "prior": "distribution", "quantities": "vary"}
#: Names of distributions in files: those of :class:`Prior`, and a normal one that has bounds.
DISTRIBUTIONS = (*KINDS, "truncated-normal")
#: Key that says in which way values are given -> the key that it needs with it, and the names of the
#: distributions that this makes.
WAYS: dict[str, tuple[str, tuple[str, ...]]] = {
    "values": ("values", ("values",)),
    "tolerance": ("tolerance", ("tolerance",)),
    "mean": ("standard_deviation", ("normal", "truncated-normal")),
    "median": ("factor", ("lognormal",)),
    "low": ("high", ("uniform", "log-uniform")),
}


def _amount(raw: Any) -> Any:
    if isinstance(raw, bool) or not isinstance(raw, (str, int, float)):
        raise problem(
            "is no number; write such as '3.77 mm', or a plain number where there is no unit"
        )
    return raw


def _amounts(raw: Any) -> Any:
    if not isinstance(raw, (str, list)) or (
        isinstance(raw, list) and not all(isinstance(one, (str, int, float)) for one in raw)
    ):
        raise problem("is no row of numbers; write such as '3.7, 3.8 mm' or [1, 2, 4]")
    return raw


def _plain_name(raw: Any) -> Any:
    return [word.strip() for word in raw.split(",")] if isinstance(raw, str) else raw


Amount = Annotated[str | int | float, BeforeValidator(_amount)]
Amounts = Annotated[str | list[Any], BeforeValidator(_amounts)]
Names = Annotated[list[str], BeforeValidator(_plain_name)]


class VaryModel(StrictModel):
    """One ``[[vary]]`` table: a key of the case and the values it takes, in exactly one of the ways
    below.

    ``values`` one by one; ``low`` and ``high``; ``mean`` and ``standard_deviation``, cut at ``low``
    and ``high`` where they are given;
    ``median`` and ``factor`` of a lognormal one; ``tolerance`` either way of the case's own value,
    by ``shape``. ``distribution`` names what these say, and makes a range logarithmic.
    """

    key: str
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

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, raw: Any) -> Any:
        if isinstance(raw, dict):
            raw = {ALIASES.get(key, key): value for key, value in raw.items()}
        return StrictModel._known_keys.__func__(cls, raw)

    @property
    def way(self) -> str:
        """The key of :data:`WAYS` by which values are given. Raises a located problem for none, or
        several.
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
        if self.distribution not in ("", *names):
            raise problem(
                f"does not fit the other keys, which give {' or '.join(names)}", ("distribution",)
            )
        return ways[0]


class CorrelationModel(StrictModel):
    """One ``[[correlation]]`` table: the ``coefficient`` of the normal scores of two quantities."""

    between: list[str] = Field(min_length=2, max_length=2)
    coefficient: Annotated[float, Field(gt=-1.0, lt=1.0)]


def standard_names(tree: Mapping[str, Any]) -> dict[str, Any]:
    """A file with its keys by their standard names: ``[quantities.NAME]`` tables become ``[[vary]]``
    tables with the name as label.
    """
    found = {ALIASES.get(key, key): value for key, value in tree.items()}
    named = found.get("vary")
    if isinstance(named, dict):
        found["vary"] = [
            {"label": name, **table} if isinstance(table, dict) else table
            for name, table in named.items()
        ]
    return found


def correlation_of(
    names: Sequence[str], pairs: Sequence[tuple[Sequence[str], float]]
) -> NDArray[np.float64] | None:
    """The correlation matrix of ``[[correlation]]`` tables, None without any."""
    matrix = np.eye(len(names))
    for between, coefficient in pairs:
        if len(set(between)) != 2 or not set(between) <= set(names):
            raise InputError(
                f"between names two of the varied quantities: {', '.join(names)[:200]}",
                "correlation",
            )
        first, second = map(names.index, between)
        matrix[first, second] = matrix[second, first] = coefficient
    return matrix if pairs else None


FileModel = TypeVar("FileModel", bound=StrictModel)


class FileText(Generic[FileModel]):
    """A TOML file read: its ``model``, folder and text; ``located`` places a problem in it."""

    def __init__(
        self, text: str, where: str, folder: Path, kind: type[FileModel], what: str
    ) -> None:
        self.text, self.where, self.folder = text, where, folder
        self._read(parse_toml(text, where, what), kind)

    def _read(self, tree: Mapping[str, Any], kind: type[FileModel]) -> None:
        named = tree.get("quantities")
        self.names = list(named) if isinstance(named, dict) else []
        self.tree = standard_names(tree)
        try:
            self.model = kind.model_validate(self.tree)
        except ValidationError as error:
            raise self.located(*first_problem(error)) from None
        for place, one in enumerate(getattr(self.model, "vary", ())):
            self.guarded(("vary", place), lambda one=one: one.way)

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


def text_of_file(path: Path, what: str) -> str:
    """Text of the TOML file at ``path``, which messages call ``what``. Raises :class:`InputError`,
    one sentence.
    """
    article = "an" if what[0] in "aeiou" else "a"
    try:
        return bounded_bytes(path, what).decode("utf-8-sig")
    except InputError as error:
        raise InputError(error.reason, path.name[:60]) from None
    except UnicodeDecodeError:
        raise InputError("is no text file; it is TOML in UTF-8", path.name[:60]) from None
    except FileNotFoundError:
        raise InputError(
            f"there is no file '{str(path)[:120]}'; check the path (the name of {article} {what} ends in .toml)"
        ) from None
    except (OSError, ValueError) as error:
        raise InputError(
            f"the file cannot be read ({getattr(error, 'strerror', None) or 'bad path'}); check it",
            path.name[:60],
        ) from None


def case_of_file(name: str, changes: Mapping[str, Any], folder: Path) -> Case:
    """The case of the library or next to the file in ``folder``, with its changes; an empty text
    removes a key.
    """
    path = folder / name
    made = {key: REMOVED if value == "" else value for key, value in changes.items()}
    return load_case(name if name in library_names() or not path.is_file() else path, made or None)


def case_words(text: FileText[Any]) -> list[str]:
    """What a command line takes for the case of a file with its changes: its name or path, then ``--set`` for each."""
    path = text.folder / text.model.case
    name = text.model.case
    words = [name if name in library_names() or not path.is_file() else str(path)]
    rows = [("", text.model.changes)]
    for head, value in rows:  # a table adds its own rows
        if isinstance(value, dict):
            rows += [(f"{head}.{key}".lstrip("."), one) for key, one in value.items()]
        else:
            words += ["--set", f"{head}={value if isinstance(value, str) else json.dumps(value)}"]
    return words


def space_of_file(
    text: FileText[Any],
    models: Sequence[VaryModel],
    case: Case,
    correlation: Sequence[CorrelationModel] = (),
) -> Space:
    """What a file varies, each quantity once; correlations name quantities by key or by label."""
    varied = [
        text.guarded(("vary", index), lambda one=one: varied_of_table(one, case))
        for index, one in enumerate(models)
    ]
    space: Space = text.guarded(("vary",), lambda: Space(varied))
    if not correlation:
        return space
    pairs = [(one.between, one.coefficient) for one in correlation]
    by_key = all(name in space.names for between, _ in pairs for name in between)
    names = space.names if by_key else [one.label or one.name for one in varied]
    correlated: Space = text.guarded(
        ("correlation",), lambda: Space(varied, correlation_of(names, pairs))
    )
    return correlated


def varied_of_table(one: VaryModel, case: Case | None) -> Varied:
    """A varied quantity with its distribution; units of its numbers must agree with each other and
    with the case. Without a case nothing is read from it.
    """
    way = one.way
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
        unit = unit_in_case(case, one.key) if case and one.varied == "value" else ""
    bare = Varied(one.key, unit, one.varied, label=one.label)
    dimension = dimension_of(unit) if unit else "ratio"
    if one.key == ENGINE_SPEED and (dimension != "angular speed" or one.varied != "value"):
        raise InputError(
            "is an engine speed, which is varied by its value in rpm; write such as low = '4000 rpm'",
            one.key,
        )

    def number(raw: Any, otherwise: float = math.nan) -> float:
        return otherwise if raw is None else parse_quantity(raw, dimension, one.key)

    distribution: Distribution
    low, high = number(one.low, -math.inf), number(one.high, math.inf)
    if way == "values":
        distribution = Values(parse_quantities(one.values, dimension, one.key))
        if len(distribution.values) > MAX_POINTS:
            raise InputError("has too many values; give fewer", one.key)
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
            abs(middle) * parse_quantity(one.tolerance, "ratio", one.key)
            if share
            else number(one.tolerance)
        )
        if not reach > 0:
            raise InputError(
                "has a tolerance of zero or less, or a share of a value that is zero in the case; give "
                "how far it goes either way, with its unit",
                one.key,
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
    varied = Varied(one.key, unit, one.varied, distribution, one.label)
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
