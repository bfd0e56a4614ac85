"""A point search from several starts: the branches it ends in, each with draws of its linearised
posterior.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from valvetrain.errors import InputError
from valvetrain.identification.branches import joined_peaks
from valvetrain.identification.draws import Draws
from valvetrain.identification.least_squares import Peak
from valvetrain.identification.posterior import Posterior

Array = NDArray[np.float64]
#: Branches of less than this share of the probability are left out.
LEAST_SHARE = 1e-3
#: Share of draws that tell where the linearised posterior is weighted by the true one, below which
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
    """The ``keep`` likeliest of some starts that can be computed. Raises :class:`InputError` where
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
    """Peaks that are one branch are joined, the better one is kept; those without probability are
    left out.
    """
    ordered = sorted(peaks, key=lambda one: one.misfit)
    numbers = joined_peaks(posterior, np.array([one.work for one in ordered]))
    kept = [ordered[numbers.index(number)] for number in range(max(numbers) + 1)]
    evidence = np.array([_log_evidence(posterior, one) for one in kept])
    shares = np.exp(evidence - evidence.max())
    shares /= shares.sum()
    order = [
        place
        for place in np.argsort(-shares, kind="stable").tolist()
        if shares[place] >= LEAST_SHARE
    ]
    total = float(evidence.max() + np.log(np.sum(np.exp(evidence - evidence.max()))))
    return Ends(tuple(kept[place] for place in order), shares[order] / shares[order].sum(), total)


def places_of(
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
    places, numbers, density = places_of(posterior, ends, count, seed)
    at = posterior.at(places).log_posterior
    notes = []
    for number in range(len(ends.peaks)):
        here = numbers == number
        off = np.where(np.isfinite(at[here]), at[here] - density[here], -np.inf)
        weights = np.exp(off - off.max()) if np.isfinite(off.max()) else np.zeros(len(off))
        holds = weights.sum() ** 2 / max(np.sum(weights**2), 1e-300) / max(len(off), 1)
        if len(off) > 20 and holds < HOLDS:
            notes.append(
                f"the linearised posterior does not hold ({100 * holds:.0f} % of its draws tell); sample with nested or ensemble"
            )
    draws = Draws(
        places,
        np.full(len(places), 1.0 / len(places)),
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
