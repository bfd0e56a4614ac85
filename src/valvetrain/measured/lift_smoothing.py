"""Lift, velocity, acceleration and jerk behind noisy stations, each with its uncertainty.

The stations are a law plus noise, which is independent but for the rounding of the table; the law
is a spline that rests on the base circle at both ends and whose jerk is white noise of a scale that
varies along the event. Both scales are those of largest marginal likelihood, so no acceleration is
invented that the stations do not support, and what they leave open, between them too, is the spread
of the posterior (Wahba, J. R. Stat. Soc. B 45, 1983; Patterson and Thompson, Biometrika 58, 1971,
for the likelihood). Rounding is a sawtooth of the lift, so its error is alike in stations of almost
the same lift; its covariance is the sawtooth's Fourier series (Widrow, IRE Trans. CT-3, 1956).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array, Flags
from valvetrain.errors import InputError
from valvetrain.measured.stations import events_of, last_digit
from valvetrain.solution.display import Shown
from valvetrain.units import si_array

DEGREE = 5
TURN = 2 * np.pi
#: Rounds in which the local scale of the jerk is found; the first has one scale for the whole
#: event.
ROUNDS = 4
#: Intervals of knots, and angle (rad), on either side over which the scale of the jerk is averaged;
#: least share of its largest value.
WINDOW, WINDOW_ANGLE, MIN_SHARE = 5, np.radians(5), 1e-3
#: Knots at most: where stations are closer they share them, for what a lobe does within a third
#: of a degree is in no table. Elsewhere there are two a station, and none (rad) further apart, for what
#: stations leave open between them.
MAX_KNOTS, MAX_SPACING = 400, np.radians(1.5)
#: Bounds (m) and number of trials of the noise where it is not stated, and of the ratio of the two
#: variances.
NOISE_BOUNDS = (1e-9, 1e-3)
#: Terms of the Fourier series of a rounding error; those beyond count as independent.
HARMONICS = 4
#: What a station of the base circle says of the noise, next to one of the event: the surface is another.
SCATTER = 0.5
#: Error of a base circle that reads zero, since a gauge is zeroed there by eye, next to the rounding error of another reading.
ZEROED = 0.5
#: Stations of the base circle, and angle (rad), on either side that belong to the fit: data
#: below the noise there is of the ramp.
MARGIN, MARGIN_ANGLE = 3, np.radians(3)
#: Angle (rad) next to the flanks in which there may be a ramp; the base circle is read off beyond it.
RAMP_ANGLE = np.radians(25)
#: Quantile of the bands: 95 % of a normal distribution are within.
BAND = 1.959963984540054


@dataclass(frozen=True, eq=False)
class SmoothedLift(Shown):
    """A lift with its uncertainty: splines of degree 5 on ``knots`` (rad) with ``coefficients``
    (m), the mean, and what spreads about it.

    ``factor`` (free, free): draws are coefficients plus factor @ standard normal numbers. ``noise``
    (m): standard deviation of a station; ``base`` (m): level of the base circle that was taken off,
    ``runout`` (m) the standard deviation of its stations. ``cam_angles``, ``residuals`` (rad, m) of
    the stations of the event. ``widened``: whether the smoothing was weakened to meet a band.

    >>> angles = np.radians(np.arange(90.0, 271.0))
    >>> stations = 9e-3 * np.clip(1 - ((angles - np.pi) / np.radians(60)) ** 2, 0, None) ** 3
    >>> lobe = smooth_lift(angles, stations + np.random.default_rng(1).normal(0, 3e-6, len(angles)))
    >>> abs(float(lobe.lift(np.pi)) - 9e-3) < 4 * float(lobe.spread(np.pi))
    True
    """

    knots: Array
    coefficients: Array
    factor: Array
    noise: float
    base: float
    runout: float
    cam_angles: Array
    residuals: Array
    widened: bool = False

    def __repr__(self) -> str:
        first, last = np.degrees(self.event)
        peak = 1e3 * float(np.max(self.lift(np.linspace(*self.event, 721))))
        return f"SmoothedLift: {first:.1f} to {last:.1f} cam deg, peak {peak:.4f} mm, noise {1e6 * self.noise:.2g} um"

    @property
    def event(self) -> tuple[float, float]:
        """First and last cam angle (rad) of the event."""
        return float(self.knots[0]), float(self.knots[-1])

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        """Mean of the lift (m) or its ``derivative`` (m/rad**derivative), zero outside the event,
        of the shape of ``cam_angle``.
        """
        return self.evaluated(self.coefficients, cam_angle, derivative)

    def spread(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        """Standard deviation of the same."""
        inside, angle = self._inside(cam_angle)
        rows = (
            _design(self.knots, angle.ravel(), derivative)[:, _free(len(self.coefficients))]
            @ self.factor
        )
        return np.where(
            inside, np.sqrt(np.einsum("ij,ij->i", rows, rows)).reshape(angle.shape), 0.0
        )

    def draws(self, count: int, seed: int = 0) -> Array:
        """Coefficients (count, coefficients) of laws that the stations allow; the same ``seed``
        gives the same laws.
        """
        numbers = np.random.default_rng(seed).standard_normal((count, self.factor.shape[1]))
        found = np.tile(self.coefficients, (count, 1))
        # one by one: the bits of a draw do not depend on how many there are
        found[:, _free(len(self.coefficients))] += np.array(
            [self.factor @ row for row in numbers]
        ).reshape(count, -1)
        return found

    def evaluated(self, coefficients: Array, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        """As :meth:`lift` with other ``coefficients`` (m), such as a row of :meth:`draws`."""
        from scipy.interpolate import BSpline

        inside, angle = self._inside(cam_angle)
        return np.where(
            inside, BSpline(self.knots, coefficients, DEGREE)(angle, nu=derivative), 0.0
        )

    def _inside(self, cam_angle: ArrayLike) -> tuple[Flags, Array]:
        first, last = self.event
        angle = first + np.mod(np.asarray(cam_angle, dtype=float) - first, TURN)
        return angle <= last, np.minimum(angle, last)


def smooth_lift(
    cam_angles: ArrayLike, lifts: ArrayLike, noise: float | None = None, band: float | None = None
) -> SmoothedLift:
    """The law behind noisy stations.

    Parameters
    ----------
    cam_angles, lifts : (stations,) cam rad, rising within one revolution, and m, or quantities with a
        unit; the base circle on both sides may be part of it
    noise : standard deviation (m) of one station; None to find it
    band : (m) by which the mean may leave a station at most; None for no such bound

    Returns
    -------
    SmoothedLift with mean and spread of lift, velocity, acceleration and jerk

    Raises
    ------
    InputError : degrees or millimetres given as rad or m, no lift above the base circle, an event cut off, too few stations, a noise that is
        not positive

    Examples
    --------
    >>> angles = np.radians(np.arange(100.0, 261.0))
    >>> true = 9e-3 * np.clip(np.cos((angles - np.pi) / (2 * np.radians(60) / np.pi)), 0, None) ** 4
    >>> smooth = smooth_lift(angles, true + np.random.default_rng(1).normal(0, 3e-6, len(angles)))
    >>> bool(2e-6 < smooth.noise < 4e-6)
    True
    """
    angles = si_array(cam_angles, "cam_angle", "cam_angles")
    raw = si_array(lifts, "valve_lift", "lifts")
    for name, value in (("noise", noise), ("band", band)):
        if value is not None and not 0 < value < NOISE_BOUNDS[1]:
            raise InputError(
                f"{name} is a length above zero and below 1 mm, such as 0.003 mm; it is {value * 1e3:g} mm",
                name,
            )
    rounding, events = last_digit(raw), events_of(angles, raw)
    if len(events) > 1:
        raise InputError(
            f"the stations hold {len(events)} events, but a lift law has one; give those of one, or name it as lobe of a file"
        )
    begin, end, base, runout, rest = _event(angles, raw, noise, rounding)
    raw = raw - base
    if band is not None:  # the law is zero at the first and last of its stations
        begin = max([at for at in range(begin + 1) if abs(raw[at]) <= band], default=begin)
        end = min([at for at in range(end, len(raw)) if abs(raw[at]) <= band], default=end)
    angles, raw = angles[begin : end + 1], raw[begin : end + 1]
    start = runout if noise is None and runout > 0 else noise
    zeroed = ZEROED if rest and base == 0 else 1.0
    fit = _Fit(angles, raw, start, noise is not None, rounding, rest, runout, zeroed)
    ratio = fit.ratio
    mean = fit.mean(ratio)
    widened = False
    if band is not None:
        while np.max(np.abs(fit.basis @ mean - raw)) > band and ratio < 1e14 * fit.ratio:
            ratio, widened = 4 * ratio, True
            mean = fit.mean(ratio)
    coefficients = np.zeros(fit.count)
    coefficients[_free(fit.count)] = mean
    return SmoothedLift(
        fit.knots,
        coefficients,
        np.column_stack([fit.factor(ratio), fit.shifted(ratio)]),
        fit.noise,
        base,
        runout,
        angles,
        raw - fit.basis @ mean,
        widened,
    )


class _Fit:
    """Normal equations of the event, with the scale of the jerk along it and the noise that are
    likeliest. ``rounding`` (m) of the stations; ``rest`` is the number of those behind the base circle.
    """

    def __init__(
        self, angles: Array, lifts: Array, noise: float | None, stated: bool, rounding: float,
        rest: int, runout: float, zeroed: float
    ) -> None:  # fmt: skip
        sites = angles
        if len(angles) > MAX_KNOTS:
            sites = angles[np.round(np.linspace(0, len(angles) - 1, MAX_KNOTS)).astype(int)]
        spacing = float(np.median(np.diff(sites)))
        if not rest:  # where no base circle is left, the acceleration may end in a jump
            sites = np.concatenate([[sites[0] - MARGIN_ANGLE], sites, [sites[-1] + MARGIN_ANGLE]])
        parts = max(1 + (2 * len(sites) < MAX_KNOTS), int(np.ceil(spacing / MAX_SPACING - 1e-9)))
        sites = np.interp(
            np.arange(parts * (len(sites) - 1) + 1) / parts, np.arange(len(sites)), sites
        )
        self.knots = np.concatenate([np.full(DEGREE, sites[0]), sites, np.full(DEGREE, sites[-1])])
        self.count = len(self.knots) - DEGREE - 1
        free = _free(self.count)
        basis = _design(self.knots, angles)[:, free]
        self.basis = basis
        nodes, weights = np.polynomial.legendre.leggauss(4)
        self.points = (sites[:-1, None] + np.diff(sites)[:, None] * (nodes + 1) / 2).ravel()
        self.weights = (np.diff(sites)[:, None] * weights / 2).ravel()
        self.window = parts * max(WINDOW, round(WINDOW_ANGLE / spacing))
        self.jerk = _design(self.knots, self.points, 3)[:, free]
        least = rounding / np.sqrt(12)
        scale: Array = np.ones(len(self.points))
        self.noise, self.alone, self.lifts = max(noise or 0.0, least), 1.0, lifts
        for round_ in range(ROUNDS):
            self.penalty = (self.jerk * (self.weights / scale)[:, None]).T @ self.jerk
            self.noise, self.ratio = _likeliest(
                basis,
                self.penalty,
                lifts,
                max(noise or 0.0, least),
                stated,
                least,
                (SCATTER * rest, runout),
            )
            if round_ < ROUNDS - 1:
                scale = self._local_scale()
        mean = basis @ self.mean(self.ratio)
        shared = _rounded(mean, self.noise, rounding)
        coherent = float(np.sum(shared[0] ** 2))
        self.alone = 1 - coherent / self.noise**2
        # what the base circle is off by is in every station but those that read as it does
        read = zeroed**2 * coherent * (np.abs(mean) > rounding / 2)
        base = np.sqrt(read + self.noise**2 / max(rest, 1) * (rest > 0))
        self.shared = np.column_stack([base, shared])

    def mean(self, ratio: float) -> Array:
        """Coefficients at a ratio of the variance of the jerk to that of the noise."""
        return self._solved(ratio, self.lifts)

    def _solved(self, ratio: float, values: Array) -> Array:
        whole = self.basis.T @ self.basis + self.penalty / ratio
        return np.asarray(np.linalg.solve(whole, self.basis.T @ values), dtype=float)

    def factor(self, ratio: float) -> Array:
        """Square root of the covariance of the coefficients."""
        told = self.basis.T @ self.basis
        inner = np.linalg.cholesky(self.alone * told + self.penalty / ratio)
        found: Array = self.noise * np.linalg.solve(told + self.penalty / ratio, inner)
        return found

    def shifted(self, ratio: float) -> Array:
        """What one standard deviation of each error that stations share does to the coefficients: the stations cannot tell it."""
        return self._solved(ratio, self.shared)

    def _local_scale(self) -> Array:
        """Expected square of the jerk at the points, averaged over some stations, its largest value
        one.
        """
        mean, spread = self.jerk @ self.mean(self.ratio), self.jerk @ self.factor(self.ratio)
        square = mean**2 + np.einsum("ij,ij->i", spread, spread)
        per = square.reshape(-1, 4).mean(axis=1)
        kernel = np.ones(2 * min(self.window, (len(per) - 1) // 2) + 1)
        smooth = np.convolve(per, kernel, "same") / np.convolve(np.ones(len(per)), kernel, "same")
        return np.asarray(np.repeat(np.maximum(smooth / smooth.max(), MIN_SHARE), 4), dtype=float)


def _likeliest(
    design: Array, penalty: Array, lifts: Array, noise: float | None, stated: bool, least: float,
    rest: tuple[float, float]
) -> tuple[float, float]:  # fmt: skip
    """Noise (m), at ``least`` that, and ratio of variances of largest marginal likelihood; a ``stated`` noise is retained."""
    from scipy.linalg import solve_triangular
    from scipy.optimize import minimize_scalar

    lower = np.linalg.cholesky(
        penalty + 1e-14 * np.trace(penalty) / len(penalty) * np.eye(len(penalty))
    )
    half = solve_triangular(lower, design.T, lower=True)
    vectors, sizes, _ = np.linalg.svd(half.T, full_matrices=False)
    along, sizes = vectors.T @ lifts, sizes**2
    across = max(float(lifts @ lifts - along @ along), 0.0)
    count = len(lifts) + rest[0]
    across += rest[0] * rest[1] ** 2

    def at(log_ratio: float) -> tuple[float, float]:
        """Minus twice the log likelihood, and the noise it has."""
        spread = 1 + np.exp(log_ratio) * sizes
        square = float(np.sum(along**2 / spread)) + across
        variance = (
            noise**2 if stated and noise else max(square / count, least**2, NOISE_BOUNDS[0] ** 2)
        )
        return square / variance + count * np.log(variance) + float(
            np.sum(np.log(spread))
        ), variance

    middle = -np.log(float(np.median(sizes)))
    grid = middle + np.linspace(-40, 40, 81)
    best = int(np.argmin([at(place)[0] for place in grid]))
    found = minimize_scalar(
        lambda place: at(place)[0],
        bounds=(grid[max(best - 1, 0)], grid[min(best + 1, 80)]),
        method="bounded",
    )
    return float(np.sqrt(at(found.x)[1])), float(np.exp(found.x))


def _rounded(lifts: Array, noise: float, rounding: float) -> Array:
    """Columns (stations, 2 x :data:`HARMONICS`) whose products are the covariance (m2) of the rounding errors that stations
    share which have nearly the same lift (m): reading noise blurs the phase of the sawtooth.
    """
    if not rounding:
        return np.zeros((len(lifts), 1))
    loose = max(noise**2 - rounding**2 / 12, 0.0)
    turns = 2 * np.pi / rounding * np.arange(1, HARMONICS + 1)
    sizes = np.sqrt(2) / turns * np.exp(-loose * turns**2 / 2)
    phases = lifts[:, None] * turns
    return np.hstack([sizes * np.cos(phases), sizes * np.sin(phases)])


def _event(
    angles: Array, lifts: Array, noise: float | None, rounding: float
) -> tuple[int, int, float, float, int]:  # fmt: skip
    """First and last station of the event, level of the base circle (m), the scatter of its
    stations (m) and how many they are.
    """
    top = float(lifts.max())
    low = lifts < lifts.min() + 0.02 * float(np.ptp(lifts))
    if len(lifts) < 8 or top <= 0 or not np.ptp(lifts) > 0:
        raise InputError(
            "the table holds no lift above its base circle, or fewer than eight stations; check the unit"
        )
    nose = int(np.argmax(lifts))
    left, right = np.flatnonzero(low[:nose]), np.flatnonzero(low[nose:])
    if not len(left) or not len(right):
        raise InputError(
            "a table of lifts must begin and end on the base circle; add its stations on both sides"
        )
    begin, end = int(left[-1]), nose + int(right[0])
    first = int(np.searchsorted(angles, angles[begin] - RAMP_ANGLE + 1e-9)) - 1
    last = int(np.searchsorted(angles, angles[end] + RAMP_ANGLE - 1e-9)) + 1
    rest = np.concatenate([lifts[: max(first, 0)], lifts[last:]])
    if len(rest) < 4:
        return 0, len(lifts) - 1, 0.0, 0.0, 0
    # a ramp, dust or a slip may reach into these stations, so what is far off counts no more than its neighbours
    middle = float(np.median(rest))
    reach = max(3 * 1.4826 * float(np.median(np.abs(rest - middle))), rounding)
    kept = np.clip(rest, middle - reach, middle + reach)
    base, runout = float(np.mean(kept)), float(np.std(kept))
    threshold = base + max(4 * (noise or runout), 1e-7)
    while begin > 0 and lifts[begin] > threshold:
        begin -= 1
    while end < len(lifts) - 1 and lifts[end] > threshold:
        end += 1
    # the lift below the noise: as wide as it takes from there to eight times as much, which is its start where it goes as t^3
    high = np.flatnonzero(lifts > base + 8 * max(threshold - base, rounding))
    widths = (
        (angles[high[0]] - angles[begin], angles[end] - angles[high[-1]])
        if len(high)
        else (0.0, 0.0)
    )
    before, after = np.clip(widths, MARGIN_ANGLE, RAMP_ANGLE)
    first = min(begin - MARGIN, int(np.searchsorted(angles, angles[begin] - before - 1e-9)))
    last = max(end + MARGIN, int(np.searchsorted(angles, angles[end] + after + 1e-9)) - 1)
    return max(first, 0), min(last, len(lifts) - 1), base, runout, len(rest)


def _design(knots: Array, angles: Array, derivative: int = 0) -> Array:
    """Values (angles, coefficients) of the basis or its derivative."""
    from scipy.interpolate import BSpline

    count = len(knots) - DEGREE - 1
    basis: Any = BSpline(knots, np.eye(count), DEGREE)
    found: Array = basis(angles, nu=derivative)
    return found


def _free(count: int) -> slice:
    """Coefficients that are not held at zero: lift, velocity and acceleration vanish at both ends."""
    return slice(3, count - 3)
