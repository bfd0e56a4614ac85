"""Which highlight is which coil: all of them found in every frame at once, in their order, near where they were expected."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.measurements.film.peaks import find_peaks, half_width

Array = NDArray[np.float64]
#: A highlight stands out by this share of the picture's contrast; a number of coils is believed that this share of frames shows.
PROMINENCE, BELIEVED = 0.25, 0.15
#: Most coils of a spring that are tracked.
MOST_COILS = 40
#: What a highlight loses that lies as far from its prediction as the next coil, beside 1 for a highlight that fits.
MISSED = 0.5


@dataclass(frozen=True, eq=False)
class Found:
    """``frames`` (frames,) in which all coils stand apart; ``places`` (frames, coils) px of their highlights there; ``width`` (px) of one
    at half height; ``reach`` (px) to either side that its profile takes."""

    frames: NDArray[np.int64]
    places: Array
    width: float
    reach: float


def find_coils(picture: Array, coils: int | None) -> Found:
    """Number, places and width of the highlights. Raises :class:`InputError` where the picture shows none or not as many as told."""
    smooth = _smoothed(picture)
    contrast = np.percentile(smooth, 98, axis=1) - np.percentile(smooth, 5, axis=1)
    usual = float(np.median(contrast))
    if not usual > 0:
        raise InputError("the line shows no highlight; lay it across the coils, where the lamp's glare is", "line")
    peaks = [find_peaks(row, PROMINENCE * usual) for row in smooth]
    counts = np.array([len(place) for place, _ in peaks])
    told = coils is not None
    if coils is None:
        shares = [(count, np.mean(counts == count)) for count in range(1, int(counts.max(initial=0)) + 1)]
        believed = [count for count, share in shares if share >= BELIEVED]
        if not believed:
            raise InputError("the line shows no clear highlights; lay it across the coils, or give the number of coils it crosses", "coils")
        coils = max(believed)
    if not 1 <= coils <= MOST_COILS:
        raise InputError(f"{coils} highlights lie on the line; 1 to {MOST_COILS} are tracked, so shorten it or give their number", "coils")
    enough = np.flatnonzero(counts >= coils)
    if not len(enough):
        raise InputError(
            f"{coils} coils are stated, but no frame shows more than {counts.max()} highlights; correct it or the line", "coils"
        )
    # A number that is told leaves out what else shines, such as rear coils: the least prominent peaks.
    frames = enough if told else enough[counts[enough] == coils]
    picks = [np.sort(np.argsort(-peaks[frame][1], kind="stable")[:coils]) for frame in frames]
    places = np.array([peaks[frame][0][pick] for frame, pick in zip(frames, picks, strict=True)], dtype=float)
    some = range(0, len(frames), max(1, len(frames) // 50))
    widths = [half_width(smooth[frames[k]], *one) for k in some for one in zip(*(part[picks[k]] for part in peaks[frames[k]]), strict=True)]
    width = float(np.median(widths))
    apart = float(np.median(np.diff(places, axis=1).min(axis=1))) if coils > 1 else 4.0 * width
    return Found(frames, places, width, float(np.clip(1.5 * width, 4.0, max(4.0, 0.5 * apart))))


def _smoothed(picture: Array) -> Array:
    """A little smoothed along the line, so that noise makes no peaks."""
    kernel = np.array([1.0, 4.0, 6.0, 4.0, 1.0]) / 16.0
    wide = np.pad(np.asarray(picture, dtype=float), ((0, 0), (2, 2)), mode="edge")
    return np.asarray(sum(share * wide[:, k : k + picture.shape[1]] for k, share in enumerate(kernel)))


def ordered(response: Array, expected: Array, scale: float, apart: int) -> Array:
    """Stations of all coils with the largest sum of response less distance from expectation, ``apart`` stations apart at least."""
    coils, stations = response.shape
    station = np.arange(stations)
    score = response - MISSED * np.minimum(((station - expected[:, None]) / scale) ** 2, 4.0)
    best, choice = score[0], []
    for coil in range(1, coils):
        highest = np.maximum.accumulate(best)
        place = np.maximum.accumulate(np.where(best >= highest, station, 0))
        before = np.concatenate([np.full(apart, -1e9), highest[:-apart]])
        choice.append(np.concatenate([np.zeros(apart, dtype=np.int64), place[:-apart]]))
        best = score[coil] + before
    found = [int(np.argmax(best))]
    for place in reversed(choice):
        found.append(int(place[found[-1]]))
    return np.array(found[::-1], dtype=float)
