"""Which draws or peaks belong together: separate branches of a posterior, between which its density
falls.

Draws are parted by density (HDBSCAN: R. Campello, D. Moulavi and J. Sander, Lecture Notes in
Computer Science 7819 (2013) 160); two parts
are two branches only where the posterior itself, computed on the line between their likeliest
points, dips.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from valvetrain.identification.draws import Draws, extra
from valvetrain.identification.posterior import Posterior

Array = NDArray[np.float64]
Labels = NDArray[np.int64]
#: Fall of the log posterior below the lower of two peaks that parts them (a factor of 7), and
#: points computed between them.
DIP, BETWEEN = 2.0, 7
#: Draws that are parted, least share of them in a part, and dimensions of a posterior whose parts
#: are looked for among fewer draws.
PARTED, LEAST_SHARE = 1000, 0.03


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
    if len(chosen) < 4 / LEAST_SHARE:
        return np.zeros(len(draws.work), dtype=np.int64)
    found = HDBSCAN(
        min_cluster_size=max(10, int(LEAST_SHARE * len(chosen))),
        allow_single_cluster=True,
        copy=True,
    ).fit_predict(scaled[chosen])
    words = sorted(set(found.tolist()) - {-1})
    if len(words) < 2:
        return np.zeros(len(draws.work), dtype=np.int64)
    at = posterior.at(draws.work[chosen]).log_posterior
    peaks = np.array(
        [chosen[np.flatnonzero(found == word)[np.argmax(at[found == word])]] for word in words]
    )
    joined = joined_peaks(posterior, draws.work[peaks])
    known = found >= 0
    labels = np.array([joined[words.index(one)] for one in found[known]])
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
    places, counts = np.unique(
        np.searchsorted(np.cumsum(weights), steps).clip(0, len(weights) - 1), return_counts=True
    )
    return places, counts


def _by_share(labels: Labels, weights: Array) -> Labels:
    """The same parts numbered by their probability."""
    words = np.unique(labels)
    share = [weights[labels == word].sum() for word in words]
    order = words[np.argsort(-np.array(share), kind="stable")].tolist()
    return np.array([order.index(one) for one in labels.tolist()], dtype=np.int64)
