"""The shaft behind the channel that tells it: angle, pulses or one pulse a turn, of cam or crank."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, CubicSpline, PchipInterpolator, make_smoothing_spline
from scipy.ndimage import median_filter

from valvetrain.errors import InputError
from valvetrain.rig.channels import Chosen, RigAnswers
from valvetrain.rig.recording import RigChannel

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
#: Share of the swing at which a pulse counts as down or up: noise between them makes no edges.
LOW, HIGH = 0.35, 0.65
#: Intervals whose median is the usual one; a shorter interval than this share of it is no tooth.
AROUND, TOO_SHORT = 11, 0.4


def rising_edges(values: Array, start: float, step: float, name: str) -> Array:
    """Times (s) at which a pulse channel rises through the middle of its swing, between samples by
    a straight line.

    Raises :class:`InputError` where the channel does not swing.
    """
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    if not np.isfinite(high - low) or high - low <= 0:
        raise InputError(
            f"channel '{name[:80]}' holds no pulses: it never changes; name the channel of the pulses"
        )
    share = (values - low) / (high - low)
    decided = np.where(share >= HIGH, 1, np.where(share <= LOW, 0, -1))
    known = np.flatnonzero(decided >= 0)
    state = decided[known]
    flips = known[1:][(state[1:] == 1) & (state[:-1] == 0)]
    crossing = np.flatnonzero((share[:-1] < 0.5) & (share[1:] >= 0.5))
    if not len(crossing) or not len(flips):
        raise InputError(
            f"channel '{name[:80]}' holds no pulses that rise; name the channel of the pulses"
        )
    found = crossing[np.maximum(np.searchsorted(crossing, flips) - 1, 0)]
    part = (0.5 - share[found]) / (share[found + 1] - share[found])
    times: Array = start + (found + part) * step
    return times


@dataclass(frozen=True, eq=False)
class Teeth:
    """Edges with the tooth each stands for: ``times`` (s), ``numbers`` that rise by one a tooth,
    ``marks`` the numbers at a mark.
    """

    times: Array
    numbers: Numbers
    marks: Numbers
    notes: tuple[str, ...] = ()


def numbered(times: Array, teeth: int, missing: int, name: str) -> Teeth:
    """Number the edges of a wheel of ``teeth`` places of which ``missing`` side by side are cut
    away; the mark is the tooth behind the gap.

    Edges in between that are no teeth are left out, lost ones are counted, both are told. Raises
    :class:`InputError` where the gap does
    not come back after the teeth that were told.
    """
    if len(times) < 2 * AROUND:
        raise InputError(
            f"channel '{name[:80]}' holds {len(times)} pulses, too few for cycles; give a longer recording"
        )
    notes = []
    usual = median_filter(np.diff(times), AROUND, mode="nearest")
    extra = np.flatnonzero(np.diff(times) < TOO_SHORT * usual) + 1
    if len(extra):
        notes.append(
            f"{len(extra)} pulses of '{name}' follow too soon to be teeth and were left out, the first at {times[extra[0]]:.6g} s"
        )
        times = np.delete(times, extra)
        usual = median_filter(np.diff(times), AROUND, mode="nearest")
    steps = np.maximum(np.rint(np.diff(times) / usual).astype(np.int64), 1)
    numbers: Numbers = np.concatenate([[0], np.cumsum(steps)])
    gaps = np.flatnonzero(steps == missing + 1) + 1 if missing else np.zeros(0, dtype=np.int64)
    if missing:
        gaps = _of_the_wheel(numbers, gaps, teeth, missing, name)
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


def _of_the_wheel(numbers: Numbers, gaps: Numbers, teeth: int, missing: int, name: str) -> Numbers:
    """Those gaps that come back once a turn."""
    if not len(gaps):
        raise InputError(
            f"'{name[:80]}' shows no gap of {missing} missing teeth; correct the number of missing teeth or leave it out"
        )
    rest = numbers[gaps] % teeth
    counts = np.bincount(rest, minlength=teeth)
    most = int(np.argmax(counts))
    turns = (numbers[-1] - numbers[0]) / teeth
    if counts[most] < 0.6 * turns - 1:
        every = float(np.median(np.diff(numbers[gaps]))) if len(gaps) > 1 else 0.0
        raise InputError(
            f"the gap of '{name[:80]}' does not come back after {teeth} teeth but after {every:g}; correct the number of teeth (with those "
            "that are missing)",
            "teeth",
        )
    kept: Numbers = gaps[rest == most]
    return kept


TURN = 2 * np.pi
#: Knots of the spline in a cam turn at most: what is told more often is averaged between them,
#: which takes jitter out.
KNOTS = 36
#: Fewest knots that are smoothed, most of them by which the smoothing is chosen, costs of bending
#: that are tried.
FEWEST, LEARNT, COSTS = 60, 2000, tuple(np.geomspace(1e-3, 1e6, 19).tolist())


@dataclass(frozen=True, eq=False)
class ShaftAngle:
    """Cam angle (rad) over time by a spline through ``times`` (s) and ``cam_angles`` (rad, zero at
    the mark), both of shape (knots,).

    ``scatter`` (rad): standard deviation of what was told about the spline; ``told``: how often a
    cam turn; ``notes`` on how;
    ``smoothing``: what the bend of the spline costs (0: it goes through every knot); ``repeated``
    (rad): what of the scatter comes back
    in every turn (errors of the wheel's pitch, speed that the spline does not follow), root mean
    square.

    >>> shaft = ShaftAngle(np.linspace(0, 1, 50), 20 * np.linspace(0, 1, 50))
    >>> round(float(shaft.times_at(np.array([10.0]))[0]), 9), round(float(shaft.cam_speed(np.array([0.3]))[0]), 9)
    (0.5, 20.0)
    """

    times: Array
    cam_angles: Array
    scatter: float = 0.0
    told: float = 0.0
    notes: tuple[str, ...] = field(default=())
    smoothing: float = 0.0
    repeated: float = 0.0

    @cached_property
    def _spline(self) -> Any:
        spline = (
            _smooth(self.times, self.cam_angles, self.smoothing)
            if self.smoothing
            else CubicSpline(self.times, self.cam_angles)
        )
        fine = np.linspace(self.times[0], self.times[-1], 8 * len(self.times))
        # a shaft that stands or jerks makes a cubic overshoot backwards, which a monotone one
        # cannot
        return (
            spline
            if np.all(spline(fine, 1) > 0)
            else PchipInterpolator(self.times, self.cam_angles)
        )

    def angle_at(self, times: Array) -> Array:
        """Cam angle (rad) at ``times`` (s)."""
        found: Array = self._spline(times)
        return found

    def cam_speed(self, times: Array) -> Array:
        """Speed of the cam (rad/s) at ``times`` (s)."""
        found: Array = self._spline(times, 1)
        return found

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
    """The shaft behind ``cam_angles`` (rad) told at ``times`` (s), both rising; averaged where they
    are told very often.

    Raises :class:`InputError` where there are too few or the shaft does not turn one way.
    """
    if (
        len(times) < 4
        or not np.all(np.diff(times) > 0)
        or not cam_angles[-1] - cam_angles[0] > TURN
    ):
        raise InputError(
            f"channel '{name[:80]}' does not hold one whole cam turn; give a longer recording"
        )
    turns = (cam_angles[-1] - cam_angles[0]) / TURN
    told = (len(times) - 1) / turns
    if told <= KNOTS * 1.5:
        knots = times, cam_angles
    else:
        window = np.floor((cam_angles - cam_angles[0]) / (TURN / KNOTS)).astype(np.int64)
        _, window = np.unique(window, return_inverse=True)
        held = np.bincount(window)
        knots = np.bincount(window, times) / held, np.bincount(window, cam_angles) / held
    if not np.all(np.diff(knots[1]) > 0):
        raise InputError(
            f"the angle of '{name[:80]}' does not rise: the shaft stands or turns back; cut the recording to what turns"
        )
    shaft = ShaftAngle(
        *knots,
        0.0,
        told,
        notes,
        _best_smoothing(*knots) if len(knots[0]) >= FEWEST and told > 4 else 0.0,
    )
    if told <= 4:
        return shaft
    left = cam_angles - shaft.angle_at(times)
    place = np.floor((cam_angles % TURN) / TURN * 2 * KNOTS).astype(np.int64)
    held = np.bincount(place, minlength=2 * KNOTS)
    means = np.bincount(place, left, minlength=2 * KNOTS)[held > 0] / held[held > 0]
    return replace(shaft, scatter=float(np.std(left)), repeated=float(np.sqrt(np.mean(means**2))))


def _smooth(times: Array, angles: Array, smoothing: float) -> BSpline:
    """Cubic smoothing spline (C. H. Reinsch, "Smoothing by spline functions", Numerische Mathematik
    10, 1967), in steps of the knots.
    """
    step = float(times[-1] - times[0]) / (len(times) - 1)
    trend = (angles[-1] - angles[0]) / (len(times) - 1)
    places = (times - times[0]) / step
    found = make_smoothing_spline(places, angles - angles[0] - trend * places, lam=smoothing)
    coefficients = (
        found.c + angles[0] + trend * np.convolve(found.t[1:-1], np.ones(3) / 3, "valid")
    )  # a straight line, by its Greville points
    return BSpline(times[0] + step * found.t, coefficients, 3)


def _best_smoothing(times: Array, angles: Array) -> float:
    """The cost of bending by which every second knot tells the others best: jitter is smoothed
    away, changes of speed are not.
    """
    times, angles = times[:LEARNT], angles[:LEARNT]
    away = []
    for smoothing in COSTS:
        spline = _smooth(
            times[::2], angles[::2], smoothing / 16
        )  # twice the step, so a sixteenth of the cost
        away.append(float(np.mean((spline(times[3:-3:2]) - angles[3:-3:2]) ** 2)))
    return float(COSTS[int(np.argmin(away))])


def unwrapped(values: Array, name: str) -> tuple[Array, float]:
    """An encoder's angle (rad) without its jumps, and its period (rad): one or two turns; inf where
    it never jumps.

    Raises :class:`InputError` where it jumps by something else.
    """
    steps = np.diff(values)
    jumps = steps[np.abs(steps) > np.pi]
    if not len(jumps):
        return values, np.inf
    period = TURN * round(float(np.median(np.abs(jumps))) / TURN)
    if period not in (TURN, 2 * TURN):
        raise InputError(
            f"angle '{name[:80]}' jumps by {np.degrees(np.median(np.abs(jumps))):.4g} deg, not by a turn or two; check its unit"
        )
    whole = values + period * np.concatenate([[0], np.cumsum(-np.rint(steps / period))])
    return whole, period


def told_by_counts(values: Array, times: Array) -> tuple[Array, Array, float]:
    """Times and angles that an encoder tells which counts in steps, and its step (rad; 0 where its
    angle is smooth).

    A counter shows the edge that it has passed: where it stays for several samples it is exact as
    it changes, else half a step late.
    """
    steps = np.abs(np.diff(values))
    changed = steps > 1e-9
    if not changed.any():
        return times, values, 0.0
    least = _common_step(steps[changed][:20_000])
    if not least or np.all(
        np.abs(steps - least) < 1e-5
    ):  # a smooth angle at an even speed rises by one step too
        return times, values, 0.0
    if np.count_nonzero(changed) > 0.5 * len(changed):
        return times, values + least / 2, least
    place = np.flatnonzero(changed)
    return (times[place] + times[place + 1]) / 2, values[place + 1], least


def _common_step(steps: Array) -> float:
    """The step (rad) of which all others are multiples, by Euclid's rule; 0 where there is none."""
    found = 0.0
    for step in np.unique(np.round(steps, 6))[:200]:
        one, two = float(step), found
        while two > 2e-6:
            one, two = two, abs(one - two * round(one / two))
        found = one
        if found < 2e-5:
            return 0.0
    return found


#: Crank turns per cam turn.
RATIO = 2
_HALF = "the mark comes once a crank turn: which of the two turns of a cycle comes first is not known, so angles may be half a cam turn off"


def shaft_of(chosen: Chosen, answers: RigAnswers) -> ShaftAngle:
    """Cam angle over time. Raises :class:`InputError` for pulses that do not fit their wheel and
    shafts that do not turn.
    """
    ratio = 1 if answers.angle_of == "cam" else RATIO
    channel = chosen.shaft
    if chosen.kind == "encoder":
        return _by_angle(channel, ratio)
    edges = rising_edges(channel.values, channel.start, channel.step, channel.name)
    if chosen.kind == "once":
        return _by_pulse_a_turn(edges, ratio, channel)
    assert answers.teeth is not None
    teeth = numbered(edges, answers.teeth, answers.missing, channel.name)
    return _by_teeth(teeth, answers.teeth, ratio, channel, chosen.index)


def _by_angle(channel: RigChannel, ratio: int) -> ShaftAngle:
    known = np.isfinite(channel.values)
    if not known.all():
        raise InputError(
            f"angle '{channel.name[:40]}' has gaps; cut the recording to what was recorded in one go"
        )
    angles, period = unwrapped(channel.values, channel.name)
    times: Array = channel.start + channel.step * np.arange(len(angles), dtype=np.float64)
    notes = []
    if angles[-1] < angles[0]:
        angles = -angles
        notes.append(
            f"angle '{channel.name}' falls, so its sign is changed: the cam turns with rising angle"
        )
    # how often the file's angle passes zero: a crank's that runs over two turns tells which turn of
    # the cycle it is
    if ratio == RATIO and period == TURN:
        notes.append(_HALF)
    times, angles, least = told_by_counts(angles, times)
    if least:
        notes.append(
            f"angle '{channel.name}' counts in steps of {np.degrees(least):.4g} deg of its shaft; a count is taken as the edge just passed"
        )
    return shaft_through(times, angles / ratio, tuple(notes), channel.name)


def _by_pulse_a_turn(edges: Array, ratio: int, channel: RigChannel) -> ShaftAngle:
    if len(edges) < 4:
        raise InputError(
            f"channel '{channel.name[:40]}' holds {len(edges)} pulses; one pulse a turn needs four turns"
        )
    intervals = np.diff(edges)
    odd = np.flatnonzero(
        (intervals < 0.6 * np.median(intervals)) | (intervals > 1.6 * np.median(intervals))
    )
    if len(odd):
        raise InputError(
            f"the pulses of '{channel.name[:40]}' are not one a turn: {len(odd)} intervals leave the others by more than 60 %, the first "
            f"at {edges[odd[0]]:.6g} s; cut the recording, or give teeth if it is a wheel",
            "once",
        )
    notes = [
        "one pulse a turn shows how the speed changes from turn to turn, by a spline; a change within a turn is not seen"
    ]
    if ratio == RATIO:
        notes.append(_HALF)
    return shaft_through(
        edges, TURN / ratio * np.arange(len(edges), dtype=np.float64), tuple(notes), channel.name
    )


def _by_teeth(
    teeth: Teeth, count: int, ratio: int, channel: RigChannel, index: RigChannel | None
) -> ShaftAngle:
    notes = [*teeth.notes]
    zero, every = 0.0, 0
    if index is not None:
        marks = rising_edges(index.values, index.start, index.step, index.name)
        at = np.interp(marks, teeth.times, teeth.numbers.astype(float))
        inside = (marks >= teeth.times[0]) & (marks <= teeth.times[-1])
        if np.count_nonzero(inside) < 2:
            raise InputError(
                f"channel '{index.name[:40]}' marks fewer than two turns; name another channel, or leave it out",
                "index",
            )
        zero, every = float(at[inside][0]), round(float(np.median(np.diff(at[inside]))) / count)
        if every not in (1, ratio):
            raise InputError(
                f"'{index.name[:40]}' comes every {np.median(np.diff(at[inside])):.4g} teeth, not once a turn of {count}; correct the "
                "number of teeth",
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
    angles = np.asarray(TURN / ratio * (teeth.numbers - zero) / count, dtype=np.float64)
    return shaft_through(teeth.times, angles, tuple(notes), channel.name)
