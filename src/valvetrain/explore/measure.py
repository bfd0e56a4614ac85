"""Measures of a design: one number from the runs of a quantity, or a limit speed; objectives and
constraints on them.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from valvetrain.explore.engine import Engine, Evaluation, PointJob
from valvetrain.explore.outputs import LimitSearch, Outcome, Run, has_pair
from valvetrain.explore.space import Varied
from valvetrain.solution.definition import definition_of, not_given, of_pair, shown
from valvetrain.solution.status import Status

#: How a search ended: a bracket was found; the bound is left at the lowest speed already; it is
#: met up to the highest one.
FOUND, BELOW, BEYOND = "found", "below", "beyond"
#: A rise over its neighbours this many times what a parabola through the three gives is regarded
#: possible between them.
CAUTION = 2.0
#: Runs of the search for a limit speed beyond those of its grid, about as many as there are.
CLOSER = 10
Scan = Generator[list[float], list[float], "LimitFound"]


@dataclass(frozen=True, slots=True)
class LimitFound:
    """The bracket: the bound is met up to ``low`` and exceeded at ``high`` (rad/s); ``kind`` says
    whether there is one.

    ``missed``: where the bound is left at the lowest speed already, by which share of it.
    """

    kind: str
    low: float
    high: float
    missed: float = 0.0

    @property
    def value(self) -> float:
        """The limit speed (rad/s): the highest one at which the bound was met; the lowest
        searched where there is none.
        """
        return self.high if self.kind == BELOW else self.low


def find_limit(limit: LimitSearch) -> Scan:
    """Request values at engine speeds (rad/s), batch by batch; a value that is not there (nan)
    counts as beyond the bound.
    """
    sign = 1.0 if limit.upper else -1.0
    known: dict[float, float] = {}

    def excess(engine_speed: float) -> float:
        value = known[engine_speed]
        return sign * (value - limit.bound) if np.isfinite(value) else np.inf

    for engine_speed in limit.engine_speeds:
        known[engine_speed] = (yield [engine_speed])[0]
        if excess(engine_speed) > 0:
            break
    while True:
        order = sorted(known)
        beyond = next((place for place, one in enumerate(order) if excess(one) > 0), None)
        if beyond == 0:
            return LimitFound(BELOW, 0.0, order[0], excess(order[0]) / (abs(limit.bound) or 1.0))
        near = _nearing(order[:beyond], [excess(one) for one in order[:beyond]], limit.resolution)
        if near:  # a peak between the points of the grid that may leave the bound
            known |= dict(zip(near, (yield near), strict=True))
            continue
        if beyond is None:
            return LimitFound(BEYOND, order[-1], np.inf)
        low, high = order[beyond - 1], order[beyond]
        if high - low <= limit.resolution * (1 + 1e-9):
            return LimitFound(FOUND, low, high)
        middle = 0.5 * (low + high)
        known[middle] = (yield [middle])[0]


def _nearing(engine_speeds: list[float], excess: list[float], resolution: float) -> list[float]:
    """Speeds about the lowest peak inside the bound whose top, as a parabola with some caution
    gives it, may be beyond the bound.
    """
    for place in range(1, len(engine_speeds) - 1):
        before, top, after = excess[place - 1 : place + 2]
        if not (top >= before and top >= after and (top > before or top > after)):
            continue
        left, here, right = engine_speeds[place - 1 : place + 2]
        if (
            top + CAUTION * _rise(np.array([left, here, right]), np.array([before, top, after]))
            <= 0
        ):
            continue
        middles = [
            0.5 * (one + two)
            for one, two in ((left, here), (here, right))
            if two - one > 2 * resolution
        ]
        if middles:
            return middles
    return []


def _rise(
    x: np.ndarray[tuple[int], np.dtype[np.float64]], y: np.ndarray[tuple[int], np.dtype[np.float64]]
) -> float:
    """How far the top of the parabola through three points is above the middle one."""
    first, second = np.diff(y) / np.diff(x)
    curvature = (second - first) / (x[2] - x[0])
    if curvature >= 0:
        return 0.0
    slope = first + curvature * (x[1] - x[0])
    return float(-(slope**2) / (4 * curvature))


#: Where a number comes from: springs at rest, runs at the speeds of the file, runs of a search for
#: a limit speed.
REST, RUNS, LIMIT = "rest", "runs", "limit"
#: The value of what is varied, which needs no point.
VARIED = "varied"
#: Status of a design whose points lack a number that was requested.
INCOMPLETE = "incomplete"
#: A requested point: its source, and the run.
Ask = tuple[str, Run]
Answers = Generator[list[Ask], list[Outcome], "Measured"]
#: Dimension and shown unit of a limit speed.
_RPM = np.pi / 30


@dataclass(frozen=True)
class Measure:
    """One number of a design: ``quantity`` over ``runs``, the ``over`` (worst, mean) of several, or
    a limit speed where ``limit`` is given, or the value of what is ``varied``.

    ``largest_is_worst`` gives which of several is the worst. ``label``: plain words. ``bounds``: of
    the limit speed of each run, where they
    are shares of what the case has; else that of ``limit`` holds for all. ``optional``: a run need not
    give it.
    """

    source: str
    quantity: str
    runs: tuple[Run, ...]
    label: str
    largest_is_worst: bool = True
    over: str = "worst"
    limit: LimitSearch | None = None
    bounds: tuple[float, ...] = ()
    varied: Varied | None = None
    optional: bool = False

    def limit_of(self, place: int) -> LimitSearch:
        """The search for the limit speed of the run at ``place``."""
        assert self.limit is not None
        return replace(self.limit, bound=self.bounds[place]) if self.bounds else self.limit

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
        if self.varied is not None:
            return self.varied.si_unit or "1"
        return "rad/s" if self.limit is not None else definition_of(self.quantity).si_unit

    @property
    def unit(self) -> str:
        """Unit in which tables show it."""
        if self.varied is not None:
            return self.varied.unit
        return "rpm" if self.limit is not None else definition_of(self.quantity).unit_word

    def shown(self, value: float) -> float:
        """A value (SI) in the unit of tables."""
        if self.varied is not None:
            return self.varied.shown(value)
        return value / _RPM if self.limit is not None else float(shown(self.quantity, value)[0])

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


def measuring(measures: Sequence[Measure], stop: object = None, pair: bool = False) -> Answers:
    """Request the points of ``measures`` batch by batch and give their numbers; what a design
    cannot be is found first, at rest.

    ``stop(values)`` may say, before the search for limit speeds, that these are not needed. ``pair``: a
    run has two springs, whose quantities have the name of each in front.
    """
    values: dict[Measure, float] = {}
    for source in (REST, RUNS, LIMIT):
        here = [one for one in measures if one.source == source and one.limit is None]
        asks = list(dict.fromkeys((source, run) for one in here for run in one.runs))
        if not asks:
            continue
        found = dict(zip(asks, (yield asks), strict=True))
        values |= {
            one: one.of([found[source, run].values.get(one.quantity, np.nan) for run in one.runs])
            for one in here
        }
        for (_, run), outcome in found.items():
            if not outcome.status.completed:
                return Measured(
                    values, {}, _at(run, outcome.status.sentence()), outcome.status.code
                )
        lacking = [one for one in here if not np.isfinite(values[one]) and not one.optional]
        if lacking:
            name = lacking[0].quantity
            return Measured(values, {}, not_given(name, of_pair(name) if pair else ()), INCOMPLETE)
    if callable(stop) and stop(values):
        return Measured(values, {})
    limits: dict[Measure, tuple[LimitFound, ...]] = {}
    for one in (one for one in measures if one.limit is not None):
        brackets: list[LimitFound] = []
        for place, run in enumerate(one.runs):
            found_limit, failed = yield from _limit(one, place)
            if failed is not None:
                return Measured(
                    values, limits, _at(run, failed.status.sentence()), failed.status.code
                )
            brackets.append(found_limit)
        limits[one] = tuple(brackets)
        values[one] = one.of([bracket.value for bracket in brackets])
    return Measured(values, limits)


def _limit(
    one: Measure, place: int
) -> Generator[list[Ask], list[Outcome], tuple[LimitFound, Outcome | None]]:
    """The bracket of one limit speed; a run that fails at the lowest speed is returned, a higher
    one counts as beyond the bound.
    """
    run, search = one.runs[place], find_limit(one.limit_of(place))
    requested = next(search)
    first = True
    while True:
        found = yield [(LIMIT, (engine_speed, run[1], run[2])) for engine_speed in requested]
        if first and not found[0].status.completed:
            return LimitFound(BELOW, 0.0, requested[0]), found[0]
        if first and one.quantity not in found[0].values:
            missing = Status(INCOMPLETE, not_given(one.quantity, found[0].values))
            return LimitFound(BELOW, 0.0, requested[0]), Outcome(missing)
        first = False
        reported = [
            outcome.values.get(one.quantity, np.nan) if outcome.status.completed else np.nan
            for outcome in found
        ]
        try:
            requested = search.send(reported)
        except StopIteration as end:
            return end.value, None


def _at(run: Run, sentence: str) -> str:
    speed = "" if run[0] is None else f"at {run[0] / _RPM:.6g} rpm: "
    return f"{speed}{sentence}"


#: A design to be measured: its experiments by source, with or without what is varied, and its
#: values (SI).
Subject = tuple[Mapping[str, Evaluation], tuple[float, ...]]
Stop = Callable[[Mapping[Measure, float]], bool]


def _has_pair(one: Evaluation) -> bool:
    return one.case is not None and has_pair(one.case, one.runs)


def measure_designs(
    engine: Engine,
    subjects: Sequence[Subject],
    measures: Sequence[Measure],
    stop: Stop | None = None,
) -> list[Measured]:
    """The numbers of every design, in order, measured side by side batch by batch;
    ``stop(values)`` may spare a design the search for limit speeds.
    """
    if not measures:
        return [Measured({}, {}) for _ in subjects]
    running = {
        index: measuring(measures, stop, any(map(_has_pair, subject[0].values())))
        for index, subject in enumerate(subjects)
    }
    requested = {index: next(one, None) for index, one in running.items()}
    done: dict[int, Measured] = {}
    while running:
        batch: list[PointJob] = [
            (subjects[index][0][source], subjects[index][1], run)
            for index in running
            for source, run in requested[index] or ()
        ]
        outcomes = iter(engine.outcomes(batch))
        for index in tuple(running):
            answer = [next(outcomes) for _ in requested[index] or ()]
            try:
                requested[index] = running[index].send(answer)
            except StopIteration as end:
                done[index] = end.value
                del running[index], requested[index]
    return [done[index] for index in range(len(subjects))]
