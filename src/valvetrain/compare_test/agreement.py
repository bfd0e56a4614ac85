"""How near a curve is to the mean of repeats over one cam revolution, and by which angle it comes later."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import stdtrit

from valvetrain.arrays import Array

#: Largest shift that is looked for (rad of cam).
MAX_SHIFT = math.pi / 4
#: Points per step of the angle at which the correlation is first looked up, fewer where these would
#: be more than the other number.
_FINER, _MAX_POINTS = 8, 1 << 17


@dataclass(frozen=True, slots=True)
class Agreement:
    """Model against the mean of the repeats over one turn, SI.

    ``bias``: mean of model less test. ``rms``: root mean square of that difference.
    ``correlation``: coefficient of the two curves. ``shift``: cam angle (rad) by which the model
    comes later, found from the largest cross-correlation of the curves without their means; NaN
    where a curve is level. ``shift_reach``: half width of its 95 % interval from the shifts of the
    single repeats, NaN for fewer than two. ``rest``: root mean square that is left when bias and
    shift are taken away. ``scatter``: root mean square of one repeat about the mean, NaN for one
    repeat.
    """

    bias: float
    rms: float
    correlation: float
    shift: float
    shift_reach: float
    rest: float
    scatter: float


def agreement(
    cam_angle: Array, values: Array, model: Array, weights: Array, even: bool
) -> Agreement:
    """Model (angles,) against ``values`` (repeats, angles) at ``cam_angle`` (rad); ``weights`` sum
    to one; ``even``: equal steps.
    """
    mean = values.mean(axis=0)
    difference = model - mean
    bias = float(weights @ difference)
    rms = math.sqrt(float(weights @ difference**2))
    mine, theirs = model - weights @ model, mean - weights @ mean
    power = math.sqrt(float(weights @ mine**2) * float(weights @ theirs**2))
    correlation = float(weights @ (mine * theirs)) / power if power > 0 else math.nan
    ring = (
        _even(cam_angle, np.vstack([model, mean, values]))
        if not even
        else np.vstack([model, mean, values])
    )
    shift = best_shift(ring[0], ring[1])
    single = np.array([best_shift(ring[0], one) for one in ring[2:]])
    repeats = len(values)
    reach = (
        float(stdtrit(repeats - 1, 0.975) * np.std(single, ddof=1) / math.sqrt(repeats))
        if repeats > 1
        else math.nan
    )
    rest = rms
    if math.isfinite(shift):
        left = shifted(ring[0], -shift) - ring[1]
        rest = float(np.std(left))
    scatter = (
        math.sqrt(float(weights @ np.var(values, axis=0, ddof=1))) if repeats > 1 else math.nan
    )
    return Agreement(bias, rms, correlation, shift, reach, rest, scatter)


def best_shift(model: Array, test: Array) -> float:
    """Angle (rad) by which ``model`` comes later than ``test``, both on the same even ring: where
    their correlation is largest.

    Between the steps the curves are the sums of their harmonics. Within :data:`MAX_SHIFT`; NaN
    where a curve is level.
    """
    count = len(model)
    cross = np.conj(np.fft.rfft(test - test.mean())) * np.fft.rfft(model - model.mean())
    if count % 2 == 0:
        cross[-1] = 0.0  # the harmonic of half the steps has no phase
    if not np.abs(cross).max(initial=0.0) > 1e-24 * (count * (np.ptp(model) + 1e-300)) * (
        count * (np.ptp(test) + 1e-300)
    ):
        return math.nan
    points = count * max(2, min(_FINER, _MAX_POINTS // count))
    finer = np.fft.irfft(cross, points)
    shifts = np.fft.fftfreq(points) * 2 * np.pi
    near = np.abs(shifts) <= MAX_SHIFT
    place = float(shifts[near][np.argmax(finer[near])])
    harmonics = np.arange(len(cross))

    def slope(angle: float) -> float:
        return -float(harmonics @ (cross * np.exp(1j * harmonics * angle)).imag)

    low, high = place - 2 * np.pi / points, place + 2 * np.pi / points
    rises = slope(low) > 0 > slope(high)
    return float(brentq(slope, low, high, xtol=1e-14)) if rises else place


def shifted(values: Array, later: float) -> Array:
    """An even ring of values turned by an angle (rad), positive comes later; the sum of its
    harmonics.
    """
    spectrum = np.fft.rfft(values)
    turn = np.exp(-1j * np.arange(len(spectrum)) * later)
    return np.fft.irfft(spectrum * turn, len(values))


def _even(cam_angle: Array, rows: Array) -> Array:
    """Rows on the even ring of as many angles, straight between those that there are."""
    even = cam_angle[0] + np.arange(len(cam_angle)) * 2 * np.pi / len(cam_angle)
    return np.vstack([np.interp(even, cam_angle, row, period=2 * np.pi) for row in rows])
