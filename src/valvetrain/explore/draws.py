"""Draws of a posterior, all of one weight: of a linearised one, or by nested sampling of the library nautilus; and its separate branches.

Source: J. Lange, Monthly Notices of the Royal Astronomical Society 525 (2023) 3181.
"""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from valvetrain.arrays import Array, Ints
from valvetrain.errors import InputError
from valvetrain.explore.execution import silent
from valvetrain.explore.identification_file import EFFECTIVE, Search
from valvetrain.explore.least_squares import Peak, covariance_of
from valvetrain.explore.posterior import Posterior
from valvetrain.explore.samplers import needs
from valvetrain.runs.stopping import Stopped
from valvetrain.runs.workers import Progress

Labels = Ints
#: Fall of the log posterior below the lower of two peaks that parts them (a factor of 7), and
#: points computed between them.
DIP, BETWEEN = 2.0, 7
#: Draws among which clusters are looked for, and least share of them in a cluster.
CLUSTERED, LEAST_CLUSTER = 1000, 0.03
#: Branches of less than this share of the probability are left out.
MIN_SHARE = 1e-3
#: Share of effective draws where the linearised posterior is weighted by the true one, below which
#: it does not hold.
HOLDS = 0.3
#: Points of the prior of which one has to be possible.
TRIED = 2000
#: Log likelihood of an impossible point: below any other, and a number.
IMPOSSIBLE = -1e100


@dataclass(frozen=True, eq=False)
class Draws:
    """Points ``work`` (n, quantities) of one weight with their branches ``labels`` (n), the most probable being 0; the
    logarithm of the evidence; ``note``: what a reader should know; ``whole``: False where the search was cut short.
    """

    work: Array
    labels: Labels
    log_evidence: float = np.nan
    note: str = ""
    whole: bool = True


def even_places(size: int, count: int, seed: int) -> Labels:
    """``count`` places, spread evenly over ``size`` draws of one weight."""
    steps = np.arange(count) + np.random.default_rng(seed).random()
    return np.asarray(steps * size / max(count, 1), dtype=np.int64)


def likeliest_of_clusters(posterior: Posterior, work: Array, seed: int) -> Array:
    """The likeliest draw of all, then that of each cluster of draws (n, quantities). Raises
    :class:`MissingExtraError` without scikit-learn.
    """
    with needs("scikit-learn"):
        from sklearn.cluster import HDBSCAN
    chosen = work[even_places(len(work), min(CLUSTERED, len(work)), seed)]
    height = posterior.log_posterior(chosen)
    tops, least = [np.argmax(height)], max(10, int(LEAST_CLUSTER * len(chosen)))
    if len(chosen) > 4 * least:
        scaled = chosen / np.maximum(np.std(chosen, axis=0), np.finfo(float).tiny)
        parts = HDBSCAN(least, allow_single_cluster=True, copy=True).fit_predict(scaled)
        tops += [np.argmax(np.where(parts == k, height, -np.inf)) for k in range(max(parts) + 1)]
    return chosen[list(dict.fromkeys(tops))]


def joined_peaks(posterior: Posterior, peaks: Array) -> list[int]:
    """Number of the branch of each of some peaks (n, quantities): those between which the posterior
    does not dip share one.
    """
    owner = list(range(len(peaks)))
    pairs = list(itertools.combinations(owner, 2))
    if not pairs:
        return owner
    shares = np.linspace(0.0, 1.0, BETWEEN + 2)[:, None]
    lines = [peaks[first] + shares * (peaks[other] - peaks[first]) for first, other in pairs]
    heights = posterior.log_posterior(np.vstack(lines)).reshape(len(pairs), -1)
    for (first, other), along in zip(pairs, heights, strict=True):
        if not np.min(along[1:-1]) < min(along[0], along[-1]) - DIP:
            low, high = sorted((owner[first], owner[other]))
            owner = [low if number == high else number for number in owner]
    order = list(dict.fromkeys(owner))
    return [order.index(number) for number in owner]


def branches_of_peaks(
    posterior: Posterior, peaks: Sequence[Peak]
) -> tuple[list[Peak], list[float], float]:
    """The best peak of each branch, the most probable first, with the probability of each and the
    logarithm of the evidence, where each is taken for normal (Laplace).
    """
    ordered = sorted(peaks, key=lambda one: one.misfit)
    numbers = joined_peaks(posterior, np.array([one.work for one in ordered]))
    best = [ordered[numbers.index(number)] for number in range(max(numbers) + 1)]
    heights = posterior.log_posterior(np.array([one.work for one in best]))
    spreads = [covariance_of(posterior, one.jacobian) for one in best]
    evidence = heights + 0.5 * np.linalg.slogdet(2 * np.pi * np.array(spreads))[1]
    total = float(np.logaddexp.reduce(evidence))
    shares = np.exp(evidence - total)
    order = [k for k in np.argsort(-shares, kind="stable").tolist() if shares[k] >= MIN_SHARE]
    return [best[k] for k in order], (shares[order] / shares[order].sum()).tolist(), total


def branches_of_draws(
    posterior: Posterior, peaks: Sequence[Peak], work: Array
) -> tuple[list[Peak], list[float], Labels]:
    """The peaks that draws belong to, the most probable first, with the share and the labels (n) of their draws: those to
    which its linearised misfit is the least.
    """
    misfits = []
    for one in peaks:
        off = (work - one.work) / posterior.spread
        misfits.append(one.misfit + np.sum((off @ one.jacobian.T) ** 2, axis=1) + np.sum(off**2, axis=1))  # fmt: skip
    nearest = np.argmin(misfits, axis=0)
    shares = np.bincount(nearest, minlength=len(peaks)) / len(work)
    order = [k for k in np.argsort(-shares, kind="stable").tolist() if shares[k]]
    rank = np.argsort(np.argsort(-shares, kind="stable"))
    return [peaks[k] for k in order], shares[order].tolist(), rank[nearest]


def linear_draws(
    posterior: Posterior, peaks: Sequence[Peak], shares: Sequence[float], count: int, seed: int
) -> Draws:
    """About ``count`` draws of the linearised posteriors within the bounds, all of one weight; a
    note says where they do not hold. Their evidence is not set.
    """
    random = np.random.default_rng(seed)
    work, note = [], ""
    for peak, share in zip(peaks, shares, strict=True):
        drawn, density = draws_of_peak(posterior, peak, max(round(share * count), 1), random)
        off = posterior.log_posterior(drawn) - density
        top = np.max(off, initial=-np.inf)
        weights = np.exp(off - top) if np.isfinite(top) else np.zeros(len(off))
        holds = weights.sum() ** 2 / max(np.sum(weights**2), 1e-300) / max(len(off), 1)
        if len(off) > 20 and holds < HOLDS:
            note = f"the linearised posterior does not hold ({100 * holds:.0f} % of its draws count); sample with nested"
        work.append(drawn)
    labels = np.repeat(np.arange(len(peaks)), [len(drawn) for drawn in work])
    return Draws(np.vstack(work), labels, note=note)


def draws_of_peak(
    posterior: Posterior, peak: Peak, count: int, random: np.random.Generator
) -> tuple[Array, Array]:
    """``count`` draws (working coordinates) of a linearised posterior within the bounds, and the
    logarithm of the density of each above that of the peak; fewer where the bounds leave too few.
    """
    from scipy.stats.qmc import LatinHypercube

    root = np.linalg.cholesky(covariance_of(posterior, peak.jacobian))
    low, high = posterior.bounds
    cube = LatinHypercube(len(low), rng=random)
    work, density = np.empty((0, len(low))), np.empty(0)
    for _ in range(1000):
        unit = ndtri(cube.random(count))
        at = peak.work + unit @ root.T
        inside = np.all((at >= low) & (at <= high), axis=1)
        work = np.vstack([work, at[inside]])
        density = np.append(density, -0.5 * np.sum(unit[inside] ** 2, axis=1))
        if len(work) >= count:
            break
    return work[:count], density[:count]


def nested(posterior: Posterior, search: Search, report: Progress = silent) -> Draws:
    """Draws of the posterior, of one branch so far, and the logarithm of its evidence, which has no error bar.

    Another number of ``lanes`` of the search, points requested at once, is another (equally good) sequence of
    points. Raises :class:`InputError` where no point of the prior can be computed,
    :class:`MissingExtraError` without the library.
    """
    with needs("nautilus-sampler"):
        from nautilus import Sampler
    count = len(posterior.unknowns)
    expected = search.sampled(count)
    done = possible = 0

    def log_likelihoods(shares: Array) -> Array:
        nonlocal done, possible
        heights = posterior.log_likelihood(
            posterior.from_shares(np.clip(shares[:, :count], 0.0, 1.0))
        )
        done, possible = done + len(heights), possible + int(np.isfinite(heights).sum())
        if not possible and done >= TRIED:
            raise InputError(
                "no point of the priors can be computed or meets the data; widen the priors or check the measurements"
            )
        report(min(done / expected, 0.99), f"{done} points")
        return np.maximum(heights, IMPOSSIBLE)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        sampler = Sampler(
            np.asarray,
            log_likelihoods,
            n_dim=max(count, 2),  # it takes no single quantity: the second one has no effect
            n_live=max(search.live_points, 2 * count + 2),
            n_batch=search.lanes,
            n_networks=1,
            vectorized=True,
            pass_dict=False,
            seed=search.seed,
        )
        whole = True
        try:
            sampler.run(f_live=search.precision, n_eff=EFFECTIVE)
        except Stopped:
            whole = False
            if not possible:
                raise
            for shell in range(len(sampler.points)):  # the stop met one half updated
                sampler.update_shell_info(shell)
        shares, *_ = sampler.posterior(equal_weight=True)
    work = posterior.from_shares(shares[:, :count])
    return Draws(work, np.zeros(len(work), dtype=np.int64), float(sampler.log_z), whole=whole)
