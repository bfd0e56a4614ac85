"""``valvetrain animate``: one cam revolution of a spring or a train as a GIF or MP4 for slides."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from valvetrain.cli.options import (
    JsonOption,
    QuietOption,
    SetOption,
    asks,
    read_engine_speeds,
    read_models,
    read_names,
)
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.parameters.case import Case
    from valvetrain.report.motion.parts import Variant
    from valvetrain.solution.result import Solution
    from valvetrain.solution.study import Study

#: Files of a saved run that are looked at.
MAX_FILES = 200


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("animate")(animate)


def animate(
    case: Annotated[
        str,
        typer.Argument(
            metavar="CASE_OR_RUN", help="A case (name or file), or the folder of a saved run."
        ),
    ],
    output: Annotated[
        str,
        asks("--output", "FILE", "Film to write: FILE.gif, or FILE.mp4 (needs the extra 'film')."),
    ] = "",
    engine_speed: Annotated[
        str | None,
        asks("--engine-speed", "SPEED", "Crank speed, '5600 rpm' (default: the case's highest)."),
    ] = None,
    spring: Annotated[
        str, asks("--spring", "MODEL", "Spring model (default: the case's first).")
    ] = "",
    spring_set: Annotated[
        str, asks("--spring-set", "SET", "Spring set of a train (default: the case's first).")
    ] = "",
    colour: Annotated[
        str,
        asks(
            "--colour",
            "WORD",
            "Colour: stress, contact, gap or velocity (default: the first there is).",
        ),
    ] = "",
    duration: Annotated[
        str,
        typer.Option("--duration", metavar="TIME", help="Time for one cam revolution, 1 to 20 s."),
    ] = "4 s",
    width: Annotated[
        int, typer.Option("--width", metavar="PIXELS", help="Width (height: 16:9), 320 to 1920.")
    ] = 800,
    settings: SetOption = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """One cam revolution of the spring or the train, slowed, as a film for slides."""
    from valvetrain.cli.options import choose_case
    from valvetrain.cli.outcome import Outcome, deliver, measured
    from valvetrain.cli.progress import busy
    from valvetrain.report.motion.film import FilmRequest, check_ending, write_film
    from valvetrain.runs.saved_runs import run_of_path
    from valvetrain.units import parse_quantity

    path = _path(output)
    check_ending(path)
    request = FilmRequest(parse_quantity(duration, "time", "--duration"), width, colour.strip())
    request.check()
    speeds = read_engine_speeds(engine_speed)
    if speeds is not None and len(speeds) != 1:
        raise InputError(
            f"a film shows one engine speed, and {len(speeds)} are given; give one",
            "--engine-speed",
        )
    models, sets = (
        read_models([spring] if spring else None),
        read_names([spring_set] if spring_set else None),
    )
    if len(models) > 1 or len(sets) > 1:
        raise InputError(
            "a film shows one run; give one spring model and one spring set", "--spring"
        )
    chosen = choose_case(case, settings)
    saved = None if settings else run_of_path(Path(case))
    study = (
        _computed(chosen, speeds, models, sets)
        if saved is None
        else _of_saved_run(saved.folder, chosen, speeds, models, sets)
    )
    variant = _variant(study)
    with busy("drawing the film"):
        film = write_film(variant, path, request)
    data = {
        "command": "animate", "case": chosen.name, "completed": True, "file": str(film.path), "run": variant.label,
        "engine_speed": measured(variant.engine_speed, "rad/s"), "pictures": film.pictures, "duration": measured(request.duration, "s"),
        "slowness": film.slowness, "size": measured(film.size, "B"), "notes": list(variant.notes),
    }  # fmt: skip

    def show(console: Console) -> None:
        seen = f"{film.pictures} pictures, {request.duration:g} s, 1/{film.slowness:.0f} of real time, {film.size / 1e6:.2g} MB"
        console.print(f"{film.path}: {variant.title}, {seen}", soft_wrap=True)
        for note in variant.notes:
            console.print(f"{note[:1].upper()}{note[1:].rstrip('.')}.", soft_wrap=True)

    deliver(Outcome(data, show))


def _path(output: str) -> Path:
    if not output.strip() or "\0" in output:
        raise InputError("a film needs a file; give --output FILE.gif or FILE.mp4", "--output")
    path = Path(output)
    if path.is_dir() or not path.parent.is_dir():
        sentence = "is a folder" if path.is_dir() else "is in a folder that does not exist"
        raise InputError(
            f"'{output[:80]}' {sentence}; give a file in a folder that is there", "--output"
        )
    return path


def _computed(
    case: Case, speeds: tuple[float, ...] | None, models: tuple[str, ...], sets: tuple[str, ...]
) -> Study:
    """The one run of a case: its highest speed, first model and first spring set where none is
    requested.
    """
    from valvetrain.cli.progress import busy
    from valvetrain.runs.api import simulate
    from valvetrain.system.build import build

    problem = build(case, spring_models=models, spring_set=sets)
    known = speeds or (max(problem.engine_speeds),) if speeds or problem.engine_speeds else ()
    if not known or not problem.moves:
        sentence = f"case '{case.name}' names no engine speed or has no lift law, so nothing moves; give --engine-speed"
        raise InputError(sentence, "--engine-speed")
    first = next((member for member in problem.members if not member.refusal), problem.members[0])
    with busy("computing the run"):
        return simulate(
            case,
            known,
            spring_models=models or (first.model.word,),
            spring_set=sets or ((first.spring_set,) if first.spring_set else ()),
            workers=1,
        )


def _of_saved_run(
    folder: Path,
    case: Case,
    speeds: tuple[float, ...] | None,
    models: tuple[str, ...],
    sets: tuple[str, ...],
) -> Study:
    """The saved run that fits best, read from its file."""
    from valvetrain.solution.netcdf import load_netcdf
    from valvetrain.solution.quantity import same_speed
    from valvetrain.solution.study import Study

    found: list[Solution] = []
    for path in sorted(folder.glob("*.nc"))[:MAX_FILES]:
        if re.match(r"(static|modes)-", path.name):
            continue
        try:
            run = load_netcdf(path)
        except InputError:
            continue
        fits = (not models or run.model in models) and (not sets or run.spring_set in sets)
        if fits and (speeds is None or same_speed(run.engine_speed, speeds[0])):
            found.append(run)
    if not found:
        raise InputError(
            f"the saved run '{folder}' holds no solution that fits; run its case again, or name another model or speed"
        )
    fastest = max(run.engine_speed for run in found)
    return Study(
        case.record(), solutions=tuple(run for run in found if run.engine_speed == fastest)
    )


def _variant(study: Study) -> Variant:
    from valvetrain.report.motion.scene import Limits, moving_picture, refuse_nothing

    failed = [run for run in study.solutions if not run.has("valve_lift")]
    if failed and len(failed) == len(study.solutions):
        raise InputError(f"nothing moves: {failed[0].status.sentence()}")
    return refuse_nothing(
        moving_picture(study, Limits(variants=1, run_size=4_000_000, size=4_000_000, frames=1440))
    ).variants[0]
