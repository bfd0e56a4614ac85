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
FINE, AT_ONCE, STEPS = 16, 256, 6
#: How far (px) a place may move in one step, and the scatter of heights about the usual one that is expected.
LARGEST_STEP, HEIGHT_SCATTER = 1.0, 0.3
#: Frames from which a profile is learnt at most.
LEARNT_FROM = 400


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


def learn(
    picture: Array, frames: NDArray[np.int64], places: Array, heights: Array | None, reach: float, others: Array | None = None
) -> Profiles:
    """Profiles from the frames given: a smooth curve through grey levels over the distance from each coil's place.

    ``others``: picture of what else is there, to be taken off for each coil (frames, coils, stations).
    """
    from scipy.interpolate import BSpline

    pick = np.arange(len(frames))[:: max(1, len(frames) // LEARNT_FROM)]
    station = np.arange(picture.shape[1], dtype=float)
    knots = np.arange(-np.ceil(reach) - 3, np.ceil(reach) + 4.5, 0.7)
    fine = np.arange(-round(reach * FINE), round(reach * FINE) + 1) / FINE
    second = np.diff(np.eye(len(knots) - 4), 2, axis=0)
    table = []
    for coil in range(places.shape[1]):
        distance = station - places[pick, coil][:, None]
        near = np.abs(distance) <= reach + 1.0
        grey = picture[frames[pick]] - (0.0 if others is None else others[pick, coil])
        if heights is not None:
            grey = grey / np.maximum(heights[pick, coil], 1e-3)[:, None]
        basis = BSpline.design_matrix(distance[near], knots, 3).toarray()
        normal = basis.T @ basis
        normal += 1e-3 * np.trace(normal) / len(normal) * second.T @ second + 1e-9 * np.trace(normal) * np.eye(len(normal))
        curve = BSpline(knots, np.linalg.solve(normal, basis.T @ grey[near]), 3)(fine)
        table.append(curve - 0.5 * (curve[0] + curve[-1]))
    return Profiles(np.array(table), float(fine[-1]))


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


def fit(picture: Array, start: Array, profiles: Profiles, light: Array, least_apart: float) -> Fit:
    """All coils of every frame fitted together by Gauss-Newton steps: places, heights and a smooth ground, least squares.

    Heights are expected near ``light`` (frames,), so that two highlights that merge share their brightness as they did apart.
    """
    parts = [
        _some(picture[k : k + AT_ONCE], start[k : k + AT_ONCE], profiles, light[k : k + AT_ONCE], least_apart)
        for k in range(0, len(start), AT_ONCE)
    ]
    return Fit(*(np.concatenate([getattr(one, name) for one in parts]) for name in ("places", "spread", "heights", "noise")))


def _some(picture: Array, start: Array, profiles: Profiles, light: Array, least_apart: float) -> Fit:
    frames, coils = start.shape
    station = np.arange(picture.shape[1], dtype=float)
    grounds = np.stack([np.ones_like(station), *(np.cos(np.pi * k * station / len(station)) for k in (1, 2, 3))])
    places, heights = start.copy(), np.repeat(light[:, None], coils, axis=1)
    ground = np.zeros((frames, len(grounds)))
    scale = float(np.abs(profiles.table).max())
    # Between coils other things shine (rear coils, the inner spring): only what lies under the profiles counts.
    for step in range(STEPS + 1):
        distance = station - places[:, :, None]
        shape, slope = profiles.at(distance, profiles.table), profiles.at(distance, profiles.slope)
        near = (np.abs(distance) <= profiles.reach).any(axis=1).astype(float)
        columns = (
            np.concatenate([-heights[:, :, None] * slope, shape, np.broadcast_to(grounds, (frames, *grounds.shape))], axis=1)
            * near[:, None]
        )
        left = (picture - np.einsum("fc,fcs->fs", heights, shape) - ground @ grounds) * near
        count = near.sum(axis=1)
        free = np.maximum(count - 2 * coils - len(grounds), 1.0)
        noise = np.maximum(np.sqrt((left**2).sum(axis=1) / free), 1e-6 * scale)
        normal = columns @ columns.transpose(0, 2, 1)
        right = np.einsum("fps,fs->fp", columns, left)
        stiff = (noise / (HEIGHT_SCATTER * np.maximum(light, 1e-9))) ** 2
        index = np.arange(coils, 2 * coils)
        normal[:, index, index] += stiff[:, None]
        right[:, coils : 2 * coils] += stiff[:, None] * (light[:, None] - heights)
        diagonal = np.arange(normal.shape[1])
        normal[:, diagonal, diagonal] += 1e-9 * np.trace(normal, axis1=1, axis2=2)[:, None] / normal.shape[1] + 1e-12
        if step == STEPS:
            break
        change = np.linalg.solve(normal, right[..., None])[..., 0]
        places = _kept_in_order(places + np.clip(change[:, :coils], -LARGEST_STEP, LARGEST_STEP), least_apart)
        heights = np.clip(heights + change[:, coils : 2 * coils], 0.05 * light[:, None], 4 * light[:, None])
        ground = ground + change[:, 2 * coils :]
    spread = noise[:, None] * np.sqrt(np.maximum(np.diagonal(np.linalg.inv(normal), axis1=1, axis2=2)[:, :coils], 0.0))
    return Fit(places, spread, heights, noise)


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
