"""Critical speeds as numbers: the speed inside its bracket, repeated with another model, other damping and
finer numerics.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from scipy.optimize import brentq

from valvetrain.integrate.train_leapfrog import SAMPLES
from valvetrain.integrate.train_run import TrainOptions, runner
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.runs.critical_search import Limit, Search, SpeedSample, pulled_ranges
from valvetrain.runs.prepared import FAILURES, PreparedRun, prepare
from valvetrain.runs.refine_trains import divided
from valvetrain.runs.train_runs import member_statics
from valvetrain.solution.critical import (
    DAMPING_FACTORS,
    RPM,
    CriticalSpeed,
    RangeMember,
    SpeedBracket,
)
from valvetrain.solution.partial_failures import reason
from valvetrain.springs.spec import spring_model
from valvetrain.system.problem import Problem
from valvetrain.system.train_system import TrainSystem

#: Width (rad/s) to which the speed itself is found, and to which its repeats are.
NOMINAL_WIDTH, REPEAT_WIDTH = 1e-2 * RPM, 2.0 * RPM
#: Change per cycle at which the runs of the nominal speed repeat: what is left moves it less than
#: :data:`NOMINAL_WIDTH`.
NOMINAL_TOLERANCE = 1e-6
DIVISION, STEP = 1.5, 0.5
#: First and largest step from the nominal speed in a repeat, and first step where motion does not
#: repeat, over the speed; the latter's growth from step to step.
FIRST_STRIDE, MAX_STRIDE, SCATTER_STRIDE, SCATTER_GROWTH = 0.0025, 0.01, 0.005, 1.5
#: Steps, at most, through speeds whose motion does not repeat; dips of a margin that are looked at
#: below the nominal speed, and above it.
MAX_SCATTERED, MAX_DIPS = 5, 8
#: Dips, the deepest, that are always looked at; others as far as this multiple of the largest loss at one before.
MIN_DIPS, MARGIN = 2, 3.0
#: Share of a speed below the onset of a changed train in which it is searched for a lower one.
LOOK_BELOW = 0.1
#: An onset is a graze where the margin changed by :data:`SMALL` of its value at standstill moves it up or
#: down by more than :data:`GRAZE` of the speed: half as far again as inertia, which grows with the
#: square of speed, would.
SMALL, GRAZE = 0.1, 0.075
#: Sample of the train at an engine speed (rad/s).
SampleAt = Callable[[float], SpeedSample]
#: Continued margin (SI) at an engine speed (rad/s): control is maintained where it is positive.
Measure = Callable[[float], float]


@dataclass(frozen=True, eq=False)
class Variant:
    """A train whose critical speeds are repeated: ``cause`` and ``change`` as in
    :class:`valvetrain.solution.critical.RangeMember`, and its time step over the default one.
    """

    cause: str
    change: str
    ready: PreparedRun
    step: float = 1.0

    def time_step(self, engine_speed: float, samples: int | None) -> float | None:
        """Its time step (s) at an engine speed (rad/s) with ``samples`` per cam revolution; None for
        the default one.
        """
        if self.step == 1.0:
            return None
        assert isinstance(self.ready.system, TrainSystem)
        chosen = TrainOptions(samples or SAMPLES)
        own = runner(self.ready.system, engine_speed / 2, chosen, rest=self.ready.rest).time_step
        return self.step * own * (1 + 1e-9)


@dataclass(frozen=True, eq=False)
class Repeat:
    """The runs of one changed train, each once: ``run`` makes that at an engine speed (rad/s) from those before.

    ``refusal``: why the train cannot run, empty where it can.
    """

    cause: str
    change: str
    run: Callable[[float, Mapping[float, SpeedSample]], SpeedSample]
    refusal: str = ""
    samples: dict[float, SpeedSample] = field(default_factory=dict)

    def __call__(self, engine_speed: float) -> SpeedSample:
        if engine_speed not in self.samples:
            self.samples[engine_speed] = self.run(engine_speed, self.samples)
        return self.samples[engine_speed]


def variants_of(problem: Problem, one: PreparedRun) -> tuple[Variant, ...]:
    """The trains of the repeats, those that cannot run with their refusal; none for springs whose runs take
    minutes.
    """
    assert isinstance(one.system, TrainSystem)
    if one.system.has_large_springs:
        return ()
    member = one.member
    found = [Variant("step", _times(STEP), one, STEP)]
    finer = tuple(divided(member, spring, DIVISION) for spring in member.springs)
    changed = [("mesh", _times(DIVISION), replace(member, springs=finer))]
    for factor in DAMPING_FACTORS:
        damped = tuple(_damped(spring, factor) for spring in member.springs)
        changed.append(("damping", _times(factor), replace(member, springs=damped)))
    for word in member.model.beside:
        changed.append(("model", word, replace(member, model=spring_model(word), instead="")))
    for cause, change, other in changed:
        if (other.springs, other.model) == (member.springs, member.model):
            continue
        try:
            ready = prepare(problem, other, member_statics(problem, other), problem.record.study)
        except FAILURES as error:
            ready = PreparedRun(other, one.frame, refusal=reason(error))
        found.append(Variant(cause, change, ready))
    return tuple(found)


def _times(factor: float) -> str:
    return f"×{factor:g}"


def _damped(spring: InstalledSpring, factor: float) -> InstalledSpring:
    damping = spring.damping
    mass, stiffness = factor * damping.mass_damping, factor * damping.stiffness_damping
    changed = damping.replace(mass_damping=mass, stiffness_damping=stiffness)
    return replace(spring, damping=changed)


def root(measure: Measure, bracket: SpeedBracket, width: float) -> float | None:
    """Engine speed (rad/s) in a bracket at which a measure passes zero, to ``width``; None where it
    has one sign at both ends.
    """
    known: dict[float, float] = {}

    def at(engine_speed: float) -> float:
        if engine_speed not in known:
            # zero and NaN count as lost, which brentq has to see as a sign
            value = measure(engine_speed)
            known[engine_speed] = value if value > 0 or value < 0 else -1e-12
        return known[engine_speed]

    low, high = bracket.lower_engine_speed, bracket.upper_engine_speed
    if (at(low) > 0) == (at(high) > 0):
        return None
    return float(brentq(at, low, high, xtol=width, rtol=1e-14))


def dips(kind: str, samples: Mapping[float, SpeedSample], nominal: float) -> tuple[float, ...]:
    """Sampled speeds at which the measure of a kind is less than at both neighbours, or at the first of equals, rising: the
    :data:`MAX_DIPS` least of them below the nominal speed and the :data:`MAX_DIPS` next above it.
    """
    speeds = sorted(samples)
    values = {one: samples[one].measure(kind) for one in speeds}
    low = [
        here
        for below, here, above in zip(speeds, speeds[1:], speeds[2:], strict=False)
        if values[below] > values[here] <= values[above]
    ]
    below = sorted((one for one in low if one < nominal), key=values.__getitem__)[:MAX_DIPS]
    return (*sorted(below), *[one for one in low if one > nominal][:MAX_DIPS])


def first_lost(measure: Measure, low: Mapping[float, float]) -> float | None:
    """The lowest of the dips ``low`` (engine speed -> measure of the unchanged train) that the
    changed train loses; None for none.

    The deepest come first; the search ends at one that is further from zero than :data:`MARGIN`
    times the largest loss that the change has brought so far.
    """
    lost, largest = [], 0.0
    for count, (speed, before) in enumerate(sorted(low.items(), key=lambda one: one[1])):
        if count >= MIN_DIPS and before > MARGIN * largest:
            break
        after = measure(speed)
        largest = max(largest, before - after)
        if not after > 0:
            lost.append(speed)
    return min(lost, default=None)


def change(
    nominal: float,
    measure: Measure,
    ends: tuple[float, float],
    low: Mapping[float, float],
    sampled: Collection[float] = (),
) -> SpeedBracket:
    """Bracket of the onset of a changed train: from the nominal one in growing steps to a change; at
    0 where control is lost down to the first of ``ends``, at infinity where it is maintained up to the
    last.

    ``measure``: positive where control is maintained; ``low``: speeds at which that of the unchanged
    train dips, and what it is there; the lowest of them that the changed train loses comes first.
    ``sampled``: speeds at which the measure costs no run; a step ends at the last of them.
    """
    first, last = ends
    earlier = first_lost(measure, {one: at for one, at in low.items() if one < nominal})
    here = nominal if earlier is None else earlier
    controlled, step = measure(here) > 0, FIRST_STRIDE * nominal
    while True:
        if controlled:
            there = min(last, here + step, *(one for one in low if one > here))
            there = max((one for one in sampled if here < one < there), default=there)
        else:
            there = max(first, here - step)
            there = min((one for one in sampled if there < one < here), default=there)
        if there == here:
            end = math.inf if controlled else 0.0
            return SpeedBracket(end, end)
        if (measure(there) > 0) != controlled:
            return SpeedBracket(min(here, there), max(here, there))
        here, step = there, min(2 * step, MAX_STRIDE * nominal)


def onset_in(bracket: SpeedBracket, measure: Measure) -> float:
    """The onset in a bracket of :func:`change`, to :data:`REPEAT_WIDTH`."""
    if bracket.lower_engine_speed == bracket.upper_engine_speed:
        return bracket.upper_engine_speed
    found = root(measure, bracket, REPEAT_WIDTH)
    return bracket.upper_engine_speed if found is None else found


def scattered(
    kind: str, nominal: float, sample: SampleAt, ends: tuple[float, float]
) -> SpeedBracket:
    """From the next speed below whose motion repeats and keeps control to the next above whose
    motion repeats and loses it: in between the last revolution decides.
    """
    found = []
    for sign, lost, end in ((-1, False, ends[0]), (1, True, ends[1])):
        here = nominal
        for count in range(MAX_SCATTERED):
            here = here + sign * SCATTER_STRIDE * SCATTER_GROWTH**count * nominal
            here = max(here, end) if sign < 0 else min(here, end)
            one = sample(here)
            if here == end or (one.repeats and one.lost(kind) == lost):
                break
        found.append(here)
    return SpeedBracket(*found)


def repeated(
    row: CriticalSpeed,
    search: Search,
    precise: SampleAt,
    repeats: Sequence[Repeat],
    whole: float,
    limits: tuple[Limit, ...],
) -> CriticalSpeed:
    """The result of a search with its nominal speed, the members of its range and what kind of onset it is.

    ``precise``: runs to :data:`NOMINAL_TOLERANCE`; ``repeats``: the runs of every variant;
    ``whole``: the margin (SI) of the train at standstill, whatever speeds are searched; ``limits``: how each kind is
    searched.
    """
    if row.found and row.begins is None:
        return row  # control is lost already at the first speed
    ends, kind = (row.first_engine_speed, row.last_engine_speed), row.kind
    nominal, steady, pulled = math.inf, True, False
    if row.begins is not None:
        bracket = row.begins.from_rest
        sides = bracket.lower_engine_speed, bracket.upper_engine_speed
        pulled = search.pulled_in(bracket)
        steady = not pulled and all(search.known(one).repeats for one in sides)
        inside = (
            root(lambda one: precise(one).measure(kind), bracket, NOMINAL_WIDTH) if steady else None
        )
        steady = inside is not None
        nominal = bracket.upper_engine_speed if inside is None else inside
    row = replace(row, nominal_engine_speed=nominal)
    if not repeats:
        return row
    begin = min(nominal, ends[1])
    low = dips(kind, search.samples, begin)
    at = {one: search.samples[one].measure(kind) for one in low}
    moved: list[tuple[str, str, float]] = []
    onset = "sharp"
    if pulled:
        moved = [("ends", "", bracket.lower_engine_speed)]
    elif not steady:
        onset, scatter = "non-repeating", scattered(kind, begin, search.sample, ends)
        for end in (scatter.lower_engine_speed, scatter.upper_engine_speed):
            moved.append(("revolution", "", end))
    else:
        both = _moved(kind, begin, search, ends, at, SMALL * whole)
        if any(abs(one - nominal) > GRAZE * begin for one in both):
            onset = "graze"
            moved = [("force", sign, one) for sign, one in zip("−+", both, strict=True)]
    members = [RangeMember(*one) for one in moved]
    for sample in repeats:
        if sample.refusal:
            members.append(RangeMember(sample.cause, sample.change, math.nan, (), sample.refusal))
            continue
        # where motion does not repeat, finer numerics give another revolution, not a better one
        if steady or sample.cause not in ("step", "mesh"):
            speed = _onset_of(row, sample, begin, at, limits, steady)
            until = min(speed, ends[1])
            pulls = pulled_ranges(sample.samples, until)
            members.append(RangeMember(sample.cause, sample.change, speed, pulls))
    if nominal == math.inf and not any(
        one.engine_speed < math.inf or one.pulled or one.refusal for one in members
    ):
        return row  # never lost, by every repeat
    return replace(row, members=tuple(members), onset=onset)


def _onset_of(
    row: CriticalSpeed,
    sample: Repeat,
    begin: float,
    at: Mapping[float, float],
    limits: tuple[Limit, ...],
    steady: bool,
) -> float:
    """The lowest onset of a changed train that is found from the nominal one (``begin``, rad/s) and by a search
    of what lies below.
    """
    ends = row.first_engine_speed, row.last_engine_speed

    def measure(engine_speed: float) -> float:
        return sample(engine_speed).measure(row.kind)

    bracket = change(begin, measure, ends, at)
    while True:
        # where motion does not repeat, what is inside the bracket says nothing of the next revolution
        onset = onset_in(bracket, measure) if steady else bracket.upper_engine_speed
        kept = min(bracket.lower_engine_speed, ends[1])
        if kept <= ends[0]:
            return onset
        lost = [one for one in sample.samples if one < kept and sample.samples[one].lost(row.kind)]
        first = min(lost, default=None) or _lost_below(row, sample, kept, limits)
        if first is None:
            return onset
        bracket = change(first, measure, ends, {})


def _lost_below(
    row: CriticalSpeed, sample: Repeat, kept: float, limits: tuple[Limit, ...]
) -> float | None:
    """The lowest speed (rad/s) at which a changed train loses control over :data:`LOOK_BELOW` below one that it
    keeps, by a search of its own; None where it never does.
    """
    low = max(row.first_engine_speed, (1 - LOOK_BELOW) * kept)
    known = {one: sample.samples[one] for one in sample.samples if low <= one <= kept}
    below = Search(
        lambda one, orbit: sample(one), {low: sample(low)} | known, limits, row.resolution
    )
    found = below.onset(row.kind)
    return found.upper_engine_speed if isinstance(found, SpeedBracket) else found


def _moved(
    kind: str,
    nominal: float,
    search: Search,
    ends: tuple[float, float],
    low: Mapping[float, float],
    small: float,
) -> list[float]:
    """The onset with the margin less, and more, by ``small``; none where the brackets of both show
    that this is no graze.
    """
    found: list[tuple[SpeedBracket, Measure]] = []
    for more in (-small, small):

        def measure(engine_speed: float, more: float = more) -> float:
            one = search.sample(engine_speed)
            return one.measure(kind) + (0.0 if kind in one.unknown else more)

        sampled = tuple(search.samples)
        found.append((change(nominal, measure, ends, low, sampled), measure))
    far = [
        abs(end - nominal) > GRAZE * nominal
        for bracket, _ in found
        for end in (bracket.lower_engine_speed, bracket.upper_engine_speed)
    ]
    return [onset_in(bracket, measure) for bracket, measure in found] if any(far) else []
