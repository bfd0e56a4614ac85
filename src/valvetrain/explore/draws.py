"""Weighted draws of a posterior: of a linearised one, or by nested sampling of the library nautilus; and its separate branches.

Source: J. Lange, Monthly Notices of the Royal Astronomical Society 525 (2023) 3181.
"""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from valvetrain.errors import InputError, MissingExtraError
from valvetrain.explore.execution import silent
from valvetrain.explore.identification_file import EFFECTIVE, Search
from valvetrain.explore.least_squares import Peak, covariance_of
from valvetrain.explore.posterior import Posterior
from valvetrain.explore.space import Array
from valvetrain.runs.stopping import Stopped
from valvetrain.runs.workers import Progress

Labels = NDArray[np.int64]
#: Fall of the log posterior below the lower of two peaks that parts them (a factor of 7), and
#: points computed between them.
DIP, BETWEEN = 2.0, 7
#: Draws that are parted, and least share of them in a part.
PARTED, MIN_PART = 1000, 0.03
#: Branches of less than this share of the probability are left out.
MIN_SHARE = 1e-3
#: Share of effective draws where the linearised posterior is weighted by the true one, below which
#: it does not hold.
HOLDS = 0.3
#: Draws with less than this share of the largest weight do not count.
NO_WEIGHT = 1e-8
#: Points of the prior of which one has to be possible.
TRIED = 2000
#: Log likelihood of an impossible point: below any other, and a number.
IMPOSSIBLE = -1e100


@dataclass(frozen=True, eq=False)
class Draws:
    """Points ``work`` (n, quantities) with ``weights`` (n) of sum one and their branches
    ``labels`` (n), the most probable being 0; the logarithm of the evidence; ``note``: what a
    reader should know; ``whole``: False where the search was cut short.
    """

    work: Array
    weights: Array
    labels: Labels
    log_evidence: float = np.nan
    note: str = ""
    whole: bool = True

    @property
    def shares(self) -> list[float]:
        """Probability of each branch."""
        return [float(one) for one in np.bincount(self.labels, self.weights)]


def extra(package: str) -> MissingExtraError:
    """The error of a package of the extra ``studies`` that is not installed."""
    return MissingExtraError(
        f"{package} is not installed; install it with pip install 'valvetrain[studies]'"
    )


def branches_of_draws(posterior: Posterior, work: Array, weights: Array, seed: int = 1) -> Labels:
    """Number (n) of the branch of each draw, the most probable branch being 0. Raises
    :class:`MissingExtraError` without scikit-learn.
    """
    try:
        from sklearn.cluster import HDBSCAN
        from sklearn.neighbors import KNeighborsClassifier
    except ImportError as error:
        raise extra("scikit-learn") from error
    single = np.zeros(len(work), dtype=np.int64)
    deviation = np.sqrt(weights @ (work - weights @ work) ** 2)
    scaled = work / np.where(deviation > 0, deviation, 1.0)
    chosen, _ = even_draws(weights, min(PARTED, len(work)), seed)
    if len(chosen) < 4 / MIN_PART:
        return single
    smallest = max(10, int(MIN_PART * len(chosen)))
    parts = HDBSCAN(smallest, allow_single_cluster=True, copy=True).fit_predict(scaled[chosen])
    count = parts.max() + 1
    if count < 2:
        return single
    height = posterior.log_posterior(work[chosen])
    tops = [chosen[np.argmax(np.where(parts == part, height, -np.inf))] for part in range(count)]
    joined = np.array(joined_peaks(posterior, work[tops]))
    clear = parts >= 0
    near = KNeighborsClassifier(min(5, int(clear.sum())))
    labels = near.fit(scaled[chosen[clear]], joined[parts[clear]]).predict(scaled)
    rank = np.argsort(np.argsort(-np.bincount(labels, weights), kind="stable"))
    return np.asarray(rank[labels], dtype=np.int64)


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


def even_draws(weights: Array, count: int, seed: int) -> tuple[Labels, Labels]:
    """Places of about ``count`` draws chosen evenly by weight, and how often each was."""
    steps = (np.arange(max(count, 1)) + np.random.default_rng(seed).random()) / max(count, 1)
    indices, counts = np.unique(
        np.searchsorted(np.cumsum(weights), steps).clip(0, len(weights) - 1), return_counts=True
    )
    return indices, counts


def percentiles(values: Array, weights: Array, shares: tuple[float, ...]) -> tuple[float, ...]:
    """Weighted percentiles (0 to 100) of values that are not NaN, by the middle of each weight; NaN
    where there is none.
    """
    known = np.isfinite(values) & (weights > 0)
    if not known.any():
        return (np.nan,) * len(shares)
    order = np.argsort(values[known], kind="stable")
    ordered = weights[known][order]
    middle = (np.cumsum(ordered) - 0.5 * ordered) / ordered.sum()
    found = np.interp(np.array(shares) / 100.0, middle, values[known][order])
    return tuple(found.tolist())


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


def linear_draws(
    posterior: Posterior, peaks: Sequence[Peak], shares: Sequence[float], count: int, seed: int
) -> Draws:
    """About ``count`` draws of the linearised posteriors within the bounds, all of one weight; a
    note says where they do not hold. Their evidence is not set.
    """
    random = np.random.default_rng(seed)
    work, labels, note = [], [], ""
    for number, (peak, share) in enumerate(zip(peaks, shares, strict=True)):
        drawn, density = draws_of_peak(posterior, peak, max(round(share * count), 1), random)
        off = posterior.log_posterior(drawn) - density
        top = np.max(off, initial=-np.inf)
        weights = np.exp(off - top) if np.isfinite(top) else np.zeros(len(off))
        holds = weights.sum() ** 2 / max(np.sum(weights**2), 1e-300) / max(len(off), 1)
        if len(off) > 20 and holds < HOLDS:
            note = f"the linearised posterior does not hold ({100 * holds:.0f} % of its draws count); sample with nested"
        work.append(drawn)
        labels.append(np.full(len(drawn), number))
    points = np.vstack(work)
    return Draws(points, np.full(len(points), 1.0 / len(points)), np.concatenate(labels), note=note)


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
    """Weighted draws of the posterior with their branches, and the logarithm of its evidence, which
    has no error bar.

    Another number of ``lanes`` of the search, points requested at once, is another (equally good) sequence of
    points. Raises :class:`InputError` where no point of the prior can be computed,
    :class:`MissingExtraError` without the library.
    """
    try:
        from nautilus import Sampler
    except ImportError as error:
        raise extra("nautilus-sampler") from error
    count = len(posterior.unknowns)
    expected = search.sampled(count)
    done = possible = 0

    def log_likelihoods(shares: Array) -> Array:
        nonlocal done, possible
        found = posterior.log_likelihood(
            posterior.from_shares(np.clip(shares[:, :count], 0.0, 1.0))
        )
        done, possible = done + len(found), possible + int(np.isfinite(found).sum())
        if not possible and done >= TRIED:
            raise InputError(
                "no point of the priors can be computed or meets the data; widen the priors or check the measurements"
            )
        report(min(done / expected, 0.99), f"{done} points")
        return np.maximum(found, IMPOSSIBLE)

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
        shares, log_weights, _ = sampler.posterior()
    weights = np.exp(log_weights - np.max(log_weights))
    retained = weights > NO_WEIGHT
    work = posterior.from_shares(shares[retained, :count])
    weights = weights[retained] / weights[retained].sum()
    labels = np.zeros(len(work), dtype=np.int64)
    if whole:
        labels = branches_of_draws(posterior, work, weights, search.seed)
    return Draws(work, weights, labels, float(sampler.log_z), whole=whole)
