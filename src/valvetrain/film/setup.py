"""How a film was taken and what it shows: the questions that only who filmed can answer."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, ValidationInfo

from valvetrain.film.space_time import DEFAULT_WIDTH, MARKER_RADIUS, Point
from valvetrain.parameters.schema_types import Angle, Length, Table, problem, quantity, table
from valvetrain.units import parse_quantities


def _points(given: Any, info: ValidationInfo) -> tuple[Any, ...]:
    """A point, or two: nested as a :class:`SightLine` takes them."""
    count = 2 if info.field_name == "marker" else 4
    try:
        parts = given.split(",") if isinstance(given, str) else given
        numbers = np.array(parts, dtype=float).ravel()
    except (TypeError, ValueError):
        numbers = np.empty(0)
    if len(numbers) != count or not (np.abs(numbers) < 1e6).all():
        such = ", ".join(["12, 5", "12, 205"][: count // 2])
        raise problem(
            f"{info.field_name} is {count} numbers of pixels, such as '{such}', not '{str(given)[:40]}'; correct it"
        )
    points = [tuple(point) for point in numbers.reshape(-1, 2).tolist()]
    return tuple(points) if count == 4 else points[0]


def _window(given: Any) -> tuple[float, float]:
    """Two cam angles (rad) in order, within a turn."""
    try:
        if isinstance(given, str):
            begin, end = parse_quantities(given.replace(":", ","), "angle", "dwell")
            end += math.tau * (end < begin)
        else:
            begin, end = (float(value) for value in given)
    except (TypeError, ValueError):
        begin = end = 0.0
    if not 0 < end - begin < 6.283 or not abs(end) < 1e6:
        raise problem(
            f"'{str(given)[:40]}' is no window; give two angles less than a turn apart, such as '170:350 deg'"
        )
    return begin, end


FrameRate = Annotated[float, quantity("frequency", low=1.0, high=1e7)]
CamSpeed = Annotated[float, quantity("angular speed", low=1e-3, high=1e7)]
Ends = Annotated[tuple[Point, Point], BeforeValidator(_points)]


@table("the film")
class FilmSetup(Table):
    """Inputs of a film in addition to its pictures. Points are (x, y): column and row in px from the
    centre of the upper left pixel.

    Parameters
    ----------
    frame_rate : frames a second of the camera; needed unless the file gives a rate above that of
        screens
    line : the two end points of the line along the spring, as numbers or text ("12, 5, 12, 205"); found
        from the picture where not given
    line_width : px across the line that are averaged
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
    dwell : cam angles (rad) between which the valve is closed, (first, last), or text such as
        "170:350 deg"; the last one beyond a turn where it wraps
    free_decay : the cam does not turn; the spring is struck and rings, so the whole film is one
        decay
    first_frame, last_frame : frames that are used, counted from 0

    Raises
    ------
    InputError : a scale of two equal points, an unknown end, frames out of order

    Examples
    --------
    >>> FilmSetup(frame_rate=2000, scale_points=((10, 20), (10, 220)), scale_length="33.7 mm").metres_per_pixel
    0.0001685
    """

    frame_rate: FrameRate | None = None
    line: Ends | None = None
    line_width: float = DEFAULT_WIDTH
    coils: int | None = None
    seat: Literal["", "start", "end"] = ""
    scale_points: Ends | None = None
    scale_length: Length | None = None
    marker: Annotated[Point, BeforeValidator(_points)] | None = None
    marker_radius: float = MARKER_RADIUS
    marker_angle: Angle | None = None
    cam_speed: CamSpeed | None = None
    first_angle: Angle | None = None
    dwell: Annotated[tuple[float, float], BeforeValidator(_window)] | None = None
    free_decay: bool = False
    first_frame: int = 0
    last_frame: int | None = None

    def __post_init__(self) -> None:
        if (self.scale_points is None) != (self.scale_length is None):
            raise problem("a scale is two points and their distance; give both")
        if self.scale_length is not None and not 0 < self.metres_per_pixel < 1.0:
            raise problem(
                "the two points of the scale are the same or their distance is not positive; correct them"
            )
        last = self.last_frame
        if self.first_frame < 0 or (last is not None and last < self.first_frame):
            raise problem(
                f"frames {self.first_frame} to {last} are none; count from 0, the first one first"
            )

    @property
    def metres_per_pixel(self) -> float:
        """Metres that a pixel shows; 0 without a scale, or for points that are the same."""
        if self.scale_points is None or self.scale_length is None:
            return 0.0
        apart = math.dist(*self.scale_points)
        return self.scale_length / apart if apart > 0 else 0.0
