"""Events of a curve over one cam turn: largest and least values, spikes that stand out, and how surely repeats tell them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from valvetrain.quantities.compare import pair_angles
from valvetrain.quantities.peaks import prominences, prominent_peaks

Array = NDArray[np.float64]
_TURN = 2 * np.pi
#: A spike stands out by this share of the range of the curve, and by this many standard errors of the mean.
SPIKE_SHARE, SPIKE_ERRORS = 0.04, 6.0
#: A maximum is as high as another where it is less than this many standard errors lower.
RIVAL = 4.0
#: Most spikes that are told, the most prominent ones.
MOST_SPIKES = 8
#: A spike of the model meets one of the test within this angle (rad).
MEETING = math.radians(20.0)


@dataclass(frozen=True, slots=True)
class EventRow:
    """One event in model and test.

    ``name`` in words; ``dimension``: ``value`` of the curve or ``angle`` (rad). ``error``: standard error of the test's by leaving out
    one repeat at a time (NaN where it cannot be told); ``repeats`` behind it. ``model`` is NaN where the model shows none.

    >>> EventRow("largest", "value", model=820.0, test=800.0, error=5.0, repeats=10).in_errors
    4.0
    """

    name: str
    dimension: str
    model: float
    test: float
    error: float
    repeats: int

    @property
    def difference(self) -> float:
        """Model less test; angles the short way round."""
        off = self.model - self.test
        return (off + math.pi) % _TURN - math.pi if self.dimension == "angle" else off

    @property
    def scatter(self) -> float:
        """Standard deviation of one repeat."""
        return self.error * math.sqrt(self.repeats)

    @property
    def in_errors(self) -> float:
        """Difference in standard errors of the test's mean; NaN where there are none."""
        return self.difference / self.error if self.error > 0 else math.nan

    @property
    def outside(self) -> bool | None:
        """Whether the model lies outside the 95 % interval of the test; None where that cannot be told."""
        if not math.isfinite(self.in_errors):
            return None
        return abs(self.in_errors) > float(stdtrit(self.repeats - 1, 0.975))


def jackknife(values: Array, told: Callable[[Array], float]) -> tuple[float, float]:
    """What ``told`` makes of the mean of ``values`` (repeats, angles), and its standard error by leaving out one repeat at a time."""
    repeats = len(values)
    whole = told(values.mean(axis=0))
    if repeats < 2:
        return whole, math.nan
    total = values.sum(axis=0)
    parts = np.array([told((total - one) / (repeats - 1)) for one in values])
    if not np.all(np.isfinite(parts)):
        return whole, math.nan
    return whole, math.sqrt((repeats - 1) / repeats * float(np.sum((parts - parts.mean()) ** 2)))


def extreme_rows(name: str, cam_angle: Array, values: Array, model: Array, inside: NDArray[np.bool_], sign: float) -> list[EventRow]:
    """Largest (``sign`` 1) or least (-1) value within ``inside``, and its angle; the angle only of one that stands alone within."""
    places = np.flatnonzero(inside)
    if len(places) < 3:
        return []

    def value(curve: Array) -> float:
        return sign * _top(cam_angle, sign * curve, places)[1]

    def angle(curve: Array) -> float:
        return _top(cam_angle, sign * curve, places)[0]

    rows = []
    for dimension, told in (("value", value), ("angle", angle)):
        test, error = jackknife(values, told)
        rows.append(EventRow(name, dimension, told(model), test, error, len(values)))
    if _rivalled(sign * values.mean(axis=0)[places], rows[0].error):
        return rows[:1]
    ends = {int(places[0]), int(places[-1])} if len(places) < len(cam_angle) else set()
    at_end = any(int(places[np.argmax(sign * curve[places])]) in ends for curve in (model, values.mean(axis=0)))
    return rows[:1] if at_end else rows


def _rivalled(curve: Array, error: float) -> bool:
    """Whether another maximum is as high but for what the repeats scatter, so that the place of the largest is a matter of chance."""
    near = RIVAL * error if error > 0 else 0.01 * float(np.ptp(curve))
    peaks = prominent_peaks(curve, max(near, 1e-12))
    return int(np.sum(curve[peaks] > float(curve.max()) - near)) > 1


def _top(cam_angle: Array, curve: Array, places: NDArray[np.int64]) -> tuple[float, float]:
    """Angle and height of the largest of ``curve`` at ``places``, by the parabola through it and its neighbours on the ring."""
    count = len(curve)
    top = int(places[np.argmax(curve[places])])
    before, here, after = (float(curve[(top + step) % count]) for step in (-1, 0, 1))
    bend = before - 2 * here + after
    steps = [float((cam_angle[(top + step + 1) % count] - cam_angle[(top + step) % count]) % _TURN) for step in (-1, 0)]
    if not bend < 0 or here < before or here < after or abs(steps[0] - steps[1]) > 0.01 * steps[0]:
        return float(cam_angle[top]), here
    return float(cam_angle[top]) + steps[0] * (before - after) / (2 * bend), here - (after - before) ** 2 / (8 * bend)


def spike_rows(cam_angle: Array, values: Array, model: Array) -> list[EventRow]:
    """Maxima that stand out of the mean of ``values`` (repeats, angles), each beside the model's: height and angle; and the mean
    distance of those that follow each other where three or more are met."""
    mean = values.mean(axis=0)
    error = float(np.sqrt(np.mean(np.var(values, axis=0, ddof=1)) / len(values))) if len(values) > 1 else 0.0
    least = max(SPIKE_SHARE * float(np.ptp(mean)), SPIKE_ERRORS * error)
    theirs, mine = _spikes(mean, least), _spikes(model, 0.5 * least, 3 * MOST_SPIKES)
    angles = [float(cam_angle[place]) for place in theirs]
    partners = pair_angles(angles, [float(cam_angle[place]) for place in mine]) if len(theirs) else []
    rows: list[EventRow] = []
    half = 0.5 * MEETING
    for count, (angle, partner) in enumerate(zip(angles, partners, strict=True), start=1):
        met = partner is not None and abs((partner - angle + math.pi) % _TURN - math.pi) <= MEETING
        around = np.abs((cam_angle - angle + math.pi) % _TURN - math.pi) <= 0.5 * _room(angles, angle, half)
        for dimension in ("value", "angle"):
            column = 1 if dimension == "value" else 0
            test, spread = jackknife(values, lambda curve, c=column, a=around: _top(cam_angle, curve, np.flatnonzero(a))[c])  # type: ignore[misc]
            ours = math.nan
            if met and partner is not None:
                ours = _top(cam_angle, model, np.flatnonzero(cam_angle == partner))[column]
            rows.append(EventRow(f"spike {count}", dimension, ours, test, spread, len(values)))
    return rows


def _room(angles: list[float], angle: float, most: float) -> float:
    """Angle (rad) in which a spike may be looked for: less than the distance of its neighbour."""
    others = [abs((other - angle + math.pi) % _TURN - math.pi) for other in angles if other != angle]
    return min([most, *others])


def _spikes(curve: Array, least: float, most: int = MOST_SPIKES) -> list[int]:
    """Places of the most prominent maxima of a ring, in order."""
    count = len(curve)
    start = int(np.argmin(curve))
    turned = np.append(np.roll(curve, -start), curve[start])
    peaks = prominent_peaks(turned, least)
    strongest = peaks[np.argsort(-prominences(turned, peaks), kind="stable")[:most]]
    return sorted((int(place) + start) % count for place in strongest)


def interval_row(rows: list[EventRow], first: float, last: float) -> EventRow | None:
    """Mean distance (rad) of the spikes between two cam angles that model and test both show; None for fewer than two."""
    told = [one for one in rows if one.dimension == "angle" and math.isfinite(one.model) and first <= one.test < last]
    if len(told) < 2:
        return None
    count = len(told) - 1
    ends = told[0], told[-1]
    model, test = ((getattr(ends[1], side) - getattr(ends[0], side)) / count for side in ("model", "test"))
    error = math.hypot(ends[0].error, ends[1].error) / count
    return EventRow(f"interval of {count + 1} spikes", "angle", model, test, error, ends[0].repeats)
