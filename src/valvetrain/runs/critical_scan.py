"""A scan of settled motion over engine speed: what each speed says of control, and the roots at which control is
lost and regained. It knows no trains.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import pairwise

from scipy.optimize import brentq

from valvetrain.integrate.contract import Orbit
from valvetrain.solution.critical import NARROW, SpeedBracket

#: A run starts from the motion of the next speed below, no further away than this share of the speed.
CLOSE = 0.02
#: Width of a root over its speed.
RELATIVE = 1e-6
#: A dip is looked into where this many times the depth of a parabola through its three speeds reaches zero.
CAUTION = 2.0
#: Ranges of lost control whose ends are computed; those of further ones are speeds of the scan.
MAX_ROOTS = 4
#: Resolutions between the speeds of a scan, and between those just below a loss.
SCAN, BELOW = 5.0, 2.5
#: Width over its speed to which the step below a run that says nothing is halved.
FLANK = 5e-4
#: Measure (SI) where a run says nothing or just reaches zero.
NO_MARGIN = 1e-12


@dataclass(frozen=True, eq=False)
class SpeedSample:
    """The train at one engine speed.

    ``measures`` by kind pass zero where control is lost, which NaN says too; ``places`` of the loss; ``orbit`` on which
    the run ended, None where it does not repeat; ``cam_force``: the least one (N) while open, and ``surge_force``: the
    amplitude (N) of surge, NaN where there is none.
    ``unknown``: kinds of which the run says nothing, since it ended early or ends of its springs would pull
    (``pulls``), which they cannot.
    """

    measures: Mapping[str, float]
    places: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    orbit: Orbit | None = None
    repeats: bool = True
    cam_force: float = math.nan
    unknown: frozenset[str] = frozenset()
    pulls: bool = False
    surge_force: float = math.nan

    def measure(self, kind: str) -> float:
        """The measure with a sign; hardly positive of what a run does not say, hardly negative of 0 and NaN."""
        value = self.measures[kind]
        if value > 0 or value < 0:
            return NO_MARGIN if kind in self.unknown and value < 0 else value
        return NO_MARGIN if kind in self.unknown else -NO_MARGIN

    def kept(self, kind: str) -> bool:
        """Whether control is known to be kept."""
        return kind not in self.unknown and self.measures[kind] > 0

    def lost(self, kind: str) -> bool:
        """Whether control is known to be lost."""
        return kind not in self.unknown and not self.measures[kind] > 0


#: Runs at an engine speed (rad/s) from a motion, or from that of rigid parts, ``precise`` or as a scan is.
RunAt = Callable[[float, Orbit | None, bool], SpeedSample]


@dataclass(eq=False)
class Scan:
    """Samples of one train by engine speed (rad/s), those from precise runs apart.

    ``resolution`` (rad/s): to which a change is narrowed where the motion does not repeat. ``beside``: a scan whose
    motions are starts where this one has none. ``width`` (rad/s) of roots; 0: :data:`RELATIVE`, by precise runs.
    """

    run_at: RunAt
    resolution: float
    beside: Scan | None = None
    samples: dict[float, SpeedSample] = field(default_factory=dict)
    precise: dict[float, SpeedSample] = field(default_factory=dict)
    width: float = 0.0
    runs_count: int = 0

    def at(self, engine_speed: float, precise: bool = False) -> SpeedSample:
        """The sample of a speed, run once from the motion of the next speed below: that of a rising speed."""
        pool = self.precise if precise else self.samples
        if engine_speed not in pool:
            pool[engine_speed] = self.from_motion(engine_speed, self.near(engine_speed), precise)
        return pool[engine_speed]

    def from_motion(
        self, engine_speed: float, orbit: Orbit | None, precise: bool = False
    ) -> SpeedSample:
        """A run at a speed from a motion, which is no sample of the scan."""
        self.runs_count += 1
        return self.run_at(engine_speed, orbit, precise)

    def near(self, engine_speed: float) -> Orbit | None:
        """The motion at the next speed below that has one."""
        below = {
            speed: one.orbit
            for pool in (self.samples, self.precise)
            for speed, one in pool.items()
            if one.orbit is not None and (1 - CLOSE) * engine_speed <= speed <= engine_speed
        }
        if below:
            return below[max(below)]
        return None if self.beside is None else self.beside.near(engine_speed)

    def fill(self, step: float) -> None:
        """Run speeds no more than ``step`` (rad/s) apart between those sampled; next to motion that does not repeat,
        which is dear and says little of its neighbours, only as far apart as a range that an engine passes at once.
        """
        for low, high in pairwise(sorted(self.samples)):
            repeats = self.samples[low].repeats and self.samples[high].repeats
            widest = step if repeats else max(step, NARROW * low)
            count = math.ceil((high - low) / widest - 1e-9)
            for place in range(1, count):
                self.at(low + (high - low) * place / count)

    def look_into_dips(self, kind: str) -> None:
        """Run speeds around the least values between which control may be lost unseen, until it is or cannot be."""
        while near := [one for dip in self._dips_near_zero(kind) for one in dip]:
            for engine_speed in near:
                self.at(engine_speed)

    def look_below_onset(self, kind: str) -> None:
        """Run speeds at half the distance in the short range below the first loss, since two samples that keep
        control may have an earlier loss between them.
        """
        step = BELOW * self.resolution * (1 + 1e-9)
        while lost := [one for one in self.samples if self.samples[one].lost(kind)]:
            top = min(lost)
            near = [one for one in sorted(self.samples) if (1 - NARROW) * top <= one <= top]
            middles = [(low + high) / 2 for low, high in pairwise(near) if high - low > step]
            if not middles or not all(self.samples[one].repeats for one in near):
                return
            for engine_speed in middles:
                self.at(engine_speed)

    def look_before_pulls(self, kind: str, top: float) -> None:
        """Halve the steps below ``top`` (rad/s), to :data:`FLANK`, from a speed that keeps control to one of which a run says
        nothing: contact may have been lost before the ends of its springs pull.
        """

        def wide(low: float, high: float) -> bool:
            unknown = kind in self.samples[high].unknown and self.samples[low].kept(kind)
            return unknown and high <= top and high - low > FLANK * high

        while found := [two for two in pairwise(sorted(self.samples)) if wide(*two)]:
            for low, high in found:
                self.at((low + high) / 2)

    def _dips_near_zero(self, kind: str) -> Iterator[tuple[float, ...]]:
        for three, (before, least, after) in self._dips(kind):
            known = not any(kind in self.samples[one].unknown for one in three)
            near = three[2] - three[0] <= 3 * NARROW * three[1]
            depth = parabola_depth(three, (before, least, after))
            if known and near and 0 < least <= CAUTION * depth:
                yield tuple(
                    (low + high) / 2
                    for low, high in pairwise(three)
                    if high - low > 2 * self.resolution
                )

    def _dips(self, kind: str) -> Iterator[tuple[list[float], list[float]]]:
        """Three neighbouring speeds whose motions repeat with their measures, the middle one the least; what a run does
        not say is hardly positive.
        """
        speeds = sorted(self.samples)
        for place in range(1, len(speeds) - 1):
            three = speeds[place - 1 : place + 2]
            runs = [self.samples[one] for one in three]
            values = [one.measure(kind) for one in runs]
            if all(one.repeats for one in runs) and values[0] > values[1] <= values[2]:
                yield three, values

    def dips(self, kind: str) -> dict[float, float]:
        """Speeds (rad/s) at which control is kept, or not known to be lost, with less than at both neighbours -> the
        measure there.
        """
        return {three[1]: values[1] for three, values in self._dips(kind) if not self.samples[three[1]].lost(kind)}  # fmt: skip

    def lost_ranges(self, kind: str) -> tuple[list[SpeedBracket], list[SpeedBracket]]:
        """Ranges of lost control by the roots at their ends, from 0 where it is lost at the first speed; and short
        ones whose motion never repeats, by their lowest and highest sample: the next revolution may not lose it.
        """
        self.look_below_onset(kind)
        while (wide := next(self._of_unknown_width(kind), 0.0)) > 0:
            self.at(wide)
        speeds, found, passed = sorted(self.samples), list[SpeedBracket](), list[SpeedBracket]()
        for first, last in self._stretches(kind, speeds):
            low, high = speeds[first], speeds[last]
            single = not any(self.samples[one].repeats for one in speeds[first : last + 1])
            if single and 0 < first and last < len(speeds) - 1 and high - low <= NARROW * low:
                passed.append(SpeedBracket(low, high))
                continue
            begin, end = (0.0 if first == 0 else low), speeds[-1]
            above = next((one for one in speeds[last + 1 :] if self.samples[one].kept(kind)), None)
            if above is not None:
                end = speeds[speeds.index(above) - 1]
            if len(found) < MAX_ROOTS:
                if first > 0 and self.samples[speeds[first - 1]].kept(kind):
                    begin = self.root(kind, speeds[first - 1], low)
                if above is not None and end == high:
                    end = self.root(kind, high, above)
            found.append(SpeedBracket(begin, max(begin, end)))
        return found, passed

    def _of_unknown_width(self, kind: str) -> Iterator[float]:
        """Speeds (rad/s) that tell whether a range whose motion never repeats is a short one."""
        speeds = sorted(self.samples)
        for first, last in self._stretches(kind, speeds):
            if 0 < first and last < len(speeds) - 1:
                below, low, high, above = (speeds[n] for n in (first - 1, first, last, last + 1))
                single = not any(self.samples[one].repeats for one in speeds[first : last + 1])
                if single and high - low <= NARROW * low < above - below:
                    yield (below + low) / 2 if low - below > above - high else (high + above) / 2

    def _stretches(self, kind: str, speeds: list[float]) -> list[tuple[int, int]]:
        """First and last place of ``speeds`` that lose control. Samples between them say nothing or, within a short
        range whose motion does not repeat, may lose it in the next revolution.
        """
        found = list[tuple[int, int]]()
        for place in (n for n, one in enumerate(speeds) if self.samples[one].lost(kind)):
            last = found[-1][1] if found else place
            between = [self.samples[one] for one in speeds[last + 1 : place]]
            kept = [one for one in between if one.kept(kind)]
            single = not any(one.repeats for one in kept)
            if found and (not kept or (single and speeds[place] - speeds[last] <= NARROW * speeds[last])):  # fmt: skip
                found[-1] = found[-1][0], place
            else:
                found.append((place, place))
        return found

    def root(self, kind: str, low: float, high: float, width: float = 0.0) -> float:
        """Engine speed (rad/s) between two samples at which a measure passes zero: to ``width`` by runs of the scan,
        by default to that of the scan; to the resolution where a motion does not repeat.
        """
        width = width or self.width
        precise = not width and self.samples[low].repeats and self.samples[high].repeats
        ends = {low: self.samples[low], high: self.samples[high]}
        lost_low = ends[low].lost(kind)
        sides = [low, high]

        def measure(engine_speed: float) -> float:
            one = ends.get(engine_speed) or self.at(engine_speed, precise)
            sides[one.lost(kind) != lost_low] = engine_speed
            if not one.repeats and abs(sides[1] - sides[0]) <= self.resolution:
                return 0.0
            return one.measure(kind)

        wide = width or (RELATIVE * low if precise else self.resolution)
        return float(brentq(measure, low, high, xtol=wide, rtol=1e-14))

    def falling(self, kind: str, begin: float, step: float) -> float:
        """Engine speed (rad/s) below which a falling speed regains control, where that is more than a short range below
        the onset ``begin``, else NaN: in steps of ``step``, each from the motion at the speed before. NaN too where
        the motion does not repeat, and where runs just below the onset say nothing; it ends where they begin to.
        """
        above = [one for one in sorted(self.samples) if one >= begin and self.samples[one].lost(kind)]  # fmt: skip
        below = max(
            (at for at, one in self.samples.items() if at < begin and not one.lost(kind)),
            default=0.0,
        )
        if not above or not below > 0 or not self.samples[below].kept(kind):
            return math.nan
        here, orbit = above[0], self.samples[above[0]].orbit
        lowest = min(self.samples)
        while orbit is not None and here > lowest:
            before, here = here, max(here - step, lowest)
            one = self.from_motion(here, orbit)
            if not one.lost(kind):
                end = here if one.kept(kind) else before
                return end if end < (1 - NARROW) * begin else math.nan
            orbit = one.orbit
        return math.nan

    def pulled(self, ranges: Collection[SpeedBracket]) -> tuple[SpeedBracket, ...]:
        """Ranges of neighbouring samples in which ends of springs would pull, outside ``ranges`` of lost control."""
        found, before = list[SpeedBracket](), 0.0
        for speed in sorted(self.samples):
            lost = any(one.lower_engine_speed <= speed <= one.upper_engine_speed for one in ranges)
            if lost or not self.samples[speed].pulls:
                before = 0.0
                continue
            begin = found.pop().lower_engine_speed if speed <= (1 + CLOSE) * before else speed
            found.append(SpeedBracket(begin, speed))
            before = speed
        return tuple(found)

    def silent(self, kind: str, pulled: Collection[SpeedBracket]) -> tuple[SpeedBracket, ...]:
        """Those of the ranges ``pulled`` in which runs lose control by their measures, over more than a short range or up to
        the last speed: whether a train does that can lift its springs is not known.
        """
        top, found = max(self.samples), list[SpeedBracket]()
        for one in pulled:
            within = (
                at for at in self.samples if one.lower_engine_speed <= at <= one.upper_engine_speed
            )
            lost = [at for at in within if not self.samples[at].measures[kind] > 0]
            if lost and (max(lost) - min(lost) > NARROW * min(lost) or max(lost) == top):
                found.append(one)
        return tuple(found)


def parabola_depth(x: Collection[float], y: Collection[float]) -> float:
    """How far the bottom of the parabola through three points is below the middle one.

    >>> round(parabola_depth((-1.0, 0.5, 2.0), (1.0, 0.25, 4.0)), 9)
    0.25
    """
    left, middle, right = x
    before, least, after = y
    first, second = (least - before) / (middle - left), (after - least) / (right - middle)
    curvature = (second - first) / (right - left)
    slope = first + curvature * (middle - left)
    return slope**2 / (4 * curvature) if curvature > 0 else 0.0
