"""Cam angle over time, from an encoder's angle, a toothed wheel or one pulse per revolution.

The channel may belong to the cam or the crank; lost and false pulses are found, jitter is smoothed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import BSpline, CubicSpline, PchipInterpolator, make_smoothing_spline
from scipy.ndimage import median_filter

from valvetrain.arrays import Array, Ints
from valvetrain.errors import InputError
from valvetrain.rig.channels import ChosenChannels
from valvetrain.rig.reader import RigChannel
from valvetrain.rig.request import RigAnswers

Numbers = Ints
REVOLUTION = 2 * np.pi
#: Crank revolutions per cam revolution.
RATIO = 2
#: Share of the swing at which a pulse counts as down or up: noise between them makes no edges.
LOW, HIGH = 0.35, 0.65
#: Intervals whose median is the typical one; a shorter interval than this share of it is no tooth.
AROUND, TOO_SHORT = 11, 0.4
#: Knots of the spline per cam revolution at most: more frequent readings are averaged between
#: them, which takes jitter out.
KNOTS = 36
#: Knots that are smoothed at least; knots by which the smoothing is chosen at most; costs of
#: bending that are tried.
MIN_SMOOTHED, MAX_LEARNT = 60, 2000
COSTS = tuple(np.geomspace(1e-3, 1e6, 19).tolist())
_HALF = (
    "the mark comes once per crank revolution: which of the two of a cycle comes first is not known, so angles may be half a cam revolution "
    "off"
)


def rising_edges(channel: RigChannel) -> Array:
    """Times (s) at which a pulse channel rises through the middle of its swing, between samples by
    a straight line.

    Raises :class:`InputError` where the channel does not swing.
    """
    values, name = channel.values, channel.name[:80]
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    if not np.isfinite(high - low) or high - low <= 0:
        raise InputError(
            f"channel '{name}' holds no pulses: it never changes; name the channel of the pulses"
        )
    share = (values - low) / (high - low)
    level = np.where(share >= HIGH, 1, np.where(share <= LOW, 0, -1))
    decided = np.flatnonzero(level >= 0)
    state = level[decided]
    flips = decided[1:][(state[1:] == 1) & (state[:-1] == 0)]
    crossings = np.flatnonzero((share[:-1] < 0.5) & (share[1:] >= 0.5))
    if not len(crossings) or not len(flips):
        raise InputError(
            f"channel '{name}' holds no pulses that rise; name the channel of the pulses"
        )
    before = crossings[np.maximum(np.searchsorted(crossings, flips) - 1, 0)]
    part = (0.5 - share[before]) / (share[before + 1] - share[before])
    times: Array = channel.start + (before + part) * channel.step
    return times


class Teeth(NamedTuple):
    """Edges of a wheel: ``times`` (s), ``numbers`` that rise by one per tooth, ``marks`` the
    numbers at a mark.
    """

    times: Array
    numbers: Numbers
    marks: Numbers
    notes: tuple[str, ...] = ()


def number_teeth(times: Array, teeth: int, missing: int, name: str) -> Teeth:
    """Number the edges of a wheel of ``teeth`` positions of which ``missing`` adjacent ones are cut
    away; the mark is the tooth behind the gap.

    False edges are left out, lost ones are counted, both are noted. Raises :class:`InputError`
    where the gap does not come back after the specified number of teeth.
    """
    if len(times) < 2 * AROUND:
        raise InputError(
            f"channel '{name[:80]}' holds {len(times)} pulses, too few for cycles; give a longer recording"
        )
    notes = []
    typical = median_filter(np.diff(times), AROUND, mode="nearest")
    false = np.flatnonzero(np.diff(times) < TOO_SHORT * typical) + 1
    if len(false):
        notes.append(
            f"{len(false)} pulses of '{name}' follow too soon to be teeth and were left out, the first at {times[false[0]]:.6g} s"
        )
        times = np.delete(times, false)
        typical = median_filter(np.diff(times), AROUND, mode="nearest")
    steps = np.maximum(np.rint(np.diff(times) / typical).astype(np.int64), 1)
    numbers: Numbers = np.concatenate([[0], np.cumsum(steps)])
    gaps: Numbers = np.zeros(0, dtype=np.int64)
    if missing:
        gaps = np.flatnonzero(steps == missing + 1) + 1
        gaps = _once_per_revolution(numbers, gaps, teeth, missing, name)
    lost = np.flatnonzero((steps > 1) & ~np.isin(np.arange(1, len(times)), gaps))
    if not missing and len(lost) > 2 and len(set(np.diff(numbers[lost + 1]).tolist())) == 1:
        every, gone = int(np.diff(numbers[lost + 1])[0]), int(steps[lost[0]]) - 1
        raise InputError(
            f"'{name[:80]}' lacks {gone} of every {every} teeth; say teeth {every} and missing {gone}",
            "missing",
        )
    if len(lost):
        notes.append(
            f"{len(lost)} pulses of '{name}' were lost, the first at {times[lost[0]]:.6g} s; the angle there follows from the others"
        )
    return Teeth(times, numbers, numbers[gaps], tuple(notes))


def _once_per_revolution(
    numbers: Numbers, gaps: Numbers, teeth: int, missing: int, name: str
) -> Numbers:
    """Those gaps that come back after ``teeth`` teeth."""
    if not len(gaps):
        raise InputError(
            f"'{name[:80]}' shows no gap of {missing} missing teeth; correct the number of missing teeth or leave it out"
        )
    remainders = numbers[gaps] % teeth
    counts = np.bincount(remainders, minlength=teeth)
    most = int(np.argmax(counts))
    if counts[most] < 0.6 * (numbers[-1] - numbers[0]) / teeth - 1:
        every = float(np.median(np.diff(numbers[gaps]))) if len(gaps) > 1 else 0.0
        raise InputError(
            f"the gap of '{name[:80]}' does not come back after {teeth} teeth but after {every:g}; correct the number of teeth (with those "
            "that are missing)",
            "teeth",
        )
    regular: Numbers = gaps[remainders == most]
    return regular


@dataclass(frozen=True, eq=False)
class ShaftAngle:
    """Cam angle (rad) over time by a spline through ``times`` (s) and ``cam_angles`` (rad, zero at
    the mark), both of shape (knots,).

    ``scatter`` (rad): standard deviation of the readings about the spline; ``readings``: how often
    per cam revolution the angle was recorded; ``smoothing``: cost of bending of the spline (0: it
    goes through every knot); ``repeated`` (rad): root mean square of that scatter which comes back
    in every revolution (errors of the wheel's pitch, speed that the spline does not follow).

    >>> shaft = ShaftAngle(np.linspace(0, 1, 50), 20 * np.linspace(0, 1, 50))
    >>> round(float(shaft.times_at(np.array([10.0]))[0]), 9), round(float(shaft.cam_speed(np.array([0.3]))[0]), 9)
    (0.5, 20.0)
    """

    times: Array
    cam_angles: Array
    scatter: float = 0.0
    readings: float = 0.0
    notes: tuple[str, ...] = ()
    smoothing: float = 0.0
    repeated: float = 0.0

    @cached_property
    def _spline(self) -> Any:
        knots = self.times, self.cam_angles
        spline = _smooth(*knots, self.smoothing) if self.smoothing else CubicSpline(*knots)
        fine = np.linspace(self.times[0], self.times[-1], 8 * len(self.times))
        # a shaft that stops or jerks makes a cubic overshoot backwards, which a monotone one
        # cannot
        return spline if np.all(spline(fine, 1) > 0) else PchipInterpolator(*knots)

    def angle_at(self, times: Array) -> Array:
        """Cam angle (rad) at ``times`` (s)."""
        angles: Array = self._spline(times)
        return angles

    def cam_speed(self, times: Array) -> Array:
        """Speed of the cam (rad/s) at ``times`` (s)."""
        speeds: Array = self._spline(times, 1)
        return speeds

    def times_at(self, cam_angles: Array) -> Array:
        """Times (s) at which the cam is at ``cam_angles`` (rad): the inverse, by Newton's steps
        from the straight line between knots.
        """
        times = np.interp(cam_angles, self.cam_angles, self.times)
        low, high = self.times[0], self.times[-1]
        for _ in range(6):
            slope = np.maximum(self.cam_speed(times), 1e-9)
            times = np.clip(times - (self.angle_at(times) - cam_angles) / slope, low, high)
        return times


def shaft_through(
    times: Array, cam_angles: Array, notes: tuple[str, ...] = (), name: str = ""
) -> ShaftAngle:
    """The shaft with readings ``cam_angles`` (rad) at ``times`` (s), both rising; averaged where
    they are very frequent.

    Raises :class:`InputError` where there are too few or the shaft does not turn one way.
    """
    if (
        len(times) < 4
        or not np.all(np.diff(times) > 0)
        or not cam_angles[-1] - cam_angles[0] > REVOLUTION
    ):
        raise InputError(
            f"channel '{name[:80]}' does not hold one whole cam revolution; give a longer recording"
        )
    readings = (len(times) - 1) / ((cam_angles[-1] - cam_angles[0]) / REVOLUTION)
    if readings <= KNOTS * 1.5:
        knots = times, cam_angles
    else:
        window = np.floor((cam_angles - cam_angles[0]) / (REVOLUTION / KNOTS)).astype(np.int64)
        _, window = np.unique(window, return_inverse=True)
        count = np.bincount(window)
        knots = np.bincount(window, times) / count, np.bincount(window, cam_angles) / count
    if not np.all(np.diff(knots) > 0):
        raise InputError(
            f"the angle of '{name[:80]}' does not rise: the shaft stops or turns back; cut the recording to what turns"
        )
    smoothed = len(knots[0]) >= MIN_SMOOTHED and readings > 4
    smoothing = _best_smoothing(*knots) if smoothed else 0.0
    shaft = ShaftAngle(*knots, 0.0, readings, notes, smoothing)
    if readings <= 4:
        return shaft
    residuals = cam_angles - shaft.angle_at(times)
    sector = np.floor((cam_angles % REVOLUTION) / REVOLUTION * 2 * KNOTS).astype(np.int64)
    count = np.bincount(sector, minlength=2 * KNOTS)
    means = np.bincount(sector, residuals, minlength=2 * KNOTS)[count > 0] / count[count > 0]
    return replace(
        shaft, scatter=float(np.std(residuals)), repeated=float(np.sqrt(np.mean(means**2)))
    )


def _smooth(times: Array, angles: Array, smoothing: float) -> BSpline:
    """Cubic smoothing spline (C. H. Reinsch, "Smoothing by spline functions", Numerische Mathematik
    10, 1967), its cost of bending in steps of the knots.
    """
    step = float(times[-1] - times[0]) / (len(times) - 1)
    return make_smoothing_spline(times, angles, lam=smoothing * step**3)


def _best_smoothing(times: Array, angles: Array) -> float:
    """The cost of bending with which every second knot predicts the others best: jitter is smoothed
    away, changes of speed are not.
    """
    times, angles = times[:MAX_LEARNT], angles[:MAX_LEARNT]
    errors = []
    for smoothing in COSTS:
        spline = _smooth(
            times[::2], angles[::2], smoothing / 16
        )  # twice the step, so a sixteenth of the cost
        errors.append(float(np.mean((spline(times[3:-3:2]) - angles[3:-3:2]) ** 2)))
    return float(COSTS[int(np.argmin(errors))])


def unwrapped(values: Array, name: str) -> tuple[Array, float]:
    """An encoder's angle (rad) without its jumps, and its period (rad): one or two revolutions; inf
    where it never jumps.

    Raises :class:`InputError` where it jumps by something else.
    """
    steps = np.diff(values)
    jumps = steps[np.abs(steps) > np.pi]
    if not len(jumps):
        return values, np.inf
    jump = float(np.median(np.abs(jumps)))
    period = REVOLUTION * round(jump / REVOLUTION)
    if period not in (REVOLUTION, 2 * REVOLUTION):
        raise InputError(
            f"angle '{name[:80]}' jumps by {np.degrees(jump):.4g} deg, not by one revolution or two; check its unit"
        )
    return values + period * np.concatenate([[0], np.cumsum(-np.rint(steps / period))]), period


def decode_counts(values: Array, times: Array) -> tuple[Array, Array, float]:
    """Times and angles at the edges of an encoder that counts in steps, and its step (rad; 0 where
    its angle is smooth).

    A counter shows the edge that it has passed: where it stays for several samples it is exact as
    it changes, else half a step late.
    """
    steps = np.abs(np.diff(values))
    changed = steps > 1e-9
    step = _common_step(steps[changed][:20_000])
    # a smooth angle at an even speed rises by one step too
    if not step or np.all(np.abs(steps - step) < 1e-5):
        return times, values, 0.0
    if np.count_nonzero(changed) > 0.5 * len(changed):
        return times, values + step / 2, step
    edges = np.flatnonzero(changed)
    return (times[edges] + times[edges + 1]) / 2, values[edges + 1], step


def _common_step(steps: Array) -> float:
    """The step (rad) of which all others are multiples, by Euclid's rule; 0 where there is none."""
    common = 0.0
    for step in np.unique(np.round(steps, 6))[:200]:
        larger, smaller = float(step), common
        while smaller > 2e-6:
            larger, smaller = smaller, abs(larger - smaller * round(larger / smaller))
        common = larger
        if common < 2e-5:
            return 0.0
    return common


def shaft_of(chosen: ChosenChannels, answers: RigAnswers) -> ShaftAngle:
    """Cam angle over time. Raises :class:`InputError` for pulses that do not fit their wheel and
    shafts that do not turn.
    """
    ratio = 1 if answers.angle_of == "cam" else RATIO
    channel = chosen.shaft
    if chosen.kind == "encoder":
        return _by_encoder(channel, ratio)
    edges = rising_edges(channel)
    if chosen.kind == "once":
        return _by_single_pulse(edges, ratio, channel)
    assert answers.teeth is not None
    teeth = number_teeth(edges, answers.teeth, answers.missing, channel.name)
    return _by_teeth(teeth, answers.teeth, ratio, channel, chosen.index_channel)


def _by_encoder(channel: RigChannel, ratio: int) -> ShaftAngle:
    if not np.isfinite(channel.values).all():
        raise InputError(
            f"angle '{channel.name[:40]}' has gaps; cut the recording to what was recorded in one go"
        )
    angles, period = unwrapped(channel.values, channel.name)
    times: Array = channel.start + channel.step * np.arange(len(angles), dtype=np.float64)
    notes = []
    if angles[-1] < angles[0]:
        angles = -angles
        notes.append(
            f"angle '{channel.name}' falls, so its sign is changed: the cam rotates with rising angle"
        )
    # a crank angle that runs over two revolutions says which of the two of the cycle it is
    if ratio == RATIO and period == REVOLUTION:
        notes.append(_HALF)
    times, angles, step = decode_counts(angles, times)
    if step:
        notes.append(
            f"angle '{channel.name}' counts in steps of {np.degrees(step):.4g} deg of its shaft; a count is taken as the edge just passed"
        )
    return shaft_through(times, angles / ratio, tuple(notes), channel.name)


def _by_single_pulse(edges: Array, ratio: int, channel: RigChannel) -> ShaftAngle:
    if len(edges) < 4:
        raise InputError(
            f"channel '{channel.name[:40]}' holds {len(edges)} pulses; one pulse per revolution needs four revolutions"
        )
    intervals = np.diff(edges)
    typical = np.median(intervals)
    odd = np.flatnonzero((intervals < 0.6 * typical) | (intervals > 1.6 * typical))
    if len(odd):
        raise InputError(
            f"the pulses of '{channel.name[:40]}' are not one per revolution: {len(odd)} intervals leave the others by more than 60 %, the "
            f"first at {edges[odd[0]]:.6g} s; cut the recording, or give teeth if it is a wheel",
            "once",
        )
    notes = [
        "one pulse per revolution shows how the speed changes from one to the next, by a spline; a change within a revolution is not seen"
    ]
    notes += [_HALF] if ratio == RATIO else []
    angles = REVOLUTION / ratio * np.arange(len(edges), dtype=np.float64)
    return shaft_through(edges, angles, tuple(notes), channel.name)


def _by_teeth(
    teeth: Teeth, count: int, ratio: int, channel: RigChannel, index: RigChannel | None
) -> ShaftAngle:
    notes = [*teeth.notes]
    zero, every = 0.0, 0
    if index is not None:
        marks = rising_edges(index)
        inside = (marks >= teeth.times[0]) & (marks <= teeth.times[-1])
        positions = np.interp(marks, teeth.times, teeth.numbers.astype(float))[inside]
        if len(positions) < 2:
            raise InputError(
                f"channel '{index.name[:40]}' marks fewer than two revolutions; name another channel, or leave it out",
                "index",
            )
        apart = float(np.median(np.diff(positions)))
        zero, every = float(positions[0]), round(apart / count)
        if every not in (1, ratio):
            raise InputError(
                f"'{index.name[:40]}' comes every {apart:.4g} teeth, not once per revolution of {count}; correct the number of teeth",
                "teeth",
            )
    elif len(teeth.marks):
        zero, every = float(teeth.marks[0]), 1
    else:
        notes.append(
            f"'{channel.name}' has no mark, so the angle begins at its first pulse; a case or an offset is needed to relate it to the cam"
        )
    if ratio == RATIO and every == 1:
        notes.append(_HALF)
    angles = np.asarray(REVOLUTION / ratio * (teeth.numbers - zero) / count, dtype=np.float64)
    return shaft_through(teeth.times, angles, tuple(notes), channel.name)
