"""The search for critical speeds, on any function that looks at one engine speed: where to look
next, brackets, hysteresis.

What is looked for may hold on several stretches of speed (resonances lose contact at 7800 and not
at 8100 rpm), so between two speeds
that keep control one that does not may hide. An interval is halved as long as its margins could
reach zero inside: by the
steepest slope seen nearby, with a factor, as in S. A. Piyavskii, USSR Comput. Math. Math. Phys. 12
(1972) 57. See decision 0046.
"""

from __future__ import annotations

import math
from bisect import bisect_left, insort
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from valvetrain.solution.critical import Crossing, SpeedBracket

#: The steepest slope seen within this share of the speed counts, times this factor.
NEAR, FACTOR = 0.1, 2.0
#: Largest step between speeds with carried motion, in resolutions.
STRIDE = 4.0
#: Distance from a bracket, in resolutions, at which the motion is taken that is carried towards it.
AWAY = 3.0


@dataclass(frozen=True, eq=False)
class Look:
    """One engine speed: ``margins`` by kind, positive where control is kept (lost where zero,
    negative or NaN), the ``places`` where it is
    lost, and the motion the run ended on (None where it cannot be carried over)."""

    margins: Mapping[str, float]
    places: Mapping[str, str]
    orbit: Any = None

    def lost(self, kind: str) -> bool:
        """Whether control is lost."""
        return not self.margins[kind] > 0


@dataclass(frozen=True, slots=True)
class Limit:
    """How one kind is searched. ``size``: margin of a train far from its limit (None: the largest
    seen). ``width``: how narrow a
    stretch, in resolutions, is guarded against where nothing steeper was seen. ``sign``: the kind
    that announces this one, empty for none;
    with it kept and the whole margin at both ends of an interval nothing hides between, unless
    ``within``: this kind is met only where the
    other is (a train floats only where it has lost contact), and so hides where that may hide."""

    kind: str
    size: float | None
    width: float
    sign: str = ""
    within: bool = False


#: Looks at an engine speed (rad/s), from the motion given or from rest.
LookAt = Callable[[float, Any], Look]


class Search:
    """Looks at speeds from rest, kept in order, and what they say; ``resolution`` in rad/s."""

    def __init__(
        self,
        look_at: LookAt,
        looks: Mapping[float, Look],
        limits: tuple[Limit, ...],
        resolution: float,
    ) -> None:
        self._look_at, self._looks = look_at, dict(looks)
        self._speeds = sorted(looks)
        self._limits = {limit.kind: limit for limit in limits}
        self._resolution = resolution * (1 + 1e-9)
        self.runs_count = 0

    def look(self, engine_speed: float) -> Look:
        """The look at a speed from rest, its motion with it."""
        known = self._looks.get(engine_speed)
        if known is None or known.orbit is None:
            if known is None:
                insort(self._speeds, engine_speed)
            known = self._looks[engine_speed] = self._from(engine_speed, None)
        return known

    def known(self, engine_speed: float) -> Look:
        """The look at a speed that was looked at."""
        return self._looks[engine_speed]

    def _from(self, engine_speed: float, orbit: Any) -> Look:
        self.runs_count += 1
        return self._look_at(engine_speed, orbit)

    def _lost(self, kind: str, engine_speed: float) -> bool:
        return self._looks[engine_speed].lost(kind)

    def onset(self, kind: str) -> SpeedBracket | float | None:
        """Bracket of the lowest onset; the first speed where control is lost there already; None
        for never.
        """
        while (middle := self._next(kind)) is not None:
            self.look(middle)
        lost = [place for place, one in enumerate(self._speeds) if self._lost(kind, one)]
        if not lost:
            return None
        return (
            self._speeds[0]
            if lost[0] == 0
            else SpeedBracket(self._speeds[lost[0] - 1], self._speeds[lost[0]])
        )

    def end(self, kind: str, engine_speed: float) -> SpeedBracket | None:
        """Bracket of the end of the stretch that is lost at ``engine_speed``; None where it lasts
        to the last speed.
        """
        while True:
            above = self._speeds[bisect_left(self._speeds, engine_speed) :]
            kept = next(
                (place for place, one in enumerate(above) if not self._lost(kind, one)), None
            )
            if kept is None:
                return None
            low, high = above[kept - 1], above[kept]
            if high - low <= self._resolution:
                return SpeedBracket(low, high)
            self.look((low + high) / 2)

    def stretches(self, kind: str) -> list[SpeedBracket]:
        """All stretches of speeds seen to lose control, by their lowest and highest speed."""
        found: list[SpeedBracket] = []
        before = False
        for one in self._speeds:
            now = self._lost(kind, one)
            if now and before:
                found[-1] = replace(found[-1], upper_engine_speed=one)
            elif now:
                found.append(SpeedBracket(one, one))
            before = now
        return found

    def crossing(self, kind: str, bracket: SpeedBracket) -> Crossing:
        """The bracket found from rest with those of rising and of falling speed."""
        low, high = bracket.lower_engine_speed, bracket.upper_engine_speed
        return Crossing(
            bracket,
            self._carried(kind, self._away(kind, low, -1), high),
            self._carried(kind, self._away(kind, high, 1), low),
        )

    def _away(self, kind: str, engine_speed: float, sign: int) -> float:
        """The nearest speed looked at that lies :data:`AWAY` from a bracket's end on the same side
        of the change, or that end: just
        beyond a change the motion from rest may not have jumped yet."""
        place, side = bisect_left(self._speeds, engine_speed), self._lost(kind, engine_speed)
        while 0 <= place < len(self._speeds) and self._lost(kind, self._speeds[place]) == side:
            if abs(self._speeds[place] - engine_speed) >= AWAY * self._resolution:
                return self._speeds[place]
            place += sign
        return engine_speed

    def _carried(self, kind: str, begin: float, towards: float) -> SpeedBracket | None:
        """From the motion at ``begin`` on, each speed from the one before, in steps that grow and,
        since a long one may leave a motion
        that lives on, come back to one resolution before a change is believed."""
        last = self._speeds[-1 if towards > begin else 0]
        sign, most, step = (
            math.copysign(1.0, towards - begin),
            STRIDE * self._resolution,
            self._resolution / (1 + 1e-9),
        )
        first, here = self.look(begin), begin
        side, orbit = first.lost(kind), first.orbit
        while orbit is not None:
            there = min(here + step, last) if sign > 0 else max(here - step, last)
            found = self._from(there, orbit)
            if found.lost(kind) == side:
                if there == last:
                    return None
                here, orbit, step = there, found.orbit, min(2 * step, most)
            elif abs(there - here) > self._resolution:
                most = step = self._resolution / (1 + 1e-9)
            else:
                return SpeedBracket(min(here, there), max(here, there))
        return None

    def _next(self, kind: str) -> float | None:
        """The lowest speed still to be looked at before the lowest onset is certain."""
        for low, high in zip(self._speeds, self._speeds[1:], strict=False):
            if self._lost(kind, low):
                return None
            if high - low > self._resolution and (
                self._lost(kind, high) or self._may_hide(kind, low, high)
            ):
                return (low + high) / 2
        return None

    def _may_hide(self, kind: str, low: float, high: float) -> bool:
        """Whether between two speeds that keep control one may not, as far as slopes seen nearby
        tell.
        """
        limit, ends = self._limits[kind], (self._looks[low], self._looks[high])
        margins = [one.margins[kind] for one in ends]
        size = (
            max(one.margins[kind] for one in self._looks.values() if one.margins[kind] > 0)
            if limit.size is None
            else limit.size
        )
        if limit.sign and min(margins) >= size and not any(one.lost(limit.sign) for one in ends):
            return limit.within and self._may_hide(limit.sign, low, high)
        steepness = max(
            FACTOR * self._steepest(kind, (low + high) / 2),
            2 * size / (limit.width * self._resolution),
        )
        return sum(margins) < steepness * (high - low)

    def _steepest(self, kind: str, engine_speed: float) -> float:
        """Largest change of the margin per rad/s between neighbours near ``engine_speed``."""
        near = self._speeds[
            max(0, bisect_left(self._speeds, (1 - NEAR) * engine_speed) - 1) : bisect_left(
                self._speeds, (1 + NEAR) * engine_speed
            )
            + 1
        ]
        values = [self._looks[one].margins[kind] for one in near]
        slopes = [
            abs(b - a) / (y - x)
            for a, b, x, y in zip(values, values[1:], near, near[1:], strict=False)
        ]
        return max((slope for slope in slopes if slope == slope), default=0.0)
