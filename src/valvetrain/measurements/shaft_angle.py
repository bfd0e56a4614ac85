"""Cam angle over time: a spline through what encoder, toothed wheel or pulse once a turn tell."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, CubicSpline, PchipInterpolator, make_smoothing_spline

from valvetrain.errors import InputError

Array = NDArray[np.float64]
TURN = 2 * np.pi
#: Knots of the spline in a cam turn at most: what is told more often is averaged between them, which takes jitter out.
KNOTS = 36
#: Fewest knots that are smoothed, most of them by which the smoothing is chosen, costs of bending that are tried.
FEWEST, LEARNT, COSTS = 60, 2000, tuple(np.geomspace(1e-3, 1e6, 19).tolist())


@dataclass(frozen=True, eq=False)
class ShaftAngle:
    """Cam angle (rad) over time by a spline through ``times`` (s) and ``cam_angles`` (rad, zero at the mark), both of shape (knots,).

    ``scatter`` (rad): standard deviation of what was told about the spline; ``told``: how often a cam turn; ``notes`` on how;
    ``smoothing``: what the bend of the spline costs (0: it goes through every knot); ``repeated`` (rad): what of the scatter comes back
    in every turn (errors of the wheel's pitch, speed that the spline does not follow), root mean square.

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
        spline = _smooth(self.times, self.cam_angles, self.smoothing) if self.smoothing else CubicSpline(self.times, self.cam_angles)
        fine = np.linspace(self.times[0], self.times[-1], 8 * len(self.times))
        # a shaft that stands or jerks makes a cubic overshoot backwards, which a monotone one cannot
        return spline if np.all(spline(fine, 1) > 0) else PchipInterpolator(self.times, self.cam_angles)

    def angle_at(self, times: Array) -> Array:
        """Cam angle (rad) at ``times`` (s)."""
        found: Array = self._spline(times)
        return found

    def cam_speed(self, times: Array) -> Array:
        """Speed of the cam (rad/s) at ``times`` (s)."""
        found: Array = self._spline(times, 1)
        return found

    def times_at(self, cam_angles: Array) -> Array:
        """Times (s) at which the cam is at ``cam_angles`` (rad): the inverse, by Newton's steps from the straight line between knots."""
        times = np.interp(cam_angles, self.cam_angles, self.times)
        low, high = self.times[0], self.times[-1]
        for _ in range(6):
            slope = np.maximum(self.cam_speed(times), 1e-9)
            times = np.clip(times - (self.angle_at(times) - cam_angles) / slope, low, high)
        return times


def shaft_through(times: Array, cam_angles: Array, notes: tuple[str, ...] = (), name: str = "") -> ShaftAngle:
    """The shaft behind ``cam_angles`` (rad) told at ``times`` (s), both rising; averaged where they are told very often.

    Raises :class:`InputError` where there are too few or the shaft does not turn one way.
    """
    if len(times) < 4 or not np.all(np.diff(times) > 0) or not cam_angles[-1] - cam_angles[0] > TURN:
        raise InputError(f"channel '{name[:80]}' does not hold one whole cam turn; give a longer recording")
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
        raise InputError(f"the angle of '{name[:80]}' does not rise: the shaft stands or turns back; cut the recording to what turns")
    shaft = ShaftAngle(*knots, 0.0, told, notes, _best_smoothing(*knots) if len(knots[0]) >= FEWEST and told > 4 else 0.0)
    if told <= 4:
        return shaft
    left = cam_angles - shaft.angle_at(times)
    place = np.floor((cam_angles % TURN) / TURN * 2 * KNOTS).astype(np.int64)
    held = np.bincount(place, minlength=2 * KNOTS)
    means = np.bincount(place, left, minlength=2 * KNOTS)[held > 0] / held[held > 0]
    return replace(shaft, scatter=float(np.std(left)), repeated=float(np.sqrt(np.mean(means**2))))


def _smooth(times: Array, angles: Array, smoothing: float) -> BSpline:
    """Cubic smoothing spline (C. H. Reinsch, "Smoothing by spline functions", Numerische Mathematik 10, 1967), in steps of the knots."""
    step = float(times[-1] - times[0]) / (len(times) - 1)
    trend = (angles[-1] - angles[0]) / (len(times) - 1)
    places = (times - times[0]) / step
    found = make_smoothing_spline(places, angles - angles[0] - trend * places, lam=smoothing)
    coefficients = (
        found.c + angles[0] + trend * np.convolve(found.t[1:-1], np.ones(3) / 3, "valid")
    )  # a straight line, by its Greville points
    return BSpline(times[0] + step * found.t, coefficients, 3)


def _best_smoothing(times: Array, angles: Array) -> float:
    """The cost of bending by which every second knot tells the others best: jitter is smoothed away, changes of speed are not."""
    times, angles = times[:LEARNT], angles[:LEARNT]
    away = []
    for smoothing in COSTS:
        spline = _smooth(times[::2], angles[::2], smoothing / 16)  # twice the step, so a sixteenth of the cost
        away.append(float(np.mean((spline(times[3:-3:2]) - angles[3:-3:2]) ** 2)))
    return float(COSTS[int(np.argmin(away))])


def unwrapped(values: Array, name: str) -> tuple[Array, float]:
    """An encoder's angle (rad) without its jumps, and its period (rad): one or two turns; inf where it never jumps.

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
    """Times and angles that an encoder tells which counts in steps, and its step (rad; 0 where its angle is smooth).

    A counter shows the edge that it has passed: where it stays for several samples it is exact as it changes, else half a step late.
    """
    steps = np.abs(np.diff(values))
    changed = steps > 1e-9
    if not changed.any():
        return times, values, 0.0
    least = _common_step(steps[changed][:20_000])
    if not least or np.all(np.abs(steps - least) < 1e-5):  # a smooth angle at an even speed rises by one step too
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
