"""The most probable point by scipy's bounded least squares from several starts.

Differences are batches of points, so they run side by side; the path does not depend on how many do.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from valvetrain.errors import InputError
from valvetrain.explore.posterior import Numbers, Posterior

Array = NDArray[np.float64]
#: Step of a difference in standard deviations of the prior where nothing is known yet, and of what
#: the data leave once it is.
FIRST_STEP, LATER_STEP, MIN_STEP = 0.03, 0.1, 1e-5
#: Relative change of misfit or point, and slope, below which a search ends.
TOLERANCE = 1e-6


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
    from scipy.stats.qmc import LatinHypercube

    cube = LatinHypercube(len(posterior.unknowns), rng=np.random.default_rng(seed))
    tried = posterior.centre[None, :]
    if count > 1:
        tried = np.vstack([tried, posterior.from_shares(cube.random(count - 1))])
    height = posterior.log_posterior(tried)
    order = np.argsort(-height, kind="stable")
    possible = order[np.isfinite(height[order])]
    if not len(possible):
        raise InputError(
            f"none of {count} starts can be computed; narrow the priors to what is possible"
        )
    return tried[possible[:keep]]
