"""``valvetrain film``: a high-speed film of a valve spring in; motion of its coils, peaks, surge
lines and damping out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import (
    JsonOption,
    OpenOption,
    OutputOption,
    QuietOption,
    asks,
    read_count,
    take_folder,
)
from valvetrain.cli.run_answer import SavedRequest, keep_run, show_page
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from valvetrain.film.cycles import Lift
    from valvetrain.film.model import FilmedModel
    from valvetrain.film.result import CoilMotion
    from valvetrain.film.setup import FilmSetup


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("film")(film)


def film(
    film: Annotated[
        Path,
        typer.Argument(
            metavar="FILE_OR_FOLDER", help="A video, or a folder of its frames as pictures."
        ),
    ],
    frame_rate: Annotated[
        str | None, asks("--frame-rate", "RATE", "Frames a second of the camera: '2000 1/s'.")
    ] = None,
    line: Annotated[
        str | None,
        asks("--line", "X, Y, X, Y", "Ends of the line along the spring (default: found)."),
    ] = None,
    line_width: Annotated[
        float | None, asks("--line-width", "PX", "Width over which grey levels are averaged (5).")
    ] = None,
    coils: Annotated[
        int | None, asks("--coils", "N", "Highlights on the line (default: counted).")
    ] = None,
    seat: Annotated[
        str, asks("--seat", "start|end", "End of the line at the fixed seat (default: found).")
    ] = "",
    scale: Annotated[
        str | None, asks("--scale", "X, Y, X, Y, LENGTH", "Two points and their distance.")
    ] = None,
    marker: Annotated[
        str | None, asks("--marker", "X, Y", "Spot whose brightness marks each cam revolution.")
    ] = None,
    marker_radius: Annotated[
        float | None, asks("--marker-radius", "PX", "Radius of that spot (3).")
    ] = None,
    marker_angle: Annotated[
        str | None, asks("--marker-angle", "ANGLE", "Cam angle at which the mark passes.")
    ] = None,
    cam_speed: Annotated[
        str | None, asks("--cam-speed", "SPEED", "Speed of the cam, such as '1034 rpm'.")
    ] = None,
    first_angle: Annotated[
        str | None,
        asks("--first-angle", "ANGLE", "Cam angle of the first frame, with --cam-speed."),
    ] = None,
    lift_table: Annotated[
        Path | None,
        asks(
            "--lift", "FILE", "Table of lifts with headed columns, from which the phase is found."
        ),
    ] = None,
    dwell: Annotated[
        str | None,
        asks(
            "--dwell",
            "FIRST:LAST",
            "Cam angles of the closed valve: '170:350 deg' (default: found).",
        ),
    ] = None,
    free_decay: Annotated[
        bool, typer.Option("--free-decay", help="The cam does not turn: a struck spring rings.")
    ] = False,
    first_frame: Annotated[
        int,
        typer.Option(
            "--first-frame", metavar="N", help="First frame that is used, counted from 0."
        ),
    ] = 0,
    last_frame: Annotated[int | None, asks("--last-frame", "N", "Last frame that is used.")] = None,
    exposure: Annotated[
        str | None, asks("--exposure", "TIME", "Exposure of a frame: what motion blur takes.")
    ] = None,
    case: Annotated[
        str | None,
        asks("--case", "CASE", "Case run at this speed for comparison; its lift gives the phase."),
    ] = None,
    spring: Annotated[str, asks("--spring", "MODEL", "Spring model of that run.")] = "",
    filmed_spring: Annotated[
        str,
        asks("--filmed-spring", "NAME", "Which of nested springs is seen (default: the outer)."),
    ] = "",
    first_turn: Annotated[
        float | None,
        asks("--first-turn", "TURNS", "Turn of the wire that coil 1 is (default: found)."),
    ] = None,
    curve_angles: Annotated[
        int, typer.Option("--angles", metavar="N", help="Cam angles of the written curves.")
    ] = 360,
    synthetic: Annotated[
        bool, typer.Option("--synthetic", help="Synthetic film: every result is marked as such.")
    ] = False,
    output: OutputOption = None,
    open_page: OpenOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """High-speed film of a valve spring: coil motion over the cam angle, peaks, surge frequencies
    with damping; compared with a model.
    """
    from valvetrain.film.setup import FilmSetup
    from valvetrain.registry import find

    take_folder(output)
    read_count(curve_angles, 24, 36_000, "--angles")
    if case is None and (spring or filmed_spring or first_turn is not None):
        raise InputError("a model is run with a case; name it with --case", "--case")
    if spring:
        find("springs", spring, "--spring")
    given_options: dict[str, Any] = {"line_width": line_width, "marker_radius": marker_radius}
    setup = FilmSetup(
        frame_rate=frame_rate,
        line=_line(line),
        coils=coils,
        seat=seat,
        **_scale(scale),
        marker=_point(marker),
        marker_angle=marker_angle,
        cam_speed=cam_speed,
        first_angle=first_angle,
        dwell=_window(dwell),
        free_decay=free_decay,
        first_frame=first_frame,
        last_frame=last_frame,
        exposure=exposure,
        **{name: value for name, value in given_options.items() if value is not None},
    )
    if free_decay and (case or lift_table or marker):
        raise InputError(
            "a free decay has no cam; leave out --case, --lift and --marker, or --free-decay",
            "--free-decay",
        )
    request = _Request(
        film,
        setup,
        lift_table,
        case,
        spring,
        filmed_spring,
        first_turn,
        curve_angles,
        synthetic,
        output,
        datetime.now(UTC).replace(microsecond=0),
        open_page,
    )
    _answer(request)


@dataclass(frozen=True)
class _Request:
    """The command as requested."""

    film: Path
    setup: FilmSetup
    lift_table: Path | None
    case_name: str | None
    spring_model: str
    spring: str
    first_turn: float | None
    curve_angles: int
    synthetic: bool
    output: Path | None
    created_at: datetime
    open_page: bool


@dataclass(frozen=True)
class _Name:
    """A result saved under a name that is no case."""

    name: str


def _numbers(text: str, count: int, flag: str) -> tuple[float, ...]:
    parts = text.split(",")
    try:
        found = tuple(float(part) for part in parts)
    except ValueError:
        found = ()
    if len(found) != count or not all(abs(one) < 1e6 for one in found):
        raise InputError(
            f"'{text[:40]}' is not {count} numbers with commas between; points are given in pixels, such as {flag} "
            f"'{', '.join(['12, 5', '12, 205'][: count // 2])}'",
            flag,
        )
    return found


def _point(text: str | None) -> tuple[float, float] | None:
    if text is None:
        return None
    x, y = _numbers(text, 2, "--marker")
    return x, y


def _line(text: str | None) -> tuple[tuple[float, float], tuple[float, float]] | None:
    if text is None:
        return None
    x, y, x_end, y_end = _numbers(text, 4, "--line")
    return (x, y), (x_end, y_end)


def _scale(text: str | None) -> dict[str, Any]:
    if text is None:
        return {}
    points, comma, length = text.rpartition(",")
    if not comma:
        raise InputError(
            f"'{text[:40]}' is no scale; give two points and their distance, such as '12, 5, 12, 205, 33.7 mm'",
            "--scale",
        )
    x, y, x_end, y_end = _numbers(points, 4, "--scale")
    return {"scale_points": ((x, y), (x_end, y_end)), "scale_length": length.strip()}


def _window(text: str | None) -> tuple[float, float] | None:
    """Two cam angles (rad) of text such as ``170:350 deg``."""
    from valvetrain.units import parse_quantity

    if text is None:
        return None
    first, colon, last = text.partition(":")
    unit = last.strip().lstrip("+-.0123456789eE").strip()
    if not colon:
        raise InputError(
            f"'{text[:40]}' is no window; give two angles, such as '170:350 deg'", "--dwell"
        )
    begin = parse_quantity(f"{first.strip()} {unit}".strip(), "angle", "--dwell")
    end = parse_quantity(last.strip(), "angle", "--dwell")
    return begin, end if end > begin else end + 6.283185307179586


def _answer(request: _Request) -> None:
    from valvetrain.cli.outcome import Outcome, deliver
    from valvetrain.cli.progress import busy
    from valvetrain.film.answer import FilmAnswer
    from valvetrain.film.files import film_json, write_film
    from valvetrain.film.motion import coil_motion
    from valvetrain.findings.words import Words
    from valvetrain.parameters.loading import load_case
    from valvetrain.solution.partial_failures import PartialFailures
    from valvetrain.units.reader import shown_system
    from valvetrain.views.results import write_page
    from valvetrain.views.terminal import screen

    case = None if request.case_name is None else load_case(request.case_name)
    lift = _lift(request)
    with busy("following the coils"):
        motion = coil_motion(
            request.film, request.setup, lift, request.curve_angles, request.synthetic
        )
    model = _model(request, motion, case)
    data = film_json(motion, model) | {"synthetic": request.synthetic}
    pages: list[Path] = []

    words = Words(shown_system(), case=request.case_name or "")
    answer, gaps = FilmAnswer(motion, model, request.synthetic, words=words), PartialFailures()

    def fill(folder: Path) -> list[Path]:
        nonlocal answer
        answer = replace(answer, folder=str(folder))
        plain = replace(answer, words=replace(words, units="si"))
        data["findings"] = [one.to_dict() for one in plain.findings]
        pages.extend(filter(None, (write_page(answer, folder, gaps),)))
        return [*write_film(motion, model, folder), *pages]

    name = f"film-{request.film.resolve().stem}"[:80]
    text = (
        'name = "film"\ntitle = "Film of a valve spring"\n' if case is None else case.record().text
    )
    setup_values = vars(request) | vars(request.setup)
    choices = {
        key: str(value)
        for key, value in setup_values.items()
        if key not in ("setup", "output", "created_at", "open_page")
    }
    with busy("writing files"):
        folder, files = keep_run(
            SavedRequest("film", case or _Name(name), request.output, request.created_at),
            text,
            choices,
            data,
            fill,
        )
    page = str(pages[0]) if pages else None
    if request.open_page and pages:
        show_page(pages[0])
    data |= {"folder": str(folder), "files": files, "page": page}
    deliver(
        Outcome(
            data,
            lambda console: console.print(screen(answer, page or "", str(folder))),
            gaps.sentences,
        )
    )


def _lift(request: _Request) -> Lift | None:
    """Lift over the cam angle, from a table or the case."""
    import numpy as np

    from valvetrain.film.model import lift_of_case
    from valvetrain.measured.lift_file import LiftAnswers, chosen_lobe, read_lift
    from valvetrain.measured.lift_smoothing import smooth_lift

    if request.lift_table is not None:
        lobe = chosen_lobe(
            read_lift(request.lift_table, LiftAnswers()), "", request.lift_table.name
        )
        law = smooth_lift(lobe.cam_angles, lobe.lifts)
        # A table may begin at any angle, below zero too.
        return lambda cam_angle: law.lift(
            law.event[0] + np.mod(cam_angle - law.event[0], 2 * np.pi)
        )
    return None if request.case_name is None else lift_of_case(request.case_name)


def _model(request: _Request, motion: CoilMotion, case: Any) -> FilmedModel | None:
    """The case run at the speed of the film."""
    from valvetrain.cli.progress import announce_compilation, busy
    from valvetrain.film.model import film_over_model

    if case is None:
        return None
    announce_compilation("train" if case.train is not None else "transient")
    with busy(f"running {case.name} at the speed of the film"):
        return film_over_model(
            motion, case, request.spring_model, request.spring, request.first_turn
        )
