"""What the stations of a spring tester say without any model of the wire: contact, rate, force and
solid height, each with its standard deviation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2, t

from valvetrain.arrays import Array

#: Slope of the table over its typical slope from which the coils are taken to be bound.
BOUND = 5.0
#: The same for the last interval alone, over the largest slope before it.
STIFFER = 2.2
#: Stations from which on the scatter is read off the stations themselves, and those of the window
#: that does so.
MANY, WINDOW = 12, 7
#: Chance with which a parabola that fits is refused, and share of a window that it keeps per step.
REFUSED, NARROWER = 0.1, 0.8


class Estimate(NamedTuple):
    """A ``value`` and its standard ``deviation``, SI."""

    value: float
    deviation: float


@dataclass(frozen=True, eq=False)
class Parabola:
    """A parabola (a line for few stations) through the stations about ``place``: ``coefficients`` by
    rising power of the distance to it and their ``covariance``; ``share`` of the stations it holds for.
    """

    place: float
    coefficients: Array
    covariance: Array
    share: float

    def at(self, place: float, derivative: int = 0) -> Estimate:
        """The value there, or the slope (``derivative`` 1)."""
        row = self.row(place, derivative)
        return Estimate(float(row @ self.coefficients), float(np.sqrt(row @ self.covariance @ row)))

    def row(self, place: float, derivative: int = 0) -> Array:
        """What the coefficients are multiplied by for the value there, or for the slope."""
        powers, away = np.arange(len(self.coefficients)), place - self.place
        if derivative:
            return np.asarray(powers * away ** np.maximum(powers - 1, 0), dtype=float)
        return np.asarray(away**powers, dtype=float)

    def root(self, level: float, start: float) -> Estimate:
        """Place nearest to ``start`` at which the value is ``level``."""
        place = start
        for _ in range(30):
            value, slope = self.at(place).value, self.at(place, 1).value
            if slope <= 0:
                break
            step = float(np.clip((level - value) / slope, -self.place / 2 - 1, self.place / 2 + 1))
            place += step
            if abs(step) < 1e-12:
                break
        slope = max(self.at(place, 1).value, 1e-300)
        return Estimate(place, self.at(place).deviation / slope)


@dataclass(frozen=True, eq=False)
class ForceCurve:
    """Stations by rising ``travel`` (m) with their ``force`` (N), the ``scatter`` (N) of a station, the
    stations ``first`` to ``last`` (not included) between contact and coil bind, those from ``hard`` on
    in coil bind, the ``quiet_force`` (N) that the tester shows before contact, and the last ``digit``
    (m) of the travel.

    >>> travel = np.linspace(0.0, 20e-3, 41)
    >>> curve = force_curve(travel, 40e3 * travel + 0.1 * np.sin(1e6 * travel))
    >>> round(curve.rate_at(10e-3).value / 1e3, 1), curve.bind()
    (40.0, None)
    """

    travel: Array
    force: Array
    scatter: float
    first: int
    last: int
    hard: int
    quiet_force: float = 0.0
    digit: float = 0.0

    @property
    def elastic(self) -> tuple[Array, Array]:
        """Travel and force between contact and coil bind."""
        return self.travel[self.first : self.last], self.force[self.first : self.last]

    def near(self, place: float) -> Parabola:
        """The parabola about ``place`` over the widest window that it fits within the scatter."""
        travel, force = self.elastic
        half = float(max(place - travel[0], travel[-1] - place))
        least = min(6 if len(travel) > 8 else 4, len(travel))
        distance = np.abs(travel - place)
        narrowest = np.partition(distance, least - 1)[least - 1]
        while True:
            near = distance <= max(half, narrowest)
            fit = self._through(travel[near], force[near], place)
            if fit is not None or half <= narrowest:
                break
            half *= NARROWER
        fit = fit or self._through(travel[near], force[near], place, True)
        assert fit is not None
        return fit

    def _through(
        self, travel: Array, force: Array, place: float, whatever: bool = False
    ) -> Parabola | None:
        """The parabola through stations; None where it misses them by more than the scatter, unless
        ``whatever`` it misses.
        """
        count = min(3, max(2, len(travel) - 2))
        unit = float(np.ptp(travel)) or 1.0
        powers = ((travel - place) / unit)[:, None] ** np.arange(count)
        coefficients, *_ = np.linalg.lstsq(powers, force, rcond=None)
        spare, left = len(travel) - count, float(np.sum((powers @ coefficients - force) ** 2))
        few = len(self.travel) < MANY
        if not (few or whatever) and left > self.scatter**2 * chi2.isf(REFUSED, spare):
            return None
        deviation = self.scatter
        if spare > 0 and (few or whatever):
            wider = float(t.isf(0.025, spare) / 1.96)
            deviation = max(deviation, wider * np.sqrt(left / spare))
        scale = unit ** -np.arange(count, dtype=float)
        covariance = deviation**2 * np.linalg.pinv(powers.T @ powers) * np.outer(scale, scale)
        share = len(travel) / max(self.last - self.first, 1)
        return Parabola(place, coefficients * scale, covariance, share)

    def contact(self) -> Estimate:
        """Travel (m) at which the spring begins to press."""
        start = float(self.travel[self.first])
        near = self.near(start)
        root = near.root(self.quiet_force, start)
        span = float(self.travel[self.last - 1] - start)
        if root.deviation > span:
            return Estimate(start, span)
        beyond = start - root.value
        if near.share > 0.9 or beyond <= 0.1 * span:
            return root
        # Far from the stations the curvature is a guess: the line's answer counts as much.
        line = near.at(start)
        other = start - (line.value - self.quiet_force) / near.at(start, 1).value
        return Estimate(root.value, float(np.hypot(root.deviation, (root.value - other) / 2)))

    def force_at(self, place: float, from_contact: bool = False) -> Estimate:
        """Force (N) at a travel (m); ``from_contact``: at a travel beyond contact, wherever that is."""
        near = self.near(place)
        value, deviation = near.at(place)
        if not from_contact:
            return Estimate(value, deviation)
        contact = self.contact()
        ratio = near.at(place, 1).value / near.at(contact.value, 1).value
        if near.share > 0.9:  # one parabola makes both: what moves contact moves the force too
            row = near.row(place) - ratio * near.row(contact.value)
            return Estimate(value, float(np.sqrt(row @ near.covariance @ row)))
        slope = near.at(place, 1).value
        return Estimate(value, float(np.hypot(deviation, slope * contact.deviation)))

    def rate_at(self, place: float) -> Estimate:
        """Rate (N/m) at a travel (m)."""
        return self.near(place).at(place, 1)

    def bind(self) -> Estimate | None:
        """Travel (m) at which the coils are bound; None where the stations end before."""
        travel, force = self.travel[self.hard :], self.force[self.hard :]
        if not len(travel):
            return None
        before, first = float(self.travel[self.last - 1]), float(travel[0])
        if len(travel) >= 3:
            soft = self.near(before)
            slope, level = np.polyfit(travel - before, force, 1)
            stiffer = max(slope - soft.at(before, 1).value, 1e-300)
            away = float((soft.at(before).value - level) / stiffer)
            left, middle = (
                force - slope * (travel - before) - level,
                float(np.mean(travel)) - before,
            )
            spare = len(left) - 2
            spread = float(np.hypot(self.scatter / stiffer, self.digit / np.sqrt(12)))
            if left @ left > (stiffer * spread) ** 2 * chi2.isf(0.05, spare):
                spread = float(t.isf(0.025, spare) / 1.96 * np.sqrt(left @ left / spare)) / stiffer
            square = float(np.sum((travel - before - middle) ** 2))
            inner = spread * np.sqrt(1 / len(travel) + (middle - away) ** 2 / square)
            deviation = float(np.hypot(inner, soft.at(before).deviation / stiffer))
            if -2 * deviation <= away <= first - before + 2 * deviation:
                return Estimate(before + away, deviation)
        return Estimate((before + first) / 2, (first - before) / np.sqrt(12.0))


def force_curve(
    travel: Array, force: Array, scatter: float = 0.0, digit: float = 0.0
) -> ForceCurve:
    """The curve behind stations by rising travel (m) with its last ``digit`` (m); ``scatter`` (N) is the
    least that is believed.

    The scatter is read off the stations where there are many of them, as what parabolas over seven
    neighbours leave.
    """
    least = max(scatter, 1e-6 * float(np.max(np.abs(force))))
    if len(travel) >= MANY:
        least = max(least, _local_scatter(travel, force))
    first, quiet = _first_pressed(travel, force, least)
    curve = ForceCurve(travel, force, least, first, len(travel), len(travel), quiet, digit)
    last, hard = _bound_stations(curve)
    curve = replace(curve, last=last, hard=hard)
    if not first:  # stations within the scatter of contact do not press
        place = curve.contact()
        before = int(np.count_nonzero(travel < place.value))
        curve = replace(curve, first=before if before + MANY <= curve.last else 0)
    return curve


def _local_scatter(travel: Array, force: Array) -> float:
    """Standard deviation (N) of a station about parabolas through its neighbours."""
    spare, left = WINDOW - 3, []
    for start in np.unique(np.linspace(0, len(travel) - WINDOW, 2000).astype(int)):
        near = slice(start, start + WINDOW)
        places = (travel[near] - travel[start]) / (travel[start + WINDOW - 1] - travel[start])
        powers = places[:, None] ** np.arange(3)
        off = force[near] - powers @ np.linalg.lstsq(powers, force[near], rcond=None)[0]
        left.append(float(off @ off))
    return float(np.sqrt(np.median(left) / chi2.median(spare)))


def _first_pressed(travel: Array, force: Array, scatter: float) -> tuple[int, float]:
    """Number of the first station after contact and the force (N) before it; 0 and 0 where no station
    lies clearly before contact.
    """
    top = float(np.max(force))
    low = (force > 0.05 * top) & (force < 0.35 * top)
    if np.count_nonzero(low) < 3:
        return 0, 0.0
    slope, level = np.polyfit(travel[low], force[low], 1)
    before = int(np.count_nonzero(travel < -level / slope)) if slope > 0 else 0
    early = slice(0, (before + 1) // 2)
    if before < 4:  # too few to show a slope, but they hardly press
        rise = slope * float(travel[1] - travel[0])
        return (
            (before, 0.0) if np.all(np.abs(force[:before]) < 0.1 * rise + 4 * scatter) else (0, 0.0)
        )
    away = travel[early] - np.mean(travel[early])
    quiet, creep = float(np.mean(force[early])), float(away @ force[early] / (away @ away))
    unsure = scatter / float(np.sqrt(away @ away))
    if creep + 2 * unsure > 0.4 * slope or abs(quiet) > 0.05 * top:
        return (before if creep - 2 * unsure < 0.4 * slope else 0), 0.0
    still = np.flatnonzero(force[:before] <= quiet + 4 * scatter)
    zero_is_off = abs(quiet) > 5 * scatter / np.sqrt(len(away))
    return int(still[-1]) + 1, quiet if zero_is_off else 0.0


def _bound_stations(curve: ForceCurve) -> tuple[int, int]:
    """Count of stations that are clearly not in coil bind, and number of the first that clearly is."""
    count, (travel, force) = len(curve.travel), curve.elastic
    if len(travel) < 5:
        return count, count
    coarse = slice(None, None, max(1, len(force) // 40))
    typical = float(np.median(np.diff(force[coarse]) / np.diff(travel[coarse])))
    if typical <= 0:
        return count, count
    apart, picked = max(10 * curve.scatter / typical, float(np.ptp(travel)) / 200), [0]
    for number, place in enumerate(travel):
        if place - travel[picked[-1]] >= apart:
            picked.append(number)
    if len(picked) < 3:
        return count, count
    picked[-1] = len(travel) - 1
    slopes = np.diff(force[picked]) / np.diff(travel[picked])
    steep = slopes > BOUND * typical
    steep[-1] |= slopes[-1] > STIFFER * np.max(slopes[:-1])
    last = float((force[-1] - force[-2]) / (travel[-1] - travel[-2]))
    if not steep[-1] and last > BOUND * typical and force[-1] - force[-2] > 8 * curve.scatter:
        return count - 1, count - 1
    if len(picked) < 5 or not steep[-1]:
        return count, count
    soft = picked[len(steep) - int(np.argmin(steep[::-1])) - 1] if not steep.all() else 0
    if soft < 3:
        return count, count
    end = curve.first + soft + 1
    near = replace(curve, last=end).near(float(travel[soft]))
    beyond = np.array([near.at(float(place)).value for place in travel[soft:]])
    off = force[soft:] - beyond > 5 * curve.scatter + typical / 2 * (travel[soft:] - travel[soft])
    hard = count - int(np.argmin(off[::-1])) if not off.all() else end
    return end, hard
