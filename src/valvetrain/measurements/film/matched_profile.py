"""Places of highlights to a small part of a pixel: all profiles of a frame fitted together, their shapes learnt from the film."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from valvetrain.measurements.film.coil_search import Found

Array = NDArray[np.float64]
#: Points of a profile per pixel, frames fitted at a time, and steps of a fit.
FINE, AT_ONCE, STEPS = 16, 256, 8
#: Change (px) of a place at which steps end, how far it may move in one, and the scatter of heights about the usual one that is expected.
SETTLED, LARGEST_STEP, HEIGHT_SCATTER = 1e-3, 1.0, 0.3


@dataclass(frozen=True, eq=False)
class Profiles:
    """Brightness of each coil's highlight over the distance from it: ``table`` (coils, points), ``FINE`` points a pixel, to ``reach``."""

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
    """``places`` and their standard deviations (frames, coils) px, ``heights`` of the profiles, ``noise`` (frames,) of a station."""

    places: Array
    spread: Array
    heights: Array
    noise: Array


def responses(picture: Array, profiles: Profiles, light: Array) -> Callable[[int], Array]:
    """How well each coil's profile fits at each station of a frame (coils, stations): the height that it would have there, 1.2 at most."""
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


def fit(picture: Array, start: Array, profiles: Profiles, light: Array, least_apart: float, near: float = 0.0) -> Fit:
    """All coils of every frame fitted together by Gauss-Newton steps: places, heights and a smooth ground, least squares.

    Heights are expected near ``light`` (frames,), so that two highlights that merge share their brightness as they did apart.
    ``near``: standard deviation (px) of the places about ``start`` where that is a prediction; 0 for a start that tells nothing.
    """
    parts = [
        _some(picture[k : k + AT_ONCE], start[k : k + AT_ONCE], profiles, light[k : k + AT_ONCE], least_apart, near)
        for k in range(0, len(start), AT_ONCE)
    ]
    return Fit(*(np.concatenate([getattr(one, name) for one in parts]) for name in ("places", "spread", "heights", "noise")))


def grounds_of(stations: int) -> Array:
    """Smooth shapes (shapes, stations) of which the ground behind the spring is made."""
    station = np.arange(stations, dtype=float)
    return np.stack([np.ones_like(station), *(np.cos(np.pi * k * station / stations) for k in (1, 2, 3))])


def _some(picture: Array, start: Array, profiles: Profiles, light: Array, least_apart: float, prediction: float) -> Fit:
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
        # Between coils other things shine (rear coils, the inner spring): only what lies under the profiles counts.
        near = (np.abs(distance) <= profiles.reach).any(axis=1).astype(float)
        columns = np.concatenate([-heights[:, :, None] * slope, shape, np.broadcast_to(grounds, (frames, *grounds.shape))], axis=1)
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
        normal[:, diagonal, diagonal] += 1e-9 * np.trace(normal, axis1=1, axis2=2)[:, None] / len(diagonal) + 1e-12
        if step == STEPS or settled:
            break
        change = np.linalg.solve(normal, right[..., None])[..., 0]
        places = _kept_in_order(places + np.clip(change[:, :coils], -LARGEST_STEP, LARGEST_STEP), least_apart)
        heights = np.clip(heights + change[:, coils : 2 * coils], 0.05 * light[:, None], 4 * light[:, None])
        ground = ground + change[:, 2 * coils :]
        # Before the first step heights and ground are not known, so the noise that a prediction is weighed against is not either.
        settled = bool(np.abs(change[:, :coils]).max() < SETTLED) and (step > 0 or prediction == 0)
    # What blur leaves runs on from station to station, so it tells less than noise would.
    alike = np.clip((left[:, 1:] * left[:, :-1]).sum(axis=1) / np.maximum((left**2).sum(axis=1), 1e-300), 0.0, 0.8)
    told = np.sqrt(np.maximum(np.diagonal(np.linalg.inv(normal), axis1=1, axis2=2)[:, :coils], 0.0))
    return Fit(places, (noise * np.sqrt((1 + alike) / (1 - alike)))[:, None] * told, heights, noise)


def _kept_in_order(places: Array, least_apart: float) -> Array:
    """Neighbours that came nearer than that are moved apart alike."""
    for coil in range(places.shape[1] - 1):
        missing = np.maximum(least_apart - (places[:, coil + 1] - places[:, coil]), 0.0)
        places[:, coil] -= 0.5 * missing
        places[:, coil + 1] += 0.5 * missing
    return places


def light_of(picture: Array, found: Found) -> Array:
    """Brightness of the lamp (frames,) about 1: contrast of the line, smoothed over frames."""
    from scipy.ndimage import uniform_filter1d

    contrast = np.percentile(picture, 98, axis=1) - np.percentile(picture, 10, axis=1)
    smooth = uniform_filter1d(contrast, min(51, 2 * (len(contrast) // 4) + 1), mode="nearest")
    return np.asarray(smooth / np.median(smooth[found.frames]))
