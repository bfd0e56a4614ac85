"""Critical speeds of a train: where it loses contact, floats and bounces, as roots between the speeds of a scan."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from valvetrain.integrate.contract import Orbit, Periodic
from valvetrain.quantities.clash import PULL
from valvetrain.quantities.train_events import counted_losses, drive_forces
from valvetrain.runs.critical_causes import with_cause
from valvetrain.runs.critical_ranges import Variant, range_members, variants_of
from valvetrain.runs.critical_scan import SCAN, Scan, SpeedSample
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
    NARROW,
    CriticalSpeed,
    CriticalSpeeds,
    RangeMember,
)
from valvetrain.solution.result import Solution
from valvetrain.system.problem import Member, Problem
from valvetrain.system.train_system import TrainSystem

RPM = math.pi / 30
#: Stiffness (N/m) of a drive at the cam, typical: it continues a contact force below zero by the
#: gap, to judge how deep control is lost; the speed of zero does not depend on it.
DRIVE_STIFFNESS = 5e7
#: Change per cycle at which the runs of the scan repeat, and precise ones: what is left of these moves a root by less
#: than its relative width.
SCAN_TOLERANCE, PRECISE_TOLERANCE = 1e-4, 1e-6
#: Cycles of the search for a periodic motion: half of them accelerated, then as many plain ones as show
#: a period of eight. With 60 the same speeds result at twice the time of all that never repeats.
SCAN_CYCLES = 24
#: Steps of a search near a known limit over those of a scan of all speeds.
COARSE = 2.0


@dataclass(frozen=True, slots=True)
class CriticalOptions:
    """Options of the search.

    ``resolution`` (rad/s of the crank): width to which a change is narrowed where motion does not repeat; speeds are
    scanned :data:`~valvetrain.runs.critical_scan.SCAN` of it apart. ``float_lift``: lift (m) above the
    rigid one beyond which a train floats. ``bounce_height``: lift (m) beyond which a bounce counts.
    ``ranges``: repeat each speed with finer numerics and other damping, not the nominal one alone.
    """

    resolution: float = 10 * RPM
    float_lift: float = FLOAT_LIFT
    bounce_height: float = BOUNCE_HEIGHT
    ranges: bool = True

    def limit_of(self, kind: str) -> float:
        """Limit (SI) of a kind: the contact force of a loss of contact is zero."""
        return {"float": self.float_lift, "bounce": self.bounce_height}.get(kind, 0.0)


def sample_of(
    solution: Solution, options: CriticalOptions, orbit: Orbit | None = None
) -> SpeedSample:
    """What a run of a train says of control: least contact force of the drive while open (N), below zero by the force
    that would about close the largest gap, and lift left to float and to bounce (m, at least minus the limit).
    """
    least = {name: one for name, one in drive_forces(solution).items() if math.isfinite(one)}
    whole = bool(least) and "float_excess_lift" in solution.quantities
    opened = tuple(name for name, force in least.items() if force <= 0)
    contact, floats, bounces = KINDS
    gap = max((one.size for one in counted_losses(solution.events)), default=0.0)
    force = min(least.values(), default=math.nan)
    measures = {contact: force if force > 0 else -DRIVE_STIFFNESS * gap}
    for kind, name, limit in (
        (floats, "float_excess_lift", options.float_lift),
        (bounces, "bounce_height", options.bounce_height),
    ):
        # none as far as a run to coil bind goes
        measures[kind] = max(-limit, limit - float(solution.quantities.get(name, 0.0)))
    if not whole:
        measures = dict.fromkeys(KINDS, math.nan)
    repeats = solution.status.completed and solution.statistics.get("motion_period_count") == 1
    ended = whole and "bounce_height" not in solution.quantities  # before the valve closed
    pulls = any(event.kind == PULL for event in solution.events)
    return SpeedSample(
        measures,
        {contact: opened or ("run",), floats: ("valve",), bounces: ("seat",)},
        orbit if repeats else None,
        repeats,
        float(solution.quantities.get("minimum_cam_contact_force", math.nan)),
        frozenset(KINDS if pulls else {bounces} if ended else ()),
        pulls,
        float(solution.quantities.get("surge_amplitude_force", math.nan)),
    )


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
    jobs: list[tuple[int, dict[float, SpeedSample]]] = []
    for index, one in enumerate(ready):
        runs = (run for run in solutions if run.label == one.member.label)
        samples = {run.engine_speed: sample_of(run, options) for run in runs}
        if one.system is not None and samples:
            jobs.append((index, samples))
    shared = problem, tuple(ready), plan, options
    found = map_points(_search, shared, jobs, workers, processes=True, tell=tell) if jobs else ()
    by_member = {ready[index].member: rows for (index, _), rows in zip(jobs, found, strict=True)}
    return CriticalSpeeds(tuple(row for one in by_member for row in _by_models(one, by_member)))


def _by_models(
    member: Member, found: Mapping[Member, tuple[CriticalSpeed, ...]]
) -> tuple[CriticalSpeed, ...]:
    """The results of a member, the ranges with those of the same train by other models that were requested and know
    surge: each was searched whole, so it replaces the root that the range has of the model.
    """
    others = {
        one.model.word: rows
        for one, rows in found.items()
        if (one.springs, one.gear) == (member.springs, member.gear) and one.model.damped
    }
    others.pop(member.model.word, None)

    def with_models(row: CriticalSpeed) -> CriticalSpeed:
        kept = tuple(
            one for one in row.members if not (one.cause == "model" and one.change in others)
        )
        also = (next(one for one in rows if one.kind == row.kind) for rows in others.values())
        added = tuple(
            RangeMember("model", word, one.deciding_speed)
            for word, one in zip(others, also, strict=True)
        )
        return replace(row, members=(*kept, *added)) if row.members else row

    return tuple(map(with_models, found[member]))


def _search(
    shared: tuple[Problem, tuple[PreparedRun, ...], Plan, CriticalOptions],
    job: tuple[int, dict[float, SpeedSample]],
) -> tuple[CriticalSpeed, ...]:
    """The critical speeds of one member, by its index, from the samples of its sweep."""
    problem, ready, plan, options = shared
    index, samples = job
    one = ready[index]
    assert isinstance(one.system, TrainSystem)
    scan = scan_of(problem, Variant("", "", one), plan, options, samples)
    if not one.system.has_large_springs:
        scan.fill(SCAN * options.resolution)
    rows = _rows(problem, one, plan, options, scan)
    curve = tuple(
        (at, run.cam_force, run.surge_force)
        for at, run in sorted((scan.samples | scan.precise).items())
        if math.isfinite(run.cam_force)
    )
    rows[0] = replace(rows[0], curve=curve)
    if not options.ranges:
        return tuple(rows)

    def run_there(engine_speed: float) -> Solution:
        all_channels = replace(plan, whole=True, keep="ends")
        origin = provenance_of(problem, one.member, engine_speed, plan.created_at)
        run = integrate_point(one, engine_speed, all_channels, origin)
        return with_quantities(one, run, all_channels, {})

    return tuple(with_cause(row, problem, one, plan, run_there) for row in rows)


def _rows(
    problem: Problem,
    one: PreparedRun,
    plan: Plan,
    options: CriticalOptions,
    scan: Scan,
    kinds: Collection[str] = KINDS,
    last: float = 0.0,
) -> list[CriticalSpeed]:
    """The critical speeds of a scanned train without their causes, those of ``kinds`` with ranges up to ``last`` (rad/s) or to
    the end of the scan.
    """
    assert isinstance(one.system, TrainSystem)
    if not one.system.has_large_springs:
        for kind in KINDS:
            scan.look_into_dips(kind)
    rows = [critical_speed(kind, scan, one.member.label, options) for kind in KINDS]
    other = min((row.engine_speed for row in rows[1:] if row.ranges), default=math.inf)
    rows[0] = rows[0].decided(other)
    if not options.ranges or one.system.has_large_springs:
        return rows
    changed = {
        each: scan_of(problem, each, plan, options, {}, scan if each.cause == "damping" else None)
        for each in variants_of(problem, one)
    }
    whole = {kind: options.limit_of(kind) or standing_force(one) for kind in KINDS}
    return [
        with_range(row, scan, changed, whole[row.kind], last) if row.kind in kinds else row
        for row in rows
    ]


def speeds_near(
    problem: Problem,
    ready: PreparedRun,
    options: CriticalOptions,
    ends: tuple[float, float],
    kinds: Collection[str],
) -> CriticalSpeeds:
    """The critical speeds of a prepared train by few runs, without causes: from the first of ``ends`` (rad/s) no further than
    control stays lost, those of ``kinds`` with their ranges.
    """
    plan = Plan("ends", 720, False, problem.cycles, problem.cycles_to_settle)
    scan = scan_of(problem, Variant("", "", ready), plan, options, {})
    (kept, last), step, lost = ends, COARSE * SCAN * options.resolution, False
    for place in range(math.floor((last - kept) / step) + 1):
        engine_speed = ends[0] + place * step
        sample = scan.at(engine_speed)
        lost = lost or any(map(sample.lost, KINDS))
        if all(map(sample.kept, KINDS)):
            kept, lost = engine_speed, False
        elif lost and engine_speed - kept > NARROW * kept + 2 * step:
            break
    return CriticalSpeeds(tuple(_rows(problem, ready, plan, options, scan, kinds, last)))


def scan_of(
    problem: Problem,
    variant: Variant,
    plan: Plan,
    options: CriticalOptions,
    samples: dict[float, SpeedSample],
    beside: Scan | None = None,
) -> Scan:
    """The scan of a train, or of one in which something is changed; see :class:`Scan`."""
    # margins are those of the train's contacts: what the coils do inside is not looked at
    reduced = replace(plan, whole=False, keep="ends", coil_contacts=False)
    ready = variant.ready
    large = isinstance(ready.system, TrainSystem) and ready.system.has_large_springs
    # ranges are of uncertain inputs: whether each of their orbits attracts is not tested
    usual = Periodic(
        SCAN_CYCLES, tolerance=SCAN_TOLERANCE, compared=False, probed=not variant.cause
    )

    def run(engine_speed: float, orbit: Orbit | None, precise: bool) -> SpeedSample:
        origin = provenance_of(problem, ready.member, engine_speed, plan.created_at)
        tolerance = PRECISE_TOLERANCE if precise else SCAN_TOLERANCE
        solution, ended = integrate_from(
            ready,
            engine_speed,
            reduced,
            origin,
            orbit,
            time_step=variant.time_step(engine_speed, plan.samples),
            periodic=Periodic() if large else replace(usual, tolerance=tolerance),
        )
        return sample_of(with_quantities(ready, solution, reduced, {}), options, ended)

    width = options.resolution if large else 0.0
    return Scan(run, options.resolution, beside, samples, width=width)


def first_loss(
    kind: str,
    problem: Problem,
    ready: PreparedRun,
    engine_speeds: Sequence[float],
    options: CriticalOptions,
    stopped: Callable[[], bool] = lambda: False,
) -> tuple[float, float] | None:
    """The engine speed (rad/s) from which a prepared train loses control by ``kind``, by few runs at rising
    ``engine_speeds`` until it does, then to the resolution; and the highest of them at which it is kept (0: none). A range
    between two of them is not looked for.

    The first is infinite where control is kept up to the last speed, and NaN up to one at which the model does not know:
    its springs pull where real ends lift. None once ``stopped``, called before each of these runs, is true.
    """
    plan = Plan("ends", None, False, problem.cycles, problem.cycles_to_settle)
    scan, low = scan_of(problem, Variant("", "", ready), plan, options, {}), 0.0
    for engine_speed in engine_speeds:
        if stopped():
            return None
        sample = scan.at(engine_speed)
        if kind in sample.unknown:
            return math.nan, low
        if sample.lost(kind):
            return scan.root(kind, low, engine_speed, options.resolution) if low else 0.0, low
        low = engine_speed
    return math.inf, low


def critical_speed(kind: str, scan: Scan, label: str, options: CriticalOptions) -> CriticalSpeed:
    """The nominal result of a scan for one kind."""
    ranges, passed = scan.lost_ranges(kind)
    begin = ranges[0].lower_engine_speed if ranges else math.inf
    lost = [one for one in sorted(scan.samples) if one >= begin and scan.samples[one].lost(kind)]
    pulled = scan.pulled(ranges)
    return CriticalSpeed(
        label,
        kind,
        options.limit_of(kind),
        min(scan.samples),
        max(scan.samples),
        tuple(ranges),
        scan.samples[lost[0]].places.get(kind, ()) if lost else (),
        runs_count=scan.runs_count,
        pulled=pulled,
        silent=scan.silent(kind, pulled),
        passed=tuple(passed),
        falling_engine_speed=scan.falling(kind, begin, SCAN * options.resolution / 2),
    )


def with_range(
    row: CriticalSpeed,
    scan: Scan,
    changed: Mapping[Variant, Scan],
    whole: float,
    last: float = 0.0,
) -> CriticalSpeed:
    """The result with its range: of the loss that stays where short ones come before it; changed trains run up to ``last``
    (rad/s), by default to the end of the scan.
    """
    if row.ranges and not row.ranges[0].lower_engine_speed > 0:
        return row  # control is lost already at the first speed
    first, place = row.first_engine_speed, row.deciding_place
    if place:
        first = row.ranges[place - 1].upper_engine_speed * (1 + NARROW)
    begin = row.deciding_speed
    onset, members = range_members(row.kind, scan, changed, begin, (first, last), whole)
    lost = any(one.engine_speed < math.inf or one.pulled or one.refusal for one in members)
    return replace(row, members=members, onset=onset) if row.ranges or lost else row
