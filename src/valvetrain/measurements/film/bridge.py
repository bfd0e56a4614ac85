"""Coils followed through the frames in which their highlights merge, from the clear frames on either side."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from valvetrain.measurements.film.coil_search import ordered
from valvetrain.measurements.film.matched_profile import Profiles, fit, responses

Array = NDArray[np.float64]
#: Standard deviation of a prediction in parts of the coils' spacing.
PREDICTED = 0.12


def bridge(
    picture: Array, clear: NDArray[np.bool_], places: Array, number: NDArray[np.int64], profiles: Profiles, light: Array, least_apart: float
) -> tuple[Array, Array]:  # fmt: skip
    """Places of all frames, those of ``clear`` frames (frames,) being known, and how far (px) the two ways through a gap differ.

    In every other frame all coils are fitted together from where their motion predicts them and from the best ordered set of stations; the
    better fit goes on. Gaps are gone through both ways, and the way with the smaller misfit is taken.
    """
    places, apart = places.copy(), np.zeros(len(places))
    spacing = float(np.median(np.diff(np.median(places[clear], axis=0)))) if places.shape[1] > 1 else 4 * profiles.reach
    fits = responses(picture, profiles, light)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], ~clear, [False]]).astype(int)))
    for first, end in zip(edges[::2], edges[1::2], strict=True):
        ways = []
        for order, step, begins in ((range(first, end), 1, first > 0), (range(end - 1, first - 1, -1), -1, end < len(clear))):
            if begins:
                ways.append(_through(picture, places, order, step, number, profiles, light, fits, spacing, least_apart))
        best = min(ways, key=lambda one: one[1])
        places[first:end] = best[0]
        if len(ways) > 1:
            apart[first:end] = np.abs(ways[0][0] - ways[1][0]).max(axis=1)
    return places, apart


def _through(
    picture: Array, places: Array, order: range, step: int, number: NDArray[np.int64], profiles: Profiles, light: Array,
    fits: Callable[[int], Array], spacing: float, least_apart: float,
) -> tuple[Array, float]:  # fmt: skip
    """Places (frames of the gap, coils) in rising order, and the sum of squared misfits."""
    known, misfit = places.copy(), 0.0
    for frame in order:
        before, earlier = frame - step, frame - 2 * step
        span = abs(int(number[frame] - number[before]))
        velocity = np.zeros(places.shape[1])
        if 0 <= earlier < len(places):
            velocity = (known[before] - known[earlier]) / abs(int(number[before] - number[earlier]))
        expected = np.maximum.accumulate(known[before] + velocity * min(span, 2))
        station = ordered(fits(frame), expected, spacing * np.sqrt(span), max(2, round(least_apart)))
        both, one = np.stack([expected, station]), np.repeat(picture[frame : frame + 1], 2, axis=0)
        found = fit(one, both, profiles, np.repeat(light[frame], 2), least_apart, PREDICTED * spacing * np.sqrt(span))
        # The best stations must fit clearly better: where all has merged they only guess.
        better = int(found.noise[1] < 0.8 * found.noise[0])
        known[frame] = found.places[better]
        misfit += float(found.noise[better] ** 2)
    return known[min(order) : max(order) + 1], misfit
