"""Tracks of all coils through a film, with their standard deviations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.film.profile import (
    FINE,
    Fit,
    FoundCoils,
    Profiles,
    find_coils,
    fit,
    grounds_of,
    light_of,
    ordered,
    responses,
)
from valvetrain.film.space_time import SpaceTime

Array = NDArray[np.float64]
#: Standard deviation of a prediction in parts of the coils' spacing.
PREDICTED = 0.12


def bridge(
    picture: Array,
    clear: NDArray[np.bool_],
    places: Array,
    number: NDArray[np.int64],
    profiles: Profiles,
    light: Array,
    least_apart: float,
) -> tuple[Array, Array]:
    """Places of all frames, those of ``clear`` frames (frames,) being known, and how far (px) the
    two ways through a gap differ.

    In every other frame all coils are fitted together from where their motion predicts them and
    from the best ordered set of stations; the
    better fit continues. Gaps are gone through both ways, and the way with the smaller misfit is
    taken.
    """
    places, apart = places.copy(), np.zeros(len(places))
    spacing = (
        float(np.median(np.diff(np.median(places[clear], axis=0))))
        if places.shape[1] > 1
        else 4 * profiles.reach
    )
    fits = responses(picture, profiles, light)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], ~clear, [False]]).astype(int)))
    for first, end in zip(edges[::2], edges[1::2], strict=True):
        ways = []
        for order, step, begins in (
            (range(first, end), 1, first > 0),
            (range(end - 1, first - 1, -1), -1, end < len(clear)),
        ):
            if begins:
                ways.append(
                    _through(
                        picture,
                        places,
                        order,
                        step,
                        number,
                        profiles,
                        light,
                        fits,
                        spacing,
                        least_apart,
                    )
                )
        best = min(ways, key=lambda one: one[1])
        places[first:end] = best[0]
        if len(ways) > 1:
            apart[first:end] = np.abs(ways[0][0] - ways[1][0]).max(axis=1)
    return places, apart


def _through(
    picture: Array,
    places: Array,
    order: range,
    step: int,
    number: NDArray[np.int64],
    profiles: Profiles,
    light: Array,
    fits: Callable[[int], Array],
    spacing: float,
    least_apart: float,
) -> tuple[Array, float]:
    """Places (frames of the gap, coils) in rising order, and the sum of squared misfits."""
    known, misfit = places.copy(), 0.0
    for frame in order:
        before, earlier = frame - step, frame - 2 * step
        span = abs(int(number[frame] - number[before]))
        velocity = np.zeros(places.shape[1])
        if 0 <= earlier < len(places):
            velocity = (known[before] - known[earlier]) / abs(int(number[before] - number[earlier]))
        expected = np.maximum.accumulate(known[before] + velocity * min(span, 2))
        station = ordered(
            fits(frame), expected, spacing * np.sqrt(span), max(2, round(least_apart))
        )
        both, one = np.stack([expected, station]), np.repeat(picture[frame : frame + 1], 2, axis=0)
        found = fit(
            one,
            both,
            profiles,
            np.repeat(light[frame], 2),
            least_apart,
            PREDICTED * spacing * np.sqrt(span),
        )
        # The best stations must fit clearly better: where all has merged they only guess.
        better = int(found.noise[1] < 0.8 * found.noise[0])
        known[frame] = found.places[better]
        misfit += float(found.noise[better] ** 2)
    return known[min(order) : max(order) + 1], misfit


#: Distance (px) of the knots of a profile, frames from which it is learnt at most, and how smooth
#: it is taken to be.
KNOT, LEARNT_FROM, SMOOTH = 0.7, 150, 1e-3


def learn(
    picture: Array, frames: NDArray[np.int64], places: Array, heights: Array, reach: float
) -> Profiles:
    """Profiles of all coils and a smooth ground together, by least squares of the grey levels
    below.

    ``places``, ``heights`` (frames, coils) of the ``frames`` given. A profile is a cubic spline,
    zero from ``reach`` px on.
    """
    from scipy.interpolate import BSpline
    from scipy.sparse import csr_matrix

    pick = np.arange(len(frames))[:: max(1, len(frames) // LEARNT_FROM)]
    coils, stations = places.shape[1], picture.shape[1]
    inside = np.linspace(-reach, reach, int(np.ceil(2 * reach / KNOT)) + 1)
    step = inside[1] - inside[0]
    knots = np.concatenate(
        [inside[0] - step * np.arange(3, 0, -1), inside, inside[-1] + step * np.arange(1, 4)]
    )
    # The first and last two splines are left out, so value and slope at the ends are those of a
    # third one's foot.
    count = len(knots) - 4 - 4
    distance = np.arange(stations) - places[pick][:, :, None]
    frame, coil, station = np.nonzero(np.abs(distance) < reach)
    basis = BSpline.design_matrix(distance[frame, coil, station], knots, 3).tocoo()
    interior = (basis.col >= 2) & (basis.col < count + 2)
    row, column = basis.row[interior], basis.col[interior] - 2
    value = basis.data[interior] * heights[pick][frame, coil][row]
    near = np.zeros((len(pick), stations), dtype=bool)
    near[frame, station] = True
    grounds, light = grounds_of(stations), heights[pick].mean(axis=1)
    at_frame, at_station = np.nonzero(near)
    ground_rows = np.tile(at_frame * stations + at_station, len(grounds))
    ground_columns = np.repeat(coils * count + np.arange(len(grounds)), len(at_frame))
    rows = np.concatenate([(frame * stations + station)[row], ground_rows])
    columns = np.concatenate([coil[row] * count + column, ground_columns])
    values = np.concatenate([value, (light[at_frame] * grounds[:, at_station]).ravel()])
    size = coils * count + len(grounds)
    matrix = csr_matrix((values, (rows, columns)), shape=(len(pick) * stations, size))
    normal = (matrix.T @ matrix).toarray()
    right = matrix.T @ np.where(near, picture[frames[pick]], 0.0).ravel()
    bend = np.diff(np.eye(count), 2, axis=0)
    weight = np.trace(normal[: coils * count, : coils * count]) / (coils * count)
    for one in range(coils):
        part = slice(one * count, (one + 1) * count)
        normal[part, part] += SMOOTH * weight * bend.T @ bend
    normal[np.arange(size), np.arange(size)] += 1e-7 * weight
    shares = np.linalg.solve(normal, right)
    half = int(np.floor(reach * FINE))
    fine = np.arange(-half, half + 1) / FINE
    table = [
        BSpline(knots, np.concatenate([[0, 0], shares[k * count : (k + 1) * count], [0, 0]]), 3)(
            fine
        )
        for k in range(coils)
    ]
    return Profiles(np.array(table), half / FINE)


#: Rounds of learning the profiles and fitting the places.
ROUNDS = 2
#: Factor of the standard deviation of a place where highlights merge: there it depends on shapes
#: that are never known exactly.
MERGED = 2.0
#: Factor within which a highlight is as bright as it typically is where it is separate, and one
#: below which it may be of a rear coil.
ALIKE, DIM = 2.0, 0.5
#: Reach of a profile to either side in widths of a highlight.
WIDE = 1.6
#: A place is given up whose standard deviation is larger than this share of the highlight's width.
LOST = 0.5
#: Share of such places beyond which a film gives no result.
MAX_LOST = 0.5


@dataclass(frozen=True, eq=False)
class Tracks:
    """``places`` (frames, coils) px from the start of the line, in the order along it, and their
    ``spread`` (standard deviation);
    ``merged`` (frames, coils): the highlight was nearer to its neighbour than their widths, so
    its motion and order say which it is;
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
    profiles = learn(
        picture,
        frames,
        found.places,
        np.repeat(light[frames, None], places.shape[1], axis=1),
        found.reach,
    )
    for _ in range(ROUNDS):
        known = fit(picture[frames], places[frames], profiles, light[frames], apart)
        places[frames] = known.places
        profiles = learn(picture, frames, known.places, known.heights, WIDE * found.width)
    typical = np.median(known.heights / light[frames, None], axis=0)
    alike = np.abs(np.log(np.maximum(known.heights / light[frames, None], 1e-6) / typical)).max(
        axis=1
    ) < np.log(ALIKE)
    sure = alike & (known.noise < 2.5 * np.median(known.noise))
    if (
        sure.any()
    ):  # a peak next to a merged one is no coil: such a frame is followed like the others
        clear[frames[~sure]] = False
    places, doubt = bridge(picture, clear, places, seen.number, profiles, light, apart)
    result = fit(picture, places, profiles, light, apart)
    profiles = learn(
        picture, np.arange(len(picture)), result.places, result.heights, WIDE * found.width
    )
    result = fit(picture, result.places, profiles, light, apart)
    bright = profiles.table.max(axis=1)
    dim = np.flatnonzero(bright < DIM * np.median(bright)) + 1
    return _as_tracks(result, found, doubt, tuple(dim.tolist()))


def _as_tracks(result: Fit, found: FoundCoils, doubt: Array, dim: tuple[int, ...]) -> Tracks:
    spread = np.maximum(result.spread, np.where(doubt > found.width, doubt, 0.0)[:, None])
    gaps = np.diff(result.places, axis=1)
    close = gaps < 1.5 * found.width
    merged = np.zeros(result.places.shape, dtype=bool)
    merged[:, :-1] |= close
    merged[:, 1:] |= close
    spread = np.where(merged, MERGED * spread, spread)
    lost = spread > LOST * found.width
    if lost.mean() > MAX_LOST:
        sentence = "the highlights are too weak or too blurred to follow"
        raise InputError(
            f"{sentence}; light the spring with one lamp next to the camera, lay the line across the highlights, or give the number of coils",
            "line",
        )
    notes = []
    if dim:
        notes.append(
            f"{len(dim)} of {len(merged.T)} highlights are less than half as bright as the others; where they are rear coils, say "
            "how many coils the line crosses"
        )
    if merged.any():
        notes.append(
            f"neighbouring highlights merge in {int(merged.any(axis=1).sum())} of {len(merged)} frames; there their order and their "
            "own profiles show which is which"
        )
    if lost.any():
        notes.append(
            f"{int(lost.sum())} places of {lost.size} are too uncertain (highlight weak or hidden) and are left open"
        )
    return Tracks(np.where(lost, np.nan, result.places), spread, merged, found.width, tuple(notes))
