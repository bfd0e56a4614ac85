"""The line across a film along which the spring is looked at: grey levels by cubic interpolation, averaged across its width."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.measurements.film.frames import Film, Picture

Array = NDArray[np.float64]
Point = tuple[float, float]
#: Width (px) of a line where none is told, and frames that are looked at to find a line.
USUAL_WIDTH, LOOKED_AT = 5.0, 120
#: Shorter lines hold no spring.
SHORTEST = 12.0


@dataclass(frozen=True, slots=True)
class SightLine:
    """From ``start`` to ``end`` ((x, y) in px: column and row, counted from the centre of the upper left pixel).

    ``line_width`` px across it, averaged over ``samples_across``; stations stand one pixel apart.
    """

    start: Point
    end: Point
    line_width: float = USUAL_WIDTH
    samples_across: int = 5

    @property
    def length(self) -> float:
        """Distance (px) between the two ends."""
        return float(np.hypot(self.end[0] - self.start[0], self.end[1] - self.start[1]))

    @property
    def stations(self) -> Array:
        """Distances (px) of the stations from the start."""
        return np.arange(int(np.floor(self.length + 1e-9)) + 1, dtype=float)

    def along(self, point: Point) -> float:
        """Distance (px) from the start of the foot of ``point`` on the line."""
        across, down = (self.end[k] - self.start[k] for k in (0, 1))
        return float(((point[0] - self.start[0]) * across + (point[1] - self.start[1]) * down) / self.length)

    def weights(self, rows: int, columns: int) -> Any:
        """Sparse matrix (stations, rows * columns) that turns a picture into the profile along the line.

        Raises :class:`InputError` for a line that leaves the picture or is too short.
        """
        from scipy.sparse import csr_matrix

        self._check(rows, columns)
        direction = np.array([self.end[0] - self.start[0], self.end[1] - self.start[1]]) / self.length
        normal = np.array([-direction[1], direction[0]])
        offsets = ((np.arange(self.samples_across) + 0.5) / self.samples_across - 0.5) * self.line_width
        points = np.array(self.start) + self.stations[:, None, None] * direction + offsets[None, :, None] * normal
        station = np.broadcast_to(np.arange(len(points))[:, None], points.shape[:2])
        parts = []
        for right in range(-1, 3):
            for lower in range(-1, 3):
                (x, x_share), (y, y_share) = _taps(points[..., 0], right), _taps(points[..., 1], lower)
                # Beyond the edge of the picture its last pixel goes on.
                place = np.clip(y, 0, rows - 1) * columns + np.clip(x, 0, columns - 1)
                parts.append((station.ravel(), place.ravel(), (x_share * y_share).ravel() / self.samples_across))
        row, column, share = (np.concatenate(one) for one in zip(*parts, strict=True))
        return csr_matrix((share, (row, column)), shape=(len(points), rows * columns))

    def _check(self, rows: int, columns: int) -> None:
        if not all(np.isfinite(value) for point in (self.start, self.end) for value in point) or self.length < SHORTEST:
            raise InputError(f"the line is {self.length:.3g} px long; give two points at least {SHORTEST:g} px apart", "line")
        for x, y in (self.start, self.end):
            if not (-0.5 <= x <= columns - 0.5 and -0.5 <= y <= rows - 0.5):
                raise InputError(f"the point {x:g}, {y:g} lies outside the picture of {columns} x {rows} pixels; correct it", "line")
        if not 0 < self.line_width <= 500 or not 1 <= self.samples_across <= 500:
            raise InputError("a line is up to 500 px wide, with 1 to 500 samples across; correct it", "line_width")


def _taps(place: Array, tap: int) -> tuple[NDArray[np.int64], Array]:
    """Pixel and share of one of the four taps of the cubic kernel of Keys (1981), exact at pixels."""
    low = np.floor(place)
    near = abs(tap - (place - low))
    inner = 1.5 * near**3 - 2.5 * near**2 + 1
    outer = -0.5 * near**3 + 2.5 * near**2 - 4 * near + 2
    return (low + tap).astype(np.int64), np.where(near <= 1, inner, np.where(near < 2, outer, 0.0))


def find_line(film: Film, line_width: float = USUAL_WIDTH, samples_across: int = 5) -> SightLine:
    """A line along the picture where highlights stand above each other, and move, most clearly.

    Highlights of coils are bands across the spring, so grey levels change along the spring more than across it.
    """
    total, squared = (np.zeros((film.rows, film.columns)) for _ in range(2))
    steep, count = [0.0, 0.0], 0
    for picture in _some(film):
        grey = np.asarray(picture, dtype=float)
        down, across = np.diff(grey, axis=0), np.diff(grey, axis=1)
        for place, change in enumerate((down, across)):
            steep[place] += float(np.sum(np.abs(change)))
        total += grey
        squared += grey**2
        count += 1
    if not count:
        raise InputError(f"'{film.name}' holds no frame; export the film again")
    mean = total / count
    moved = np.maximum(squared / count - mean**2, 0.0)
    upright = steep[0] >= steep[1]
    contrast = np.var(mean, axis=0 if upright else 1)
    change = moved.mean(axis=0 if upright else 1)
    kernel = np.ones(max(1, min(int(line_width), len(change)))) / max(1, min(int(line_width), len(change)))
    clear = np.convolve(change + contrast, kernel, mode="same")
    if not clear.max() > 0:
        raise InputError(f"nothing in '{film.name}' changes along any line; give the line, or another film", "line")
    # The middle of all lines that are nearly as good: the wire looks alike over some width.
    good = np.flatnonzero(clear >= 0.9 * clear.max())
    middle = float(round(good[np.argmin(np.abs(good - np.average(good, weights=clear[good])))]))
    if upright:
        return SightLine((middle, 0.0), (middle, film.rows - 1.0), line_width, samples_across)
    return SightLine((0.0, middle), (film.columns - 1.0, middle), line_width, samples_across)


def _some(film: Film) -> Iterator[Picture]:
    """Frames from all over a film of known length, else its first ones."""
    stride = max(1, film.claimed // LOOKED_AT)
    yield from islice(film.frames(), 0, LOOKED_AT * stride, stride)
