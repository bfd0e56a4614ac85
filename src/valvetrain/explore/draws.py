"""Weighted draws of a posterior, its separate branches, and what the data determine."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import MissingExtraError
from valvetrain.explore.posterior import Posterior

Array = NDArray[np.float64]
#: Called with the share done and a text.
Report = Callable[[float, str], None]


@dataclass(frozen=True, eq=False)
class Draws:
    """Points ``work`` (n, quantities) with ``weights`` (n) of sum one, and where known the
    logarithm of the evidence and its error.

    ``evidence_kind``: how the evidence was found. ``whole``: False where the search was cut short;
    ``notes``: what a reader should know.
    """

    work: Array
    weights: Array
    log_evidence: float = np.nan
    evidence_error: float = np.nan
    evidence_kind: str = ""
    whole: bool = True
    notes: tuple[str, ...] = ()

    @property
    def effective(self) -> float:
        """Number of equally weighted draws with the same information (Kish)."""
        return float(1.0 / np.sum(self.weights**2))


def extra(package: str) -> MissingExtraError:
    """The error of a package of the extra ``studies`` that is not installed."""
    return MissingExtraError(
        f"{package} is not installed; install it with pip install 'valvetrain[studies]'"
    )


def silent(done: float, text: str) -> None:
    """A report that goes nowhere."""


Labels = NDArray[np.int64]
#: Fall of the log posterior below the lower of two peaks that parts them (a factor of 7), and
#: points computed between them.
DIP, BETWEEN = 2.0, 7
#: Draws that are parted, least share of them in a part, and dimensions of a posterior whose parts
#: are looked for among fewer draws.
PARTED, MIN_SHARE = 1000, 0.03


def branches_of_draws(posterior: Posterior, draws: Draws, seed: int = 1) -> Labels:
    """Number (n) of the branch of each draw, the most probable branch being 0. Raises
    :class:`MissingExtraError` without scikit-learn.
    """
    try:
        from sklearn.cluster import HDBSCAN
        from sklearn.neighbors import KNeighborsClassifier
    except ImportError as error:
        raise extra("scikit-learn") from error
    middle = draws.weights @ draws.work
    deviation = np.sqrt(draws.weights @ (draws.work - middle) ** 2)
    scaled = (draws.work - middle) / np.where(deviation > 0, deviation, 1.0)
    chosen, _ = even_draws(draws.weights, min(PARTED, len(draws.work)), seed)
    if len(chosen) < 4 / MIN_SHARE:
        return np.zeros(len(draws.work), dtype=np.int64)
    found = HDBSCAN(
        min_cluster_size=max(10, int(MIN_SHARE * len(chosen))),
        allow_single_cluster=True,
        copy=True,
    ).fit_predict(scaled[chosen])
    phrase = sorted(set(found.tolist()) - {-1})
    if len(phrase) < 2:
        return np.zeros(len(draws.work), dtype=np.int64)
    at = posterior.at(draws.work[chosen]).log_posterior
    peaks = np.array(
        [chosen[np.flatnonzero(found == word)[np.argmax(at[found == word])]] for word in phrase]
    )
    joined = joined_peaks(posterior, draws.work[peaks])
    known = found >= 0
    labels = np.array([joined[phrase.index(one)] for one in found[known]])
    near = KNeighborsClassifier(n_neighbors=min(5, int(known.sum()))).fit(
        scaled[chosen[known]], labels
    )
    return _by_share(np.asarray(near.predict(scaled), dtype=np.int64), draws.weights)


def joined_peaks(posterior: Posterior, peaks: Array) -> list[int]:
    """Number of the branch of each of some peaks (n, quantities): those between which the posterior
    does not dip share one.
    """
    count = len(peaks)
    owner = list(range(count))
    pairs = list(itertools.combinations(range(count), 2))
    if not pairs:
        return owner
    shares = np.arange(BETWEEN + 2) / (BETWEEN + 1.0)
    lines = [peaks[one] + shares[:, None] * (peaks[other] - peaks[one]) for one, other in pairs]
    at = posterior.at(np.vstack(lines)).log_posterior.reshape(len(pairs), -1)
    for (one, other), along in zip(pairs, at, strict=True):
        if not np.min(along[1:-1]) < min(along[0], along[-1]) - DIP:
            first, second = sorted((owner[one], owner[other]))
            owner = [first if number == second else number for number in owner]
    order = list(dict.fromkeys(owner))
    return [order.index(number) for number in owner]


def even_draws(weights: Array, count: int, seed: int) -> tuple[Labels, Labels]:
    """Places of about ``count`` draws chosen evenly by weight, and how often each was."""
    steps = (np.arange(max(count, 1)) + np.random.default_rng(seed).random()) / max(count, 1)
    indices, counts = np.unique(
        np.searchsorted(np.cumsum(weights), steps).clip(0, len(weights) - 1), return_counts=True
    )
    return indices, counts


def _by_share(labels: Labels, weights: Array) -> Labels:
    """The same parts numbered by their probability."""
    phrase = np.unique(labels)
    share = [weights[labels == word].sum() for word in phrase]
    order = phrase[np.argsort(-np.array(share), kind="stable")].tolist()
    return np.array([order.index(one) for one in labels.tolist()], dtype=np.int64)


#: Posterior correlation beyond which two quantities are one, and information (over the prior's)
#: that each would have were the other known.
TWINS, KNOWN_ALONE = 0.9, 4.0
#: Share of the prior's deviation that must be left of one of the two, for a narrow stretch within a
#: wide prior is knowledge all the same.
OPEN = 0.4
#: Least part of a combination that makes a quantity a member of its group.
NAMED = 0.3


@dataclass(frozen=True, eq=False)
class Information:
    """``determined`` (quantities): share of the prior's variance that the data remove. ``brought``
    (measurements, quantities): share that each
    measurement has of all the data's information on a quantity, the others known. ``lost``
    (measurements, quantities): share by which the
    variance is smaller than it were without that measurement. ``correlation`` (quantities,
    quantities) of what is left open; ``groups``: places of quantities of which the data determine a
    combination only."""

    measurements: tuple[str, ...]
    determined: Array
    brought: Array
    lost: Array
    correlation: Array
    groups: tuple[tuple[int, ...], ...] = ()


def information_of(posterior: Posterior, jacobian: Array, whole_search: bool = True) -> Information:
    """From the slopes (used data, quantities) at the likeliest point; without groups where the search
    was cut short.
    """
    count = jacobian.shape[1]
    owners = [one.name for one in posterior.used]
    measurements = tuple(dict.fromkeys(owners))
    whole: NDArray[Any] = np.linalg.inv(posterior.precision + jacobian.T @ jacobian)
    variance = np.diag(whole)
    lost, brought = np.zeros((len(measurements), count)), np.zeros((len(measurements), count))
    every = np.sum(jacobian**2, axis=0)
    for place, name in enumerate(measurements):
        others = jacobian[[owner != name for owner in owners]]
        brought[place] = np.sum(
            jacobian[[owner == name for owner in owners]] ** 2, axis=0
        ) / np.where(every > 0, every, 1.0)
        without = np.diag(np.linalg.inv(posterior.precision + others.T @ others))
        lost[place] = np.clip(1.0 - variance / without, 0.0, 1.0)
    correlation = np.asarray(whole / np.sqrt(np.outer(variance, variance)), dtype=np.float64)
    return Information(
        measurements,
        1.0 - variance,
        brought,
        lost,
        correlation,
        _groups(jacobian, whole, correlation) if whole_search else (),
    )


def _groups(
    jacobian: Array, covariance: NDArray[Any], correlation: NDArray[Any]
) -> tuple[tuple[int, ...], ...]:
    """Pairs that are one, then larger groups of which a combination is left to the priors."""
    count, alone = jacobian.shape[1], np.sum(jacobian**2, axis=0)
    vague = np.sqrt(np.diag(covariance))
    found: list[tuple[int, ...]] = [
        (one, other)
        for one, other in itertools.combinations(range(count), 2)
        if min(alone[one], alone[other]) > KNOWN_ALONE
        and abs(correlation[one, other]) > TWINS
        and max(vague[one], vague[other]) > OPEN
    ]
    values, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    for value, vector in zip(values, vectors.T, strict=True):
        large = np.flatnonzero(np.abs(vector) > NAMED)
        new = set(large.tolist()) - {place for pair in found for place in pair}
        if value < 1.0 and len(large) > 2 and new and np.all(alone[large] > KNOWN_ALONE):
            found.append(tuple(large.tolist()))
    return tuple(found)
