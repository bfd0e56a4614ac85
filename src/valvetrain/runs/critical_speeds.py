"""Critical speeds of a train: where it loses contact, floats and bounces, searched between the
speeds of a sweep.
"""

from __future__ import annotations

import math
from bisect import bisect_left, insort
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from valvetrain.errors import InputError
from valvetrain.runs.prepared import (
    Plan,
    PreparedRun,
    integrate_from,
    provenance_of,
    with_quantities,
)
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

#: The steepest slope within this share of the speed counts, times this factor.
NEAR, FACTOR = 0.1, 2.0
#: Largest step between speeds with continued motion, and distance from a bracket at which
#: continuation starts, in resolutions.
STRIDE, AWAY = 4.0, 3.0


@dataclass(frozen=True, eq=False)
class SpeedSample:
    """The train at one engine speed: ``margins`` by kind (control is lost where not positive),
    ``locations`` of the loss, and the ``orbit`` on which the run ended (None where it cannot be
    continued).
    """

    margins: Mapping[str, float]
    locations: Mapping[str, str]
    orbit: Any = None

    def lost(self, kind: str) -> bool:
        """Whether control is lost."""
        return not self.margins[kind] > 0


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
        self.runs_count = 0

    def sample(self, engine_speed: float) -> SpeedSample:
        """The sample of a speed from rest, with its orbit."""
        known = self._samples.get(engine_speed)
        if known is None or known.orbit is None:
            if known is None:
                insort(self._speeds, engine_speed)
            known = self._samples[engine_speed] = self._from(engine_speed, None)
        return known

    def known(self, engine_speed: float) -> SpeedSample:
        """The sample of a speed that has one."""
        return self._samples[engine_speed]

    def _from(self, engine_speed: float, orbit: Any) -> SpeedSample:
        self.runs_count += 1
        return self._run_at(engine_speed, orbit)

    def _lost(self, kind: str, engine_speed: float) -> bool:
        return self._samples[engine_speed].lost(kind)

    def onset(self, kind: str) -> SpeedBracket | float | None:
        """Bracket of the lowest onset; the first speed where control is lost there already; None
        for never.
        """
        while (middle := self._next(kind)) is not None:
            self.sample(middle)
        first = next((n for n, one in enumerate(self._speeds) if self._lost(kind, one)), None)
        if not first:
            return None if first is None else self._speeds[0]
        return SpeedBracket(self._speeds[first - 1], self._speeds[first])

    def end(self, kind: str, engine_speed: float) -> SpeedBracket | None:
        """Bracket of the end of the range that begins at ``engine_speed``; None where it lasts to
        the last speed.
        """
        while True:
            above = self._speeds[bisect_left(self._speeds, engine_speed) :]
            first = next((n for n, one in enumerate(above) if not self._lost(kind, one)), None)
            if first is None:
                return None
            low, high = above[first - 1], above[first]
            if high - low <= self._resolution:
                return SpeedBracket(low, high)
            self.sample((low + high) / 2)

    def stretches(self, kind: str) -> list[SpeedBracket]:
        """All ranges of speeds that lose control, by their lowest and highest sampled speed."""
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
        """The bracket from rest with those of rising and of falling speed."""
        low, high = bracket.lower_engine_speed, bracket.upper_engine_speed
        return Crossing(
            bracket,
            self._carried(kind, self._away(kind, low, -1), high),
            self._carried(kind, self._away(kind, high, 1), low),
        )

    def _away(self, kind: str, engine_speed: float, sign: int) -> float:
        """The nearest sampled speed :data:`AWAY` from the end of a bracket on the same side of the
        change, or that end: just beyond a change the motion from rest may not have jumped yet.
        """
        index, side = bisect_left(self._speeds, engine_speed), self._lost(kind, engine_speed)
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
        """The lowest speed to sample before the lowest onset is certain; None where it is."""
        for low, high in zip(self._speeds, self._speeds[1:], strict=False):
            if self._lost(kind, low):
                return None
            if high - low > self._resolution and (
                self._lost(kind, high) or self._may_hide(kind, low, high)
            ):
                return (low + high) / 2
        return None

    def _may_hide(self, kind: str, low: float, high: float) -> bool:
        """Whether control may be lost between two speeds that maintain it, by the slopes nearby."""
        limit, ends = self._limits[kind], (self._samples[low], self._samples[high])
        margins = [one.margins[kind] for one in ends]
        size = limit.size
        if size is None:
            size = max(one.margins[kind] for one in self._samples.values() if not one.lost(kind))
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
        values = [self._samples[one].margins[kind] for one in near]
        slopes = [
            abs(b - a) / (y - x)
            for a, b, x, y in zip(values, values[1:], near, near[1:], strict=False)
        ]
        return max((slope for slope in slopes if slope == slope), default=0.0)


RPM = math.pi / 30
#: Contacts of the drive, from the cam to the valve.
DRIVE = ("cam", "tappet", "rocker", "valve_tip")


@dataclass(frozen=True, slots=True)
class CriticalOptions:
    """Options of the search.

    ``resolution``: width (rad/s of the crank) of a bracket. ``float_lift``: lift (m) above the
    rigid one beyond which a train floats. ``bounce_height``: lift (m) beyond which a bounce counts.
    """

    resolution: float = 10 * RPM
    float_lift: float = 50e-6
    bounce_height: float = 100e-6

    def __post_init__(self) -> None:
        examples = {"resolution": "10 rpm", "float_lift": "0.05 mm", "bounce_height": "0.1 mm"}
        for name, example in examples.items():
            if not (math.isfinite(value := getattr(self, name)) and value > 0):
                raise InputError(
                    f"the {name.replace('_', ' ')} of critical speeds must be positive; give such as '{example}'",
                    f"--{name.replace('_', '-')}",
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
    """Options from "10 rpm" or rad/s, "50 um" or m, or pint quantities.

    Raises :class:`InputError` for another unit or what is not positive.
    """
    return CriticalOptions(
        si(resolution, "engine_speed", "resolution"),
        si(float_lift, "length", "float_lift"),
        si(bounce_height, "length", "bounce_height"),
    )


def sample_of(solution: Solution, options: CriticalOptions, orbit: Any = None) -> SpeedSample:
    """Margins of a run of a train: least contact force of the drive while open (N), and lift left
    to float and to bounce (m, at most the limit itself, at least its negative). A run without its
    numbers has lost control.
    """
    forces = (
        float(solution.statistics.get(f"least_{name}_contact_force", math.nan)) for name in DRIVE
    )
    least = {name: force for name, force in zip(DRIVE, forces, strict=True) if math.isfinite(force)}
    whole = bool(least) and "float_excess_lift" in solution.quantities
    opened = ", ".join(name.replace("_", " ") for name, force in least.items() if force <= 0)
    contact, floats, bounces = KINDS
    margins = {contact: max(0.0, min(least.values())) if whole else math.nan}
    for kind, name, limit in (
        (floats, "float_excess_lift", options.float_lift),
        (bounces, "bounce_height", options.bounce_height),
    ):
        margins[kind] = max(-limit, limit - float(solution.quantities[name])) if whole else math.nan
    locations = {contact: opened or "run failed", floats: "valve", bounces: "seat"}
    return SpeedSample(margins, locations, orbit)


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

    Members are searched in parallel, each alone and in the same order of runs, so that the result
    does not depend on ``workers``. ``tell(done, total)`` is called after each member.
    """
    jobs: list[tuple[int, Mapping[float, SpeedSample]]] = []
    for index, one in enumerate(ready):
        runs = (run for run in solutions if run.label == one.member.label)
        samples = {run.engine_speed: sample_of(run, options) for run in runs}
        if one.system is not None and samples:
            jobs.append((index, samples))
    shared = problem, tuple(ready), plan, options
    found = map_points(_search, shared, jobs, workers, processes=True, tell=tell) if jobs else ()
    return CriticalSpeeds(tuple(row for rows in found for row in rows))


def _search(
    shared: tuple[Problem, tuple[PreparedRun, ...], Plan, CriticalOptions],
    job: tuple[int, Mapping[float, SpeedSample]],
) -> tuple[CriticalSpeed, ...]:
    """The search of one member, by its index, from the samples of its sweep."""
    problem, ready, plan, options = shared
    index, samples = job
    one, reduced = ready[index], replace(plan, whole=False)

    def run_at(engine_speed: float, orbit: Any) -> SpeedSample:
        origin = provenance_of(problem, one.member, engine_speed, plan.created_at)
        solution, ended = integrate_from(one, engine_speed, reduced, origin, orbit)
        return sample_of(with_quantities(one, solution, reduced, {}), options, ended)

    search = Search(run_at, samples, options.limits, options.resolution)
    return tuple(
        critical_speed(search, kind, one.member.label, min(samples), max(samples), options)
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
    """The result of a search for one kind between two engine speeds (rad/s)."""
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
    return replace(
        none,
        found=True,
        place=search.known(from_speed).locations[kind],
        begins=begins,
        ends=ends,
        again=again,
        runs_count=search.runs_count - before,
    )
