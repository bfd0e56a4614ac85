"""A limit speed: the highest engine speed up to which a quantity stays within a bound, searched by one job."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, fields, replace
from functools import cache

import numpy as np

from valvetrain.explore.outputs import LimitSearch, Outcome
from valvetrain.runs.critical_scan import parabola_depth
from valvetrain.solution.critical import RPM

#: How a search ended: a bracket was found; the bound is left at the lowest speed already; it is
#: met up to the highest one.
FOUND, BELOW, BEYOND = "found", "below", "beyond"
#: A peak is looked into where this many times the rise of a parabola through its three points
#: reaches the bound.
CAUTION = 2.0
#: Runs of a search beyond those of its grid, about as many as there are.
CLOSER = 10


@dataclass(frozen=True, slots=True)
class LimitFound:
    """The bracket: the ``bound`` (SI) is met up to ``low`` and exceeded at ``high`` (rad/s).

    ``low`` is 0 where the bound is left at the lowest speed already, ``missed`` by which share of it;
    ``high`` is infinite where it is met up to the highest one.
    """

    low: float
    high: float
    missed: float = 0.0
    bound: float = np.nan

    @property
    def kind(self) -> str:
        """:data:`FOUND`, :data:`BELOW` or :data:`BEYOND`."""
        return BELOW if self.low == 0 else FOUND if np.isfinite(self.high) else BEYOND

    @property
    def value(self) -> float:
        """The limit speed (rad/s): the highest one at which the bound was met; the lowest
        searched where there is none.
        """
        return self.low or self.high


def find_limit(limit: LimitSearch, value_at: Callable[[float], float]) -> LimitFound:
    """The bracket of a limit speed, from the lowest speed of the grid upwards.

    Parameters
    ----------
    limit : bound, grid and resolution
    value_at : the quantity (SI) at an engine speed (rad/s); nan counts as beyond the bound

    Examples
    --------
    >>> found = find_limit(LimitSearch("q", True, 9.0, (1.0, 2.0, 4.0), 0.25), lambda speed: speed**2)
    >>> found.low, found.high
    (3.0, 3.25)
    """
    sign = 1.0 if limit.upper else -1.0

    @cache
    def excess(engine_speed: float) -> float:
        value = value_at(engine_speed)
        return sign * (value - limit.bound) if np.isfinite(value) else np.inf

    speeds = list[float]()
    for engine_speed in limit.engine_speeds:
        speeds.append(engine_speed)
        if excess(engine_speed) > 0:
            break
    while True:
        speeds.sort()
        beyond = next((place for place, one in enumerate(speeds) if excess(one) > 0), None)
        if beyond == 0:
            missed = excess(speeds[0]) / (abs(limit.bound) or 1.0)
            return LimitFound(0.0, speeds[0], missed, limit.bound)
        within = speeds[:beyond]
        # a peak between the points of the grid may leave the bound
        if near := _nearing(within, [excess(one) for one in within], limit.resolution):
            speeds += near
        elif beyond is None:
            return LimitFound(speeds[-1], np.inf, bound=limit.bound)
        elif (high := speeds[beyond]) - within[-1] <= limit.resolution * (1 + 1e-9):
            return LimitFound(within[-1], high, bound=limit.bound)
        else:
            speeds.append(0.5 * (within[-1] + high))


def _nearing(engine_speeds: list[float], excess: list[float], resolution: float) -> list[float]:
    """Speeds about the lowest peak inside the bound whose top, as a parabola with some caution
    gives it, may be beyond the bound.
    """
    for place in range(1, len(engine_speeds) - 1):
        before, top, after = excess[place - 1 : place + 2]
        left, here, right = engine_speeds[place - 1 : place + 2]
        is_peak = top >= before and top >= after and (top > before or top > after)
        if (
            is_peak
            and top + CAUTION * parabola_depth((left, here, right), (-before, -top, -after)) > 0
        ):
            pairs = ((left, here), (here, right))
            middles = [0.5 * (one + two) for one, two in pairs if two - one > 2 * resolution]
            if middles:
                return middles
    return []


def limit_outcome(
    limit: LimitSearch, at: Callable[[float], Outcome], of_case: Callable[[float], Outcome]
) -> Outcome:
    """The limit speed of a point by its name, and the fields of :class:`LimitFound`; or why there is none.

    ``at``, ``of_case``: the outcome of the point, and of the case itself, at an engine speed (rad/s). A run that fails above the
    lowest speed leaves the bound.
    """
    name, lowest = limit.quantity, limit.engine_speeds[0]
    for compute in (of_case, at) if limit.share is not None else (at,):
        first = compute(lowest)
        if not first.status.completed or name not in first.values:
            return _at_lowest(first, lowest)
        if compute is of_case and limit.share is not None:
            limit = replace(limit, bound=limit.share * first.values[name])

    def value_at(engine_speed: float) -> float:
        there = first if engine_speed == lowest else at(engine_speed)
        return there.values.get(name, np.nan) if there.status.completed else np.nan

    found = find_limit(limit, value_at)
    return Outcome(values={limit.name: found.value, **asdict(found)})


def limit_of(outcome: Outcome) -> LimitFound:
    """The bracket in the outcome of a search that completed."""
    return LimitFound(*(outcome.values[one.name] for one in fields(LimitFound)))


def _at_lowest(outcome: Outcome, engine_speed: float) -> Outcome:
    """The status of a run at the lowest speed, without numbers."""
    if outcome.status.completed:
        return Outcome()
    message = (
        f"at {engine_speed / RPM:.6g} rpm, the lowest speed searched: {outcome.status.message}"
    )
    return Outcome(replace(outcome.status, message=message))
