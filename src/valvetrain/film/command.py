"""``valvetrain film``: a high-speed film of a valve spring in; motion of its coils, peaks, surge
lines and damping out.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import (
    JsonOption,
    OpenOption,
    OutputOption,
    QuietOption,
    asking,
    take_folder,
)
from valvetrain.cli.run_answer import SavedRequest, saved_result
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from valvetrain.film.cycles import Lift
    from valvetrain.parameters.case import Case

#: Field of :class:`FilmSetup` -> its option, what follows that, and its help.
SETUP = {
    "frame_rate": ("--frame-rate", "RATE", "Frames a second of the camera: '2000 1/s'."),
    "line": ("--line", "X, Y, X, Y", "Ends of the line along the spring (default: found)."),
    "line_width": ("--line-width", "PX", "Width over which grey levels are averaged (5)."),
    "coils": ("--coils", "N", "Highlights on the line (default: counted)."),
    "seat": ("--seat", "start|end", "End of the line at the fixed seat (default: found)."),
    "marker": ("--marker", "X, Y", "Spot whose brightness marks each cam revolution."),
    "marker_radius": ("--marker-radius", "PX", "Radius of that spot (3)."),
    "marker_angle": ("--marker-angle", "ANGLE", "Cam angle at which the mark passes."),
    "cam_speed": ("--cam-speed", "SPEED", "Speed of the cam, such as '1034 rpm'."),
    "first_angle": ("--first-angle", "ANGLE", "Cam angle of the first frame, with --cam-speed."),
    "dwell": ("--dwell", "FIRST:LAST", "Closed valve, cam angles: '170:350 deg' (default: found)."),
    "free_decay": ("--free-decay", "", "The cam does not turn: a struck spring rings."),
    "first_frame": ("--first-frame", "N", "First frame that is used, counted from 0."),
    "last_frame": ("--last-frame", "N", "Last frame that is used."),
}
#: Further questions, in the same way.
ASKED = SETUP | {
    "scale": ("--scale", "X, Y, X, Y, LENGTH", "Two points and their distance."),
    "lift": ("--lift", "FILE", "Table of lifts with headed columns, which gives the phase."),
    "case": ("--case", "CASE", "Case run at this speed for comparison; its lift gives the phase."),
    "spring_model": ("--model", "MODEL", "Spring model of that run."),
    "spring": ("--filmed-spring", "NAME", "Which of nested springs is seen (default: the outer)."),
    "first_turn": ("--first-turn", "TURNS", "Turn of the wire that coil 1 is (default: found)."),
    "synthetic": ("--synthetic", "", "Synthetic film: every result is marked as such."),
}


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("film")(asking(film, ASKED))


def film(
    film: Annotated[
        Path,
        typer.Argument(
            metavar="FILE_OR_FOLDER", help="A video, or a folder of its frames as pictures."
        ),
    ],
    output: OutputOption = None,
    open_page: OpenOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
    *,
    answers: dict[str, Any],
) -> None:
    """High-speed film of a valve spring: coil motion over the cam angle, peaks, surge frequencies
    with damping; compared with a model.
    """
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import announce_compilation, busy
    from valvetrain.film.answer import FilmAnswer, film_json
    from valvetrain.film.model import film_over_model
    from valvetrain.film.motion import coil_motion
    from valvetrain.film.setup import FilmSetup
    from valvetrain.findings.words import Words
    from valvetrain.parameters.loading import load_case
    from valvetrain.registry import find
    from valvetrain.units.reader import shown_system

    take_folder(output)
    given = answers.get
    case, synthetic = given("case"), given("synthetic", False)
    of_model = {name: answers[name] for name in ("spring_model", "spring", "first_turn") if name in answers}  # fmt: skip
    if case is None and of_model:
        raise InputError("a model is run with a case; name it with --case", "--case")
    if "spring_model" in of_model:
        find("springs", of_model["spring_model"], "--model")
    setup = {name: answers[name] for name in SETUP if name in answers}
    if "scale" in answers:
        setup["scale_points"], _, setup["scale_length"] = answers["scale"].rpartition(",")
    asked = FilmSetup(**setup)
    if asked.free_decay and (case or given("lift") or asked.marker):
        raise InputError(
            "a free decay has no cam; leave out --case, --lift and --marker, or --free-decay",
            "--free-decay",
        )
    chosen = None if case is None else load_case(case)
    lift = _lift(given("lift"), chosen)
    with busy("following the coils"):
        motion = coil_motion(film, asked, lift, synthetic)
    model, text = None, 'name = "film"\ntitle = "Film of a valve spring"\n'
    if chosen is not None:
        announce_compilation("train" if chosen.train is not None else "transient")
        with busy(f"running {chosen.name} at the speed of the film"):
            model = film_over_model(motion, chosen, **of_model)
        text = chosen.record().text

    def show(folder: Path) -> FilmAnswer:
        words = Words(shown_system(), case=case or "")
        return FilmAnswer(motion, model, synthetic, folder=folder, words=words)

    choices = {"film": str(film)} | {name: str(value) for name, value in answers.items()}
    name = Path(f"film-{film.resolve().stem}"[:80])  # what is not a case is saved by its name
    request = SavedRequest("film", chosen or name, output)
    data = film_json(motion, model) | {"synthetic": synthetic}
    deliver(
        saved_result(request, text, data, show, FilmAnswer(motion, model).write, choices, open_page)
    )


def _lift(table: str | None, case: Case | None) -> Lift | None:
    """Lift over the cam angle, from a table or the case."""
    import numpy as np

    from valvetrain.film.model import lift_of_case
    from valvetrain.measured.lift_file import LiftAnswers, chosen_lobe, read_lift
    from valvetrain.measured.lift_smoothing import smooth_lift

    if table is None:
        return None if case is None else lift_of_case(case)
    lobe = chosen_lobe(read_lift(table, LiftAnswers()), "", Path(table).name)
    law = smooth_lift(lobe.cam_angles, lobe.lifts)
    # A table may begin at any angle, below zero too.
    return lambda cam_angle: law.lift(law.event[0] + np.mod(cam_angle - law.event[0], 2 * np.pi))
