"""Events of a curve over one cam revolution: extremes and spikes, in a model as the test would have
shown them.

The largest value of a mean of repeats is too large by what scatter adds to it, and where two maxima
are alike its place is chance. So the model is judged by its events under the scatter of the test:
the mean's own scatter, drawn from the repeats, is added to it many times.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import stdtrit

from valvetrain.quantities.compare import pair_angles
from valvetrain.quantities.signal import prominences, prominent_peaks

Array = NDArray[np.float64]
#: Gives angle and height of an event of a curve.
Measure = Callable[[Array], tuple[float, float]]
_TURN = 2 * np.pi
#: A spike exceeds its surroundings by this share of the range of the curve, and by this many standard errors of
#: the mean.
SPIKE_SHARE, SPIKE_ERRORS = 0.04, 6.0
#: Spikes that are reported, the most prominent ones, at most.
MAX_SPIKES = 8
#: A spike of the model meets one of the test within this angle (rad).
MEETING = math.radians(20.0)
#: Draws of the mean's scatter, most numbers they take together, and the seed.
DRAWS, MAX_DRAWN, SEED = 200, 4_000_000, 20260101
#: An angle whose standard error is larger than this (rad) is a matter of chance.
CHANCE = math.radians(10.0)


@dataclass(frozen=True, slots=True)
class EventRow:
    """One event in model and test.

    ``name`` as shown; ``dimension``: ``value`` of the curve or ``angle`` (rad). ``model`` is NaN
    where it shows none; ``seen``: what the test would show of it on average, for its scatter moves
    extremes; ``error``: standard deviation of that (NaN for one repeat); ``shared``: standard
    deviation of what all repeats share.

    >>> EventRow("largest", "value", model=820.0, test=800.0, seen=825.0, error=5.0, repeats=10).in_errors
    5.0
    """

    name: str
    dimension: str
    model: float
    test: float
    seen: float
    error: float
    repeats: int
    shared: float = 0.0

    @property
    def difference(self) -> float:
        """Model, as the test would show it, less test; angles the short way round."""
        off = self.seen - self.test
        return _short(off) if self.dimension == "angle" else off

    @property
    def scatter(self) -> float:
        """Standard deviation of one repeat."""
        return self.error * math.sqrt(self.repeats)

    @property
    def in_errors(self) -> float:
        """Difference in standard errors, what all repeats share included; NaN where there are none."""
        return self.difference / math.hypot(self.error, self.shared) if self.error > 0 else math.nan

    @property
    def outside(self) -> bool | None:
        """Whether the test's is none that the model would show in 95 of 100 such tests; None where
        that cannot be decided.
        """
        if not math.isfinite(self.in_errors):
            return None
        return abs(self.in_errors) > float(stdtrit(self.repeats - 1, 0.975))


def _short(angle: float) -> float:
    return (angle + math.pi) % _TURN - math.pi


def scatter_of_mean(values: Array) -> Array:
    """Draws (draws, angles) of the scatter that the mean of ``values`` (repeats, angles) has; none
    for one repeat.
    """
    repeats, angles = values.shape
    if repeats < 2:
        return np.zeros((0, angles))
    count = int(np.clip(MAX_DRAWN // angles, 20, DRAWS))
    weights = np.random.default_rng(SEED).standard_normal((count, repeats)) / math.sqrt(
        repeats * (repeats - 1)
    )
    drawn: Array = weights @ (values - values.mean(axis=0))
    return drawn


def _event(
    name: str,
    test: tuple[float, float],
    measure: Measure | None,
    model: Array,
    drawn: Array,
    repeats: int,
) -> list[EventRow]:
    """Height and angle of an event: (angle, height) in the ``test``, and by ``measure`` in the model, which
    shows none where that is None.
    """
    at, moved = (math.nan, math.nan), np.zeros((0, 2))
    if measure is not None:
        at = measure(model)
        moved = np.array([measure(model + scatter) for scatter in drawn]).reshape(-1, 2) - at
        moved[:, 0] = (moved[:, 0] + math.pi) % _TURN - math.pi
    seen = at + moved.mean(axis=0) if len(moved) else np.array(at)
    error = np.std(moved, axis=0, ddof=1) if len(moved) else np.full(2, math.nan)
    return [
        EventRow(name, dimension, at[k], test[k], float(seen[k]), float(error[k]), repeats)
        for k, dimension in ((1, "value"), (0, "angle"))
    ]


def extreme_rows(
    name: str,
    cam_angle: Array,
    values: Array,
    model: Array,
    drawn: Array,
    inside: NDArray[np.bool_],
    sign: float,
) -> list[EventRow]:
    """Largest (``sign`` 1) or least (-1) value within ``inside``, and its angle where that is
    neither chance nor an end of the stretch.
    """
    places = np.flatnonzero(inside)
    if len(places) < 3:
        return []

    def measure(curve: Array) -> tuple[float, float]:
        angle, height = _top(cam_angle, sign * curve, places)
        return angle, sign * height

    mean = values.mean(axis=0)
    rows = _event(name, measure(mean), measure, model, drawn, len(values))
    ends = {int(places[0]), int(places[-1])} if len(places) < len(cam_angle) else set()
    at_end = any(int(places[np.argmax(sign * curve[places])]) in ends for curve in (model, mean))
    return rows[:1] if at_end or rows[1].error > CHANCE else rows


def _top(cam_angle: Array, curve: Array, places: NDArray[np.int64]) -> tuple[float, float]:
    """Angle and height of the largest of ``curve`` at ``places``, by the parabola through it and
    its neighbours on the ring.
    """
    count = len(curve)
    top = int(places[np.argmax(curve[places])])
    before, here, after = (float(curve[(top + step) % count]) for step in (-1, 0, 1))
    bend = before - 2 * here + after
    steps = [
        float((cam_angle[(top + step + 1) % count] - cam_angle[(top + step) % count]) % _TURN)
        for step in (-1, 0)
    ]
    if not bend < 0 or here < before or here < after or abs(steps[0] - steps[1]) > 0.01 * steps[0]:
        return float(cam_angle[top]), here
    return float(cam_angle[top]) + steps[0] * (before - after) / (2 * bend), here - (
        after - before
    ) ** 2 / (8 * bend)


def spike_rows(cam_angle: Array, values: Array, model: Array, drawn: Array) -> list[EventRow]:
    """Maxima that exceed the noise of the mean of ``values`` (repeats, angles), height and angle, each
    next to the one of the model it meets.
    """
    mean = values.mean(axis=0)
    error = (
        float(np.sqrt(np.mean(np.var(values, axis=0, ddof=1)) / len(values)))
        if len(values) > 1
        else 0.0
    )
    least = max(SPIKE_SHARE * float(np.ptp(mean)), SPIKE_ERRORS * error)
    theirs, mine = _spikes(mean, least), _spikes(model, 0.5 * least, 3 * MAX_SPIKES)
    angles, of_model = ([float(cam_angle[place]) for place in places] for places in (theirs, mine))
    partners = pair_angles(angles, of_model) if angles else []
    rows: list[EventRow] = []
    for count, (angle, partner) in enumerate(zip(angles, partners, strict=True), start=1):
        test = _top(cam_angle, mean, _around(cam_angle, angle, angles))
        measure = None
        if partner is not None and abs(_short(partner - angle)) <= MEETING:
            near = _around(cam_angle, partner, of_model)
            measure = partial(_top, cam_angle, places=near)
        rows += _event(f"spike {count}", test, measure, model, drawn, len(values))
    return rows


def _around(cam_angle: Array, angle: float, others: list[float]) -> NDArray[np.int64]:
    """Places about a spike in which it is looked for, well short of its neighbours."""
    distances = [abs(_short(other - angle)) for other in others if other != angle]
    found: NDArray[np.int64] = np.flatnonzero(
        np.abs((cam_angle - angle + math.pi) % _TURN - math.pi) <= 0.5 * min([MEETING, *distances])
    )
    return found


def _spikes(curve: Array, least: float, most: int = MAX_SPIKES) -> list[int]:
    """Places of the most prominent maxima of a ring, in order."""
    count = len(curve)
    start = int(np.argmin(curve))
    turned = np.append(np.roll(curve, -start), curve[start])
    peaks = prominent_peaks(turned, least)
    strongest = peaks[np.argsort(-prominences(turned, peaks), kind="stable")[:most]]
    return sorted((int(place) + start) % count for place in strongest)


def interval_row(rows: list[EventRow], first: float, last: float) -> EventRow | None:
    """Mean distance (rad) of the spikes between two cam angles that model and test both show; None
    for fewer than two.
    """
    angles = [
        row
        for row in rows
        if row.dimension == "angle" and math.isfinite(row.model) and first <= row.test < last
    ]
    if len(angles) < 2:
        return None
    count, first_angle, last_angle = len(angles) - 1, angles[0], angles[-1]
    error = math.hypot(first_angle.error, last_angle.error) / count
    model, test, seen = (
        (last_angle.model - first_angle.model) / count,
        (last_angle.test - first_angle.test) / count,
        (last_angle.seen - first_angle.seen) / count,
    )
    return EventRow(
        f"interval of {count + 1} spikes", "angle", model, test, seen, error, first_angle.repeats
    )


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
    found: Array = np.fft.irfft(spectrum * turn, len(values))
    return found


def _even(cam_angle: Array, rows: Array) -> Array:
    """Rows on the even ring of as many angles, straight between those that there are."""
    even = cam_angle[0] + np.arange(len(cam_angle)) * 2 * np.pi / len(cam_angle)
    return np.vstack([np.interp(even, cam_angle, row, period=2 * np.pi) for row in rows])
