"""Places of highlights to a small part of a pixel: all profiles of a frame fitted together, their
shapes learnt from the film.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError

Array = NDArray[np.float64]


def find_peaks(row: Array, least: float) -> tuple[NDArray[np.int64], Array]:
    """Places of the local maxima of ``row`` (stations,) inside it and their prominences, those of
    at least ``least``.

    The prominence is the height above the higher of the two lowest levels between the peak
    and higher ground (or the end).
    """
    rises, falls = row[1:-1] > row[:-2], row[1:-1] >= row[2:]
    places = np.flatnonzero(rises & falls) + 1
    places = places[row[places] >= row.min() + least]
    peak_columns, heights = [], []
    for place in places:
        top = row[place]
        higher = row > top
        before, after = np.flatnonzero(higher[:place]), np.flatnonzero(higher[place + 1 :])
        left = row[before[-1] + 1 if len(before) else 0 : place + 1].min()
        right = row[place : place + 1 + (after[0] if len(after) else len(row))].min()
        if top - max(left, right) >= least:
            peak_columns.append(int(place))
            heights.append(float(top - max(left, right)))
    return np.array(peak_columns, dtype=np.int64), np.array(heights)


def half_width(row: Array, place: int, prominence: float) -> float:
    """Width (stations) of a peak at half its prominence, by straight lines between stations."""
    level = row[place] - 0.5 * prominence
    edges = []
    for step in (-1, 1):
        at = place
        while 0 <= at + step < len(row) and row[at + step] > level:
            at += step
        end = at + step
        edges.append(
            at + step * (row[at] - level) / (row[at] - row[end])
            if 0 <= end < len(row)
            else float(at)
        )
    return float(edges[1] - edges[0])


#: A highlight exceeds its surroundings by this share of the picture's contrast; a number of coils is believed
#: that this share of frames shows.
PROMINENCE, BELIEVED = 0.25, 0.15
#: Most coils of a spring that are tracked.
MAX_COILS = 40
#: Weight lost by a highlight that is as far from its prediction as the next coil, against 1 for a
#: highlight that fits.
MISSED = 0.5


@dataclass(frozen=True, eq=False)
class FoundCoils:
    """``frames`` (frames,) in which all coils are separate; ``places`` (frames, coils) px of their
    highlights there; ``width`` (px) of one
    at half height; ``reach`` (px) to either side that its profile takes."""

    frames: NDArray[np.int64]
    places: Array
    width: float
    reach: float


def find_coils(picture: Array, coils: int | None) -> FoundCoils:
    """Number, places and width of the highlights. Raises :class:`InputError` where the picture
    shows none or not as many as given.
    """
    smooth = _smoothed(picture)
    contrast = np.percentile(smooth, 98, axis=1) - np.percentile(smooth, 5, axis=1)
    typical = float(np.median(contrast))
    if not typical > 0:
        raise InputError(
            "the line shows no highlight; lay it across the coils, where the lamp's glare is",
            "line",
        )
    peaks = [find_peaks(row, PROMINENCE * typical) for row in smooth]
    counts = np.array([len(place) for place, _ in peaks])
    count_given = coils is not None
    if coils is None:
        shares = [
            (count, np.mean(counts == count)) for count in range(1, int(counts.max(initial=0)) + 1)
        ]
        believed = [count for count, share in shares if share >= BELIEVED]
        if not believed:
            raise InputError(
                "the line shows no clear highlights; lay it across the coils, or give the number of coils it crosses",
                "coils",
            )
        coils = max(believed)
    if not 1 <= coils <= MAX_COILS:
        raise InputError(
            f"{coils} highlights are on the line; 1 to {MAX_COILS} are tracked, so shorten it or give their number",
            "coils",
        )
    enough = np.flatnonzero(counts >= coils)
    if not len(enough):
        raise InputError(
            f"{coils} coils are stated, but no frame shows more than {counts.max()} highlights; correct it or the line",
            "coils",
        )
    # A given number leaves out what else shines, such as rear coils: the least prominent
    # peaks.
    frames = enough if count_given else enough[counts[enough] == coils]
    picks = [np.sort(np.argsort(-peaks[frame][1], kind="stable")[:coils]) for frame in frames]
    places = np.array(
        [peaks[frame][0][pick] for frame, pick in zip(frames, picks, strict=True)], dtype=float
    )
    some = range(0, len(frames), max(1, len(frames) // 50))
    widths = [
        half_width(smooth[frames[k]], *one)
        for k in some
        for one in zip(*(part[picks[k]] for part in peaks[frames[k]]), strict=True)
    ]
    width = float(np.median(widths))
    apart = float(np.median(np.diff(places, axis=1).min(axis=1))) if coils > 1 else 4.0 * width
    return FoundCoils(
        frames, places, width, float(np.clip(1.5 * width, 4.0, max(4.0, 0.5 * apart)))
    )


def _smoothed(picture: Array) -> Array:
    """A little smoothed along the line, so that noise makes no peaks."""
    kernel = np.array([1.0, 4.0, 6.0, 4.0, 1.0]) / 16.0
    wide = np.pad(np.asarray(picture, dtype=float), ((0, 0), (2, 2)), mode="edge")
    return np.asarray(
        sum(share * wide[:, k : k + picture.shape[1]] for k, share in enumerate(kernel))
    )


def ordered(response: Array, expected: Array, scale: float, apart: int) -> Array:
    """Stations of all coils with the largest sum of response less distance from expectation,
    ``apart`` stations apart at least.
    """
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


#: Points of a profile per pixel, frames fitted at a time, and steps of a fit.
FINE, AT_ONCE, STEPS = 16, 256, 8
#: Change (px) of a place at which steps end, how far it may move in one, and the scatter of heights
#: about the typical one that is expected.
SETTLED, MAX_STEP, HEIGHT_SCATTER = 1e-3, 1.0, 0.3


@dataclass(frozen=True, eq=False)
class Profiles:
    """Brightness of each coil's highlight over the distance from it: ``table`` (coils, points),
    ``FINE`` points a pixel, to ``reach``.
    """

    table: Array
    reach: float

    @property
    def slope(self) -> Array:
        """Derivative by the distance."""
        return np.asarray(np.gradient(self.table, 1.0 / FINE, axis=1))

    def at(self, distance: Array, table: Array) -> Array:
        """``table`` (coils, points) at ``distance`` (..., coils, stations), 0 beyond the reach."""
        place = (distance + self.reach) * FINE
        low = np.clip(np.floor(place).astype(np.int64), 0, table.shape[1] - 2)
        share = place - low
        coil = np.arange(table.shape[0])[:, None]
        value = table[coil, low] * (1 - share) + table[coil, low + 1] * share
        return np.where(np.abs(distance) <= self.reach, value, 0.0)


@dataclass(frozen=True, eq=False)
class Fit:
    """``places`` and their standard deviations (frames, coils) px, ``heights`` of the profiles,
    ``noise`` (frames,) of a station.
    """

    places: Array
    spread: Array
    heights: Array
    noise: Array


def responses(picture: Array, profiles: Profiles, light: Array) -> Callable[[int], Array]:
    """How well each coil's profile fits at each station of a frame (coils, stations): the height
    that it would have there, 1.2 at most.
    """
    from scipy.ndimage import correlate1d

    steps = np.arange(-np.floor(profiles.reach), np.floor(profiles.reach) + 1)
    points = np.linspace(-profiles.reach, profiles.reach, profiles.table.shape[1])
    kernels = [np.interp(steps, points, table) for table in profiles.table]
    kernels = [one - one.mean() for one in kernels]

    @lru_cache(maxsize=2)
    def block(number: int) -> Array:
        part = slice(number * AT_ONCE, (number + 1) * AT_ONCE)
        lit = picture[part] / light[part, None]
        found = [correlate1d(lit, one / np.sum(one**2), axis=1, mode="nearest") for one in kernels]
        return np.asarray(np.clip(np.stack(found, axis=1), -0.5, 1.2))

    def at(frame: int) -> Array:
        found: Array = block(frame // AT_ONCE)[frame % AT_ONCE]
        return found

    return at


def fit(
    picture: Array,
    start: Array,
    profiles: Profiles,
    light: Array,
    least_apart: float,
    near: float = 0.0,
) -> Fit:
    """All coils of every frame fitted together by Gauss-Newton steps: places, heights and a smooth
    ground, least squares.

    Heights are expected near ``light`` (frames,), so that two highlights that merge share their
    brightness as they did apart.
    ``near``: standard deviation (px) of the places about ``start`` where that is a prediction; 0
    for a start that gives nothing.
    """
    parts = [
        _some(
            picture[k : k + AT_ONCE],
            start[k : k + AT_ONCE],
            profiles,
            light[k : k + AT_ONCE],
            least_apart,
            near,
        )
        for k in range(0, len(start), AT_ONCE)
    ]
    return Fit(
        *(
            np.concatenate([getattr(one, name) for one in parts])
            for name in ("places", "spread", "heights", "noise")
        )
    )


def grounds_of(stations: int) -> Array:
    """Smooth shapes (shapes, stations) of which the ground behind the spring is made."""
    station = np.arange(stations, dtype=float)
    return np.stack(
        [np.ones_like(station), *(np.cos(np.pi * k * station / stations) for k in (1, 2, 3))]
    )


def _some(
    picture: Array,
    start: Array,
    profiles: Profiles,
    light: Array,
    least_apart: float,
    prediction: float,
) -> Fit:
    frames, coils = start.shape
    station = np.arange(picture.shape[1], dtype=float)
    grounds = grounds_of(len(station))
    places, heights = start.copy(), np.repeat(light[:, None], coils, axis=1)
    ground = np.zeros((frames, len(grounds)))
    scale = float(np.abs(profiles.table).max())
    slopes = profiles.slope
    index, diagonal = np.arange(coils), np.arange(2 * coils + len(grounds))
    settled = False
    for step in range(STEPS + 1):
        distance = station - places[:, :, None]
        shape, slope = profiles.at(distance, profiles.table), profiles.at(distance, slopes)
        # Between coils other things shine (rear coils, the inner spring): only what is under the
        # profiles counts.
        near = (np.abs(distance) <= profiles.reach).any(axis=1).astype(float)
        columns = np.concatenate(
            [
                -heights[:, :, None] * slope,
                shape,
                np.broadcast_to(grounds, (frames, *grounds.shape)),
            ],
            axis=1,
        )
        columns *= near[:, None]
        left = (picture - np.einsum("fc,fcs->fs", heights, shape) - ground @ grounds) * near
        free = np.maximum(near.sum(axis=1) - len(diagonal), 1.0)
        noise = np.maximum(np.sqrt((left**2).sum(axis=1) / free), 1e-6 * scale)
        normal = columns @ columns.transpose(0, 2, 1)
        right = np.einsum("fps,fs->fp", columns, left)
        stiff = (noise / (HEIGHT_SCATTER * np.maximum(light, 1e-9))) ** 2
        normal[:, coils + index, coils + index] += stiff[:, None]
        right[:, coils : 2 * coils] += stiff[:, None] * (light[:, None] - heights)
        if prediction > 0:
            stiff = (noise / prediction) ** 2
            normal[:, index, index] += stiff[:, None]
            right[:, :coils] += stiff[:, None] * (start - places)
        normal[:, diagonal, diagonal] += (
            1e-9 * np.trace(normal, axis1=1, axis2=2)[:, None] / len(diagonal) + 1e-12
        )
        if step == STEPS or settled:
            break
        change = np.linalg.solve(normal, right[..., None])[..., 0]
        places = _in_order(places + np.clip(change[:, :coils], -MAX_STEP, MAX_STEP), least_apart)
        heights = np.clip(
            heights + change[:, coils : 2 * coils], 0.05 * light[:, None], 4 * light[:, None]
        )
        ground = ground + change[:, 2 * coils :]
        # Before the first step heights and ground are not known, so the noise that a prediction is
        # weighed against is not either.
        settled = bool(np.abs(change[:, :coils]).max() < SETTLED) and (step > 0 or prediction == 0)
    # What blur leaves runs on from station to station, so it carries less information than noise would.
    alike = np.clip(
        (left[:, 1:] * left[:, :-1]).sum(axis=1) / np.maximum((left**2).sum(axis=1), 1e-300),
        0.0,
        0.8,
    )
    deviation = np.sqrt(
        np.maximum(np.diagonal(np.linalg.inv(normal), axis1=1, axis2=2)[:, :coils], 0.0)
    )
    return Fit(
        places, (noise * np.sqrt((1 + alike) / (1 - alike)))[:, None] * deviation, heights, noise
    )


def _in_order(places: Array, least_apart: float) -> Array:
    """Neighbours that came nearer than that are moved apart alike."""
    for coil in range(places.shape[1] - 1):
        missing = np.maximum(least_apart - (places[:, coil + 1] - places[:, coil]), 0.0)
        places[:, coil] -= 0.5 * missing
        places[:, coil + 1] += 0.5 * missing
    return places


def light_of(picture: Array, found: FoundCoils) -> Array:
    """Brightness of the lamp (frames,) about 1: contrast of the line, smoothed over frames."""
    from scipy.ndimage import uniform_filter1d

    contrast = np.percentile(picture, 98, axis=1) - np.percentile(picture, 10, axis=1)
    smooth = uniform_filter1d(contrast, min(51, 2 * (len(contrast) // 4) + 1), mode="nearest")
    return np.asarray(smooth / np.median(smooth[found.frames]))
