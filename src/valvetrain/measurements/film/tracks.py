"""Tracks of all coils through a film, with their standard deviations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.measurements.film.coil_search import Found, find_coils, follow
from valvetrain.measurements.film.matched_profile import Fit, Profiles, fit, learn, light_of, responses
from valvetrain.measurements.film.space_time import SpaceTime

Array = NDArray[np.float64]
#: Rounds of learning the profiles and fitting the places.
ROUNDS = 3
#: A place is given up whose standard deviation is larger than this share of the highlight's width.
LOST = 0.5


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
    profiles = learn(picture, found.frames, found.places, np.repeat(light[found.frames, None], found.places.shape[1], axis=1), found.reach)
    places = follow(responses(picture, profiles, light), found, seen.number)
    apart = max(1.5, 0.5 * found.width)
    result = fit(picture, places, profiles, light, apart)
    for _ in range(ROUNDS - 1):
        profiles = _learnt_again(picture, result, found, profiles)
        result = fit(picture, result.places, profiles, light, apart)
    return _told(result, found)


def _learnt_again(picture: Array, result: Fit, found: Found, profiles: Profiles) -> Profiles:
    """Profiles from the frames in which all coils stand apart, the neighbours' taken off."""
    frames = found.frames
    places, heights = result.places[frames], result.heights[frames]
    return learn(picture, frames, places, heights, profiles.reach)


def _told(result: Fit, found: Found) -> Tracks:
    gaps = np.diff(result.places, axis=1)
    close = gaps < 1.5 * found.width
    merged = np.zeros(result.places.shape, dtype=bool)
    merged[:, :-1] |= close
    merged[:, 1:] |= close
    lost = result.spread > LOST * found.width
    notes = []
    if merged.any():
        notes.append(
            f"neighbouring highlights merge in {int(merged.any(axis=1).sum())} of {len(merged)} frames; there their order and their "
            "own profiles tell which is which"
        )
    if lost.any():
        notes.append(f"{int(lost.sum())} places of {lost.size} are too uncertain (highlight weak or hidden) and are left open")
    return Tracks(np.where(lost, np.nan, result.places), result.spread, merged, found.width, tuple(notes))
