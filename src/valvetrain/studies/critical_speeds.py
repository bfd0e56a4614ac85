"""Critical speeds of a train: where it loses contact, floats and bounces, between and beyond the
speeds of a sweep.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from valvetrain.errors import InputError
from valvetrain.solution.critical import KINDS, CriticalSpeed, CriticalSpeeds, Crossing
from valvetrain.solution.result import Solution
from valvetrain.studies.critical_search import Limit, Look, Search
from valvetrain.studies.engine import map_points
from valvetrain.studies.ready import Plan, Ready, integrate_from, judge, provenance_of
from valvetrain.system.problem import Problem
from valvetrain.units import Given, si

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
    ready: Sequence[Ready],
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
    shared: tuple[Problem, tuple[Ready, ...], Plan, CriticalOptions], job: _Job
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
    ready: Ready,
    plan: Plan,
    options: CriticalOptions,
    engine_speed: float,
    orbit: Any,
) -> Look:
    origin = provenance_of(problem, ready.member, engine_speed, plan.created_at)
    solution, ended = integrate_from(ready, engine_speed, plan, origin, orbit)
    return look_of(judge(ready, solution, plan, {}), options, ended)
