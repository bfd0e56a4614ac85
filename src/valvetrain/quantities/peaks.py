"""Peaks of a sampled curve, found by how far they stand out."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def prominent_peaks(values: ArrayLike, prominence: float) -> Index:
    """Indices of inner local maxima that rise by ``prominence`` above the saddle to any higher one;
    the middle of a flat top.
    """
    curve = np.asarray(values, dtype=float)
    if len(curve) < 3:
        return np.zeros(0, dtype=np.int64)
    # Runs of equal values count as one, so that a flat top is one maximum.
    starts = np.flatnonzero(np.r_[True, np.diff(curve) != 0.0])
    ends = np.r_[starts[1:], len(curve)] - 1
    level = curve[starts]
    inner = np.flatnonzero((level[1:-1] > level[:-2]) & (level[1:-1] > level[2:])) + 1
    peaks = (starts[inner] + ends[inner]) // 2
    standing: Index = peaks[prominences(curve, peaks) >= prominence]
    return standing


def ring_peak(values: Array) -> float:
    """Largest value of one closed turn of even samples: the top of the parabola through the largest
    sample and its neighbours.
    """
    place = int(np.argmax(values))
    before, top, after = (float(values[(place + step) % len(values)]) for step in (-1, 0, 1))
    bend = before - 2 * top + after
    return top - (after - before) ** 2 / (8 * bend) if bend < 0 else top


def ring_top(cam_angle: Array, values: Array) -> float:
    """Angle (rad) of :func:`ring_peak`; of a level top its middle, straight on from its first
    sample.
    """
    place, step = int(np.argmax(values)), 2 * np.pi / len(values)
    before, top, after = (float(values[(place + one) % len(values)]) for one in (-1, 0, 1))
    bend = before - 2 * top + after
    return float(cam_angle[place]) + (step * (before - after) / (2 * bend) if bend < 0 else 0.0)


def ring_value(cam_angle: Array, values: Array, place: float) -> float:
    """Value of one closed turn of even samples at an angle (rad): the cubic through the two samples
    on either side of it.
    """
    step = 2 * np.pi / len(values)
    first = int(np.floor((place - float(cam_angle[0])) / step))
    share = (place - float(cam_angle[0])) / step - first
    a, b, c, d = (float(values[(first + one) % len(values)]) for one in (-1, 0, 1, 2))
    slope, end = (c - a) / 2, (d - b) / 2
    return b + share * (
        slope + share * (3 * (c - b) - 2 * slope - end + share * (slope + end - 2 * (c - b)))
    )


def prominences(values: Array, peaks: Index) -> Array:
    """How far each peak rises above the higher of the lowest points on its two sides, up to a
    higher value or the end.
    """
    rises = np.zeros(len(peaks))
    for number, peak in enumerate(peaks):
        higher = np.flatnonzero(values > values[peak])
        left = int(higher[higher < peak].max(initial=-1)) + 1
        right = int(higher[higher > peak].min(initial=len(values)))
        rises[number] = values[peak] - max(values[left : peak + 1].min(), values[peak:right].min())
    return rises


def separate_spikes(position: Array, size: Array, separation: float, threshold: float) -> Index:
    """Indices of the largest values, largest first, at least ``separation`` apart and at least
    ``threshold`` in size.
    """
    candidates = np.flatnonzero(
        (size >= threshold)
        & (size >= np.r_[size[1:], -np.inf])
        & (size >= np.r_[-np.inf, size[:-1]])
    )
    chosen: list[int] = []
    for index in candidates[np.argsort(-size[candidates], kind="stable")]:
        if all(abs(position[index] - position[other]) >= separation for other in chosen):
            chosen.append(int(index))
    return np.array(chosen, dtype=np.int64)
