"""Fisher's test of adequacy: does a model miss the mean of repeats by more than the repeats miss
each other?

The ratio is that of lack of fit to pure error. Values along the cam angle follow their neighbours,
so degrees of freedom are counted by how the repeats move together along the angle (Box 1954; Shen
and Faraway 2004 for curves), not by how densely the angle was sampled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import chdtri, fdtrc, fdtri, stdtr, stdtrit

from valvetrain.arrays import Array, Flags
from valvetrain.errors import InputError

#: Degrees of freedom from which on more make no difference beyond some 1e-8.
MANY = 1e8
#: Share of adequate models that a test may refute.
LEVEL = 0.05
#: A gap in the angles counts as this many steps at most.
WIDEST = 4.0
#: Steps of a ring of angles that differ by less than this share of the median are even.
EVEN = 0.01


@dataclass(frozen=True, slots=True)
class AdequacyTest:
    """Fisher's test of a model against repeats.

    Parameters
    ----------
    mean_square : mean square of model less mean of repeats, times the number of repeats; square of
        the unit
    reproducibility : variance between repeats; with stated scatters both are in units of them and
        this is 1
    repeats : number of repeats; 0 where scatters are stated
    places : angles or values compared
    independent : how many of them are independent
    fitted : parameters of the model that were found from these values
    shared : mean square of each error that all repeats share, of calibration or angle, square of
        the unit

    Raises
    ------
    InputError : repeats that are all the same, more fitted parameters than independent places

    Examples
    --------
    Lack of fit of a straight line, by hand: 3 places with 2 repeats each, 2 parameters fitted.

    >>> test = AdequacyTest(mean_square=3.0, reproducibility=2.0, repeats=2, places=3, independent=3.0, fitted=2)
    >>> round(test.ratio, 2), test.degrees, round(test.critical, 2), test.adequate
    (4.5, (1.0, 3.0), 10.13, True)
    """

    mean_square: float
    reproducibility: float
    repeats: int
    places: int
    independent: float
    fitted: int = 0
    shared: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if not self.reproducibility > 0:
            raise InputError(
                "the repeats are the same number by number, so they show no scatter; give repeats as they were measured"
            )
        if self.fitted >= self.independent:
            raise InputError(
                f"{self.fitted} fitted values use up all {self.independent:.3g} independent values; none is left to test; give more of these"
            )

    @property
    def adequacy(self) -> float:
        """Variance of adequacy: the mean square over the degrees of freedom that fitted parameters
        leave.
        """
        return self.mean_square * self.independent / (self.independent - self.fitted)

    @property
    def ratio(self) -> float:
        """Fisher's ratio, adequacy over reproducibility, to which what all repeats share is added."""
        return self.adequacy / self.expected

    @property
    def expected(self) -> float:
        """Variance of adequacy that a true model has: that of reproducibility and, for each repeat,
        what all share.
        """
        return self.reproducibility + max(self.repeats, 1) * sum(self.shared)

    @property
    def degrees(self) -> tuple[float, float]:
        """Degrees of freedom of adequacy and of reproducibility, the latter infinite where scatters
        are stated; of sums by Satterthwaite, what is shared having one each above and none to show
        below.
        """
        own, parts = (
            self.reproducibility**2,
            [(max(self.repeats, 1) * one) ** 2 for one in self.shared],
        )
        first = self.expected**2 / (own / (self.independent - self.fitted) + sum(parts))
        second = self.independent * (self.repeats - 1) if self.repeats else math.inf
        return first, second * self.expected**2 / own

    @property
    def critical(self) -> float:
        """Ratio above which the model is refuted."""
        return critical_ratio(*self.degrees)

    @property
    def p_value(self) -> float:
        """Chance of such a ratio, or a larger one, where the model is true."""
        return chance(self.ratio, *self.degrees)

    @property
    def adequate(self) -> bool:
        """Whether the test does not refute the model."""
        return self.ratio <= self.critical

    @property
    def refutable(self) -> float:
        """Root mean square difference from the mean of the repeats above which this test refutes;
        in the unit, or in scatters.
        """
        share = (self.independent - self.fitted) / self.independent
        return math.sqrt(self.critical * self.expected * share / max(self.repeats, 1))


def critical_ratio(first: float, second: float) -> float:
    """Ratio that the chance :data:`LEVEL` exceeds; ``second`` may be infinite."""
    return float(fdtri(first, min(second, MANY), 1 - LEVEL))


def chance(ratio: float, first: float, second: float) -> float:
    """Chance that Fisher's ratio with such degrees of freedom is larger than ``ratio``."""
    return float(fdtrc(first, min(second, MANY), ratio))


def adequacy_test(
    values: Array,
    model: Array,
    weights: Array | None = None,
    *,
    ring: bool = False,
    fitted: int = 0,
    shared: tuple[float, ...] = (),
) -> AdequacyTest:
    """Fisher's test of a model against repeats of a curve or of a set of values.

    Parameters
    ----------
    values : repeats, shape (repeats, places)
    model : shape (places,)
    weights : share of the whole that each place represents, shape (places,); even by default
    ring : the places are even steps round one cam revolution
    fitted : parameters of the model that were found from these values
    shared : mean square of each error that all repeats share, square of the unit

    Returns
    -------
    AdequacyTest

    Raises
    ------
    InputError : fewer than two repeats, repeats that are all the same

    Examples
    --------
    >>> import numpy as np
    >>> adequacy_test(np.array([[1.0, 2.0, 4.0], [3.0, 4.0, 4.0]]), np.array([2.0, 5.0, 4.0])).ratio
    2.0
    """
    repeats, places = values.shape
    if repeats < 2:
        raise InputError(
            "one cycle shows no scatter, so there is no F-test; give two or more repeats"
        )
    shares = np.full(places, 1 / places) if weights is None else weights / weights.sum()
    mean = values.mean(axis=0)
    residuals = (values - mean) * np.sqrt(shares)
    independent = independent_places(residuals, ring)
    off = repeats * float(np.sum(shares * (mean - model) ** 2))
    return AdequacyTest(
        off,
        float(np.sum(residuals**2)) / (repeats - 1),
        repeats,
        places,
        independent,
        fitted,
        shared,
    )


def independent_places(residuals: Array, ring: bool) -> float:
    """Effective number of independent places: squared trace over trace of the square of the
    covariance of ``residuals``.

    ``residuals`` (repeats, places): less their mean, each times the root of its weight. Both traces
    are found without the bias that few repeats bring (Bai and Saranadasa 1996). On a ring the
    number of a covariance alike at all angles, which is never the smaller one and needs two repeats
    only, is the upper bound.
    """
    repeats, places = residuals.shape
    n = repeats - 1
    trace = float(np.sum(residuals**2)) / n
    if not trace > 0:
        return float(places)
    bounds = [float(places)]
    if ring:
        bounds.append(_on_a_ring(residuals, n, trace))
    if n > 1:
        square = float(np.sum((residuals @ residuals.T) ** 2)) / n**2
        scale = n / ((n - 1) * (n + 2))
        of_squares = scale * n * (square - trace**2 / n)
        squared = scale * (n + 1) * (trace**2 - 2 * square / (n + 1))
        if of_squares > 0 and squared > 0:
            bounds.append(squared / of_squares)
    return max(1.0, min(bounds))


def _on_a_ring(residuals: Array, n: int, trace: float) -> float:
    """Effective number where all angles are alike: from the powers of the harmonics, each the mean
    of ``n`` independent ones.
    """
    places = residuals.shape[1]
    power = (
        np.mean(np.abs(np.fft.rfft(residuals, axis=1)) ** 2, axis=0) * len(residuals) / n / places
    )
    double = np.full(len(power), 2.0)
    double[0] = 1.0
    if places % 2 == 0:
        double[-1] = 1.0
    # a harmonic is a cosine and a sine: the square of its power is too large by one part in n, that
    # of a lone one by two
    excess = 1 + np.where(double == 2.0, 1.0, 2.0) / n
    of_squares = float(np.sum(double * power**2 / excess))
    squared = trace**2 - 2 * of_squares / n
    return max(1.0, squared / of_squares) if of_squares > 0 else 1.0


def ring_weights(cam_angle: Array) -> tuple[Array, bool]:
    """Share of the cycle that each angle (rad, rising) represents, and whether the steps are even; a
    gap counts as few steps only.
    """
    steps = np.diff(np.append(cam_angle, cam_angle[0] + 2 * np.pi))
    typical = float(np.median(steps))
    even = bool(np.all(np.abs(steps - typical) < EVEN * typical))
    clipped = np.minimum(steps, WIDEST * typical)
    weights = clipped + np.roll(clipped, 1)
    return weights / weights.sum(), even


#: Fewest repeats that make a band worth drawing.
MIN_REPEATS = 3
_MAX_FACTOR = 1e6
#: No error that all repeats share.
NO_ERRORS = np.zeros((0, 1))


@dataclass(frozen=True, eq=False)
class DifferenceBand:
    """Difference of model and test over the cam angle with its band, SI, shapes (angles,).

    ``difference``: model less mean of the repeats. ``half_width``: the true difference is within
    it of the computed one at all angles at once with the chance 1 - :data:`LEVEL`. ``factor``: half
    width in standard errors of the mean.

    >>> import numpy as np
    >>> angle = np.linspace(0.0, 2 * np.pi, 90, endpoint=False)
    >>> repeats = np.outer([1.0, -1.0, 0.5, -0.5], np.ones(90)) + np.outer([0.3, 0.3, -0.3, -0.3], np.sin(angle))
    >>> band = difference_band(repeats, np.full(90, 5.0))
    >>> bool(band.outside.all())
    True
    """

    difference: Array
    half_width: Array
    factor: float

    @property
    def outside(self) -> Flags:
        """Angles at which the band leaves zero out: of a true model one turn in twenty has any."""
        return np.abs(self.difference) > self.half_width


def difference_band(values: Array, model: Array, shared: Array = NO_ERRORS) -> DifferenceBand:
    """The band for ``values`` (repeats, angles) round one cam revolution and ``model`` (angles,);
    ``shared`` (errors, angles): standard deviations of errors that all repeats share, each in step
    along the turn, to which half of the level goes (Scheffe).

    Raises :class:`InputError` for fewer than :data:`FEWEST` repeats. Angles at which all repeats
    agree have no width.
    """
    repeats = len(values)
    if repeats < MIN_REPEATS:
        raise InputError(
            f"{repeats} repeats give no band worth drawing; give {MIN_REPEATS} or more"
        )
    mean = values.mean(axis=0)
    residuals = values - mean
    size = np.sqrt(np.sum(residuals**2, axis=0))
    moving = size > 1e-12 * float(size.max(initial=0.0))
    count = len(shared)
    factor = band_factor(residuals[:, moving] / size[moving], 0.5 * LEVEL if count else LEVEL)
    half = factor * size / math.sqrt((repeats - 1) * repeats)
    if count:
        common = np.sqrt(np.sum(shared**2, axis=0))
        half = half + math.sqrt(float(chdtri(count, 0.5 * LEVEL))) * common
    return DifferenceBand(model - mean, half, factor)


def band_factor(directions: Array, level: float) -> float:
    """Standard errors on either side; ``directions`` (repeats, angles): residuals of each angle
    over their length.
    """
    repeats, places = directions.shape
    if places == 0:
        return 0.0
    freedom = repeats - 1
    by_angles = float(-stdtrit(freedom, 0.5 * level / places))
    steps = np.diff(directions, axis=1, append=directions[:, :1])
    length = float(np.sum(np.sqrt(np.sum(steps**2, axis=0))))

    def left(factor: float) -> float:
        crossings = length / math.pi * (1 + factor**2 / freedom) ** (-(freedom - 1) / 2)
        return float(crossings + 2 * stdtr(freedom, -factor) - level)

    if freedom < 2 or left(_MAX_FACTOR) > 0:
        return by_angles
    return min(
        by_angles, float(brentq(left, 0.0, _MAX_FACTOR, xtol=1e-9)) if left(0.0) > 0 else 0.0
    )
