"""Peaks of a sampled curve, found by how far they stand out."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def prominent_peaks(values: ArrayLike, prominence: float) -> Index:
    """Indices of inner local maxima that rise by ``prominence`` above the saddle to any higher one."""
    from scipy.signal import find_peaks

    return find_peaks(np.asarray(values, dtype=float), prominence=prominence)[0]


def separate_spikes(position: Array, size: Array, separation: float, threshold: float) -> Index:
    """Indices of the largest values, largest first, at least ``separation`` apart and at least ``threshold`` in size."""
    candidates = np.flatnonzero((size >= threshold) & (size >= np.r_[size[1:], -np.inf]) & (size >= np.r_[-np.inf, size[:-1]]))
    chosen: list[int] = []
    for index in candidates[np.argsort(-size[candidates], kind="stable")]:
        if all(abs(position[index] - position[other]) >= separation for other in chosen):
            chosen.append(int(index))
    return np.array(chosen, dtype=np.int64)
