"""The range of a critical speed: its root with another model, other damping, a finer step and a finer mesh, with a
tenth of the force more and less, and over revolutions that do not repeat.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from valvetrain.integrate.train_leapfrog import SAMPLES
from valvetrain.integrate.train_record import TrainOptions
from valvetrain.integrate.train_run import runner
from valvetrain.runs.critical_scan import SCAN, Scan
from valvetrain.runs.error_bars import divided, wire_damped
from valvetrain.runs.prepared import FAILURES, PreparedRun, prepare
from valvetrain.runs.train_runs import member_statics
from valvetrain.solution.critical import DAMPING_FACTORS, RPM, RangeMember, SpeedBracket
from valvetrain.solution.status import reason
from valvetrain.springs.spec import spring_model
from valvetrain.system.problem import Problem
from valvetrain.system.train_system import TrainSystem

#: Width (rad/s) to which the root of a changed train is computed.
WIDTH = 2.0 * RPM
DIVISION, STEP = 1.5, 0.5
#: Largest step, over the speed, from the root of the train to that of a changed one; step to where ends pull no more.
STRIDE, FIRST_STRIDE = 0.01, 0.0025
#: Dips that a changed train is always run at, the deepest; others as far as this multiple of the largest loss before.
MIN_DIPS, MARGIN = 2, 3.0
#: Share of a speed below the onset in which a train of other damping or another model is scanned too.
LOOK_BELOW = 0.1
#: Distance of these speeds in resolutions: another model, which is dear, only shows wider ranges.
LOOKS = {"damping": SCAN, "model": 3 * SCAN}
#: Share of a speed on either side in which motion that does not repeat may lose control.
SCATTER = 0.065
#: An onset is a graze where a margin changed by :data:`SMALL` of its value at standstill moves it by more than
#: :data:`GRAZE` of the speed: half as far again as inertia, which grows with the square of speed, would.
SMALL, GRAZE = 0.1, 0.075
#: Times that the ends of a graze, straight between samples, are run themselves.
REFINED = 3


@dataclass(frozen=True, eq=False)
class Variant:
    """A train whose roots are computed too: ``cause`` and ``change`` as in
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


def variants_of(problem: Problem, one: PreparedRun) -> tuple[Variant, ...]:
    """The changed trains of a member, those that cannot run with their refusal."""
    member = one.member
    finer = tuple(divided(member, spring, DIVISION) for spring in member.springs)
    changed = [("mesh", _times(DIVISION), replace(member, springs=finer))]
    for factor in DAMPING_FACTORS:
        damped = tuple(wire_damped(spring, factor) for spring in member.springs)
        changed.append(("damping", _times(factor), replace(member, springs=damped)))
    for word in member.model.beside:
        changed.append(("model", word, replace(member, model=spring_model(word), instead="")))
    found = [Variant("step", _times(STEP), one, STEP)]
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


def range_members(
    kind: str,
    scan: Scan,
    changed: Mapping[Variant, Scan],
    begin: float,
    ends: tuple[float, float],
    whole: float,
) -> tuple[str, tuple[RangeMember, ...]]:
    """The kind of an onset and what leaves it open.

    Parameters
    ----------
    kind : of lost control
    scan : of the train
    changed : the scan, of no samples yet, of every changed train
    begin : onset (rad/s), infinite for never
    ends : lowest and highest speed (rad/s) at which a changed train is looked at, that of the scan at least
    whole : margin (SI) of the train at standstill

    Returns
    -------
    (onset, members) as in :class:`valvetrain.solution.critical.CriticalSpeed`
    """
    first, last = ends[0], max(scan.samples)
    near = min(begin, last)
    onset, members = "sharp", list[RangeMember]()
    below = max((one for one in scan.samples if one < near), default=first)
    above = min((one for one in scan.samples if one >= near), default=last)
    steady = all(scan.samples[one].repeats for one in (below, above) if one in scan.samples)
    if math.isfinite(begin) and scan.samples[below].pulls:
        members = [RangeMember("ends", "", _last_kept(kind, scan, begin))]
    elif math.isfinite(begin) and not steady:
        onset = "non-repeating"
        members = [RangeMember("revolution", "", one) for one in _scattered(kind, scan, begin)]
    else:
        both = [_with_force(kind, scan, sign * SMALL * whole, first) for sign in (-1, 1)]
        if any(abs(one - begin) > GRAZE * near for one in both):
            onset = "graze"
            for _ in range(REFINED):
                for engine_speed in (one for one in both if 0 < one < math.inf):
                    scan.at(engine_speed)
                both = [_with_force(kind, scan, sign * SMALL * whole, first) for sign in (-1, 1)]
            members = [RangeMember("force", *one) for one in zip("−+", both, strict=True)]
    dips = {one: value for one, value in scan.dips(kind).items() if one >= first}
    lowest = max(first, (1 - LOOK_BELOW) * near)
    slope = _slope(kind, scan, near)
    for variant, own in changed.items():
        if variant.ready.refusal:
            refused = RangeMember(variant.cause, variant.change, math.nan, (), variant.ready.refusal)  # fmt: skip
            members.append(refused)
        # where motion does not repeat, finer numerics give another revolution, not a better one
        elif steady or variant.cause not in ("step", "mesh"):
            # a finer step or mesh moves the motion too little to need more than the dips
            step = LOOKS.get(variant.cause, math.inf) * scan.resolution
            places = range(math.ceil(lowest / step), math.ceil(near / step))
            looked = [step * place for place in places]
            speed = changed_onset(kind, own, near, (first, max(ends[1], last)), dips, looked, slope)
            pulled = own.pulled([SpeedBracket(speed, math.inf)])
            silent = own.silent(kind, pulled)
            members.append(RangeMember(variant.cause, variant.change, speed, pulled, "", silent))
    return onset, tuple(members)


def _last_kept(kind: str, scan: Scan, begin: float) -> float:
    """The highest sample below an onset that keeps control, or the lowest of all."""
    kept = [one for one in scan.samples if one < begin and scan.samples[one].kept(kind)]
    return max(kept, default=min(scan.samples))


def _scattered(kind: str, scan: Scan, begin: float) -> tuple[float, float]:
    """From the next speed below that keeps control in a motion that repeats to the next above that loses it in one:
    in between the last revolution decides.
    """
    settled = {one: sample for one, sample in scan.samples.items() if sample.repeats}
    below = [one for one in settled if one < begin and settled[one].kept(kind)]
    above = [one for one in settled if one >= begin and settled[one].lost(kind)]
    low, high = (1 - SCATTER) * begin, (1 + SCATTER) * begin
    low = max(low, min(scan.samples), *below)
    return low, min(high, max(scan.samples), *above)


def _with_force(kind: str, scan: Scan, more: float, first: float) -> float:
    """The onset (rad/s) with a measure larger by ``more`` (SI), straight between samples; infinite for never."""
    speeds = [one for one in sorted(scan.samples) if one >= first and kind not in scan.samples[one].unknown]  # fmt: skip
    values = [scan.samples[one].measure(kind) + more for one in speeds]
    if values and values[0] <= 0:
        return 0.0
    for (low, high), (kept, lost) in zip(pairwise(speeds), pairwise(values), strict=True):
        if kept > 0 and not lost > 0:
            return low + (high - low) * (kept / (kept - lost) if lost <= 0 else 1.0)
    return math.inf


def _slope(kind: str, scan: Scan, near: float) -> float:
    """Change of a measure by the speed (rad/s) between the samples around one."""
    pool = scan.samples | scan.precise
    low = max((one for one in pool if one < near), default=math.nan)
    high = min((one for one in pool if one > near), default=math.nan)
    if not (math.isfinite(low) and math.isfinite(high)):
        return math.nan
    return (pool[high].measure(kind) - pool[low].measure(kind)) / (high - low)


def changed_onset(
    kind: str,
    scan: Scan,
    begin: float,
    ends: tuple[float, float],
    dips: Mapping[float, float],
    looked: Sequence[float],
    slope: float,
) -> float:
    """The onset (rad/s) of a changed train: 0 where it loses control down to the first of ``ends``, infinite where it
    keeps it up to the last.

    From ``begin``, the onset of the train, in steps to a change: the first as far as its ``slope`` of the measure
    says. ``dips``: speeds at which the measure of the train is least in between, and what it is there; the lowest that
    the changed train loses at them, or at and between the speeds ``looked`` at, comes first.
    """
    largest = 0.0
    ordered = sorted((value, speed) for speed, value in dips.items() if speed < begin)
    for count, (before, speed) in enumerate(ordered):
        if count >= MIN_DIPS and before > MARGIN * largest:
            break
        after = scan.at(speed)
        largest = max(largest, before - after.measure(kind))
        while kind in after.unknown and speed < begin:
            speed += FIRST_STRIDE * begin
            after = scan.at(speed)
    for speed in looked:
        scan.at(speed)
    scan.look_into_dips(kind)
    scan.look_before_pulls(kind, begin)
    lost = [one for one in scan.samples if ends[0] <= one < begin and scan.samples[one].lost(kind)]
    here = min(lost, default=begin)
    sample = scan.at(here)
    kept, value = not sample.lost(kind), sample.measure(kind)
    expected = 1.3 * abs(value / slope) if slope < 0 and not lost else math.nan
    step = expected + WIDTH if expected < STRIDE * begin else STRIDE * begin
    while True:
        if kept:
            there = min(ends[1], here + step, *(one for one in dips if one > here))
        else:
            there = max(ends[0], here - step)
        if there == here:
            return math.inf if kept else 0.0
        if scan.at(there).lost(kind) == kept:
            return scan.root(kind, min(here, there), max(here, there), WIDTH)
        here, step = there, min(2 * step, STRIDE * begin)
