"""A study file: which case, what is varied and how, what is asked of every point. TOML in, one
typed table out, or one sentence.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Generic, Literal, TypeVar

from pydantic import BeforeValidator, Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from valvetrain.errors import InputError
from valvetrain.explore.space import Operation
from valvetrain.parameters.bounded_file import bounded_bytes
from valvetrain.parameters.schema_types import Line, StrictModel, first_problem, problem
from valvetrain.parameters.toml_text import find_line

#: Most quantities that a study varies.
MAX_VARIED = 64
#: What is made of the points besides their own numbers.
Kind = Literal["points", "tolerance", "surrogate"]


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


def _words(raw: Any) -> Any:
    return [word.strip() for word in raw.split(",")] if isinstance(raw, str) else raw


Amount = Annotated[str | int | float, BeforeValidator(_amount)]
Amounts = Annotated[str | list[Any], BeforeValidator(_amounts)]
Words = Annotated[list[str], BeforeValidator(_words)]


class VaryModel(StrictModel):
    """One ``[[vary]]`` table: a key of the case and the values it takes, in exactly one of the ways
    below.

    ``values`` one by one; ``low`` and ``high``; ``mean`` and ``standard_deviation``, cut at ``low``
    and ``high`` where they are given;
    ``median`` and ``factor`` of a lognormal one; ``tolerance`` either way of what stands in the
    case, by ``shape``.
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

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, raw: Any) -> Any:
        if isinstance(raw, dict) and "varied" in raw:
            raise problem("key 'varied' is unknown; did you mean as?", ("varied",))
        if isinstance(raw, dict) and "as" in raw:
            raw = {**raw, "varied": raw["as"]}
            raw.pop("as")
            if raw["varied"] not in ("value", "factor", "offset"):
                raise problem(
                    "is no way to vary a quantity; choose value, factor or offset", ("as",)
                )
        checked = StrictModel._known_keys.__func__(cls, raw)
        return {"as": checked.pop("varied"), **checked} if "varied" in checked else checked

    @property
    def way(self) -> str:
        """Word of the way the values are told. Raises a located problem for none, or several."""
        told = {
            "values": self.values is not None, "tolerance": self.tolerance is not None, "normal": self.mean is not None,
            "lognormal": self.median is not None,
        }  # fmt: skip
        ways = [word for word, given in told.items() if given]
        if not ways and self.low is not None and self.high is not None:
            return "uniform"
        if len(ways) != 1:
            raise problem(
                "says in "
                + ("several ways" if ways else "no way")
                + " what it goes through; give one of values, low and high, "
                "mean and standard_deviation, median and factor, tolerance"
            )
        for word, partner, given in (
            ("normal", "standard_deviation", self.standard_deviation),
            ("lognormal", "factor", self.factor),
        ):
            if ways[0] == word and given is None:
                raise problem(f"'{partner}' is missing; add it", (partner,))
        return ways[0]


class PointsModel(StrictModel):
    """The ``[points]`` table: the sampler, and its options, which it checks itself."""

    sampler: str = "latin-hypercube"

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, raw: Any) -> Any:
        if not isinstance(raw, dict):
            raise problem("a table with sampler and its options is needed here")
        return {key: value for key, value in raw.items() if key == "sampler"}


class StudyModel(StrictModel):
    """The whole file."""

    kind: Kind = "points"
    title: Line = ""
    description: Line = ""
    case: str
    changes: dict[str, Any] = Field(default_factory=dict)
    engine_speeds: str | list[Any] | None = None
    spring_models: Words = Field(default_factory=list)
    spring_sets: Words = Field(default_factory=list)
    outputs: Words
    rest_model: str = ""
    points: PointsModel = PointsModel()
    vary: list[VaryModel] = Field(min_length=1, max_length=MAX_VARIED)


FileModel = TypeVar("FileModel", bound=StrictModel)


class FileText(Generic[FileModel]):
    """A TOML file read: its ``model``, folder and text; ``located`` places a problem in it."""

    def __init__(self, text: str, where: str, folder: Path, kind: type[FileModel]) -> None:
        self.text, self.where, self.folder = text, where, folder
        try:
            self.tree: Mapping[str, Any] = tomllib.loads(text)
        except RecursionError:
            raise InputError("the values are nested too deeply; flatten them", where) from None
        except ValueError as error:
            raise InputError(
                f"is not valid TOML: {' '.join(str(error).split())[:160]}; correct it there", where
            ) from None
        try:
            self.model = kind.model_validate(dict(self.tree))
        except ValidationError as error:
            raise self.located(*first_problem(error)) from None
        for place, one in enumerate(getattr(self.model, "vary", ())):
            self.guarded(("vary", place), lambda one=one: one.way)

    def located(self, path: tuple[str | int, ...], reason: str) -> InputError:
        """The refusal of what stands under ``path``, with its line."""
        shown = tuple("as" if part == "varied" else part for part in path)
        line = find_line(self.text, shown)
        place = self.where if line is None else f"{self.where}, line {line}"
        key = ".".join(str(part) for part in shown)
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


class StudyText(FileText[StudyModel]):
    """A study file read, with the options of its sampler."""

    def __init__(self, text: str, where: str, folder: Path) -> None:
        super().__init__(text, where, folder, StudyModel)
        points = self.tree.get("points", {})
        self.sampler_options = {key: value for key, value in points.items() if key != "sampler"}


def read_study_file(path: Path) -> StudyText:
    """The study file at ``path``. Raises :class:`InputError`, one sentence with file, line and key."""
    return StudyText(text_of_file(path, "study file"), path.name[:60], path.parent)


def text_of_file(path: Path, what: str) -> str:
    """Text of the TOML file at ``path``, which messages call ``what``. Raises :class:`InputError`,
    one sentence.
    """
    try:
        return bounded_bytes(path, what).decode("utf-8-sig")
    except InputError as error:
        raise InputError(error.reason, path.name[:60]) from None
    except UnicodeDecodeError:
        raise InputError("is no text file; it is TOML in UTF-8", path.name[:60]) from None
    except FileNotFoundError:
        raise InputError(
            f"there is no file '{str(path)[:120]}'; check the path (a {what} ends in .toml)"
        ) from None
    except (OSError, ValueError) as error:
        raise InputError(
            f"the file cannot be read ({getattr(error, 'strerror', None) or 'bad path'}); check it",
            path.name[:60],
        ) from None
