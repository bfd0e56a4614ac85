"""The most probable point by bounded Levenberg-Marquardt steps, several trial steps of different
damping at once.

Differences and trials are batches of points, so they run side by side; the path does not depend on
how many do. Sources: K. Levenberg,
Quarterly of Applied Mathematics 2 (1944) 164; D. Marquardt, SIAM Journal on Applied Mathematics 11
(1963) 431.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from valvetrain.errors import InputError
from valvetrain.explore.draws import Draws, joined_peaks
from valvetrain.explore.posterior import Outcome, Posterior

Array = NDArray[np.float64]
#: Step of a difference in standard deviations of the prior where nothing is known yet, and of what
#: the data leave once it is.
FIRST_STEP, LATER_STEP, MIN_STEP = 0.03, 0.1, 1e-5
#: Search ends when a step gains less than this share of the misfit, or of one standard deviation
#: squared.
GAIN = 1e-3
#: Dampings that are tried at once, over the last that was best; and the damping at which the search
#: gives up.
TRIALS, MIN_DAMPING, MAX_DAMPING = (-2, -1, 0, 1), 1e-9, 1e8
#: A misfit below this is none.
NOTHING = 1e-12


@dataclass(frozen=True, eq=False)
class Peak:
    """A (local) peak of the posterior: ``work`` (quantities), ``outcome``, ``misfit`` (sum of
    squared scaled misses, priors included),
    ``jacobian`` (data, quantities) of the scaled misses by standard deviations of the prior,
    ``covariance`` of the working coordinates
    from it, and the ``iterations`` it took."""

    work: Array
    outcome: Outcome
    misfit: float
    jacobian: Array
    covariance: Array
    iterations: int


def least_squares(
    posterior: Posterior,
    begin: Array,
    *,
    iterations: int = 30,
    free: Array | None = None,
    step: float | None = None,
    report: Callable[[str], None] = lambda text: None,
) -> Peak:
    """Search from ``begin`` (working coordinates) over the quantities that are ``free`` (all by
    default).

    ``step``: that of the differences in standard deviations of the prior, fixed; by default it
    follows what the data leave open.
    Raises :class:`InputError` when the start itself cannot be computed.
    """
    low, high = posterior.bounds
    spread, work = posterior.spread, np.clip(begin, low, high)
    chosen = np.ones(len(work), dtype=bool) if free is None else free
    outcome = posterior.at(work[None, :]).outcomes[0]
    misses = _misses(posterior, outcome, work)
    if misses is None:
        raise InputError(
            "the start of the identification is no possible spring; choose other starting values"
        )
    damping, done, steps = 1.0, 0, np.full(len(work), step or FIRST_STEP)
    for done in range(1, iterations + 1):
        jacobian = differences(posterior, work, outcome, steps, chosen)
        whole = np.vstack([jacobian, posterior.prior_rows])[:, chosen]
        normal, gradient = whole.T @ whole, whole.T @ misses
        tried = [max(damping, MIN_DAMPING) * 10.0**power for power in TRIALS]
        indices = np.tile(work, (len(tried), 1))
        for row, one in zip(indices, tried, strict=True):
            row[chosen] -= spread[chosen] * np.linalg.solve(
                normal + one * np.eye(len(gradient)), gradient
            )
        indices = np.clip(indices, low, high)
        best: tuple[Array, Outcome, Array] | None = None
        least = float(misses @ misses)
        for one, place, found in zip(tried, indices, posterior.at(indices).outcomes, strict=True):
            off = _misses(posterior, found, place)
            if off is not None and off @ off < (least if best is None else best[2] @ best[2]):
                best, damping = (place, found, off), one
        if best is None:
            damping *= 100.0
            if damping > MAX_DAMPING or least < NOTHING:
                break
            continue
        work, outcome, misses = best
        now = float(misses @ misses)
        report(f"iteration {done}: misfit {now:.4f}, damping {damping:.1e}")
        if step is None:
            steps = _steps(jacobian, posterior, chosen)
        if least - now < GAIN * min(now, 1.0) or now < NOTHING:
            break
    jacobian = differences(posterior, work, outcome, steps, chosen)
    return Peak(
        work, outcome, float(misses @ misses), jacobian, covariance_of(posterior, jacobian), done
    )


def covariance_of(posterior: Posterior, jacobian: Array) -> Array:
    """Covariance of the working coordinates: inverse of the data's and the priors' information (a
    flat prior by its spread).
    """
    information = jacobian.T @ jacobian + posterior.precision
    return np.asarray(np.linalg.inv(information) * np.outer(posterior.spread, posterior.spread))


def differences(
    posterior: Posterior, work: Array, outcome: Outcome, steps: Array, chosen: Array
) -> Array:
    """Slopes (data, quantities) of the scaled misses by quantities in standard deviations of their
    priors, from one-sided differences.

    Zero for quantities that are not ``chosen``. Backward where a step up leaves the bounds, and
    where the next point cannot be computed;
    zero where neither side can.
    """
    high = posterior.bounds[1]
    free = np.flatnonzero(chosen)
    base = posterior.residuals(outcome)
    assert base is not None
    jacobian = np.zeros((len(base), len(work)))
    signs = np.where(work + steps * posterior.spread > high, -1.0, 1.0)
    for turn in (1.0, -1.0):  # the second time for those that had no answer
        shifted = np.tile(work, (len(free), 1))
        shifted[np.arange(len(free)), free] += turn * (signs * steps * posterior.spread)[free]
        left = []
        for place, found in zip(free, posterior.at(shifted).outcomes, strict=True):
            off = posterior.residuals(found)
            if off is None:
                left.append(place)
            else:
                jacobian[:, place] = (off - base) / (turn * signs[place] * steps[place])
        free = np.array(left, dtype=int)
        if not left:
            break
    return jacobian


def _misses(posterior: Posterior, outcome: Outcome, work: Array) -> Array | None:
    off = posterior.residuals(outcome)
    return None if off is None else np.concatenate([off, posterior.pulls(work)])


def _steps(jacobian: Array, posterior: Posterior, chosen: Array) -> Array:
    """A tenth of what the data leave open of each quantity were the others known, in standard
    deviations of the prior.
    """
    reported = np.sqrt(np.sum(jacobian**2, axis=0) + 1.0)
    return np.where(chosen, np.clip(LATER_STEP / reported, MIN_STEP, FIRST_STEP), FIRST_STEP)


#: Branches of less than this share of the probability are left out.
MIN_SHARE = 1e-3
#: Share of effective draws where the linearised posterior is weighted by the true one, below which
#: it does not hold.
HOLDS = 0.3


@dataclass(frozen=True, eq=False)
class Ends:
    """Peaks of separate branches, the most probable first, and the probability of each by its
    linearised posterior.
    """

    peaks: tuple[Peak, ...]
    shares: Array
    log_evidence: float


def starts(posterior: Posterior, count: int, seed: int) -> Array:
    """``count`` starts (working coordinates): the middle of the priors, then a Latin hypercube over
    them.
    """
    first, more = posterior.centre[None, :], count - 1
    random = np.random.default_rng(seed)
    strata = np.argsort(random.random((len(posterior.unknowns), max(more, 1))), axis=1).T[:more]
    shares = (strata + random.random((more, len(posterior.unknowns)))) / max(more, 1)
    return np.vstack([first, posterior.from_shares(shares)])


def best_starts(posterior: Posterior, tried: Array, keep: int) -> Array:
    """The ``keep`` most likely of some starts that can be computed. Raises :class:`InputError` where
    none can.
    """
    at = posterior.at(tried).log_posterior
    order = [place for place in np.argsort(-at, kind="stable").tolist() if np.isfinite(at[place])]
    if not order:
        raise InputError(
            f"none of {len(tried)} starts can be computed; narrow the priors to what is possible"
        )
    return tried[order[:keep]]


def ends_of(posterior: Posterior, peaks: list[Peak]) -> Ends:
    """Peaks that are one branch are joined, the better one remains; those without probability are
    left out.
    """
    ordered = sorted(peaks, key=lambda one: one.misfit)
    numbers = joined_peaks(posterior, np.array([one.work for one in ordered]))
    retained = [ordered[numbers.index(number)] for number in range(max(numbers) + 1)]
    evidence = np.array([_log_evidence(posterior, one) for one in retained])
    shares = np.exp(evidence - evidence.max())
    shares /= shares.sum()
    order = [
        place for place in np.argsort(-shares, kind="stable").tolist() if shares[place] >= MIN_SHARE
    ]
    total = float(evidence.max() + np.log(np.sum(np.exp(evidence - evidence.max()))))
    return Ends(
        tuple(retained[place] for place in order), shares[order] / shares[order].sum(), total
    )


def draws_of_peaks(
    posterior: Posterior, ends: Ends, count: int, seed: int
) -> tuple[Array, NDArray[np.int64], Array]:
    """About ``count`` draws (working coordinates) of the linearised posteriors within the bounds by
    probability, the branch of each, and
    the logarithm of its density above that of its peak; nothing is computed."""
    random = np.random.default_rng(seed)
    found = [
        (at, number, height)
        for number, (peak, share) in enumerate(zip(ends.peaks, ends.shares, strict=True))
        for at, height in _inside(posterior, peak, max(round(float(share) * count), 1), random)
    ]
    work, labels, density = zip(*found, strict=True)
    return np.array(work), np.array(labels, dtype=np.int64), np.array(density)


def linear_draws(
    posterior: Posterior, ends: Ends, count: int, seed: int
) -> tuple[Draws, NDArray[np.int64]]:
    """Draws of the linearised posteriors within the bounds, all of one weight, and the branch of
    each; how far they hold is noted.
    """
    indices, numbers, density = draws_of_peaks(posterior, ends, count, seed)
    at = posterior.at(indices).log_posterior
    notes = []
    for number in range(len(ends.peaks)):
        here = numbers == number
        off = np.where(np.isfinite(at[here]), at[here] - density[here], -np.inf)
        weights = np.exp(off - off.max()) if np.isfinite(off.max()) else np.zeros(len(off))
        holds = weights.sum() ** 2 / max(np.sum(weights**2), 1e-300) / max(len(off), 1)
        if len(off) > 20 and holds < HOLDS:
            notes.append(
                f"the linearised posterior does not hold ({100 * holds:.0f} % of its draws count); sample with nested"
            )
    draws = Draws(
        indices,
        np.full(len(indices), 1.0 / len(indices)),
        ends.log_evidence,
        np.nan,
        "linearised",
        notes=tuple(dict.fromkeys(notes)),
    )
    return draws, numbers


def _inside(
    posterior: Posterior, peak: Peak, count: int, random: np.random.Generator
) -> Iterator[tuple[Array, float]]:
    """``count`` draws of a linearised posterior within the bounds, each with the logarithm of its
    density above that of the peak.
    """
    root = np.linalg.cholesky(peak.covariance)
    low, high = posterior.bounds
    shares = (
        np.argsort(random.random((len(low), count)), axis=1).T + random.random((count, len(low)))
    ) / count  # even over each quantity
    found = 0
    for number in range(1000 * count):
        unit = ndtri(shares[number]) if number < count else random.standard_normal(len(low))
        at = peak.work + root @ unit
        if np.all((at >= low) & (at <= high)):
            found += 1
            yield at, -0.5 * float(unit @ unit)
        if found == count:
            return


def _log_evidence(posterior: Posterior, peak: Peak) -> float:
    """Logarithm of the evidence of a peak, its posterior taken for normal (Laplace)."""
    at = float(posterior.at(peak.work[None, :]).log_posterior[0])
    return at + 0.5 * float(np.linalg.slogdet(2 * np.pi * peak.covariance)[1])


#: Values of a profile on either side of the best, and how far it reaches in standard deviations of
#: what is left open.
SIDE, REACH = 4, 2.5


@dataclass(frozen=True, eq=False)
class Profile:
    """``values`` (n) in SI and ``misfit`` (n): least sum of squared scaled misses with the quantity
    at each; NaN where none is possible.
    """

    name: str
    values: Array
    misfit: Array


def profile(
    posterior: Posterior,
    peak: Peak,
    name: str,
    *,
    iterations: int = 10,
    report: Callable[[str], None] = lambda text: None,
) -> Profile:
    """Profile of the quantity ``name`` about a ``peak``. Raises :class:`InputError` for a name that
    is not looked for.
    """
    if name not in posterior.names:
        raise InputError(
            f"there is no quantity '{name[:60]}' to profile; choose from {', '.join(posterior.names)}",
            "profile",
        )
    place = posterior.names.index(name)
    low, high = posterior.bounds[0][place], posterior.bounds[1][place]
    reach = REACH * np.sqrt(peak.covariance[place, place])
    free = np.arange(len(posterior.names)) != place
    found = {float(peak.work[place]): peak.misfit}
    for side in (-1.0, 1.0):
        end = np.clip(peak.work[place] + side * reach, low, high)
        last = peak.work
        for at in np.linspace(peak.work[place], end, SIDE + 1)[1:]:
            begin = last.copy()
            begin[place] = at
            try:
                if free.any():
                    one = least_squares(posterior, begin, iterations=iterations, free=free)
                    last, found[float(at)] = one.work, one.misfit
                else:
                    found[float(at)] = _misfit(posterior, begin)
            except InputError:
                found[float(at)] = np.nan
            report(f"profile of {name}")
    work = np.array(sorted(found))
    return Profile(
        name,
        np.asarray(posterior.unknowns[place].prior.value(work)),
        np.array([found[float(at)] for at in work]),
    )


def _misfit(posterior: Posterior, work: Array) -> float:
    off = posterior.residuals(posterior.at(work[None, :]).outcomes[0])
    pulls = posterior.pulls(work)
    return np.nan if off is None else float(off @ off + pulls @ pulls)
