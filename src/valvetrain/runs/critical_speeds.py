"""Critical speeds of a train: where it loses contact, floats and bounces, searched between the
speeds of a sweep.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from valvetrain.errors import InputError
from valvetrain.integrate.contract import Periodic
from valvetrain.quantities.end_events import PULL
from valvetrain.quantities.train_events import drive_forces
from valvetrain.runs.critical_causes import with_cause
from valvetrain.runs.critical_repeats import (
    NOMINAL_TOLERANCE,
    Repeat,
    Variant,
    repeated,
    variants_of,
)
from valvetrain.runs.critical_search import Limit, Search, SpeedSample
from valvetrain.runs.prepared import (
    Plan,
    PreparedRun,
    integrate_from,
    integrate_point,
    provenance_of,
    with_quantities,
)
from valvetrain.runs.workers import map_points
from valvetrain.solution.critical import (
    BOUNCE_HEIGHT,
    FLOAT_LIFT,
    KINDS,
    MAX_AGAIN,
    NARROW,
    CriticalSpeed,
    CriticalSpeeds,
    Crossing,
    SpeedBracket,
)
from valvetrain.solution.result import Solution
from valvetrain.system.problem import Problem
from valvetrain.system.train_system import TrainSystem
from valvetrain.units import Given, si

RPM = math.pi / 30
#: Stiffness (N/m) of a drive at the cam, typical: it continues a contact force below zero by the
#: gap, to judge how deep control is lost; the speed of zero does not depend on it.
DRIVE_STIFFNESS = 5e7
#: Change per cycle at which the runs of the search repeat: what is left moves an onset by less than
#: a tenth of the default resolution.
SEARCH_TOLERANCE = 1e-4
#: Cycles of the search for a periodic motion: half of them accelerated, then as many plain ones as show
#: a period of eight. With 60 the same speeds are found at twice the time of all that never repeats.
SEARCH_CYCLES = 24
#: A repeat of a speed starts from the motion of a run no further away than this share of it.
CLOSE = 0.01


@dataclass(frozen=True, slots=True)
class CriticalOptions:
    """Options of the search.

    ``resolution``: width (rad/s of the crank) of a bracket. ``float_lift``: lift (m) above the
    rigid one beyond which a train floats. ``bounce_height``: lift (m) beyond which a bounce counts.
    ``ranges``: repeat each speed with finer numerics and other damping, not the nominal one alone.
    """

    resolution: float = 10 * RPM
    float_lift: float = FLOAT_LIFT
    bounce_height: float = BOUNCE_HEIGHT
    ranges: bool = True

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


def read_options(
    resolution: Given, float_lift: Given, bounce_height: Given, ranges: bool = True
) -> CriticalOptions:
    """Options from "10 rpm" or rad/s, "50 um" or m, or pint quantities.

    Raises :class:`InputError` for another unit or what is not positive.
    """
    return CriticalOptions(
        si(resolution, "engine_speed", "resolution"),
        si(float_lift, "length", "float_lift"),
        si(bounce_height, "length", "bounce_height"),
        ranges,
    )


def sample_of(
    solution: Solution, options: CriticalOptions, orbit: Any = None, missing: float = 0.0
) -> SpeedSample:
    """Margins of a run of a train: least contact force of the drive while open (N), and lift left
    to float and to bounce (m, at most the limit itself, at least its negative). A run without its
    numbers has lost control. ``missing``: :func:`missing_force` of the run.
    """
    least = {name: one for name, one in drive_forces(solution).items() if math.isfinite(one)}
    whole = bool(least) and "float_excess_lift" in solution.quantities
    opened = tuple(name for name, force in least.items() if force <= 0)
    contact, floats, bounces = KINDS
    margins = {contact: max(0.0, min(least.values())) if whole else math.nan}
    for kind, name, limit in (
        (floats, "float_excess_lift", options.float_lift),
        (bounces, "bounce_height", options.bounce_height),
    ):
        size = float(solution.quantities.get(name, 0.0))  # none as far as a run to coil bind goes
        margins[kind] = max(-limit, limit - size) if whole else math.nan
    locations = {contact: opened or ("run",), floats: ("valve",), bounces: ("seat",)}
    measures = {contact: margins[contact] or -missing}
    repeats = solution.status.completed and solution.statistics.get("motion_period_count") == 1
    force = float(solution.quantities.get("minimum_cam_contact_force", math.nan))
    ended = whole and "bounce_height" not in solution.quantities  # before the valve closed
    pulls = any(event.kind == PULL for event in solution.events)
    unknown = frozenset(KINDS if pulls else {bounces} if ended else ())
    return SpeedSample(margins, locations, orbit, measures, repeats, force, unknown, pulls)


def missing_force(ready: PreparedRun, solution: Solution) -> float:
    """Force (N) that would about close the largest gap of the drive's contacts while the valve is
    open, of a run with the events of its integrator; 0 where none opens.
    """
    begin, end = ready.window or (0.0, 2 * math.pi)
    drive = set() if ready.motion is None else set(ready.motion.forces.places)
    gaps = (
        float(event.details["largest_gap"])
        for event in solution.events
        if event.kind == "touch"
        and event.where in drive
        and (float(event.details["release_cam_angle"]) - begin) % (2 * math.pi) <= end - begin
    )
    return DRIVE_STIFFNESS * max(gaps, default=0.0)


def standing_force(ready: PreparedRun) -> float:
    """Least force (N) of a contact of the drive at standstill, the valve open by more than a tenth of its
    lift: what inertia and surge have to take.
    """
    assert ready.motion is not None and ready.window is not None
    table, (begin, end) = ready.motion.table(0.0), ready.window
    open_wide = (table.cam_angle - begin) % (2 * math.pi) <= end - begin
    forces = (table[name] for name in table.columns if name.endswith("contact_force"))
    return max(0.0, min(float(force[open_wide].min()) for force in forces))


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
    # margins are those of the train's contacts: what the coils do inside is not looked at
    one, reduced = ready[index], replace(plan, whole=False, keep="ends", coil_contacts=False)
    assert isinstance(one.system, TrainSystem)
    large = one.system.has_large_springs
    until = (
        Periodic() if large else Periodic(SEARCH_CYCLES, tolerance=SEARCH_TOLERANCE, compared=False)
    )

    def run(
        engine_speed: float,
        orbit: Any = None,
        variant: Variant = Variant("", "", one),
        periodic: Periodic = until,
    ) -> SpeedSample:
        step = variant.time_step(engine_speed, plan.samples)
        return _sample(
            problem, variant.ready, reduced, options, engine_speed, orbit, step, periodic
        )

    search = Search(run, samples, options.limits, options.resolution)

    def repeating(periodic: Periodic, chosen: Variant | None = None) -> Repeat:
        """Runs, each once, from the motion of the nearest one before, or of one of the search."""
        variant = chosen or Variant("", "", one)
        # a repeat of other steps, meshes or models shall not begin, and end at once, on the motion that it judges
        near = (search.samples,) if variant.cause in ("", "damping") else ()

        def at(engine_speed: float, known: Mapping[float, SpeedSample]) -> SpeedSample:
            pools = (known, *near)
            start = next(filter(None, (_nearest(pool, engine_speed) for pool in pools)), None)
            return run(engine_speed, start, variant, periodic)

        return Repeat(variant.cause, variant.change, at, variant.ready.refusal)

    precise = repeating(replace(until, tolerance=NOMINAL_TOLERANCE))
    # ranges are of uncertain inputs: whether each of their orbits attracts is not tested
    variants = variants_of(problem, one) if options.ranges else ()
    repeats = [repeating(replace(until, probed=False), each) for each in variants]
    ends = min(samples), max(samples)
    rows = [critical_speed(search, kind, one.member.label, *ends, options) for kind in KINDS]
    whole = {kind: options.limit_of(kind) or standing_force(one) for kind in KINDS}
    contact, *more = rows
    other = min((row.ranges[0].lower_engine_speed for row in more if row.found), default=math.inf)
    deciding = _decisive(contact, search, other)
    rows = [
        repeated(row, search, precise, repeats, whole[row.kind], options.limits)
        for row in (deciding, *more)
    ]
    if deciding is not contact:
        stays = rows[0]
        onset = repeated(contact, search, precise, (), whole[contact.kind], options.limits)
        rows[0] = replace(
            onset,
            members=stays.members,
            onset=stays.onset,
            decisive_engine_speed=stays.nominal_engine_speed,
        )
    runs = sorted(search.samples.items())
    curve = tuple((at, run.cam_force) for at, run in runs if math.isfinite(run.cam_force))
    rows = [replace(row, curve=curve if row.kind == "contact-loss" else ()) for row in rows]
    if not options.ranges:
        return tuple(rows)

    @cache
    def run_there(engine_speed: float) -> Solution:
        all_channels = replace(plan, whole=True, keep="ends")
        origin = provenance_of(problem, one.member, engine_speed, plan.created_at)
        return with_quantities(
            one, integrate_point(one, engine_speed, all_channels, origin), all_channels, {}
        )

    return tuple(with_cause(row, one, run_there) for row in rows)


def _decisive(row: CriticalSpeed, search: Search, other: float) -> CriticalSpeed:
    """The row as if its search had begun above the short ranges of lost contact below the one that stays,
    which is below ``other`` losses (rad/s); itself where none is short.
    """
    short = row.short_ranges(other)
    if not short or len(row.ranges) == len(short):
        return row
    begin = row.ranges[len(short)].lower_engine_speed
    first = short[-1].upper_engine_speed * (1 + NARROW)
    search.sample(first)
    kept = (
        one
        for one in search.samples
        if first <= one < begin and not search.known(one).lost(row.kind)
    )
    bracket = SpeedBracket(max(kept, default=first), begin)
    return replace(row, begins=Crossing(bracket), first_engine_speed=first)


def _nearest(samples: Mapping[float, SpeedSample], engine_speed: float) -> Any:
    """The orbit of the nearest sample that repeats, within :data:`CLOSE`; None for none."""
    distances = {
        abs(speed - engine_speed): sample.orbit
        for speed, sample in samples.items()
        if sample.repeats and sample.orbit is not None
    }
    nearest = min(distances, default=math.inf)
    return distances[nearest] if nearest <= CLOSE * engine_speed else None


def _sample(
    problem: Problem,
    ready: PreparedRun,
    plan: Plan,
    options: CriticalOptions,
    engine_speed: float,
    orbit: Any = None,
    time_step: float | None = None,
    periodic: Periodic = Periodic(),
) -> SpeedSample:
    """One run of the search (rad/s of the crank), from ``orbit`` or from rest."""
    origin = provenance_of(problem, ready.member, engine_speed, plan.created_at)
    solution, ended = integrate_from(
        ready,
        engine_speed,
        plan,
        origin,
        orbit,
        time_step=time_step,
        periodic=periodic,
    )
    missing = missing_force(ready, solution)
    return sample_of(with_quantities(ready, solution, plan, {}), options, ended, missing)


def first_bracket(
    kind: str,
    problem: Problem,
    ready: PreparedRun,
    engine_speeds: Sequence[float],
    options: CriticalOptions,
    stopped: Callable[[], bool] = lambda: False,
) -> SpeedBracket | None:
    """Where a prepared train first loses control by ``kind``, by few runs: rising ``engine_speeds``
    (rad/s) from rest until it does, then halves of the last step down to the resolution.

    A range between two of the speeds is not looked for, unlike in :func:`find_critical_speeds`. From
    0 where control is lost at the first speed, to infinity where it is maintained up to the last; None
    once ``stopped``, called before each run, is true.
    """
    plan = Plan("ends", None, False, problem.cycles, problem.cycles_to_settle)
    low, high, ahead = 0.0, math.inf, list(engine_speeds)
    while ahead or (low and high - low > options.resolution and math.isfinite(high)):
        if stopped():
            return None
        engine_speed = ahead.pop(0) if ahead else (low + high) / 2
        if _sample(problem, ready, plan, options, engine_speed).lost(kind):
            high, ahead = engine_speed, []
        else:
            low = engine_speed
    return SpeedBracket(low, high)


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
    none = replace(none, passed=search.passed(kind))
    if onset is None:
        pulled, count = search.pulled(), search.runs_count - before
        return replace(none, pulled=pulled, runs_count=count)
    from_speed = onset if isinstance(onset, float) else onset.upper_engine_speed
    end = search.end(kind, from_speed)
    begins = None
    if isinstance(onset, SpeedBracket):
        sides = (onset.lower_engine_speed, onset.upper_engine_speed)
        # a motion that does not repeat has no branch that a rising or falling speed could follow
        steady = all(search.known(one).repeats for one in sides) and not search.pulled_in(onset)
        begins = search.crossing(kind, onset) if steady else Crossing(onset)
    ends = None if end is None else Crossing(end)
    again = _narrowed(search, kind, from_speed)
    return replace(
        none,
        found=True,
        places=search.known(from_speed).locations[kind],
        begins=begins,
        ends=ends,
        again=again,
        runs_count=search.runs_count - before,
        pulled=search.pulled(from_speed),
    )


def _narrowed(search: Search, kind: str, engine_speed: float) -> tuple[SpeedBracket, ...]:
    """The ranges of loss above a speed (rad/s); the speeds of a sweep do not say where they begin and end, so
    those up to the first that is not short are narrowed to the resolution.
    """
    place = 0
    while place < min(len(again := _further(search, kind, engine_speed)), MAX_AGAIN):
        search.narrowed(kind, again[place].lower_engine_speed)
        again = _further(search, kind, engine_speed)
        if _is_long(again[place]):
            break
        search.end(kind, again[place].lower_engine_speed)
        again = _further(search, kind, engine_speed)
        if _is_long(again[place]):
            break
        place += 1
    return again


def _is_long(one: SpeedBracket) -> bool:
    return one.upper_engine_speed - one.lower_engine_speed > NARROW * one.lower_engine_speed


def _further(search: Search, kind: str, engine_speed: float) -> tuple[SpeedBracket, ...]:
    """The ranges of loss above a speed (rad/s), by their lowest and highest sampled speeds."""
    return tuple(one for one in search.stretches(kind) if one.lower_engine_speed > engine_speed)
