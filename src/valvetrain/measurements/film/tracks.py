"""Tracks of all coils through a film, with their standard deviations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.measurements.film.bridge import bridge
from valvetrain.measurements.film.coil_search import Found, find_coils
from valvetrain.measurements.film.learning import learn
from valvetrain.measurements.film.matched_profile import Fit, fit, light_of
from valvetrain.measurements.film.space_time import SpaceTime

Array = NDArray[np.float64]
#: Rounds of learning the profiles and fitting the places.
ROUNDS = 2
#: Factor of the standard deviation of a place where highlights merge: there it depends on shapes that are never known exactly.
MERGED = 2.0
#: Factor within which a highlight is as bright as it usually is where it stands apart, and one below which it may be of a rear coil.
ALIKE, DIM = 2.0, 0.5
#: Reach of a profile to either side in widths of a highlight.
WIDE = 1.6
#: A place is given up whose standard deviation is larger than this share of the highlight's width.
LOST = 0.5
#: Share of such places beyond which a film tells nothing.
MOST_LOST = 0.5


@dataclass(frozen=True, eq=False)
class Tracks:
    """``places`` (frames, coils) px from the start of the line, in the order along it, and their ``spread`` (standard deviation);
    ``merged`` (frames, coils): the highlight stood nearer to its neighbour than their widths, so its motion and order told which it is;
    ``width`` px of a highlight."""

    places: Array
    spread: Array
    merged: NDArray[np.bool_]
    width: float
    notes: tuple[str, ...] = ()


def track(seen: SpaceTime, coils: int | None = None) -> Tracks:
    """The coils of a space-time picture. Raises :class:`InputError` for one without highlights."""
    picture = np.asarray(seen.picture, dtype=float)
    found = find_coils(picture, coils)
    light = light_of(picture, found)
    apart = max(1.5, 0.5 * found.width)
    clear, frames = np.zeros(len(picture), dtype=bool), found.frames
    clear[frames] = True
    places = np.zeros((len(picture), found.places.shape[1]))
    places[frames] = found.places
    profiles = learn(picture, frames, found.places, np.repeat(light[frames, None], places.shape[1], axis=1), found.reach)
    for _ in range(ROUNDS):
        known = fit(picture[frames], places[frames], profiles, light[frames], apart)
        places[frames] = known.places
        profiles = learn(picture, frames, known.places, known.heights, WIDE * found.width)
    usual = np.median(known.heights / light[frames, None], axis=0)
    alike = np.abs(np.log(np.maximum(known.heights / light[frames, None], 1e-6) / usual)).max(axis=1) < np.log(ALIKE)
    sure = alike & (known.noise < 2.5 * np.median(known.noise))
    if sure.any():  # a peak beside a merged one is no coil: such a frame is followed like the others
        clear[frames[~sure]] = False
    places, doubt = bridge(picture, clear, places, seen.number, profiles, light, apart)
    result = fit(picture, places, profiles, light, apart)
    profiles = learn(picture, np.arange(len(picture)), result.places, result.heights, WIDE * found.width)
    result = fit(picture, result.places, profiles, light, apart)
    bright = profiles.table.max(axis=1)
    dim = np.flatnonzero(bright < DIM * np.median(bright)) + 1
    return _told(result, found, doubt, tuple(dim.tolist()))


def _told(result: Fit, found: Found, doubt: Array, dim: tuple[int, ...]) -> Tracks:
    spread = np.maximum(result.spread, np.where(doubt > found.width, doubt, 0.0)[:, None])
    gaps = np.diff(result.places, axis=1)
    close = gaps < 1.5 * found.width
    merged = np.zeros(result.places.shape, dtype=bool)
    merged[:, :-1] |= close
    merged[:, 1:] |= close
    spread = np.where(merged, MERGED * spread, spread)
    lost = spread > LOST * found.width
    if lost.mean() > MOST_LOST:
        words = "the highlights are too weak or too blurred to follow"
        raise InputError(
            f"{words}; light the spring with one lamp beside the camera, lay the line across the highlights, or give the number of coils",
            "line",
        )
    notes = []
    if dim:
        notes.append(
            f"{len(dim)} of {len(merged.T)} highlights are less than half as bright as the others; where they are rear coils, tell "
            "how many coils the line crosses"
        )
    if merged.any():
        notes.append(
            f"neighbouring highlights merge in {int(merged.any(axis=1).sum())} of {len(merged)} frames; there their order and their "
            "own profiles tell which is which"
        )
    if lost.any():
        notes.append(f"{int(lost.sum())} places of {lost.size} are too uncertain (highlight weak or hidden) and are left open")
    return Tracks(np.where(lost, np.nan, result.places), spread, merged, found.width, tuple(notes))
