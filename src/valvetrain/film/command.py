"""``valvetrain film``: a high-speed film of a valve spring in; motion of its coils, peaks, surge
lines and damping out.
"""

from __future__ import annotations

from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from valvetrain.cli.options import (
    JsonOption,
    OpenOption,
    OutputOption,
    QuietOption,
    asks,
    take_folder,
)
from valvetrain.cli.run_answer import SavedRequest, saved_result
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from valvetrain.film.cycles import Lift
    from valvetrain.parameters.case import Case


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
        float, asks("--line-width", "PX", "Width over which grey levels are averaged (5).")
    ] = 5.0,
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
        float, asks("--marker-radius", "PX", "Radius of that spot (3).")
    ] = 3.0,
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
    spring: Annotated[str, asks("--model", "MODEL", "Spring model of that run.")] = "",
    filmed_spring: Annotated[
        str,
        asks("--filmed-spring", "NAME", "Which of nested springs is seen (default: the outer)."),
    ] = "",
    first_turn: Annotated[
        float | None,
        asks("--first-turn", "TURNS", "Turn of the wire that coil 1 is (default: found)."),
    ] = None,
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
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import announce_compilation, busy
    from valvetrain.film.answer import FilmAnswer
    from valvetrain.film.files import film_json, write_film
    from valvetrain.film.model import film_over_model
    from valvetrain.film.motion import coil_motion
    from valvetrain.film.setup import FilmSetup
    from valvetrain.findings.words import Words
    from valvetrain.parameters.loading import load_case
    from valvetrain.registry import find
    from valvetrain.units.reader import shown_system

    take_folder(output)
    if case is None and (spring or filmed_spring or first_turn is not None):
        raise InputError("a model is run with a case; name it with --case", "--case")
    if spring:
        find("springs", spring, "--model")
    points, _, length = (None, "", None) if scale is None else scale.rpartition(",")
    setup = FilmSetup(
        frame_rate=frame_rate,
        line=line,
        line_width=line_width,
        coils=coils,
        seat=seat,
        scale_points=points,
        scale_length=length,
        marker=marker,
        marker_radius=marker_radius,
        marker_angle=marker_angle,
        cam_speed=cam_speed,
        first_angle=first_angle,
        dwell=dwell,
        free_decay=free_decay,
        first_frame=first_frame,
        last_frame=last_frame,
        exposure=exposure,
    )
    if free_decay and (case or lift_table or marker):
        raise InputError(
            "a free decay has no cam; leave out --case, --lift and --marker, or --free-decay",
            "--free-decay",
        )
    chosen = None if case is None else load_case(case)
    lift = _lift(lift_table, chosen)
    with busy("following the coils"):
        motion = coil_motion(film, setup, lift, synthetic)
    model, text = None, 'name = "film"\ntitle = "Film of a valve spring"\n'
    if chosen is not None:
        announce_compilation("train" if chosen.train is not None else "transient")
        with busy(f"running {chosen.name} at the speed of the film"):
            model = film_over_model(motion, chosen, spring, filmed_spring, first_turn)
        text = chosen.record().text

    def show(folder: Path) -> FilmAnswer:
        words = Words(shown_system(), case=case or "")
        return FilmAnswer(motion, model, synthetic, str(folder), words)

    choices = {name: str(value) for name, value in vars(setup).items()}
    choices |= {"film": str(film), "lift_table": str(lift_table), "case": str(case), "spring_model": spring, "spring": filmed_spring,
                "first_turn": str(first_turn), "synthetic": str(synthetic)}  # fmt: skip
    now = datetime.now(UTC).replace(microsecond=0)
    name = Path(f"film-{film.resolve().stem}"[:80])  # what is not a case is saved by its name
    request = SavedRequest("film", chosen or name, output, now)
    data, write = (
        film_json(motion, model) | {"synthetic": synthetic},
        partial(write_film, motion, model),
    )
    deliver(saved_result(request, text, data, show, write, choices, open_page))


def _lift(table: Path | None, case: Case | None) -> Lift | None:
    """Lift over the cam angle, from a table or the case."""
    import numpy as np

    from valvetrain.film.model import lift_of_case
    from valvetrain.measured.lift_file import LiftAnswers, chosen_lobe, read_lift
    from valvetrain.measured.lift_smoothing import smooth_lift

    if table is None:
        return None if case is None else lift_of_case(case)
    lobe = chosen_lobe(read_lift(table, LiftAnswers()), "", table.name)
    law = smooth_lift(lobe.cam_angles, lobe.lifts)
    # A table may begin at any angle, below zero too.
    return lambda cam_angle: law.lift(law.event[0] + np.mod(cam_angle - law.event[0], 2 * np.pi))
