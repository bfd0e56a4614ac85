"""Identification files: TOML in, everything an identification needs or one clear sentence out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, Field, ValidationError, model_validator

from valvetrain.errors import InputError
from valvetrain.explore.case_paths import nominal
from valvetrain.explore.engine import Computation
from valvetrain.explore.files import (
    MAX_VARIED,
    CaseModel,
    FileText,
    VaryModel,
)
from valvetrain.explore.observe import (
    FunctionPoints,
    Observed,
    PredictionModel,
    Target,
    TargetData,
    read_measurement,
)
from valvetrain.explore.posterior import Datum
from valvetrain.explore.space import Space
from valvetrain.explore.store import versions_digest
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


def _search(given: Any) -> Search:
    """The search with its options, what is wrong placed at its key."""
    if not isinstance(given, dict):
        raise problem("is no table; write [search] with its options")
    try:
        return Search(**given)
    except InputError as error:
        raise problem(error.reason, (error.where,)) from None


class IdentificationModel(CaseModel):
    """The whole file; ``search`` holds the options of a :class:`Search`."""

    what = "identification file"
    evaluator: str = ""
    options: dict[str, float] = Field(default_factory=dict)
    vary: list[VaryModel] = Field(min_length=1, max_length=MAX_VARIED)
    measurements: dict[Line, Any] = Field(min_length=1)
    predictions: dict[Line, PredictionModel] = Field(default_factory=dict)
    search: Annotated[Search, BeforeValidator(_search)] = Search()


@dataclass(frozen=True, eq=False)
class IdentificationPlan:
    """The ``unknowns``, the ``data``, and what computes points of both.

    ``compared``: what computes, for the draws alone, numbers that are not fitted. ``start``: values (SI) of
    the case, None where it has no single ones. ``units`` of computed numbers by key. ``text``: that of the file.
    """

    unknowns: Space
    data: tuple[Datum, ...]
    fitted: Computation
    compared: Computation | None = None
    search: Search = Search()
    start: tuple[float, ...] | None = None
    units: Mapping[str, str] = field(default_factory=dict)
    case: Case | None = None
    title: str = ""
    text: str = ""


def read_identification(file: FileText[IdentificationModel]) -> IdentificationPlan:
    """The plan of an identification file. Raises :class:`InputError`, one sentence with file, line and key."""
    model, case, word = file.model, file.case, file.model.evaluator
    search = model.search
    evaluator: PointEvaluator | None = None
    if word:
        evaluator = file.guarded(("evaluator",), lambda: find("evaluators", word, ""))
    space = file.space
    for place, one in enumerate(space):
        file.guarded(("vary", place, "values"), lambda one=one: one.prior)
    names, options = tuple(one.title for one in space), dict(model.options)
    if options and not word:
        raise file.located(("options",), "belongs to an evaluator; name it, or leave it out")
    data = [
        pair
        for one, table in model.measurements.items()
        for pair in file.guarded(
            ("measurements", one),
            lambda one=one, table=table: read_measurement(one, table, file.folder, bool(word)),
        )
    ]
    requested = [
        file.guarded(("predictions", one), lambda table=table: table.target)
        for one, table in model.predictions.items()
    ]
    targets = tuple(dict.fromkeys([*(target for target, _ in data), *requested]))
    compared: Computation | None = None
    start: tuple[float, ...] | None = None
    if evaluator is not None:  # it refuses names and options that it does not know
        function = file.guarded(("options",), lambda: evaluator.points(names, options))
        subject = [word, names, options, versions_digest()]
        fitted: Computation = FunctionPoints(function, subject)
        start = tuple(evaluator.values(names))
    else:
        fitted, compared = _computations(case, space, data, targets)
        try:
            start = tuple(nominal(case, one) for one in space)
        except InputError as error:
            if search.from_case:
                raise InputError(f"{error.where} {error.reason}", "search.from_case") from None
    return IdentificationPlan(
        space,
        tuple(datum for _, datum in data),
        fitted,
        compared,
        search,
        start,
        {one.key: one.unit for one in targets},
        None if word else case,
        model.title or file.where.removesuffix(".toml").replace("_", " "),
        file.text,
    )


def _computations(
    case: Case, space: Space, data: TargetData, targets: tuple[Target, ...]
) -> tuple[Computation, Computation | None]:
    """What computes the points of a case under the conditions of which something is fitted, and under the others."""
    fitted, measured = {one.station for one, datum in data if datum.used}, {one for one, _ in data}
    first = tuple(one for one in targets if one.station in fitted and one in measured)
    later = tuple(one for one in targets if one not in first)
    return Observed(case, space, first), Observed(case, space, later) if later else None


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
