"""Critical speeds of a train: where it loses contact, floats and bounces, between and beyond the
speeds of a sweep.
"""

from __future__ import annotations

import math
from bisect import bisect_left, insort
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from valvetrain.errors import InputError
from valvetrain.runs.prepared import Plan, PreparedRun, integrate_from, judge, provenance_of
from valvetrain.runs.workers import map_points
from valvetrain.solution.critical import (
    KINDS,
    CriticalSpeed,
    CriticalSpeeds,
    Crossing,
    SpeedBracket,
)
from valvetrain.solution.result import Solution
from valvetrain.system.problem import Problem
from valvetrain.units import Given, si

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


RPM = math.pi / 30
#: Contacts that drive the valve, in the order from the cam to the valve.
DRIVE = ("cam", "tappet", "rocker", "valve_tip")


@dataclass(frozen=True, slots=True)
class CriticalOptions:
    """``resolution``: width (rad/s of the crank) to which a bracket is narrowed. ``float_lift``:
    lift (m) above the rigid one beyond which
    a train floats. ``bounce_height``: lift (m) of a bounce beyond which it counts."""

    resolution: float = 10 * RPM
    float_lift: float = 50e-6
    bounce_height: float = 100e-6

    def __post_init__(self) -> None:
        for name, words in (
            ("resolution", "10 rpm"),
            ("float_lift", "0.05 mm"),
            ("bounce_height", "0.1 mm"),
        ):
            if not (math.isfinite(value := getattr(self, name)) and value > 0):
                said = name.replace("_", " ")
                raise InputError(
                    f"the {said} of critical speeds must be positive; give such as '{words}'",
                    f"--{said.replace(' ', '-')}",
                )

    @property
    def limits(self) -> tuple[Limit, ...]:
        """How each kind is searched."""
        contact, floats, bounces = KINDS
        return (
            Limit(contact, None, 100.0),
            Limit(floats, self.float_lift, 5.0, contact, within=True),
            Limit(bounces, self.bounce_height, 10.0, contact),
        )

    def limit_of(self, kind: str) -> float:
        """Limit (SI) of a kind: the contact force of a loss of contact is zero."""
        return {"float": self.float_lift, "bounce": self.bounce_height}.get(kind, 0.0)


def read_options(resolution: Given, float_lift: Given, bounce_height: Given) -> CriticalOptions:
    """Options from what people write: "10 rpm" or rad/s, "50 um" or m, or pint quantities. Raises
    :class:`InputError` for another unit or
    what is not positive."""
    return CriticalOptions(
        si(resolution, "engine_speed", "--resolution"),
        si(float_lift, "length", "--float-lift"),
        si(bounce_height, "length", "--bounce-height"),
    )


@dataclass(frozen=True, eq=False)
class _Job:
    """What the search of one member begins with: its place among the members and the looks of the
    sweep by engine speed (rad/s).
    """

    place: int
    looks: Mapping[float, Look]


def look_of(solution: Solution, options: CriticalOptions, orbit: Any = None) -> Look:
    """Margins of a run of a train: least contact force of the drive while open (N), and lift left
    to float and to bounce (m, at most the
    limit itself, at least its negative). A run without its numbers has lost control."""
    least = {
        place: float(solution.statistics.get(f"least_{place}_contact_force", math.nan))
        for place in DRIVE
    }
    least = {place: force for place, force in least.items() if math.isfinite(force)}
    whole = bool(least) and "float_excess_lift" in solution.quantities
    opened = ", ".join(place.replace("_", " ") for place, force in least.items() if force <= 0)
    contact, floats, bounces = KINDS
    margins = {contact: max(0.0, min(least.values())) if whole else math.nan}
    for kind, name, limit in (
        (floats, "float_excess_lift", options.float_lift),
        (bounces, "bounce_height", options.bounce_height),
    ):
        margins[kind] = max(-limit, limit - float(solution.quantities[name])) if whole else math.nan
    return Look(margins, {contact: opened or "run failed", floats: "valve", bounces: "seat"}, orbit)


def find_critical_speeds(
    problem: Problem,
    ready: Sequence[PreparedRun],
    plan: Plan,
    solutions: Sequence[Solution],
    options: CriticalOptions,
    workers: int,
    tell: Any = None,
) -> CriticalSpeeds:
    """The critical speeds of every member that runs, from its ``solutions`` over engine speed.

    Members are searched side by side, each by itself and in the same order of runs, so that the
    answer does not depend on ``workers``.
    ``tell(done, total)`` after each member.
    """
    jobs = []
    for place, one in enumerate(ready):
        mine = {
            run.engine_speed: look_of(run, options)
            for run in solutions
            if run.label == one.member.label
        }
        if one.system is not None and mine:
            jobs.append(_Job(place, mine))
    found = (
        map_points(
            _search,
            (problem, tuple(ready), plan, options),
            jobs,
            workers,
            processes=True,
            tell=tell,
        )
        if jobs
        else ()
    )
    return CriticalSpeeds(tuple(row for rows in found for row in rows))


def _search(
    shared: tuple[Problem, tuple[PreparedRun, ...], Plan, CriticalOptions], job: _Job
) -> tuple[CriticalSpeed, ...]:
    problem, ready, plan, options = shared
    one = ready[job.place]
    search = Search(
        partial(_look_at, problem, one, replace(plan, whole=False), options),
        job.looks,
        options.limits,
        options.resolution,
    )
    return tuple(
        critical_speed(search, kind, one.member.label, min(job.looks), max(job.looks), options)
        for kind in KINDS
    )


def critical_speed(
    search: Search,
    kind: str,
    label: str,
    first_engine_speed: float,
    last_engine_speed: float,
    options: CriticalOptions,
) -> CriticalSpeed:
    """The answer of a search for one kind between two engine speeds (rad/s)."""
    before, limit = search.runs_count, options.limit_of(kind)
    none = CriticalSpeed(
        label, kind, limit, first_engine_speed, last_engine_speed, options.resolution
    )
    onset = search.onset(kind)
    if onset is None:
        return replace(none, runs_count=search.runs_count - before)
    from_speed = onset if isinstance(onset, float) else onset.upper_engine_speed
    end = search.end(kind, from_speed)
    begins = None if isinstance(onset, float) else search.crossing(kind, onset)
    ends = None if end is None else Crossing(end)
    again = tuple(one for one in search.stretches(kind) if one.lower_engine_speed > from_speed)
    place = search.known(from_speed).places[kind]
    return replace(
        none,
        found=True,
        place=place,
        begins=begins,
        ends=ends,
        again=again,
        runs_count=search.runs_count - before,
    )


def _look_at(
    problem: Problem,
    ready: PreparedRun,
    plan: Plan,
    options: CriticalOptions,
    engine_speed: float,
    orbit: Any,
) -> Look:
    origin = provenance_of(problem, ready.member, engine_speed, plan.created_at)
    solution, ended = integrate_from(ready, engine_speed, plan, origin, orbit)
    return look_of(judge(ready, solution, plan, {}), options, ended)
