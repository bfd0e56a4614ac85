"""How a film was taken and what it shows: the questions that only who filmed can answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from valvetrain.errors import InputError
from valvetrain.film.space_time import DEFAULT_WIDTH, MARKER_RADIUS, Point
from valvetrain.units import Given, keep_si

#: Which end of the line the spring's fixed seat is at.
SEAT_ENDS = ("start", "end")


@dataclass(frozen=True, kw_only=True)
class FilmSetup:
    """Inputs of a film in addition to its pictures. Points are (x, y): column and row in px from the
    centre of the upper left pixel.

    Parameters
    ----------
    frame_rate : frames a second of the camera; needed unless the file gives a rate above that of
        screens
    line : the two end points of the line along the spring; found from the picture where not given
    line_width : px across the line that are averaged
    samples_across : samples over that width
    coils : highlights on the line; counted where not given
    seat : end of the line at which the spring is fixed, "start" or "end"; the end that moves
        less where not given
    scale_points, scale_length : two points and their distance in the plane of the highlights, a
        length
    marker, marker_radius : a spot whose brightness marks each cam revolution, and its radius in px
    marker_angle : cam angle at which the mark passes, an angle
    cam_speed : of the cam, an angular speed; compared with the marker's or the lift's where these
        give it
    first_angle : cam angle of the first frame, where a speed alone gives the phase; an angle
    dwell : cam angles (rad) between which the valve is closed, (first, last), the last one beyond a
        turn where it wraps
    free_decay : the cam does not turn; the spring is struck and rings, so the whole film is one
        decay
    first_frame, last_frame : frames that are used, counted from 0
    exposure : time for which a frame is exposed, a time; for what motion blur does to the lines

    Raises
    ------
    InputError : a scale of two equal points, an unknown end, frames out of order

    Examples
    --------
    >>> FilmSetup(frame_rate=2000, scale_points=((10, 20), (10, 220)), scale_length="33.7 mm").metres_per_pixel
    0.0001685
    """

    frame_rate: float | None = None
    line: tuple[Point, Point] | None = None
    line_width: float = DEFAULT_WIDTH
    samples_across: int = 5
    coils: int | None = None
    seat: str = ""
    scale_points: tuple[Point, Point] | None = None
    scale_length: float | None = None
    marker: Point | None = None
    marker_radius: float = MARKER_RADIUS
    marker_angle: float | None = None
    cam_speed: float | None = None
    first_angle: float | None = None
    dwell: tuple[float, float] | None = None
    free_decay: bool = False
    first_frame: int = 0
    last_frame: int | None = None
    exposure: float | None = None

    if TYPE_CHECKING:  # accepted types are wider than the stored one

        def __init__(
            self,
            *,
            frame_rate: Given | None = None,
            line: tuple[Point, Point] | None = None,
            line_width: float = DEFAULT_WIDTH,
            samples_across: int = 5,
            coils: int | None = None,
            seat: str = "",
            scale_points: tuple[Point, Point] | None = None,
            scale_length: Given | None = None,
            marker: Point | None = None,
            marker_radius: float = MARKER_RADIUS,
            marker_angle: Given | None = None,
            cam_speed: Given | None = None,
            first_angle: Given | None = None,
            dwell: tuple[float, float] | None = None,
            free_decay: bool = False,
            first_frame: int = 0,
            last_frame: int | None = None,
            exposure: Given | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        keep_si(
            self,
            "a film",
            frame_rate="frequency",
            scale_length="length",
            marker_angle="angle",
            cam_speed="cam_speed",
            first_angle="angle",
            exposure="time",
        )
        for name in ("line", "scale_points"):
            if (points := getattr(self, name)) is not None:
                object.__setattr__(
                    self, name, tuple(_pair(one, name) for one in _two(points, name))
                )
        for name in ("marker", "dwell"):
            if (pair := getattr(self, name)) is not None:
                object.__setattr__(self, name, _pair(pair, name))
        if self.seat and self.seat not in SEAT_ENDS:
            raise InputError(
                f"the seat is at the start or the end of the line, not at '{self.seat[:40]}'; say which",
                "seat",
            )
        if (self.scale_points is None) != (self.scale_length is None):
            raise InputError("a scale is two points and their distance; give both", "scale_points")
        if self.scale_length is not None and not (
            self.scale_length > 0 and self.metres_per_pixel < 1.0
        ):
            raise InputError(
                "the two points of the scale are the same or their distance is not positive; correct them",
                "scale_points",
            )
        last = self.last_frame
        if self.first_frame < 0 or (last is not None and last < self.first_frame):
            raise InputError(
                f"frames {self.first_frame} to {last} are none; count from 0, the first one first",
                "first_frame",
            )
        if self.dwell is not None and not 0 < self.dwell[1] - self.dwell[0] < 6.283:
            raise InputError(
                "the dwell ends after it begins and is less than a turn; add 360 deg to its end where it wraps",
                "dwell",
            )
        if self.exposure is not None and not self.exposure > 0:
            raise InputError("an exposure is a time above zero; correct it", "exposure")

    @property
    def metres_per_pixel(self) -> float:
        """Metres that a pixel shows; 0 without a scale."""
        if self.scale_points is None or self.scale_length is None:
            return 0.0
        one, two = self.scale_points
        apart = float(((one[0] - two[0]) ** 2 + (one[1] - two[1]) ** 2) ** 0.5)
        return self.scale_length / apart if apart > 0 else float("inf")


def _two(given: Any, name: str) -> tuple[Any, Any]:
    """Two things of a sequence of two."""
    try:
        one, two = given
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{name} is two points, such as ((12, 5), (12, 205)); correct it", name
        ) from error
    return one, two


def _pair(given: Any, name: str) -> tuple[float, float]:
    """Two numbers."""
    try:
        one, two = (float(value) for value in given)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"a point of {name} is two numbers, such as (12, 5); correct it", name
        ) from error
    if not (abs(one) < 1e6 and abs(two) < 1e6):
        raise InputError(
            f"{name} holds a number that is none of a picture or a turn; correct it", name
        )
    return one, two
