"""``valvetrain lift``: measured lifts in, the law behind them with its uncertainty out."""

from __future__ import annotations

import shlex
from dataclasses import asdict, replace
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
    UnitsOption,
    WorkersOption,
    asks,
    read_amounts,
    read_engine_speeds,
    read_models,
    read_names,
    read_workers,
    take_folder,
    take_units,
)
from valvetrain.cli.outcome import deliver
from valvetrain.cli.run_answer import SavedRequest, saved_result
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from valvetrain.lift.band import LiftBandStudy
    from valvetrain.lift.figures import LiftFigure, LobeResult
    from valvetrain.lift.rules import LiftFacts
    from valvetrain.measured.lift_file import MeasuredLift
    from valvetrain.parameters.lift_law import LiftLawParameters
    from valvetrain.runs.cost import Limits

#: Options that say where and how an answer is shown.
MANNER = ("output", "open_page", "units", "as_json", "quiet")
#: Options that say what the tables hold.
READS = (
    "exhaust", "angle_of", "lift_of", "lift_unit", "angle_unit", "columns", "zero", "direction", "lobe", "follower", "base_radius",
    "mend", "peak_lift", "duration", "opening", "noise", "band",
)  # fmt: skip


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("lift")(lift)


def lift(
    file: Annotated[
        Path | None,
        typer.Argument(
            metavar="FILE",
            help="Table of lifts or contour: text, s96, fractions, XLSX, DXF; read by content. Or a case.",
        ),
    ] = None,
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
    lobe: Annotated[str, asks("--lobe", "NAME", "Which of the lobes or events of the table.")] = "",
    events: Annotated[
        str, asks("--events", "TEXT", "Of a cam card: 'IVO 5 before top, IVC 32.5 after bottom'.")
    ] = "",
    top_dead_centre: Annotated[
        str | None,
        asks("--top-dead-centre", "ANGLE", "Cam angle of it on the page: gives IVO to EVC."),
    ] = None,
    lobe_centre: Annotated[
        str | None,
        asks(
            "--lobe-centre", "ANGLE", "Crank angle of the lobe after (−: before) top dead centre."
        ),
    ] = None,
    follower: Annotated[
        str, asks("--follower", "TEXT", "What the cam lifts: flat, 'roller 10 mm', 'dome 50 mm'.")
    ] = "",
    base_radius: Annotated[
        str | None,
        asks("--base-radius", "LENGTH", "Radius of the base circle: gives the contour of the cam."),
    ] = None,
    mend: Annotated[
        bool, typer.Option("--mend", help="Take out stations that stand out, such as dust.")
    ] = False,
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
    output: OutputOption = None,
    workers: WorkersOption = None,
    limit: LimitOption = None,
    open_page: OpenOption = False,
    units: UnitsOption = "si",
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Measured lift: figures of the lobe, lift to jerk with error bands, a lift law for a case,
    effect of the noise on forces and float.
    """
    choices = {name: str(value) for name, value in locals().items() if name not in MANNER}
    read = {name: one for name, one in locals().items() if name in READS and one}
    from valvetrain.lift.answer import LiftAnswer
    from valvetrain.lift.files import lift_case, lift_parameters, write_lift
    from valvetrain.lift.rules import LiftFacts
    from valvetrain.lift.shape import with_contour, write_contours
    from valvetrain.lift.timing import (
        cams_of,
        dead_centre_of,
        lift_of_case,
        read_off,
        typed_figures,
    )
    from valvetrain.measured.contours import Follower
    from valvetrain.measured.lift_file import LiftAnswers, chosen_lobe, read_lift
    from valvetrain.runs.cost import read_limits
    from valvetrain.solution.atomic import write_text

    take_folder(output)
    take_units(units)
    if case is None and (engine_speed or search):
        raise InputError("speeds are run with a case; name it with --case", "--case")
    answers = LiftAnswers(
        angle_of=angle_of, lift_of=lift_of, lift_unit=lift_unit, angle_unit=angle_unit, zero=zero, direction=direction,
        columns=tuple(word.strip() for word in columns.split(",") if word.strip()),
        peak_lift=_si(peak_lift, "length", "--peak-lift"), duration=_si(duration, "angle", "--duration"),
        opening=_si(opening, "angle", "--opening"), mend=mend, follower=follower
    )  # fmt: skip
    stated = _si(noise, "length", "--noise"), _si(band, "length", "--band")
    limits, heights = read_limits(limit), read_amounts(at, "length", "--at")
    options = {
        "engine_speeds": read_engine_speeds(engine_speed), "search": read_engine_speeds(search, "--search"), "draws": draws,
        "models": read_models(spring), "spring_sets": read_names(spring_set), "workers": read_workers(workers),
        "limit": ", ".join(limit or ())
    }  # fmt: skip
    is_case = file is not None and file.suffix == ".toml"
    top, centre = (
        _si(top_dead_centre, "angle", "--top-dead-centre"), _si(lobe_centre, "angle", "--lobe-centre")
    )  # fmt: skip
    tables = [one for one in (file, exhaust) if one is not None]
    named = [(one, read_lift(one, answers)) for one in tables[is_case:]]
    if is_case and file is not None:
        sampled, own_top = lift_of_case(file)
        top, named = own_top if top is None else top, [(file, (sampled,)), *named]
    cams = cams_of(events, file if is_case else None)
    if not (named or cams):
        raise InputError("a cam comes as a table of lifts, a case or --events; give one", "FILE")
    if lobe or case is not None or exhaust is not None:
        named = [(one, (chosen_lobe(found, lobe, one.name),)) for one, found in named]
    lobes, pair = _lobes(
        [one for _, found in named for one in found], exhaust is not None, stated,
        (heights, _si(lash, "length", "--lash") or 0.0)
    )  # fmt: skip
    circle = _si(base_radius, "length", "--base-radius")
    lobes = [with_contour(one, circle, Follower.of(follower or "flat")) for one in lobes]
    if not lobes and case is not None:
        raise InputError("a case takes a lift, not events alone; give a table of lifts", "--case")
    if lobes and top is None and centre is not None:
        top = dead_centre_of(lobes[0], centre)
    timing = {one.name: one for one in typed_figures(cams)}
    if top is not None:
        timing |= {one.name: one for one in read_off(lobes, top)}
    carried = None
    if case is not None:
        carried = _carried(case, lift_parameters(lobes[0], *stated), options, limits)
    own = lift_case(
        f"lift-{'events' if file is None else file.stem}", lobes[0] if lobes else None, *stated
    )
    title = " and ".join(one.name for one in tables)
    words = [
        word
        for key, one in read.items()
        for word in (f"--{key.replace('_', '-')}", *([] if one is True else [str(one)]))
    ]
    again = shlex.join([str(file or ""), *words])
    facts = LiftFacts(tuple(lobes), pair, tuple(timing.values()), carried, again=again)
    name = "case" if carried is not None else lobes[0].measured.name if lobes else "events"

    def fill(folder: Path) -> list[Path]:
        files = [*write_lift(lobes, folder, *stated), *write_contours(lobes, folder)]
        if carried is not None:
            files.append(write_text(folder / "case.toml", carried.mean.record.text))
        return files

    data = _data(facts)
    deliver(saved_result(
        SavedRequest("lift", own, output), own.text, data,
        lambda folder: LiftAnswer(replace(facts, file=str(folder / f"{name}.toml")), title), fill, choices, open_page, facts.failures
    ))  # fmt: skip


def _si(text: str | None, dimension: str, flag: str) -> float | None:
    from valvetrain.units import parse_quantity

    return None if text is None else parse_quantity(text, dimension, flag)


def _lobes(
    found: list[MeasuredLift],
    of_two_files: bool,
    stated: tuple[float | None, float | None],
    figures: tuple[tuple[float, ...], float],
) -> tuple[list[LobeResult], tuple[LiftFigure, ...]]:
    """Every lobe smoothed with the ``stated`` noise and band (m) and measured out; of intake and exhaust
    what both have together. ``figures``: lifts (m) of durations, and of ramp velocities.
    """
    from valvetrain.lift.figures import LobeResult, lift_figures, pair_figures
    from valvetrain.measured.lift_smoothing import smooth_lift

    if of_two_files:
        found = [replace(found[0], name="intake"), replace(found[1], name="exhaust")]
    results = []
    for lobe in found:
        smoothed = smooth_lift(lobe.cam_angles, lobe.lifts, *stated)
        results.append(LobeResult(lobe, smoothed, lift_figures(smoothed, *figures)))
    known = {one.measured.name: one.smoothed for one in results}
    both = {"intake", "exhaust"} <= set(known)
    return results, pair_figures(known["intake"], known["exhaust"], figures[0]) if both else ()


def _carried(
    name: str, law: LiftLawParameters, options: dict[str, Any], limits: Limits
) -> LiftBandStudy:
    """Forces and critical speeds of a case with this ``law``, over the laws that its stations allow."""
    from valvetrain.cli.progress import announce_compilation, progress_bar
    from valvetrain.lift.band import FEWER_LAWS, band_cost, lift_band_study
    from valvetrain.lift.files import case_with
    from valvetrain.parameters.loading import load_case
    from valvetrain.runs.cost import RunRequest, refuse_cost

    case = load_case(name)
    if case.lift_law is not None and case.lift_law.lift_of != law.lift_of:
        raise InputError(
            f"case '{case.name}' is driven by the lift of the {case.lift_law.lift_of}, the table holds the {law.lift_of}'s; "
            "give a table of the other or another case",
            "--case",
        )
    carried, draws = case_with(case, law), options["draws"]
    run = (options[key] for key in ("engine_speeds", "models", "spring_sets", "workers"))
    cost = band_cost(RunRequest("run", carried, *run), draws, options["search"])
    refuse_cost(cost, limits, fewer=FEWER_LAWS)
    announce_compilation("train")
    with progress_bar(f"{case.name} with {draws} laws") as report:
        return lift_band_study(carried, progress=report, **options)


def _data(facts: LiftFacts) -> dict[str, Any]:
    """The JSON answer, SI."""
    carried = facts.carried

    def figures(found: tuple[LiftFigure, ...]) -> dict[str, Any]:
        return {one.name: {"value": one.value, "standard_deviation": one.spread} for one in found}

    data: dict[str, Any] = {
        "command": "lift", "case": "", "completed": not facts.failures
    }  # fmt: skip
    data["lobes"] = [
        {
            "name": one.measured.name, "form": one.measured.form, "lift_of": one.measured.lift_of, "zero": one.measured.zero,
            "answers": {answer.question: {"answer": answer.answer, "by": answer.by} for answer in one.measured.answers},
            "notes": list(one.measured.notes), "changes": list(one.measured.changes), "mended": one.measured.mended,
            "dust": [asdict(bump) for bump in one.measured.dust], "noise": one.smoothed.noise, "figures": figures(one.figures)
        }
        for one in facts.lobes
    ]  # fmt: skip
    if facts.pair:
        data["both_lobes"] = figures(facts.pair)
    if facts.timing:
        data["timing"] = figures(facts.timing)
    if carried is not None:
        data["carried"] = [
            {
                "quantity": one.quantity, "label": one.label, "engine_speed": one.engine_speed, "value": one.value,
                "standard_deviation": one.spread, "laws": one.draws
            }
            for one in carried.spreads
        ]  # fmt: skip
    return data
