"""The most probable point by scipy's bounded least squares from several starts, and profiles.

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
#: Values of a profile on either side of the best, and how far it reaches in standard deviations of
#: what is left open.
SIDE, REACH = 4, 2.5


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
    fixed: int | None = None,
    report: Callable[[str], None] = lambda text: None,
) -> Peak:
    """Search from ``begin`` (working coordinates) over all quantities but the ``fixed`` one.

    ``step``: that of the differences in standard deviations of the prior; 0: it follows what the
    data leave open. Raises :class:`InputError` when the start itself cannot be computed.
    """
    low, high = posterior.bounds
    spread, count = posterior.spread, len(posterior.used)
    start = np.clip(begin, low, high)
    free = np.flatnonzero(np.arange(len(start)) != fixed)
    steps = np.full(len(start), step or FIRST_STEP)

    def place(moved: Array) -> Array:
        """The point (1, quantities) whose free quantities have ``moved`` by standard deviations."""
        work = start.copy()
        work[free] = np.clip(start[free] + spread[free] * moved, low[free], high[free])
        return np.asarray(work[None, :])

    def misses(moved: Array) -> Array:
        return np.asarray(posterior.misses(place(moved))[0])

    def slopes(moved: Array) -> Array:
        """One-sided differences: backward where a step up leaves the bounds or has no numbers, zero
        where neither side has.
        """
        work = place(moved)
        base = posterior.misses(work)[0, :count]
        sides = np.where(work[0] + steps * spread > high, -1.0, 1.0)
        shifts = np.diag(sides * steps * spread)[free]
        rows = posterior.misses(work + shifts)[:, :count]
        lost = np.isnan(rows).any(axis=1)
        if lost.any():
            rows[lost] = 2.0 * base - posterior.misses(work - shifts[lost])[:, :count]
        found = np.nan_to_num((rows - base) / (sides * steps)[free, None]).T
        report(f"misfit {base @ base:.4f}")
        if not step:
            open_share = 1.0 / np.sqrt(np.sum(found**2, axis=0) + 1.0)
            steps[free] = np.clip(LATER_STEP * open_share, MIN_STEP, FIRST_STEP)
        return np.asarray(np.vstack([found, posterior.prior_rows[:, free]]))

    if not np.all(np.isfinite(posterior.misses(start[None, :]))):
        raise InputError(
            "the start of the identification is no possible spring; choose other starting values"
        )
    moved, jacobian = np.zeros(len(free)), np.zeros((count, len(start)))
    if len(free):
        ends = ((low - start) / spread)[free], ((high - start) / spread)[free]
        ended = optimize.least_squares(
            misses, moved, slopes, ends, "trf",
            ftol=TOLERANCE, xtol=TOLERANCE, gtol=TOLERANCE, max_nfev=iterations,
        )  # fmt: skip
        moved, jacobian[:, free] = ended.x, ended.jac[:count]
    work = place(moved)
    misfit = float(np.sum(posterior.misses(work) ** 2))
    return Peak(work[0], posterior.outcomes(work)[0], misfit, jacobian)


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


@dataclass(frozen=True, eq=False)
class Profile:
    """``values`` (n) in SI and ``misfit`` (n): least sum of squared scaled misses with the quantity
    at each; NaN where none is possible.
    """

    name: str
    values: Array
    misfit: Array


def profile(posterior: Posterior, peak: Peak, name: str) -> Profile:
    """Profile of the quantity ``name`` about a ``peak``, each search from the end of the one
    before. Raises :class:`InputError` for a name that is not looked for.
    """
    if name not in posterior.names:
        raise InputError(
            f"there is no quantity '{name[:60]}' to profile; choose from {', '.join(posterior.names)}",
            "profile",
        )
    place = posterior.names.index(name)
    low, high = (bounds[place] for bounds in posterior.bounds)
    middle = peak.work[place]
    reach = REACH * np.sqrt(covariance_of(posterior, peak.jacobian)[place, place])
    found = {float(middle): peak.misfit}
    for side in (-reach, reach):
        begin = peak.work.copy()
        for at in np.linspace(middle, np.clip(middle + side, low, high), SIDE + 1)[1:]:
            begin[place] = at
            try:
                one = least_squares(posterior, begin, iterations=10, fixed=place)
                begin, found[float(at)] = one.work.copy(), one.misfit
            except InputError:
                found[float(at)] = np.nan
    work = np.array(sorted(found))
    values = np.asarray(posterior.unknowns[place].prior.value(work))
    return Profile(name, values, np.array([found[float(at)] for at in work]))
