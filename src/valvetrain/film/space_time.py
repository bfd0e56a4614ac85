"""The space-time picture of a film: grey levels along a line, frame by frame, and the brightness of
a marker.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.arrays import Array, Ints
from valvetrain.errors import InputError
from valvetrain.film.frames import MAX_FRAMES, SLOWEST_RATE, Film
from valvetrain.film.setup import Point

#: Width (px) of a line where none is given, and frames that are looked at to find a line.
DEFAULT_WIDTH, LOOKED_AT = 5.0, 120
#: Shorter lines hold no spring.
SHORTEST = 12.0


@dataclass(frozen=True, slots=True)
class SightLine:
    """From ``start`` to ``end`` ((x, y) in px: column and row, counted from the centre of the upper
    left pixel).

    ``width`` px across it are averaged, a sample a pixel; stations are one pixel apart.
    """

    start: Point
    end: Point
    width: float = DEFAULT_WIDTH

    def weights(self, rows: int, columns: int) -> Any:
        """Sparse matrix (stations, rows * columns) that turns a picture into the profile along the
        line.

        Raises :class:`InputError` for a line that leaves the picture or is too short.
        """
        from scipy.sparse import csr_array

        start, end = np.array(self.start, dtype=float), np.array(self.end, dtype=float)
        length = float(np.hypot(*(end - start)))
        if not length >= SHORTEST or not 0 < self.width <= 500:
            raise InputError(
                f"the line is {length:.3g} px long and {self.width:g} px wide; give two points at least {SHORTEST:g} px apart and a width up "
                "to 500 px",
                "line",
            )
        for x, y in (start, end):
            if not (-0.5 <= x <= columns - 0.5 and -0.5 <= y <= rows - 0.5):
                raise InputError(
                    f"the point {x:g}, {y:g} is outside the picture of {columns} x {rows} pixels; correct it",
                    "line",
                )
        direction = (end - start) / length
        station = np.arange(int(length + 1e-9) + 1)
        count = max(1, round(self.width))
        offsets = ((np.arange(count) + 0.5) / count - 0.5) * self.width
        points = start + station[:, None, None] * direction
        points = (points + offsets[:, None] * np.array([-direction[1], direction[0]])).reshape(-1, 2)  # fmt: skip
        # Pixels and shares of the 4 x 4 taps of the cubic kernel of Keys (1981), exact at pixels.
        taps = np.floor(points)[:, None] + np.arange(-1, 3)[:, None]
        near = np.abs(taps - points[:, None])
        inner = 1.5 * near**3 - 2.5 * near**2 + 1
        outer = -0.5 * near**3 + 2.5 * near**2 - 4 * near + 2
        shares = np.where(near <= 1, inner, np.where(near < 2, outer, 0.0)) / np.array([count, 1])
        # Beyond the edge of the picture its last pixel is repeated.
        x, y = np.moveaxis(np.clip(taps, 0, [columns - 1, rows - 1]).astype(np.int64), 2, 0)
        place = y[:, :, None] * columns + x[:, None, :]
        share = shares[:, :, None, 1] * shares[:, None, :, 0]
        row = np.repeat(station, count * 16)
        return csr_array((share.ravel(), (row, place.ravel())), shape=(len(station), rows * columns))  # fmt: skip


def find_line(film: Film, width: float = DEFAULT_WIDTH) -> SightLine:
    """A line along the picture where highlights are above each other, and move, most clearly.

    Highlights of coils are bands across the spring, so grey levels change along the spring more
    than across it.
    """
    from scipy.ndimage import uniform_filter1d

    # Frames from all over a film of known length, else its first ones.
    stride = max(1, film.claimed // LOOKED_AT)
    total, squared = (np.zeros((film.rows, film.columns)) for _ in range(2))
    steep, count = np.zeros(2), 0
    for picture in islice(film.frames(), 0, LOOKED_AT * stride, stride):
        grey = np.asarray(picture, dtype=float)
        steep += [np.sum(np.abs(np.diff(grey, axis=axis))) for axis in (0, 1)]
        total += grey
        squared += grey**2
        count += 1
    mean = total / max(count, 1)
    moved = np.maximum(squared / max(count, 1) - mean**2, 0.0)
    along = 0 if steep[0] >= steep[1] else 1
    clear = moved.mean(axis=along) + np.var(mean, axis=along)
    clear = uniform_filter1d(clear, max(1, min(int(width), len(clear))), mode="constant")
    if not clear.max() > 0:
        raise InputError(
            f"nothing in '{film.name}' changes along any line; give the line, or another film",
            "line",
        )
    # The middle of all lines that are nearly as good: the wire looks alike over some width.
    good = np.flatnonzero(clear >= 0.9 * clear.max())
    middle = float(round(good[np.argmin(np.abs(good - np.average(good, weights=clear[good])))]))
    if along == 0:
        return SightLine((middle, 0.0), (middle, film.rows - 1.0), width)
    return SightLine((0.0, middle), (film.columns - 1.0, middle), width)


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
    number: Ints
    frame_rate: float
    line: SightLine
    marker: Array
    name: str
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
    marker: Point | None = None,
    marker_radius: float = MARKER_RADIUS,
    first: int = 0,
    last: int | None = None,
) -> SpaceTime:
    """The film run through once. ``first``, ``last``: frames that are used, counted from 0.

    Raises :class:`InputError` for a film without frames, one that is too large, and a rate that
    nothing gives.
    """
    rate = film.rate if frame_rate is None else frame_rate
    if frame_rate is None and film.rate < SLOWEST_RATE:
        why = f"plays at {rate:g} frames a second, the rate of a screen" if rate else "does not state its rate"  # fmt: skip
        raise InputError(
            f"'{film.name}' {why}; give the rate of the camera, such as 2000 frames a second",
            "frame_rate",
        )
    notes = [] if frame_rate else [f"the rate of {rate:g} frames a second is the one in the file"]
    notes += film.notes
    weights = line.weights(film.rows, film.columns)
    spot = None if marker is None else _spot(marker, marker_radius, film.rows, film.columns)
    rows: list[NDArray[np.float32]] = []
    marks: list[float] = []
    white = 0
    for picture in islice(film.frames(), first, MAX_FRAMES if last is None else last + 1):
        grey = np.asarray(picture, dtype=float).ravel()
        rows.append(np.asarray(weights @ grey, dtype=np.float32))
        if picture.dtype.kind == "u":
            white += rows[-1].max() > WHITE * np.iinfo(picture.dtype).max
        if spot is not None:
            marks.append(float(grey[spot].mean()))
        if rows[-1].size * len(rows) > MAX_VALUES:
            raise InputError(
                f"'{film.name}' is too long: {len(rows)} frames by {rows[-1].size} pixels of the line; choose part of it with first_frame and "
                "last_frame, or a shorter line",
                "last_frame",
            )
    if len(rows) < MIN_FRAMES:
        raise InputError(
            f"a motion shows in {MIN_FRAMES} frames or more, of '{film.name}' only {len(rows)} can be read; give a longer film"
        )
    seen = np.stack(rows)
    if not np.isfinite(seen).all():
        raise InputError(
            f"'{film.name}' holds grey levels that are no numbers; export the film again"
        )
    short = 0 if last is not None else film.claimed - first - len(rows)  # some count one too many
    if white > 0.05 * len(rows):
        notes.append(
            f"the glare is as white as the camera can record in {white} of {len(rows)} frames; its middle is lost there, so film darker"
        )
    again = (seen[1:] == seen[:-1]).all(axis=1)
    if again.any() and not again.all():
        notes.append(
            f"{int(again.sum())} frames repeat the one before them bit for bit, as a camera does that has lost frames; look at the film"
        )
    number, counted = _numbers(film, first, len(rows))
    return SpaceTime(
        seen,
        number,
        rate,
        line,
        np.array(marks),
        film.name,
        (*notes, *counted),
        short if short > 1 else 0,
    )


def _spot(marker: Point, radius: float, rows: int, columns: int) -> Ints:
    """Pixels of the disc about the marker."""
    x, y = marker
    inside = 0 <= x <= columns - 1 and 0 <= y <= rows - 1
    if not (inside and 0 < radius <= 200):
        raise InputError(
            f"the marker {x:g}, {y:g} of {radius:g} px radius is outside the picture of {columns} x {rows} pixels or of no size; correct it",
            "marker",
        )
    down, across = np.ogrid[:rows, :columns]
    disc = np.hypot(across - x, down - y) <= max(radius, 0.75)
    return np.flatnonzero(disc)


def _numbers(film: Film, first: int, count: int) -> tuple[Ints, list[str]]:
    """Numbers of the frames with the lost ones counted, by names of files or by time stamps, and
    what is said of them.
    """
    notes = []
    number: Ints = np.arange(count)
    if film.numbers is not None:
        number = film.numbers[first : first + count] - film.numbers[first]
    elif film.clock:
        stamps = np.array(film.clock[first : first + count])
        steps = np.diff(stamps)
        typical = float(np.median(steps))
        # Containers that count whole milliseconds do not show the spacing of frames that are hardly longer.
        coarse = typical < COARSE and np.abs(1e3 * stamps - np.round(1e3 * stamps)).max() < 1e-6
        if steps.min() > 0 and not coarse:
            spans = np.maximum(1, np.round(steps / typical)).astype(np.int64)
            if np.abs(steps / typical - spans).max() > 0.3:
                notes.append(
                    "the time stamps of the frames are irregular by a third of a frame or more, so times are uncertain by as much"
                )
            if spans.sum() <= 4 * count:
                number = np.concatenate([[0], np.cumsum(spans)])
    lost = int(number[-1]) + 1 - count
    if lost:
        gaps = int((np.diff(number) > 1).sum())
        notes.append(
            f"{lost} frames are lost in {gaps} gaps, as names or time stamps of the frames show; they are left open"
        )
    return number, notes
