"""How a film was taken and what it shows: the questions that only who filmed can answer."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from valvetrain.errors import InputError
from valvetrain.runs.request_fields import (
    Answers,
    option,
    read_amounts,
    read_case,
    read_choice,
    read_count,
    read_models,
    read_path,
    read_switch,
    read_text,
    read_within,
)
from valvetrain.units import si

if TYPE_CHECKING:
    from valvetrain.parameters.case import Case

Point = tuple[float, float]
Ends = tuple[Point, Point]
ANGLE = partial(read_within, "angle", -1e6, 1e6)
PIXELS = partial(read_within, "ratio", 0.0, 500.0)
FRAME = partial(read_count, 0, 10**9)


def read_point(given: Any, where: str) -> Point:
    """A point (px), from two numbers or their text."""
    return _numbers(given, 2, where)[0]


def read_ends(given: Any, where: str) -> Ends:
    """Two points (px), from four numbers or their text."""
    first, second = _numbers(given, 4, where)
    return first, second


def _numbers(given: Any, count: int, where: str) -> list[Point]:
    import numpy as np

    try:
        parts = given.split(",") if isinstance(given, str) else given
        flat = np.ravel(np.array(parts, dtype=float)).tolist()
    except (TypeError, ValueError):
        flat = []
    if len(flat) != count or not all(abs(value) < 1e6 for value in flat):
        such = ", ".join(["12, 5", "12, 205"][: count // 2])
        raise InputError(
            f"{count} numbers of pixels are needed, such as '{such}', not '{str(given)[:40]}'; correct it",
            where,
        )
    return list(zip(flat[::2], flat[1::2], strict=True))


def read_scale(given: Any, where: str) -> tuple[Point, Point, float]:
    """Two points (px) and their distance (m), from three parts or their text."""
    points, length = given, ""
    if isinstance(given, str):
        points, _, length = given.rpartition(",")
    elif isinstance(given, (list, tuple)) and len(given) == 3:
        points, length = given[:2], given[2]
    ends = read_ends(points, where)
    scale = (*ends, si(length, "length", where))
    if not (math.dist(*ends) > 0 and 0 < scale[2] / math.dist(*ends) < 1.0):
        raise InputError(
            "the two points of the scale are the same or their distance is not positive; correct them",
            where,
        )
    return scale


def read_window(given: Any, where: str) -> tuple[float, float]:
    """Two cam angles (rad) in order, within a turn."""
    ends = read_amounts(
        "angle", given.replace(":", ",") if isinstance(given, str) else given, where
    )
    begin, end = (*ends, 0.0, 0.0)[:2]
    end += math.tau * (end < begin)
    if len(ends) != 2 or not 0 < end - begin < 6.283 or not abs(end) < 1e6:
        raise InputError(
            f"'{str(given)[:40]}' is no window; give two angles less than a turn apart, such as '170:350 deg'",
            where,
        )
    return begin, end


@dataclass(frozen=True, kw_only=True)
class FilmSetup(Answers):
    """Inputs of a film in addition to its pictures. Points are (x, y): column and row in px from the
    centre of the upper left pixel. Amounts are SI numbers, or text with a unit.

    >>> FilmSetup(frame_rate=2000, scale="10, 20, 10, 220, 33.7 mm").metres_per_pixel
    0.0001685
    """

    frame_rate: float | None = option(
        partial(read_within, "frequency", 1.0, 1e7),
        "Frames a second of the camera: '2000 1/s'; needed unless the file gives a rate above that of screens.",
        "--frame-rate",
        "RATE",
    )
    line: Ends | None = option(
        read_ends, "Ends of the line along the spring (default: found).", "--line", "X, Y, X, Y"
    )
    line_width: float = option(
        PIXELS, "Width over which grey levels are averaged (5).", "--line-width", "PX", default=5.0
    )
    coils: int | None = option(
        partial(read_count, 1, 10**6), "Highlights on the line (default: counted).", "--coils", "N"
    )
    seat: str = option(
        partial(read_choice, ("start", "end")),
        "End of the line at the fixed seat (default: found).",
        "--seat",
        "start|end",
        default="",
    )
    scale: tuple[Point, Point, float] | None = option(
        read_scale,
        "Two points and their distance in the plane of the highlights.",
        "--scale",
        "X, Y, X, Y, LENGTH",
    )
    marker: Point | None = option(
        read_point, "Spot whose brightness marks each cam revolution.", "--marker", "X, Y"
    )
    marker_radius: float = option(
        PIXELS, "Radius of that spot (3).", "--marker-radius", "PX", default=3.0
    )
    marker_angle: float | None = option(
        ANGLE, "Cam angle at which the mark passes.", "--marker-angle", "ANGLE"
    )
    cam_speed: float | None = option(
        partial(read_within, "angular speed", 1e-3, 1e7),
        "Speed of the cam, such as '1034 rpm'; compared with the marker's or the lift's where these give it.",
        "--cam-speed",
        "SPEED",
    )
    first_angle: float | None = option(
        ANGLE, "Cam angle of the first frame, with --cam-speed.", "--first-angle", "ANGLE"
    )
    dwell: tuple[float, float] | None = option(
        read_window,
        "Closed valve, cam angles: '170:350 deg' (default: found).",
        "--dwell",
        "FIRST:LAST",
    )
    free_decay: bool = option(
        read_switch, "The cam does not turn: a struck spring rings.", "--free-decay", default=False
    )
    first_frame: int = option(
        FRAME, "First frame that is used, counted from 0.", "--first-frame", "N", default=0
    )
    last_frame: int | None = option(FRAME, "Last frame that is used.", "--last-frame", "N")

    def __post_init__(self) -> None:
        """Raise :class:`InputError` for frames out of order."""
        super().__post_init__()
        last = self.last_frame
        if last is not None and last < self.first_frame:
            raise InputError(
                f"frames {self.first_frame} to {last} are none; count from 0, the first one first",
                "last_frame",
            )

    @property
    def metres_per_pixel(self) -> float:
        """Metres that a pixel shows; 0 without a scale."""
        return 0.0 if self.scale is None else self.scale[2] / math.dist(*self.scale[:2])


@dataclass(frozen=True, kw_only=True)
class FilmRequest(FilmSetup):
    """The motion of the coils in a film, and how far a model is from it."""

    command = "film"

    film: Path = option(
        read_path, "A video, or a folder of its frames as pictures.", metavar="FILE_OR_FOLDER"
    )
    lift_table: Path | None = option(
        read_path, "Table of lifts with headed columns, which gives the phase.", "--lift", "FILE"
    )
    case: Case | None = option(
        read_case,
        "Case run at this speed for comparison; its lift gives the phase.",
        "--case",
        "CASE",
    )
    models: tuple[str, ...] = option(
        read_models, "Spring model of that run.", "--model", "MODEL", default=()
    )
    spring: str = option(
        read_text,
        "Which of nested springs is seen (default: the outer).",
        "--filmed-spring",
        "NAME",
        default="",
    )
    first_turn: float | None = option(
        partial(read_within, "ratio", -100.0, 1e3),
        "Turn of the wire that coil 1 is (default: found).",
        "--first-turn",
        "TURNS",
    )
    synthetic: bool = option(
        read_switch, "Synthetic film: every result is marked as such.", "--synthetic", default=False
    )

    def __post_init__(self) -> None:
        """Raise :class:`InputError` for a model without a case, and a free decay with a cam."""
        super().__post_init__()
        if self.case is None and (self.models or self.spring or self.first_turn is not None):
            raise InputError("a model is run with a case; name it with --case", "case")
        if self.free_decay and (self.case or self.lift_table or self.marker):
            raise InputError(
                "a free decay has no cam; leave out --case, --lift and --marker, or --free-decay",
                "free_decay",
            )
