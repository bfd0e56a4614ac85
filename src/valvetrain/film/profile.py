"""Places of highlights to a small part of a pixel: all profiles of a frame fitted together, their
shapes learnt from the film.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array, Ints
from valvetrain.errors import InputError

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

    frames: Ints
    places: Array
    width: float
    reach: float


def find_coils(picture: Array, coils: int | None) -> FoundCoils:
    """Number, places and width of the highlights. Raises :class:`InputError` where the picture
    shows none or not as many as given.
    """
    from scipy.ndimage import correlate1d
    from scipy.signal import find_peaks, peak_widths

    # A little smoothed along the line, so that noise makes no peaks.
    kernel = np.array([1.0, 4.0, 6.0, 4.0, 1.0]) / 16.0
    smooth = correlate1d(picture, kernel, axis=1, mode="nearest")
    typical = float(np.median(np.ptp(np.percentile(smooth, (5, 98), axis=1), axis=0)))
    if not typical > 0:
        raise InputError(
            "the line shows no highlight; lay it across the coils, where the lamp's glare is",
            "line",
        )
    peaks = [find_peaks(row, prominence=PROMINENCE * typical) for row in smooth]
    counts = np.array([len(place) for place, _ in peaks])
    # A given number leaves out what else shines, such as rear coils: the least prominent peaks.
    fits = counts >= (coils or 1)
    if coils is None:
        believed = np.flatnonzero(np.bincount(counts) >= BELIEVED * len(counts))
        coils = int(believed.max(initial=0))
        fits = counts == coils
    if not 1 <= coils <= MAX_COILS:
        raise InputError(
            f"{coils} clear highlights are on the line; 1 to {MAX_COILS} are tracked, so lay it across the coils, or give their number",
            "coils",
        )
    frames = np.flatnonzero(fits)
    if not len(frames):
        raise InputError(
            f"{coils} coils are stated, but no frame shows more than {counts.max()} highlights; correct it or the line",
            "coils",
        )
    places = []
    for frame in frames:
        place, about = peaks[frame]
        places.append(place[np.sort(np.argsort(-about["prominences"], kind="stable")[:coils])])
    some = range(0, len(frames), max(1, len(frames) // 50))
    widths = [peak_widths(smooth[frames[k]], places[k])[0] for k in some]
    width = float(np.median(widths))
    where = np.array(places, dtype=float)
    apart = float(np.median(np.diff(where, axis=1).min(axis=1))) if coils > 1 else 4.0 * width
    reach = float(np.clip(1.5 * width, 4.0, max(4.0, 0.5 * apart)))
    return FoundCoils(frames, where, width, reach)


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
    path = [int(np.argmax(best))]
    for place in reversed(choice):
        path.append(int(place[path[-1]]))
    return np.array(path[::-1], dtype=float)


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

    def responses(self, row: Array) -> Array:
        """How well each coil's profile fits at each station of a frame (coils, stations) under a lamp of brightness 1: the
        height that it would have there, 1.2 at most.
        """
        from scipy.ndimage import correlate1d

        steps = np.arange(-np.floor(self.reach), np.floor(self.reach) + 1)
        points = np.linspace(-self.reach, self.reach, self.table.shape[1])
        kernels = np.array([np.interp(steps, points, table) for table in self.table])
        kernels -= kernels.mean(axis=1, keepdims=True)
        kernels /= np.sum(kernels**2, axis=1, keepdims=True)
        heights = [correlate1d(row, kernel, mode="nearest") for kernel in kernels]
        return np.asarray(np.clip(heights, -0.5, 1.2))

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
    if len(start) > AT_ONCE:
        fits = []
        for k in range(0, len(start), AT_ONCE):
            part = slice(k, k + AT_ONCE)
            fits.append(fit(picture[part], start[part], profiles, light[part], least_apart, near))
        names = ("places", "spread", "heights", "noise")
        return Fit(*(np.concatenate([getattr(part, name) for part in fits]) for name in names))
    coils, grounds = start.shape[1], grounds_of(picture.shape[1])
    lit = np.repeat(np.maximum(light, 1e-9)[:, None], coils, axis=1)
    free = np.zeros((len(start), len(grounds)))
    expected = np.hstack([start, lit, free])
    scatter = np.hstack([0 * start + (near or np.inf), HEIGHT_SCATTER * lit, free + np.inf])
    diagonal = np.arange(expected.shape[1])
    station, slopes = np.arange(picture.shape[1]), np.gradient(profiles.table, 1 / FINE, axis=1)
    least_noise = 1e-6 * float(np.abs(profiles.table).max())
    numbers, settled = expected.copy(), False
    for step in range(STEPS + 1):
        places, heights, ground = np.split(numbers, (coils, 2 * coils), axis=1)
        distance = station - places[:, :, None]
        shape = profiles.at(distance, profiles.table)
        slope = -heights[:, :, None] * profiles.at(distance, slopes)
        # Between coils other things shine (rear coils, the inner spring): only what is under the
        # profiles counts.
        under = (np.abs(distance) <= profiles.reach).any(axis=1).astype(float)
        behind = np.broadcast_to(grounds, (len(start), *grounds.shape))
        columns = np.concatenate([slope, shape, behind], axis=1) * under[:, None]
        left = (picture - np.einsum("fc,fcs->fs", heights, shape) - ground @ grounds) * under
        count = np.maximum(under.sum(axis=1) - len(diagonal), 1.0)
        noise = np.maximum(np.sqrt((left**2).sum(axis=1) / count), least_noise)
        stiff = (noise[:, None] / scatter) ** 2
        normal = columns @ columns.transpose(0, 2, 1)
        normal[:, diagonal, diagonal] += stiff + 1e-12
        normal[:, diagonal, diagonal] += 1e-9 * normal[:, diagonal, diagonal].mean(axis=1)[:, None]
        if step == STEPS or settled:
            break
        right = np.einsum("fps,fs->fp", columns, left) + stiff * (expected - numbers)
        change = np.linalg.solve(normal, right[..., None])[..., 0]
        change[:, :coils] = np.clip(change[:, :coils], -MAX_STEP, MAX_STEP)
        numbers += change
        for coil in range(coils - 1):  # neighbours that came too near are moved apart alike
            missing = np.maximum(least_apart - (places[:, coil + 1] - places[:, coil]), 0.0)
            places[:, coil] -= 0.5 * missing
            places[:, coil + 1] += 0.5 * missing
        np.clip(heights, 0.05 * lit, 4 * lit, out=heights)
        # Before the first step heights and ground are not known, so the noise that a prediction is
        # weighed against is not either.
        settled = bool(np.abs(change[:, :coils]).max() < SETTLED) and (step > 0 or near == 0)
    # What blur leaves runs on from station to station, so it carries less information than noise would.
    alike = (left[:, 1:] * left[:, :-1]).sum(axis=1) / np.maximum((left**2).sum(axis=1), 1e-300)
    alike = np.clip(alike, 0.0, 0.8)
    variance = np.maximum(np.linalg.inv(normal)[:, diagonal, diagonal][:, :coils], 0.0)
    deviation = (noise * np.sqrt((1 + alike) / (1 - alike)))[:, None] * np.sqrt(variance)
    return Fit(places, deviation, heights, noise)


def light_of(picture: Array, clear: Ints) -> Array:
    """Brightness of the lamp (frames,) about 1: contrast of the line, smoothed over frames, against that of ``clear`` frames."""
    from scipy.ndimage import uniform_filter1d

    contrast = np.percentile(picture, 98, axis=1) - np.percentile(picture, 10, axis=1)
    smooth = uniform_filter1d(contrast, min(51, 2 * (len(contrast) // 4) + 1), mode="nearest")
    return np.asarray(smooth / np.median(smooth[clear]))


def grounds_of(stations: int) -> Array:
    """Smooth shapes (shapes, stations) of which the ground behind the spring is made."""
    station = np.arange(stations, dtype=float)
    return np.stack(
        [np.ones_like(station), *(np.cos(np.pi * k * station / stations) for k in (1, 2, 3))]
    )
