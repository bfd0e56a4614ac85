"""``valvetrain lift``: measured lifts in, the law behind them with its uncertainty out."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import (
    JsonOption,
    LimitOption,
    OpenOption,
    OutputOption,
    QuietOption,
    SpeedOption,
    SpringOption,
    SpringSetOption,
    WorkersOption,
    asks,
    read_amounts,
    read_engine_speeds,
    read_models,
    read_names,
    read_workers,
    take_folder,
)
from valvetrain.cli.outcome import say_cost
from valvetrain.cli.run_answer import SavedRequest, keep_run, show_page
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.lift.band import LiftBandStudy
    from valvetrain.lift.figures import LiftFigure, LobeResult
    from valvetrain.measured.lift_file import LiftAnswers
    from valvetrain.runs.cost import Limits


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("lift")(lift)


def lift(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="Table of lifts: text of columns, s96, fractions, XLSX; read by content.",
        ),
    ],
    exhaust: Annotated[
        Path | None,
        asks("--exhaust", "FILE", "Table of the exhaust lobe on the same zero: gives overlap."),
    ] = None,
    angle_of: Annotated[str, asks("--angle-of", "cam|crank", "Whose angles the table holds.")] = "",
    lift_of: Annotated[str, asks("--lift-of", "valve|tappet", "Whose lift it is.")] = "",
    lift_unit: Annotated[
        str, asks("--lift-unit", "UNIT", "Unit of the lifts, such as mm or inch.")
    ] = "",
    angle_unit: Annotated[
        str, asks("--angle-unit", "deg|rad", "Unit of the angles (default: deg).")
    ] = "",
    columns: Annotated[
        str,
        asks(
            "--columns",
            "WORDS",
            "What each column is: 'angle, lift, velocity' (or intake, exhaust, ignore).",
        ),
    ] = "",
    zero: Annotated[
        str,
        asks("--zero", "file|nose", "Zero of the angle: as in the file (default) or at the nose."),
    ] = "",
    direction: Annotated[
        str,
        asks(
            "--direction", "forward|reversed", "Whether the cam turned with rising angle (forward)."
        ),
    ] = "",
    peak_lift: Annotated[
        str | None, asks("--peak-lift", "LENGTH", "Of a table of fractions: its largest lift.")
    ] = None,
    duration: Annotated[
        str | None,
        asks("--duration", "ANGLE", "Of a table of fractions: its length, in that angle."),
    ] = None,
    opening: Annotated[
        str | None, asks("--opening", "ANGLE", "Of a table of fractions: where it begins.")
    ] = None,
    noise: Annotated[
        str | None,
        asks(
            "--noise", "LENGTH", "Standard deviation of a station, such as '3 um' (default: found)."
        ),
    ] = None,
    band: Annotated[
        str | None, asks("--band", "LENGTH", "How far the law may leave a station at most.")
    ] = None,
    at: Annotated[
        list[str] | None,
        asks(
            "--at", "LENGTH", "Further lift at which the duration is given: '0.2 inch'. Repeatable."
        ),
    ] = None,
    lash: Annotated[
        str,
        typer.Option(
            "--lash", metavar="LENGTH", help="Lift at which the ramp velocities are evaluated."
        ),
    ] = "0.006 inch",
    case: Annotated[
        str | None,
        asks("--case", "CASE", "Case whose lift it becomes: its forces and speeds with the band."),
    ] = None,
    engine_speed: SpeedOption = None,
    search: Annotated[
        str | None,
        asks(
            "--search",
            "SPEEDS",
            "Range in which float and bounce are searched: '4000:9000:500 rpm'.",
        ),
    ] = None,
    draws: Annotated[
        int,
        typer.Option(
            "--draws", metavar="N", help="Lift laws drawn from the band, for forces and speeds."
        ),
    ] = 16,
    spring: SpringOption = None,
    spring_set: SpringSetOption = None,
    write: Annotated[
        Path | None, asks("--write", "FILE", "Write the smoothed lift at whole cam degrees.")
    ] = None,
    write_form: Annotated[
        str,
        typer.Option("--write-form", metavar="FORM", help="columns, s96, fractions or workbook."),
    ] = "columns",
    output: OutputOption = None,
    workers: WorkersOption = None,
    limit: LimitOption = None,
    open_page: OpenOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Measured lift: figures of the lobe, lift to jerk with error bands, a lift law for a case,
    effect of the noise on forces and float.
    """
    from valvetrain.measured.lift_file import LiftAnswers
    from valvetrain.runs.cost import read_limits
    from valvetrain.units import parse_quantity

    take_folder(output)
    if case is None and (engine_speed or search):
        raise InputError("speeds are run with a case; name it with --case", "--case")
    answers = LiftAnswers(
        angle_of=angle_of,
        lift_of=lift_of,
        lift_unit=lift_unit,
        angle_unit=angle_unit,
        zero=zero,
        direction=direction,
        columns=tuple(word.strip() for word in columns.split(",") if word.strip()),
        peak_lift=None if peak_lift is None else parse_quantity(peak_lift, "length", "--peak-lift"),
        duration=None if duration is None else parse_quantity(duration, "angle", "--duration"),
        opening=None if opening is None else parse_quantity(opening, "angle", "--opening"),
    )
    request = _Request(
        file,
        exhaust,
        answers,
        None if noise is None else parse_quantity(noise, "length", "--noise"),
        None if band is None else parse_quantity(band, "length", "--band"),
        read_amounts(at, "length", "--at"),
        parse_quantity(lash, "length", "--lash"),
        case,
        read_engine_speeds(engine_speed),
        read_engine_speeds(search, "--search"),
        draws,
        read_models(spring),
        read_names(spring_set),
        write,
        write_form,
        output,
        read_workers(workers),
        read_limits(limit),
        ", ".join(limit or ()),
        open_page,
        datetime.now(UTC).replace(microsecond=0),
    )
    _answer(request)


@dataclass(frozen=True)
class _Request:
    """The command as requested; lengths in m, speeds in rad/s."""

    file: Path
    exhaust: Path | None
    answers: LiftAnswers
    noise: float | None
    band: float | None
    heights: tuple[float, ...]
    lash: float
    case_name: str | None
    engine_speeds: tuple[float, ...] | None
    search: tuple[float, ...] | None
    draws: int
    spring_models: tuple[str, ...]
    spring_sets: tuple[str, ...]
    write: Path | None
    write_form: str
    output: Path | None
    workers: int
    limits: Limits
    limit: str
    open_page: bool
    created_at: datetime


def _answer(request: _Request) -> None:
    from valvetrain.cli.outcome import Outcome, deliver
    from valvetrain.cli.progress import busy
    from valvetrain.lift.page import lift_case, lift_page, write_lift
    from valvetrain.report.page import render
    from valvetrain.solution.atomic import write_text

    lobes, pair = _lobes(request)
    carried = _carried(request, lobes[0])
    own = lift_case(f"lift-{request.file.stem}", lobes[0], request.noise, request.band)
    title = (
        f"{request.file.name}{'' if request.exhaust is None else ' and ' + request.exhaust.name}"
    )
    data = _data(lobes, pair, carried)
    pages: list[Path] = []

    def fill(folder: Path) -> list[Path]:
        pages.append(
            write_text(folder / "report.html", render(lift_page(title, lobes, pair, carried)))
        )
        return [*write_lift(lobes, folder, request.noise, request.band), *pages]

    with busy("writing files"):
        choices = {
            name: str(value)
            for name, value in vars(request).items()
            if name not in ("output", "created_at", "open_page")
        }
        folder, files = keep_run(
            SavedRequest("lift", own, request.output, request.created_at),
            own.text,
            choices,
            data,
            fill,
        )
        if request.write is not None:
            from valvetrain.lift.page import write_table

            files.append(str(write_table(lobes, request.write, request.write_form)))
    if request.open_page:
        show_page(pages[0])
    data |= {"folder": str(folder), "files": files, "page": str(pages[0])}
    failures = () if carried is None else (*carried.mean.failures, *carried.failures)
    from valvetrain.lift.verdict import lift_verdict

    show = partial(_show, lobes=lobes, pair=pair, carried=carried, folder=folder)
    deliver(Outcome(data, show, failures, lift_verdict(lobes, pair, carried)))


def _lobes(request: _Request) -> tuple[list[LobeResult], tuple[LiftFigure, ...]]:
    """Every lobe smoothed and measured out; overlap and separation where there are intake and
    exhaust.
    """
    from dataclasses import replace

    from valvetrain.lift.figures import LobeResult, lift_figures, pair_figures
    from valvetrain.measured.lift_file import read_lift
    from valvetrain.measured.lift_smoothing import smooth_lift

    found = list(read_lift(request.file, request.answers))
    if request.exhaust is not None:
        other = read_lift(request.exhaust, request.answers)
        if len(found) != 1 or len(other) != 1:
            raise InputError(
                "with --exhaust each file holds one lobe; leave it out for a file with both",
                "--exhaust",
            )
        found = [replace(found[0], name="intake"), replace(other[0], name="exhaust")]
    results = []
    for lobe in found:
        smoothed = smooth_lift(lobe.cam_angles, lobe.lifts, request.noise, request.band)
        results.append(
            LobeResult(lobe, smoothed, lift_figures(smoothed, request.heights, request.lash))
        )
    known = {one.measured.name: one.smoothed for one in results}
    both = {"intake", "exhaust"} <= set(known)
    return results, pair_figures(known["intake"], known["exhaust"], request.heights) if both else ()


def _carried(request: _Request, lobe: LobeResult) -> LiftBandStudy | None:
    """Forces and critical speeds of the case with this lobe, over the laws that its stations allow."""
    if request.case_name is None:
        return None
    from valvetrain.cli.progress import announce_compilation, progress_bar
    from valvetrain.lift.band import FEWER_LAWS, band_cost, lift_band_study
    from valvetrain.lift.page import lift_parameters
    from valvetrain.parameters.loading import load_case
    from valvetrain.runs.request_cost import RunRequest

    case = load_case(request.case_name)
    if case.lift_law is not None and case.lift_law.lift_of != lobe.measured.lift_of:
        raise InputError(
            f"case '{case.name}' is driven by the lift of the {case.lift_law.lift_of}, the table holds the {lobe.measured.lift_of}'s; "
            "give a table of the other or another case",
            "--case",
        )
    law = lift_parameters(lobe, request.noise, request.band)
    carried = case.replace({"lift_law": law})
    run_request = RunRequest(
        "run",
        carried,
        request.engine_speeds,
        request.spring_models,
        request.spring_sets,
        request.workers,
    )
    say_cost(band_cost(run_request, request.draws, request.search), request.limits, FEWER_LAWS)
    announce_compilation("train")
    with progress_bar(f"{case.name} with {request.draws} laws") as report:
        return lift_band_study(
            carried,
            request.engine_speeds,
            draws=request.draws,
            search=request.search,
            spring_models=request.spring_models,
            spring_set=request.spring_sets,
            workers=request.workers,
            progress=report,
            limit=request.limit,
        )


def _data(
    lobes: list[LobeResult], pair: tuple[LiftFigure, ...], carried: LiftBandStudy | None
) -> dict[str, Any]:
    """The JSON answer, SI."""

    def figures(found: tuple[LiftFigure, ...]) -> dict[str, Any]:
        return {one.name: {"value": one.value, "standard_deviation": one.spread} for one in found}

    data: dict[str, Any] = {
        "command": "lift",
        "case": "",
        "completed": carried is None or not (carried.mean.failures or carried.failures),
    }
    data["lobes"] = [
        {
            "name": one.measured.name,
            "form": one.measured.form,
            "lift_of": one.measured.lift_of,
            "zero": one.measured.zero,
            "answers": {
                answer.question: {"answer": answer.answer, "by": answer.by}
                for answer in one.measured.answers
            },
            "notes": list(one.measured.notes),
            "noise": one.smoothed.noise,
            "figures": figures(one.figures),
        }
        for one in lobes
    ]
    if pair:
        data["both_lobes"] = figures(pair)
    if carried is not None:
        data["carried"] = [
            {
                "quantity": one.quantity,
                "label": one.label,
                "engine_speed": one.engine_speed,
                "value": one.value,
                "standard_deviation": one.spread,
                "laws": one.draws,
            }
            for one in carried.spreads
        ]
    return data


def _show(
    console: Console,
    lobes: list[LobeResult],
    pair: tuple[LiftFigure, ...],
    carried: LiftBandStudy | None,
    folder: Path,
) -> None:
    from valvetrain.cli.outcome import plain_table
    from valvetrain.lift.figures import figure_rows
    from valvetrain.lift.page import carried_rows, lift_notes
    from valvetrain.lift.verdict import carried_text

    for one in lobes:
        said = ", ".join(
            f"{answer.question.replace('_', ' ')} {answer.answer} ({answer.by})"
            for answer in one.measured.answers
        )
        console.print(f"{one.measured!r}; read as {one.measured.form}\n{said}", soft_wrap=True)
        console.print()
        console.print(
            plain_table(("", "value", "95 %", ""), figure_rows(one.figures), right=(1, 2))
        )
        for note in (*one.measured.notes, *lift_notes(one)):
            console.print(f"{note[:1].upper()}{note[1:]}.", soft_wrap=True)
        console.print()
    if pair:
        console.print(
            plain_table(("both lobes", "value", "95 %", ""), figure_rows(pair), right=(1, 2))
        )
        console.print()
    if carried is not None:
        console.print(
            plain_table(
                ("", "run", "mean law", "95 %", ""),
                [carried_text(one) for one in carried_rows(carried)],
                right=(2, 3),
            )
        )
        console.print()
    console.print(f"results in {folder}", soft_wrap=True)
    if carried is None:
        into = "lift.toml there holds the cam as the [lift_law] of a case; --case CASE runs a case with it"
        console.print(into, soft_wrap=True)
