"""The most probable point by scipy's bounded least squares from several starts, what the data determine there, and how well they are met.

Differences are batches of points, so they run side by side; the path does not depend on how many do.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import optimize
from scipy.special import chdtrc

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.explore.posterior import Numbers, Posterior
from valvetrain.explore.samplers import latin_hypercube

#: Step of a difference in standard deviations of the prior where nothing is known yet, and of what
#: the data leave once it is.
FIRST_STEP, LATER_STEP, MIN_STEP = 0.03, 0.1, 1e-5
#: Relative change of misfit or point, and slope, below which a search ends.
TOLERANCE = 1e-6
#: With a p value below this the model is reported as unable to meet the data, which happens to one correct model in a
#: hundred.
REFUSED = 0.01
#: Degrees of freedom below which nothing is left to test.
NOTHING_LEFT = 0.5
#: A quantity is on its bound within this share of the prior's deviation.
ON_BOUND = 1e-6
#: Posterior correlation beyond which two quantities are one, and information (over the prior's)
#: that each would have were the other known.
TWINS, KNOWN_ALONE = 0.9, 4.0
#: Share of the prior's deviation that must be left of one of the two, for a narrow stretch within a
#: wide prior is knowledge all the same.
OPEN = 0.4
#: Least part of a combination that makes a quantity a member of its group.
NAMED = 0.3
#: Scatters within which a datum is met.
MET = 2.0


@dataclass(frozen=True, eq=False)
class Peak:
    """A (local) peak of the posterior: ``work`` (quantities), ``outcome``, ``misfit`` (sum of
    squared scaled misses, priors included) and ``jacobian`` (data, quantities) of the scaled misses
    by standard deviations of the prior.
    """

    work: Array
    outcome: Numbers
    misfit: float
    jacobian: Array


def least_squares(
    posterior: Posterior,
    begin: Array,
    *,
    iterations: int = 30,
    step: float = 0.0,
    report: Callable[[str], None] = lambda text: None,
) -> Peak:
    """Search from ``begin`` (working coordinates).

    ``step``: that of the differences in standard deviations of the prior; 0: it follows what the
    data leave open. Raises :class:`InputError` when the start itself cannot be computed.
    """
    low, high = posterior.bounds
    spread, count = posterior.spread, len(posterior.used)
    start = np.clip(begin, low, high)
    steps = np.full(len(start), step or FIRST_STEP)
    normal = [0.0 if one.prior.flat else 1.0 for one in posterior.unknowns]

    def place(moved: Array) -> Array:
        """The point (1, quantities) that has ``moved`` by standard deviations."""
        return np.asarray(np.clip(start + spread * moved, low, high)[None, :])

    def misses(moved: Array) -> Array:
        return np.asarray(posterior.misses(place(moved))[0])

    def slopes(moved: Array) -> Array:
        """One-sided differences: backward where a step up leaves the bounds or has no numbers, zero
        where neither side has.
        """
        work = place(moved)
        base = posterior.misses(work)[0, :count]
        sides = np.where(work[0] + steps * spread > high, -1.0, 1.0)
        shifts = np.diag(sides * steps * spread)
        rows = posterior.misses(work + shifts)[:, :count]
        lost = np.isnan(rows).any(axis=1)
        if lost.any():
            rows[lost] = 2.0 * base - posterior.misses(work - shifts[lost])[:, :count]
        found = np.nan_to_num((rows - base) / (sides * steps)[:, None]).T
        report(f"misfit {base @ base:.4f}")
        if not step:
            open_share = 1.0 / np.sqrt(np.sum(found**2, axis=0) + 1.0)
            steps[:] = np.clip(LATER_STEP * open_share, MIN_STEP, FIRST_STEP)
        return np.asarray(np.vstack([found, np.diag(normal)]))

    if not np.all(np.isfinite(posterior.misses(start[None, :]))):
        raise InputError(
            "the start of the identification is no possible spring; choose other starting values"
        )
    ends = (low - start) / spread, (high - start) / spread
    ended = optimize.least_squares(
        misses, np.zeros(len(start)), slopes, ends, "trf",
        ftol=TOLERANCE, xtol=TOLERANCE, gtol=TOLERANCE, max_nfev=iterations,
    )  # fmt: skip
    work = place(ended.x)
    misfit = float(np.sum(posterior.misses(work) ** 2))
    return Peak(work[0], posterior.outcomes(work)[0], misfit, ended.jac[:count])


def covariance_of(posterior: Posterior, jacobian: Array) -> Array:
    """Covariance of the working coordinates: inverse of the data's and the priors' information (a
    flat prior by its spread).
    """
    return posterior.remaining(jacobian) * np.outer(posterior.spread, posterior.spread)


def best_starts(posterior: Posterior, count: int, keep: int, seed: int) -> Array:
    """The ``keep`` most likely of ``count`` points (working coordinates) that can be computed: the
    middle of the priors, and a Latin hypercube over them. Raises :class:`InputError` where none can.
    """
    tried = posterior.centre[None, :]
    if count > 1:
        cube = latin_hypercube(count - 1, len(posterior.unknowns), seed)
        tried = np.vstack([tried, posterior.from_shares(cube)])
    height = posterior.log_posterior(tried)
    order = np.argsort(-height, kind="stable")
    possible = order[np.isfinite(height[order])]
    if not len(possible):
        raise InputError(
            f"none of {count} starts can be computed; narrow the priors to what is possible"
        )
    return tried[possible[:keep]]


@dataclass(frozen=True, eq=False)
class Information:
    """``determined`` (quantities): share of the prior's variance that the data remove. ``groups``: places of quantities of
    which the data determine a combination only.
    """

    determined: Array
    groups: tuple[tuple[int, ...], ...]


def information_of(posterior: Posterior, jacobian: Array) -> Information:
    """From the slopes (used data, quantities) at the likeliest point: pairs that are one, then larger groups of which a
    combination is left to the priors.
    """
    covariance = posterior.remaining(jacobian)
    alone, vague = np.sum(jacobian**2, axis=0), np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(vague, vague)
    groups: list[tuple[int, ...]] = [
        pair
        for pair in itertools.combinations(range(len(vague)), 2)
        if np.all(alone[list(pair)] > KNOWN_ALONE)
        and abs(correlation[pair]) > TWINS
        and np.any(vague[list(pair)] > OPEN)
    ]
    paired = {place for pair in groups for place in pair}
    values, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    for value, vector in zip(values, vectors.T, strict=True):
        large = np.flatnonzero(np.abs(vector) > NAMED).tolist()
        if value < 1.0 and len(large) > 2 and set(large) - paired:
            if np.all(alone[large] > KNOWN_ALONE):
                groups.append(tuple(large))
                paired |= set(large)
    return Information(1.0 - np.diag(covariance), tuple(groups))


@dataclass(frozen=True, slots=True)
class Fit:
    """``chi_square`` of the residuals and the pulls of the priors with its degrees of ``freedom``;
    ``p_value``: how often a correct model has a larger one, NaN where no freedom is left.

    >>> round(Fit(470.0, 38.0, 0.0).widening, 2)
    3.52
    """

    chi_square: float
    freedom: float
    p_value: float

    @property
    def missed(self) -> bool:
        """Whether the model cannot meet the data."""
        return self.p_value < REFUSED

    @property
    def widening(self) -> float:
        """Factor on the scatter of all data that makes the misfit the expected one (R. T. Birge,
        Physical Review 40 (1932) 207); 1 where the model meets them.
        """
        if not self.missed:
            return 1.0
        return math.sqrt(max(self.chi_square / max(self.freedom, 1.0), 1.0))


def fit_of(posterior: Posterior, peak: Peak) -> Fit:
    """The fit at the likeliest point.

    Every datum and every normal prior counts one degree of freedom; every quantity takes one, a flat
    one as far as the data determine it, one on its bound none.

    >>> from valvetrain.explore.posterior import Datum
    >>> from valvetrain.explore.distributions import Prior
    >>> from valvetrain.explore.space import Varied
    >>> data = tuple(Datum(f"load {k}", value, 1.0) for k, value in enumerate((9.0, 10.0, 14.0)))
    >>> posterior = Posterior((Varied("load", distribution=Prior("uniform", 0.0, 1e3)),), data, lambda points: [])
    >>> found = fit_of(posterior, Peak(np.array([11.0]), {one.key: 11.0 for one in data}, 14.0, np.full((3, 1), 288.7)))
    >>> round(found.chi_square), round(found.freedom), round(found.p_value, 5)
    (14, 2, 0.00091)
    """
    low, high = posterior.bounds
    near = ON_BOUND * posterior.spread
    free = (peak.work > low + near) & (peak.work < high - near)
    flat = np.array([one.prior.flat for one in posterior.unknowns])
    determined = 1.0 - np.diag(posterior.remaining(peak.jacobian))
    freedom = len(posterior.used) + np.sum(~flat) - np.sum(np.where(flat, determined, 1.0)[free])
    p_value = float(chdtrc(freedom, peak.misfit)) if freedom > NOTHING_LEFT else math.nan
    return Fit(peak.misfit, float(freedom), p_value)
