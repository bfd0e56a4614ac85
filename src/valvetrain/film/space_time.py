"""The space-time picture of a film: grey levels along a line, frame by frame, and the brightness of
a marker.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.film.frames import MAX_FRAMES, SLOWEST_RATE, Film, Picture

Array = NDArray[np.float64]
Point = tuple[float, float]
#: Width (px) of a line where none is given, and frames that are looked at to find a line.
DEFAULT_WIDTH, LOOKED_AT = 5.0, 120
#: Shorter lines hold no spring.
SHORTEST = 12.0


@dataclass(frozen=True, slots=True)
class SightLine:
    """From ``start`` to ``end`` ((x, y) in px: column and row, counted from the centre of the upper
    left pixel).

    ``line_width`` px across it, averaged over ``samples_across``; stations are one pixel apart.
    """

    start: Point
    end: Point
    line_width: float = DEFAULT_WIDTH
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
        return float(
            ((point[0] - self.start[0]) * across + (point[1] - self.start[1]) * down) / self.length
        )

    def weights(self, rows: int, columns: int) -> Any:
        """Sparse matrix (stations, rows * columns) that turns a picture into the profile along the
        line.

        Raises :class:`InputError` for a line that leaves the picture or is too short.
        """
        from scipy.sparse import csr_matrix

        self._check(rows, columns)
        direction = (
            np.array([self.end[0] - self.start[0], self.end[1] - self.start[1]]) / self.length
        )
        normal = np.array([-direction[1], direction[0]])
        offsets = (
            (np.arange(self.samples_across) + 0.5) / self.samples_across - 0.5
        ) * self.line_width
        points = (
            np.array(self.start)
            + self.stations[:, None, None] * direction
            + offsets[None, :, None] * normal
        )
        station = np.broadcast_to(np.arange(len(points))[:, None], points.shape[:2])
        parts = []
        for right in range(-1, 3):
            for lower in range(-1, 3):
                (x, x_share), (y, y_share) = (
                    _taps(points[..., 0], right),
                    _taps(points[..., 1], lower),
                )
                # Beyond the edge of the picture its last pixel is repeated.
                place = np.clip(y, 0, rows - 1) * columns + np.clip(x, 0, columns - 1)
                parts.append(
                    (
                        station.ravel(),
                        place.ravel(),
                        (x_share * y_share).ravel() / self.samples_across,
                    )
                )
        row, column, share = (np.concatenate(one) for one in zip(*parts, strict=True))
        return csr_matrix((share, (row, column)), shape=(len(points), rows * columns))

    def _check(self, rows: int, columns: int) -> None:
        if (
            not all(np.isfinite(value) for point in (self.start, self.end) for value in point)
            or self.length < SHORTEST
        ):
            raise InputError(
                f"the line is {self.length:.3g} px long; give two points at least {SHORTEST:g} px apart",
                "line",
            )
        for x, y in (self.start, self.end):
            if not (-0.5 <= x <= columns - 0.5 and -0.5 <= y <= rows - 0.5):
                raise InputError(
                    f"the point {x:g}, {y:g} is outside the picture of {columns} x {rows} pixels; correct it",
                    "line",
                )
        if not 0 < self.line_width <= 500 or not 1 <= self.samples_across <= 500:
            raise InputError(
                "a line is up to 500 px wide, with 1 to 500 samples across; correct it",
                "line_width",
            )


def _taps(place: Array, tap: int) -> tuple[NDArray[np.int64], Array]:
    """Pixel and share of one of the four taps of the cubic kernel of Keys (1981), exact at pixels."""
    low = np.floor(place)
    near = abs(tap - (place - low))
    inner = 1.5 * near**3 - 2.5 * near**2 + 1
    outer = -0.5 * near**3 + 2.5 * near**2 - 4 * near + 2
    return (low + tap).astype(np.int64), np.where(near <= 1, inner, np.where(near < 2, outer, 0.0))


def find_line(film: Film, line_width: float = DEFAULT_WIDTH, samples_across: int = 5) -> SightLine:
    """A line along the picture where highlights are above each other, and move, most clearly.

    Highlights of coils are bands across the spring, so grey levels change along the spring more
    than across it.
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
    kernel = np.ones(max(1, min(int(line_width), len(change)))) / max(
        1, min(int(line_width), len(change))
    )
    clear = np.convolve(change + contrast, kernel, mode="same")
    if not clear.max() > 0:
        raise InputError(
            f"nothing in '{film.name}' changes along any line; give the line, or another film",
            "line",
        )
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


#: Grey levels of the picture in memory at most (4 bytes each), and fewest frames of a film that
#: shows a motion.
MAX_VALUES, MIN_FRAMES = 20_000_000, 16
#: Step (s) of time stamps below which whole milliseconds are too coarse.
COARSE = 5e-3
#: Share of the largest grey level from which a glare is white.
WHITE = 0.99
#: Radius (px) of the spot of a marker where none is given.
MARKER_RADIUS = 3.0


@dataclass(frozen=True, eq=False)
class SpaceTime:
    """``picture`` (frames, stations) grey levels; ``number`` (frames,) of each frame, lost ones
    counted; ``frame_rate`` 1/s;
    ``marker`` (frames,) brightness of the spot, empty without one; ``notes`` a sentence each;
    ``missing``: frames that the file claims and does not hold."""

    picture: NDArray[np.float32]
    number: NDArray[np.int64]
    frame_rate: float
    line: SightLine
    marker: Array
    name: str
    size: tuple[int, int]
    notes: tuple[str, ...] = ()
    missing: int = 0

    @property
    def time(self) -> Array:
        """Time (s) of the middle of each frame's exposure, from the first frame on."""
        return np.asarray(self.number / self.frame_rate)

    def __repr__(self) -> str:
        frames, stations = self.picture.shape
        return f"SpaceTime: {frames} frames by {stations} stations, {self.frame_rate:g} frames a second"


def read_space_time(
    film: Film,
    line: SightLine,
    frame_rate: float | None,
    marker: Point | None,
    marker_radius: float,
    first: int,
    last: int | None,
) -> SpaceTime:
    """The film run through once. ``first``, ``last``: frames that are used, counted from 0.

    Raises :class:`InputError` for a film without frames, one that is too large, and a rate that
    nothing gives.
    """
    rate, notes = _rate(film, frame_rate)
    weights = line.weights(film.rows, film.columns)
    spot = None if marker is None else _spot(marker, marker_radius, film.rows, film.columns)
    end = MAX_FRAMES if last is None else last + 1
    rows: list[NDArray[np.float32]] = []
    marks: list[float] = []
    white = 0
    for place, picture in enumerate(film.frames()):
        if place < first:
            continue
        if place >= end:
            break
        grey = np.asarray(picture, dtype=float).ravel()
        profile = np.asarray(weights @ grey, dtype=np.float32)
        white += (
            float(profile.max()) > WHITE * np.iinfo(picture.dtype).max
            if picture.dtype.kind == "u"
            else 0
        )
        if not np.isfinite(profile).all():
            raise InputError(
                f"frame {place} of '{film.name}' holds grey levels that are no numbers; export the film again"
            )
        rows.append(profile)
        if spot is not None:
            marks.append(float(grey[spot].mean()))
        if len(rows) * len(profile) > MAX_VALUES:
            sentence = f"'{film.name}' is too long: {len(rows)} frames by {len(profile)} pixels of the line"
            raise InputError(
                f"{sentence}; choose part of it with first_frame and last_frame, or a shorter line",
                "last_frame",
            )
    if len(rows) < MIN_FRAMES:
        raise InputError(
            f"a motion shows in {MIN_FRAMES} frames or more, of '{film.name}' only {len(rows)} can be read; give a longer film"
        )
    short = 0 if first or last is not None else film.claimed - len(rows)  # some count one too many
    if white > 0.05 * len(rows):
        notes += (
            f"the glare is as white as the camera can record in {white} of {len(rows)} frames; its middle is lost there, so film darker",
        )
    picture = np.stack(rows)
    number, said = _numbers(film, first, picture, rate)
    return SpaceTime(
        picture,
        number,
        rate,
        line,
        np.array(marks),
        film.name,
        (film.rows, film.columns),
        film.notes + notes + said,
        short if short > 1 else 0,
    )


def _rate(film: Film, given: float | None) -> tuple[float, tuple[str, ...]]:
    if given is not None:
        if not (np.isfinite(given) and 1.0 <= given <= 1e7):
            raise InputError(
                f"a camera of {given:g} frames a second films no spring; correct the rate",
                "frame_rate",
            )
        return given, ()
    if film.rate >= SLOWEST_RATE:
        return film.rate, (f"the rate of {film.rate:g} frames a second is the one in the file",)
    why = (
        f"plays at {film.rate:g} frames a second, the rate of a screen"
        if film.rate > 0
        else "does not state its rate"
    )
    raise InputError(
        f"'{film.name}' {why}; give the rate of the camera, such as 2000 frames a second",
        "frame_rate",
    )


def _spot(marker: Point, radius: float, rows: int, columns: int) -> NDArray[np.int64]:
    """Pixels of the disc about the marker."""
    x, y = marker
    if not (0 <= x <= columns - 1 and 0 <= y <= rows - 1):
        raise InputError(
            f"the marker {x:g}, {y:g} is outside the picture of {columns} x {rows} pixels; correct it",
            "marker",
        )
    if not 0 < radius <= 200:
        raise InputError(
            f"a marker of {radius:g} px radius is none; take 1 to 200 px", "marker_radius"
        )
    down, across = np.mgrid[
        max(0, int(y - radius)) : min(rows, int(y + radius) + 2),
        max(0, int(x - radius)) : min(columns, int(x + radius) + 2),
    ]
    inside = (across - x) ** 2 + (down - y) ** 2 <= radius**2
    inside |= (across == round(x)) & (down == round(y))
    found: NDArray[np.int64] = (down[inside] * columns + across[inside]).astype(np.int64)
    return found


def _numbers(
    film: Film, first: int, picture: NDArray[np.float32], rate: float
) -> tuple[NDArray[np.int64], tuple[str, ...]]:
    """Numbers of the frames with the lost ones counted, by names of files or by time stamps, and
    what is said of them.
    """
    count = len(picture)
    number, notes = np.arange(count), []
    if film.numbers:
        number = np.array(film.numbers[first : first + count]) - film.numbers[first]
    elif film.clock:
        stamps = np.array(film.clock[first : first + count])
        steps = np.diff(stamps)
        typical = float(np.median(steps))
        # Containers that count whole milliseconds do not show the spacing of frames that are hardly longer.
        coarse = typical < COARSE and bool(
            np.abs(1e3 * stamps - np.round(1e3 * stamps)).max() < 1e-6
        )
        if typical > 0 and (steps > 0).all() and not coarse:
            counted = np.maximum(1, np.round(steps / typical)).astype(np.int64)
            if np.abs(steps / typical - counted).max() > 0.3:
                notes.append(
                    "the time stamps of the frames are irregular by a third of a frame or more, so times are uncertain by as much"
                )
            if counted.sum() <= 4 * count:
                number = np.concatenate([[0], np.cumsum(counted)])
    lost = int(number[-1]) + 1 - count
    if lost:
        gaps = int((np.diff(number) > 1).sum())
        notes.append(
            f"{lost} frames are lost in {gaps} gaps, as {'names' if film.numbers else 'time stamps'} of the frames show; they are left open"
        )
    again = (picture[1:] == picture[:-1]).all(axis=1)
    if again.any() and not again.all():
        notes.append(
            f"{int(again.sum())} frames repeat the one before them bit for bit, as a camera does that has lost frames; look at the film"
        )
    return number.astype(np.int64), tuple(notes)
