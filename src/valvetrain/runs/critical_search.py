"""The search for a change between sampled engine speeds: brackets from rest, with rising and with
falling speed. It knows no trains.
"""

from __future__ import annotations

import math
from bisect import bisect_left, insort
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

from valvetrain.solution.critical import NARROW, Crossing, SpeedBracket

#: The steepest slope within this share of the speed counts, times this factor.
NEAR, FACTOR = 0.1, 2.0
#: Largest step between speeds with continued motion, and distance from a bracket at which
#: continuation starts, in resolutions.
STRIDE, AWAY = 4.0, 3.0
#: Measure (SI) of a run that says nothing: no loss, and next to one.
NO_MARGIN = 1e-12


@dataclass(frozen=True, eq=False)
class SpeedSample:
    """The train at one engine speed: ``margins`` by kind (control is lost where not positive),
    ``locations`` of the loss, and the ``orbit`` on which the run ended (None where it cannot be
    continued). ``measures``: the margin of a kind continued below zero, where it ends there;
    ``repeats``: whether the motion repeats every cycle. ``cam_force``: the least one (N) while open, NaN where
    there is none. ``unknown``: kinds of which the run says nothing: it ended early, or ends of its springs would
    pull (``pulls``), which they cannot, so that it neither keeps nor loses control.
    """

    margins: Mapping[str, float]
    locations: Mapping[str, tuple[str, ...]]
    orbit: Any = None
    measures: Mapping[str, float] = field(default_factory=dict)
    repeats: bool = True
    cam_force: float = math.nan
    unknown: frozenset[str] = frozenset()
    pulls: bool = False

    def measure(self, kind: str) -> float:
        """What passes zero where control is lost, with a sign on either side; of an unknown one hardly positive."""
        value = self.measures.get(kind, self.margins[kind])
        return value if kind not in self.unknown or value > 0 else NO_MARGIN

    def lost(self, kind: str) -> bool:
        """Whether control is known to be lost."""
        return kind not in self.unknown and not self.margins[kind] > 0


@dataclass(frozen=True, slots=True)
class Limit:
    """How one kind is searched.

    ``size``: margin of a train far from its limit (None: the largest sampled). ``width``: narrowest
    range, in resolutions, that the search finds where it sampled nothing steeper. ``sign``: the
    kind that precedes this one, empty for none; where neither end of an interval shows it and both
    have the whole margin, no range is searched between them, unless ``within``: this kind occurs
    only where the other does (a train floats only where it has lost contact).
    """

    kind: str
    size: float | None
    width: float
    sign: str = ""
    within: bool = False


#: Runs at an engine speed (rad/s), from a given orbit or from rest.
RunAt = Callable[[float, Any], SpeedSample]


class Search:
    """Samples of speeds from rest and the brackets between them; ``resolution`` in rad/s."""

    def __init__(
        self,
        run_at: RunAt,
        samples: Mapping[float, SpeedSample],
        limits: tuple[Limit, ...],
        resolution: float,
    ) -> None:
        self._run_at, self._samples = run_at, dict(samples)
        self._speeds = sorted(samples)
        self._limits = {limit.kind: limit for limit in limits}
        self._resolution = resolution * (1 + 1e-9)
        self._passed: dict[str, list[SpeedBracket]] = {}
        self.runs_count = 0

    def sample(self, engine_speed: float) -> SpeedSample:
        """The sample of a speed from rest, with its orbit."""
        known = self._samples.get(engine_speed)
        if known is None or known.orbit is None:
            if known is None:
                insort(self._speeds, engine_speed)
            known = self._samples[engine_speed] = self._from(engine_speed, None)
        return known

    @property
    def samples(self) -> Mapping[float, SpeedSample]:
        """All samples by engine speed (rad/s)."""
        return self._samples

    def known(self, engine_speed: float) -> SpeedSample:
        """The sample of a speed that has one."""
        return self._samples[engine_speed]

    def _from(self, engine_speed: float, orbit: Any) -> SpeedSample:
        self.runs_count += 1
        return self._run_at(engine_speed, orbit)

    def _lost(self, kind: str, engine_speed: float) -> bool:
        return self._samples[engine_speed].lost(kind)

    def _regained(self, kind: str, engine_speed: float) -> bool:
        """Whether control is known to be maintained: a run that says nothing ends no range of loss."""
        one = self._samples[engine_speed]
        return not one.lost(kind) and kind not in one.unknown

    def pulled(self, until: float = math.inf) -> tuple[SpeedBracket, ...]:
        """Ranges of sampled speeds below ``until`` in which ends of springs would pull."""
        return pulled_ranges(self._samples, until)

    def pulled_in(self, bracket: SpeedBracket) -> bool:
        """Whether ends of springs would pull at a sampled speed of a bracket."""
        low, high = bracket.lower_engine_speed, bracket.upper_engine_speed
        return any(self._samples[one].pulls for one in self._speeds if low <= one <= high)

    def onset(self, kind: str) -> SpeedBracket | float | None:
        """Bracket of the lowest onset; the first speed where control is lost there already; None
        for never. Short ranges in which the motion does not repeat (:meth:`passed`) are none.
        """
        while True:
            while (middle := self._next(kind)) is not None:
                self.sample(middle)
            counted = (n for n, one in enumerate(self._speeds) if self._counts(kind, one))
            first = next(counted, None)
            if not first:
                return None if first is None else self._speeds[0]
            low, high = self._speeds[first - 1 : first + 1]
            if not self._passes(kind, low, high):
                return SpeedBracket(self._last_kept(kind, high), high)

    def _last_kept(self, kind: str, engine_speed: float) -> float:
        """The next sampled speed below that is known to keep control, or the lowest of all."""
        below = self._speeds[: bisect_left(self._speeds, engine_speed)]
        return next((one for one in reversed(below) if self._regained(kind, one)), below[0])

    def passed(self, kind: str) -> tuple[SpeedBracket, ...]:
        """Short ranges, by their lowest and highest sampled speed, in which the last revolution of a motion
        that does not repeat lost control and no onset is seen: the next revolution, or grid, has others.
        """
        return tuple(self._passed.get(kind, ()))

    def _counts(self, kind: str, engine_speed: float) -> bool:
        """Whether control is lost at a sampled speed that is not passed."""
        return self._lost(kind, engine_speed) and not any(
            one.lower_engine_speed <= engine_speed <= one.upper_engine_speed
            for one in self._passed.get(kind, ())
        )

    def _passes(self, kind: str, low: float, high: float) -> bool:
        """Whether the range that begins between two speeds is short and its motion never repeats; it is passed
        from then on.
        """
        if self._samples[high].repeats:
            return False
        end = self.end(kind, high)
        if end is None or end.upper_engine_speed - low > NARROW * low:
            return False
        last = end.lower_engine_speed
        if any(self._samples[one].repeats for one in self._speeds if high <= one <= last):
            return False
        self._passed.setdefault(kind, []).append(SpeedBracket(high, last))
        return True

    def end(self, kind: str, engine_speed: float) -> SpeedBracket | None:
        """Bracket of the end of the range that begins at ``engine_speed``; None where it lasts to
        the last speed.
        """
        while True:
            above = self._speeds[bisect_left(self._speeds, engine_speed) :]
            first = next((n for n, one in enumerate(above) if self._regained(kind, one)), None)
            if first is None:
                return None
            low, high = above[first - 1], above[first]
            if high - low <= self._resolution:
                return SpeedBracket(low, high)
            self.sample((low + high) / 2)

    def narrowed(self, kind: str, engine_speed: float) -> float:
        """The lowest sampled speed of the range of loss that holds a sampled ``engine_speed``, after its begin
        was narrowed to the resolution.
        """
        high = engine_speed
        while (place := bisect_left(self._speeds, high)) and (
            self._lost(kind, low := self._speeds[place - 1]) or high - low > self._resolution
        ):
            if self._lost(kind, low):
                high = low
            elif self.sample(middle := (low + high) / 2).lost(kind):
                high = middle
        return high

    def stretches(self, kind: str) -> list[SpeedBracket]:
        """All ranges of speeds that lose control, by their lowest and highest sampled speed."""
        found: list[SpeedBracket] = []
        before = False
        for one in self._speeds:
            now = self._lost(kind, one) or (before and not self._regained(kind, one))
            if now and before:
                found[-1] = replace(found[-1], upper_engine_speed=one)
            elif now:
                found.append(SpeedBracket(one, one))
            before = now
        return found

    def crossing(self, kind: str, bracket: SpeedBracket) -> Crossing:
        """The bracket from rest with those of rising and of falling speed."""
        low, high = bracket.lower_engine_speed, bracket.upper_engine_speed
        return Crossing(
            bracket,
            self._carried(kind, self._away(kind, low, -1), high),
            self._carried(kind, self._away(kind, high, 1), low),
        )

    def _away(self, kind: str, engine_speed: float, sign: int) -> float:
        """The nearest sampled speed :data:`AWAY` from the end of a bracket on the same side of the
        change, or that end: just beyond a change the motion from rest may not have jumped yet. Where the
        next is further than a few strides, one at that distance is sampled.
        """
        index, side = bisect_left(self._speeds, engine_speed), self._lost(kind, engine_speed)
        there = engine_speed + sign * AWAY * self._resolution
        beyond = [one for one in self._speeds if (one - there) * sign >= 0]
        if beyond and min(abs(one - there) for one in beyond) > STRIDE * self._resolution:
            self.sample(there)
            index = bisect_left(self._speeds, engine_speed)
        while 0 <= index < len(self._speeds) and self._lost(kind, self._speeds[index]) == side:
            if abs(self._speeds[index] - engine_speed) >= AWAY * self._resolution:
                return self._speeds[index]
            index += sign
        return engine_speed

    def _carried(self, kind: str, begin: float, towards: float) -> SpeedBracket | None:
        """Bracket of the change when each speed continues the motion of the one before, from
        ``begin``.

        Steps grow, and shrink to one resolution before a change counts: a long step may leave a
        motion that still exists.
        """
        last = self._speeds[-1 if towards > begin else 0]
        sign, most, step = (
            math.copysign(1.0, towards - begin),
            STRIDE * self._resolution,
            self._resolution / (1 + 1e-9),
        )
        first, here = self.sample(begin), begin
        side, orbit = first.lost(kind), None if kind in first.unknown else first.orbit
        while orbit is not None:
            there = min(here + step, last) if sign > 0 else max(here - step, last)
            found = self._from(there, orbit)
            if kind in found.unknown:
                return None
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
        """The lowest speed to sample before the lowest onset is certain; None where it is."""
        for low, high in pairwise(self._speeds):
            if self._counts(kind, low):
                return None
            if high - low > self._resolution and (
                self._counts(kind, high) or self._may_hide(kind, low, high)
            ):
                return (low + high) / 2
        return None

    def _may_hide(self, kind: str, low: float, high: float) -> bool:
        """Whether control may be lost between two speeds that maintain it, by the slopes nearby; next to a
        motion that does not repeat, in a range that would not be passed.
        """
        limit, ends = self._limits[kind], (self._samples[low], self._samples[high])
        narrow = high - low <= NARROW * low
        if narrow and (
            not all(one.repeats for one in ends) or all(kind in one.unknown for one in ends)
        ):
            return False
        margins = [one.margins[kind] for one in ends]
        size = limit.size
        if size is None:
            size = max(one.measure(kind) for one in self._samples.values() if not one.lost(kind))
        if limit.sign and min(margins) >= size and not any(one.lost(limit.sign) for one in ends):
            return limit.within and self._may_hide(limit.sign, low, high)
        steepness = max(
            FACTOR * self._steepest(kind, (low + high) / 2),
            2 * size / (limit.width * self._resolution),
        )
        return sum(margins) < steepness * (high - low)

    def _steepest(self, kind: str, engine_speed: float) -> float:
        """Largest change of the margin per rad/s between neighbours near ``engine_speed``; not across a jump,
        where control is lost on one side alone or a motion does not repeat.
        """
        near = self._speeds[
            max(0, bisect_left(self._speeds, (1 - NEAR) * engine_speed) - 1) : bisect_left(
                self._speeds, (1 + NEAR) * engine_speed
            )
            + 1
        ]
        slopes = []
        for low, high in pairwise(near):
            ends = self._samples[low], self._samples[high]
            if self._jumps(kind, *ends):
                continue
            slopes.append(abs(ends[1].margins[kind] - ends[0].margins[kind]) / (high - low))
        return max((slope for slope in slopes if slope == slope), default=0.0)

    def _jumps(self, kind: str, low: SpeedSample, high: SpeedSample) -> bool:
        """Whether the margin between two neighbours says nothing of its slope elsewhere."""
        unknown = kind in low.unknown | high.unknown
        return unknown or low.lost(kind) != high.lost(kind) or not (low.repeats and high.repeats)


def pulled_ranges(
    samples: Mapping[float, SpeedSample], until: float = math.inf
) -> tuple[SpeedBracket, ...]:
    """Ranges of neighbouring sampled speeds below ``until`` in which ends of springs would pull."""
    found: list[SpeedBracket] = []
    before = False
    for speed in sorted(one for one in samples if one < until):
        now = samples[speed].pulls
        if now and before:
            found[-1] = replace(found[-1], upper_engine_speed=speed)
        elif now:
            found.append(SpeedBracket(speed, speed))
        before = now
    return tuple(found)
