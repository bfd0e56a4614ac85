"""Identification files: TOML in, everything an identification needs or one clear sentence out."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Literal, get_args

from pydantic import ValidationError

from valvetrain.errors import InputError
from valvetrain.explore.evaluator import PointEvaluator
from valvetrain.explore.files import DISTRIBUTIONS, VaryModel, correlation_of, varied_of_table
from valvetrain.explore.least_squares import SIDE
from valvetrain.explore.measurements import Target, read_measurement, read_station
from valvetrain.explore.nested import LANES, LIVE_POINTS, PRECISION, evaluations_of
from valvetrain.explore.part import Part, same_dimension
from valvetrain.explore.posterior import Array, Datum, Unknown
from valvetrain.explore.space import Kind, Prior, Space, Varied
from valvetrain.parameters.bounded_file import bounded_bytes
from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import library_names, load_case, parse_toml
from valvetrain.parameters.schema_types import first_problem
from valvetrain.registry import find
from valvetrain.solution.atomic import digest
from valvetrain.solution.definition import definition_of, no_quantity

Method = Literal["least-squares", "nested"]
METHODS: tuple[str, ...] = get_args(Method)
#: Options that take a number of zero or more; all other numbers are positive.
_FROM_ZERO = {"seed", "draws", "difference_step", "keep"}
#: Most of anything that is counted.
_MOST = 10_000_000


@dataclass(frozen=True)
class Search:
    """Method and its options; those of other methods have no effect.

    ``seed`` of all random numbers. ``least-squares``: ``starts`` tried, of which the ``keep``
    likeliest are searched from (0: none but those that are given) for at most ``iterations``;
    ``difference_step`` in standard deviations of the priors (0: follows what the data leave open);
    ``draws`` of the linearised posterior. ``nested``: ``live_points``, ``lanes`` requested at once,
    ``precision``: share of the evidence that may be left. Raises :class:`InputError` for an unknown method or a
    number out of range.

    >>> Search("nested", live_points=200).evaluations_of(2) > 1000
    True
    """

    method: str = "least-squares"
    seed: int = 1
    starts: int = 1
    keep: int = 1
    iterations: int = 30
    difference_step: float = 0.0
    draws: int = 200
    live_points: int = LIVE_POINTS
    lanes: int = LANES
    precision: float = PRECISION

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise InputError(
                f"method '{str(self.method)[:40]}' is unknown; use one of {', '.join(METHODS)}",
                "method",
            )
        for one in fields(self)[1:]:
            value = getattr(self, one.name)
            whole = one.name not in ("difference_step", "precision")
            if isinstance(value, bool) or not isinstance(value, int if whole else (int, float)):
                raise InputError(
                    f"{one.name} is a {'whole ' if whole else ''}number; it is {str(value)[:40]!r}",
                    one.name,
                )
            if not (0 if one.name in _FROM_ZERO else 1e-9) <= value <= _MOST:
                raise InputError(
                    f"{one.name} is {value:g}; give a number above zero and below {_MOST:g}",
                    one.name,
                )

    def evaluations_of(self, quantities: int, profiles: int = 0, given: int = 0) -> int:
        """About how many points will be computed for this many unknown quantities, profiles and
        ``given`` starts in addition to its own.
        """
        slopes, retained = quantities + 1, min(self.keep, self.starts) + given
        after = slopes + profiles * 2 * SIDE * 4 * (slopes + 4)
        if self.method == "nested":
            return evaluations_of(self.live_points, quantities) + after
        each = min(self.iterations, 8) * (slopes + 4)
        return (self.starts if self.keep else 0) + retained * each + self.draws + after


_OPERATIONS = ("value", "factor", "offset")


@dataclass(frozen=True)
class Request:
    """An identification as a file requests it.

    ``evaluator``: name of a package's evaluator of points (:class:`PointEvaluator`), empty for the case
    itself; ``options`` are its numbers.
    ``from_case``: whether the values of the case are a start too. ``identity``: digest of all that
    outcomes depend on but the version.
    """

    name: str
    title: str
    case: Case
    unknowns: tuple[Unknown, ...]
    varied: tuple[tuple[Varied, ...], ...]
    data: tuple[Datum, ...]
    targets: tuple[Target, ...]
    search: Search
    profiles: tuple[str, ...]
    evaluator: str
    options: tuple[tuple[str, float], ...]
    from_case: bool
    text: str
    folder: Path
    correlation: Array | None = None

    @property
    def parts(self) -> tuple[tuple[Target, ...], tuple[Target, ...]]:
        """Targets of every point, measured under conditions of which something is fitted;
        and what of the draws alone.
        """
        fitted = {one.key for one in self.data if one.used}
        searched = {one.station for one in self.targets if one.key in fitted}
        measured = {one.key for one in self.data}
        first = tuple(
            one for one in self.targets if one.station in searched and one.key in measured
        )
        return first, tuple(one for one in self.targets if one not in first)

    @property
    def identity(self) -> str:
        """What the outcome of a point depends on, in 32 digits."""
        names = tuple(one.name for one in self.unknowns)
        requested = (
            self.case.record().digest,
            self.varied,
            names,
            self.parts,
            self.evaluator,
            self.options,
        )
        return digest(repr(requested).encode())

    @property
    def digest(self) -> str:
        """What the answer depends on, in 32 digits."""
        return digest(
            repr(
                (
                    self.identity,
                    self.unknowns,
                    self.data,
                    self.search,
                    self.profiles,
                    self.from_case,
                )
            ).encode()
        )


def read_request(path: str | os.PathLike[str]) -> Request:
    """The identification in a TOML file. Raises :class:`InputError`: one sentence with the place."""
    file = Path(path)
    try:
        text = bounded_bytes(file, "identification file").decode("utf-8-sig")
    except InputError as error:
        raise InputError(error.reason, file.name) from None
    except UnicodeDecodeError:
        raise InputError("is no text file; an identification is TOML in UTF-8", file.name) from None
    except FileNotFoundError:
        raise InputError(f"there is no file '{str(path)[:120]}'; check the path") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "bad path"
        raise InputError(
            f"the file cannot be read ({reason}); check the path and its permissions",
            file.name[:60],
        ) from None
    try:
        return parse_request(text, file.stem, file.parent, file.name)
    except InputError as error:
        place = (
            f"{file.name}, {error.where}"
            if error.where and not error.where.startswith(file.name)
            else error.where or file.name
        )
        raise InputError(error.reason, place) from None
    except RecursionError:
        raise InputError("the tables are nested too deeply; flatten them", file.name) from None


def parse_request(text: str, name: str, folder: Path, where: str = "") -> Request:
    """The identification written in ``text``; ``folder`` is where the files it names are looked
    for. Errors as :func:`read_request`.
    """
    whole = Part(parse_toml(text, where, "identification file"), "")
    case = _case(whole, folder)
    evaluator = whole.text("evaluator", "")
    options = Part(whole.take("options", {}), "options")
    numbers = tuple((key, options.plain(key)) for key in list(options.table))
    if numbers and not evaluator:
        raise InputError("belongs to an evaluator; name it, or leave the table out", "options")
    own: PointEvaluator | None = find("evaluators", evaluator, "evaluator") if evaluator else None
    unknowns, varied = [], []
    for one, part in _quantities(whole):
        unknown, keys = _unknown(one, part, case, bool(evaluator))
        unknowns.append(unknown)
        varied.append(keys)
    if own is not None:
        own.points(
            tuple(one.name for one in unknowns), dict(numbers)
        )  # refuses names and options it does not know
    found = [
        pair
        for one, part in whole.parts("measurements")
        for pair in read_measurement(one, part, folder, bool(evaluator))
    ]
    requested = (
        [_requested(part) for _, part in whole.parts("predictions")]
        if whole.has("predictions")
        else []
    )
    whole.take("predictions")
    search, profiles, from_case = _search(
        Part(whole.take("search", {}), "search"), tuple(one.name for one in unknowns)
    )
    correlation = _correlation(whole, unknowns)
    title = whole.text("title", name.replace("_", " "))
    whole.text("description", "")
    whole.finish()
    return Request(
        name,
        title,
        case,
        tuple(unknowns),
        tuple(varied),
        tuple(datum for _, datum in found),
        tuple(dict.fromkeys([*(one for one, _ in found), *requested])),
        search,
        profiles,
        evaluator,
        numbers,
        from_case,
        text,
        folder,
        correlation,
    )


def _quantities(whole: Part) -> tuple[tuple[str, Part], ...]:
    """Tables of the quantities by name: ``[[vary]]`` tables by their labels or keys, or
    ``[quantities.NAME]`` tables.
    """
    key = "quantities" if whole.has("quantities") else "vary"
    tables = whole.table.get(key)
    if isinstance(tables, list):
        named: dict[str, object] = {}
        for index, table in enumerate(tables):
            own = dict(Part(table, f"{key}.{index}").table)
            name = own.pop("label", own.get("key", str(index)))
            if not isinstance(name, str) or name in named:
                raise InputError("has no name of its own; give a label", f"{key}.{index}")
            named[name] = own
        whole.table = {**whole.table, key: named}
    elif key == "vary" and tables is None:
        key = "quantities"
    return whole.parts(key)


def _correlation(whole: Part, unknowns: Sequence[Unknown]) -> Array | None:
    """The correlation matrix of ``[[correlation]]`` tables, None without any."""
    tables = whole.take("correlation", [])
    if not isinstance(tables, list):
        raise InputError("is no list of tables; write [[correlation]]", "correlation")
    pairs = []
    for index, table in enumerate(tables):
        part = Part(table, f"correlation.{index}")
        pairs.append((part.texts("between"), part.plain("coefficient")))
        part.finish()
    matrix = correlation_of([one.name for one in unknowns], pairs)
    if matrix is not None:
        Space({one.name: one.prior for one in unknowns}, matrix)  # refuses what is none
    return matrix


def _case(whole: Part, folder: Path) -> Case:
    name = whole.text("case")
    key = "changes" if whole.has("changes") else "set"
    changes = Part(whole.take(key, {}), key).table
    if name not in library_names() and not Path(name).is_absolute():
        name = str(folder / name) if name.endswith(".toml") else name
    try:
        return load_case(name, changes or None)
    except InputError as error:
        raise InputError(error.reason, f"case{', ' + error.where if error.where else ''}") from None


def _requested(part: Part) -> Target:
    """A number that is computed for the draws without having been measured."""
    station, name = read_station(part), part.text("quantity")
    part.finish()
    if not definition_of(name).dimension:
        raise InputError(no_quantity(name), part.place("quantity"))
    return Target(station, "quantity", name)


def _unknown(name: str, part: Part, case: Case, bare: bool) -> tuple[Unknown, tuple[Varied, ...]]:
    """A quantity with its prior; ``bare``: an evaluator knows it by name, so it has no key of the
    case.
    """
    keys = () if bare else part.texts("key")
    if not bare and not keys:
        raise InputError(
            'is missing; say which value of the case it is, such as key = "spring.wire_diameter"',
            part.place("key"),
        )
    operation = part.text("as", "value", _OPERATIONS)
    prior, unit = _tolerance(part, case, keys, operation) or _prior(part)
    part.finish()
    try:
        return Unknown(name, prior, unit), tuple(Varied(key, unit, operation) for key in keys)  # type: ignore[arg-type]
    except InputError as error:
        raise InputError(error.reason, part.where) from None


def _distribution_key(part: Part) -> str:
    """The key that names the distribution; where there is none, the name that the other keys imply
    is filled in.
    """
    key = "distribution" if part.has("distribution") else "prior"
    implied = {"mean": "normal", "median": "lognormal"}
    ways = [kind for one, kind in implied.items() if part.has(one)]
    if not part.has(key) and (ways or (part.has("low") and part.has("high"))):
        part.table = {**part.table, key: ways[0] if ways else "uniform"}
    return key


def _tolerance(
    part: Part, case: Case, keys: tuple[str, ...], operation: str
) -> tuple[Prior, str] | None:
    """The distribution of a ``tolerance`` about the case's own value; None without the key."""
    if not part.has("tolerance") or not keys:
        return None
    given = {key: part.take(key) for key in ("tolerance", "shape", "source") if part.has(key)}
    try:
        table = VaryModel.model_validate({"key": keys[0], "as": operation, **given})
        found = varied_of_table(table, case)
    except ValidationError as error:
        raise InputError(first_problem(error)[1], part.place("tolerance")) from None
    except InputError as error:
        raise InputError(error.reason, part.place("tolerance")) from None
    assert isinstance(found.distribution, Prior)
    return found.distribution, found.unit


def _prior(part: Part) -> tuple[Prior, str]:
    """The prior of a table and the unit its numbers are written in."""
    word = part.text(_distribution_key(part), choices=DISTRIBUTIONS)
    kind: Kind = "normal" if word == "truncated-normal" else word  # type: ignore[assignment]
    source = part.text("source", "")
    first = (
        "low" if kind in ("uniform", "log-uniform") else "mean" if kind == "normal" else "median"
    )
    middle, unit = part.amount(first)
    low, high, spread = float("-inf"), float("inf"), float("nan")
    for key in ("low", "high"):
        if part.has(key) or kind in ("uniform", "log-uniform"):
            value, own = part.amount(key)
            if not same_dimension(own, unit):
                raise InputError(
                    f"is in '{own}', the other numbers of the prior in '{unit}'; give all in one unit",
                    part.place(key),
                )
            low, high = (value, high) if key == "low" else (low, value)
    if word == "truncated-normal" and not (part.has("low") or part.has("high")):
        raise InputError("is truncated nowhere; give low or high", part.where)
    if kind == "normal":
        spread, own = part.amount("standard_deviation")
        if not same_dimension(own, unit):
            raise InputError(
                f"is in '{own}', the mean in '{unit}'; give both in one unit",
                part.place("standard_deviation"),
            )
    elif kind == "lognormal":
        factor = part.plain("factor")
        if not 1 < factor < 1e6:
            raise InputError(
                "is the factor of one standard deviation about the median; give a number above 1",
                part.place("factor"),
            )
        spread = math.log(factor)
    try:
        return Prior(
            kind, low, high, float("nan") if first == "low" else middle, spread, source
        ), unit
    except InputError as error:
        raise InputError(error.reason, part.where) from None


def _search(part: Part, names: tuple[str, ...]) -> tuple[Search, tuple[str, ...], bool]:
    given = {one.name: part.take(one.name) for one in fields(Search) if part.has(one.name)}
    if "method" in given:
        part.text("method", choices=METHODS)
    profiles, from_case = part.texts("profile"), part.truth("from_case", False)
    part.taken += [one.name for one in fields(Search)]
    part.finish()
    unknown = next((one for one in profiles if one not in names), None)
    if unknown is not None:
        raise InputError(
            f"'{unknown[:40]}' is none of the quantities; name one of {', '.join(names)[:200]}",
            "search.profile",
        )
    if (
        given.get("keep") == 0
        and not from_case
        and given.get("method", "least-squares") == "least-squares"
    ):
        raise InputError(
            "is 0, so that nothing is searched from; set from_case = true, or keep 1 or more",
            "search.keep",
        )
    try:
        return Search(**given), profiles, from_case
    except InputError as error:
        raise InputError(
            error.reason, f"search.{error.where}" if error.where else "search"
        ) from None
