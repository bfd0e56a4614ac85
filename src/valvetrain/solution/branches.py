"""Branches of a train's motion over engine speed: what a rising and a falling speed show, and which motions repel."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from valvetrain.solution.critical import SpeedBracket
from valvetrain.solution.display import Saveable

#: Share of the largest value of a branch by which rising and falling speed differ where both motions exist.
DIFFERS = 0.02
#: Lyapunov exponent a revolution, over as few as are run, from which a motion is chaotic.
CHAOTIC = 0.05
#: What is said of an orbit whose stability its multiplier does not tell.
UNRESOLVED = "unresolved"


@dataclass(frozen=True, slots=True)
class BranchPoint:
    """A motion of a train at one ``engine_speed`` (rad/s).

    ``rising``: whether it was reached as the speed rises. ``period``: revolutions after which it repeats, 0 for never.
    ``values`` (SI) of the quantity in one revolution after another: ``period`` of them, several of a motion that never
    repeats. ``landings``: closings of contacts in its last revolution. ``repels``: an orbit from which the train moves
    away, and how: ``fold``, ``flip`` or ``torus``; ``unresolved`` where its multiplier does not tell whether the train stays;
    empty of one that attracts. ``multiplier``: size of the largest one, NaN where none was computed or it is not resolved.
    ``exponent``: largest Lyapunov exponent a revolution of a motion that never repeats, NaN of others.
    """

    engine_speed: float
    rising: bool
    period: int
    values: tuple[float, ...]
    landings: int = 0
    repels: str = ""
    multiplier: float = math.nan
    exponent: float = math.nan

    @property
    def motion(self) -> str:
        """What kind of motion it is: ``period 1``, ``period 2``, ``chaotic``, ``irregular``, ``repels by flip``,
        ``unresolved``.
        """
        if self.repels:
            return UNRESOLVED if self.repels == UNRESOLVED else f"repels by {self.repels}"
        if self.period:
            return f"period {self.period}"
        return "chaotic" if self.exponent > CHAOTIC else "irregular"


@dataclass(frozen=True, slots=True, repr=False)
class Branches(Saveable):
    """Motions of a train over engine speed, marched up and down; speeds in rad/s of the crank.

    ``label`` of the run, ``quantity`` by its name, ``points`` in the order of the march, ``revolutions`` that it took, and
    ``complete``: whether it came to its end within those allowed.

    >>> low, high = (BranchPoint(100.0, rising, 1, (value,)) for rising, value in ((True, 1e-3), (False, 2e-3)))
    >>> branches = Branches("stock", "loft_gap", (low, high), 12)
    >>> branches.hysteresis
    (SpeedBracket(lower_engine_speed=100.0, upper_engine_speed=100.0),)
    """

    label: str
    quantity: str
    points: tuple[BranchPoint, ...]
    revolutions: int
    complete: bool = True

    def attracting(self, rising: bool) -> tuple[BranchPoint, ...]:
        """Motions that the train shows as the speed rises, or falls, by speed."""
        found = (one for one in self.points if one.rising is rising and not one.repels)
        return tuple(sorted(found, key=lambda one: one.engine_speed))

    @property
    def hysteresis(self) -> tuple[SpeedBracket, ...]:
        """Ranges of speeds at which a rising and a falling speed show different motions, at least one of which repeats."""
        most = max((abs(one) for point in self.points for one in point.values), default=0.0)
        falling = {one.engine_speed: one for one in self.attracting(False)}
        both = [(one, falling.get(one.engine_speed)) for one in self.attracting(True)]
        return _ranges(
            (up.engine_speed, bool(up.period or down.period) and _apart(up, down) > DIFFERS * most)
            for up, down in both
            if down is not None
        )

    @property
    def grazing(self) -> tuple[SpeedBracket, ...]:
        """Neighbouring speeds between which a motion that repeats every revolution gains or loses a landing."""
        pairs = (pair for rising in (True, False) for pair in pairwise(self.attracting(rising)))
        found = {
            SpeedBracket(low.engine_speed, high.engine_speed)
            for low, high in pairs
            if low.period == high.period == 1 and low.landings != high.landings
        }
        return tuple(sorted(found, key=lambda one: one.lower_engine_speed))

    def ranges(self, motion: str) -> tuple[SpeedBracket, ...]:
        """Ranges of neighbouring speeds with a motion such as ``chaotic`` or ``period 2``, rising or falling."""
        speeds = sorted({one.engine_speed for one in self.points})
        such = {one.engine_speed for one in self.points if one.motion == motion}
        return _ranges((one, one in such) for one in speeds)

    def __repr__(self) -> str:
        name = "Branches" + ("" if self.complete else ", not complete")
        motions = dict.fromkeys(one.motion for one in self.points)
        rows = [f"{one}: {', '.join(map(str, self.ranges(one)))} rpm" for one in motions]
        both = (
            [f"hysteresis: {', '.join(map(str, self.hysteresis))} rpm"] if self.hysteresis else []
        )
        return "\n  ".join(
            (f"{name} of {self.label}, {self.revolutions} revolutions", *rows, *both)
        )

    def to_records(self) -> list[dict[str, float | str | bool | None]]:
        """A row per motion by name: speeds in rad/s of the crank, values in SI, the least and the largest of the
        revolutions; None for what was not computed.
        """
        rows = []
        for one in self.points:
            numbers = {
                "engine_speed": one.engine_speed, "least": min(one.values), "largest": max(one.values),
                "multiplier": one.multiplier, "exponent": one.exponent,
            }  # fmt: skip
            finite = {
                name: value if math.isfinite(value) else None for name, value in numbers.items()
            }
            rows.append({"rising": one.rising, "motion": one.motion, **finite})
        return rows


def _apart(up: BranchPoint, down: BranchPoint) -> float:
    """Difference of the largest and of the least values, the larger one."""
    return max(abs(max(up.values) - max(down.values)), abs(min(up.values) - min(down.values)))


def _ranges(marked: Iterator[tuple[float, bool]]) -> tuple[SpeedBracket, ...]:
    """First and last speed of every run of marked neighbours."""
    found, inside = list[SpeedBracket](), False
    for speed, holds in marked:
        if holds:
            begin = found.pop().lower_engine_speed if inside else speed
            found.append(SpeedBracket(begin, speed))
        inside = holds
    return tuple(found)
