"""Identification files: TOML in, everything an identification needs or one clear sentence out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, Field, ValidationError, model_validator

from valvetrain.errors import InputError
from valvetrain.explore.files import (
    MAX_VARIED,
    CaseModel,
    FileText,
    VaryModel,
    varied_of_table,
)
from valvetrain.explore.measurements import PredictionModel, Target, read_measurement
from valvetrain.explore.posterior import Datum, Unknown
from valvetrain.explore.space import Prior, Varied
from valvetrain.parameters.case import Case
from valvetrain.parameters.schema_types import Line, StrictModel, first_problem, problem
from valvetrain.registry import find

Method = Literal["least-squares", "nested"]
_MOST = 10_000_000
#: Equally weighted draws with the information of those that nested sampling stores, at least.
EFFECTIVE = 2000
Count = Annotated[int, Field(gt=0, le=_MOST)]
FromZero = Annotated[int, Field(ge=0, le=_MOST)]


class Search(StrictModel):
    """Method and its options; those of the other method have no effect.

    ``seed`` of all random numbers. ``least-squares``: ``starts`` tried, of which the ``keep``
    likeliest are searched from, and the values of the case with ``from_case``, for at most
    ``iterations``;
    ``difference_step`` in standard deviations of the priors (0: follows what the data leave open);
    ``draws`` of the linearised posterior. ``nested``: ``live_points``, ``lanes`` requested at once,
    ``precision``: share of the evidence that may be left. Raises :class:`InputError` for an unknown
    method or a number out of range.

    >>> Search("nested", live_points=200).evaluations_of(2) > 1000
    True
    """

    method: Method = "least-squares"
    seed: FromZero = 1
    starts: Count = 1
    keep: FromZero = 1
    from_case: bool = False
    iterations: Count = 30
    difference_step: Annotated[float, Field(ge=0, le=_MOST)] = 0.0
    draws: FromZero = 200
    live_points: Count = 400
    lanes: Count = 64
    precision: Annotated[float, Field(gt=0, le=_MOST)] = 0.01

    def __init__(self, method: str = "least-squares", **options: Any) -> None:
        try:
            BaseModel.__init__(self, method=method, **options)
        except ValidationError as error:
            path, reason = first_problem(error)
            raise InputError(reason, ".".join(map(str, path))) from None

    @model_validator(mode="after")
    def _searched_from_somewhere(self) -> Self:
        if self.method == "least-squares" and not (self.keep or self.from_case):
            raise problem(
                "keep is 0, so that nothing is searched from; set from_case = true, or keep 1 or more",
                ("keep",),
            )
        return self

    def changed(self, **options: Any) -> Search:
        """The search with other options."""
        return Search(**(self.model_dump() | options))

    def sampled(self, quantities: int) -> int:
        """About how many points nested sampling computes (measured on posteriors of 3 to 10 quantities).

        >>> Search("nested").sampled(3)
        9600
        """
        return self.live_points * (8 + 2 * quantities) + 2 * EFFECTIVE

    def evaluations_of(self, quantities: int) -> int:
        """About how many points will be computed for this many unknown quantities."""
        each = min(self.iterations, 8) * (quantities + 2)
        after = quantities + 1
        if self.method == "nested":
            return self.sampled(quantities) + after
        searched = min(self.keep, self.starts) + self.from_case
        return (self.starts if self.keep else 0) + searched * each + self.draws + after


class UnknownModel(VaryModel):
    """A quantity that is looked for: a ``key`` of the case, or several that move alike; none of an
    evaluator, which knows it by its label.
    """

    key: str | list[str] = ""  # type: ignore[assignment]


class IdentificationModel(CaseModel):
    """The whole file; ``search`` holds the options of a :class:`Search`."""

    what = "identification file"
    evaluator: str = ""
    options: dict[str, float] = Field(default_factory=dict)
    vary: list[UnknownModel] = Field(min_length=1, max_length=MAX_VARIED)
    measurements: dict[Line, Any] = Field(min_length=1)
    predictions: dict[Line, PredictionModel] = Field(default_factory=dict)
    search: dict[str, Any] = Field(default_factory=dict)


@dataclass(frozen=True)
class IdentificationPlan:
    """An identification as a file plans it.

    ``evaluator``: name of a package's evaluator of points (:class:`PointEvaluator`), empty for the
    case itself; ``options`` are its numbers. ``varied``: the keys of each unknown.
    """

    title: str
    case: Case
    unknowns: tuple[Unknown, ...]
    varied: tuple[tuple[Varied, ...], ...]
    data: tuple[Datum, ...]
    targets: tuple[Target, ...]
    search: Search
    evaluator: str
    options: tuple[tuple[str, float], ...]
    text: str


def read_identification(file: FileText[IdentificationModel]) -> IdentificationPlan:
    """The plan of an identification file. Raises :class:`InputError`, one sentence with file, line and key."""
    model, case = file.model, file.case
    evaluator: PointEvaluator | None = None
    if model.evaluator:
        evaluator = file.guarded(("evaluator",), lambda: evaluator_of(model.evaluator))
    found = [_unknown(file, place, case) for place in range(len(model.vary))]
    unknowns, varied = tuple(one for one, _ in found), tuple(keys for _, keys in found)
    names = tuple(one.name for one in unknowns)
    options = tuple(model.options.items())
    if options and not model.evaluator:
        raise file.located(("options",), "belongs to an evaluator; name it, or leave it out")
    if evaluator is not None:  # it refuses names and options that it does not know
        file.guarded(("options",), lambda: evaluator.points(names, model.options))
    data = [
        pair
        for one, table in model.measurements.items()
        for pair in file.guarded(
            ("measurements", one),
            lambda one=one, table=table: read_measurement(
                one, table, file.folder, bool(model.evaluator)
            ),
        )
    ]
    requested = [
        file.guarded(("predictions", one), lambda table=table: table.target)
        for one, table in model.predictions.items()
    ]
    search = file.guarded(("search",), lambda: _search(model.search))
    return IdentificationPlan(
        title=model.title or file.where.removesuffix(".toml").replace("_", " "),
        case=case,
        unknowns=unknowns,
        varied=varied,
        data=tuple(datum for _, datum in data),
        targets=tuple(dict.fromkeys([*(target for target, _ in data), *requested])),
        search=search,
        evaluator=model.evaluator,
        options=options,
        text=file.text,
    )


def evaluator_of(name: str) -> PointEvaluator:
    """The evaluator of points that a package lists under ``name``."""
    found: PointEvaluator = find("evaluators", name, "evaluator")
    return found


def _unknown(
    file: FileText[IdentificationModel], place: int, case: Case
) -> tuple[Unknown, tuple[Varied, ...]]:
    """A quantity with its prior, and its keys of the case; without any for an evaluator."""
    table = file.model.vary[place]
    keys = [table.key] if isinstance(table.key, str) else table.key or [""]
    name = table.label or keys[0]
    if file.model.evaluator and any(keys):
        raise file.located(("vary", place, "key"), "is no key of an evaluator; give a label alone")
    if not file.model.evaluator and not all(keys):
        raise file.located(
            ("vary", place, "key"),
            'is missing; say which value of the case it is, such as key = "spring.wire_diameter"',
        )
    tables = [table.model_copy(update={"key": key or name}) for key in keys]
    subject = None if file.model.evaluator else case
    varied = [
        file.guarded(("vary", place), lambda one=one: varied_of_table(one, subject))
        for one in tables
    ]
    prior, unit = varied[0].distribution, varied[0].unit
    if not isinstance(prior, Prior):
        raise file.located(("vary", place, "values"), "is a list, which is no prior; give another")
    bare = tuple(Varied(one.key, unit, one.operation) for one in varied)
    return Unknown(name, prior, unit), () if file.model.evaluator else bare


def _search(given: dict[str, Any]) -> Search:
    """The search with its options, what is wrong placed at its key."""
    try:
        return Search(**given)
    except InputError as error:
        raise problem(error.reason, (error.where,)) from None


@dataclass(frozen=True)
class PointEvaluator:
    """What a package lists under ``valvetrain.evaluators``.

    ``points(names, options)``: for the unknown quantities of those names, a function of their
    values (SI) that returns numbers by name (SI), None for an impossible point; it pickles. Raises
    :class:`InputError` for a name or an option that is none. ``values(names)``: a start.

    >>> square = PointEvaluator(lambda names, options: lambda values: {"area": values[0] ** 2}, lambda names: (2.0,))
    >>> square.points(["side"], {})([3.0])
    {'area': 9.0}
    """

    points: Callable[
        [Sequence[str], Mapping[str, float]],
        Callable[[Sequence[float]], Mapping[str, float] | None],
    ]
    values: Callable[[Sequence[str]], tuple[float, ...]]
