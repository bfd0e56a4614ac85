"""``valvetrain rig``: recordings of a test rig become cycles over the cam angle; a model's trace as
a gauge sees it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import (
    JsonOption,
    OpenOption,
    OutputOption,
    QuietOption,
    SetOption,
    SpeedOption,
    SpringOption,
    asks,
    read_engine_speeds,
    read_models,
    read_sensor,
    take_folder,
)
from valvetrain.cli.study_command import SavedRequest, keep_run, show_page
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.parameters.case import Case
    from valvetrain.report.page import Page
    from valvetrain.rig.channels import RigAnswers
    from valvetrain.rig.result import RigResult


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("rig")(rig)


def rig(
    file: Annotated[
        Path | None,
        typer.Argument(
            metavar="[FILE]", help="Recording: text, MDF, TDMS, MAT, HDF5, NetCDF, UFF58."
        ),
    ] = None,
    channel: Annotated[
        list[str] | None,
        asks("--channel", "QUANTITY=NAME", "Channel of it: 'spring_force=Force 1'. Repeatable."),
    ] = None,
    encoder: Annotated[str, asks("--encoder", "NAME", "Channel of an encoder's angle.")] = "",
    pulses: Annotated[
        str, asks("--pulses", "NAME", "Channel of a toothed wheel or encoder track; needs --teeth.")
    ] = "",
    index: Annotated[
        str, asks("--index", "NAME", "Channel that marks a place of that wheel.")
    ] = "",
    once: Annotated[str, asks("--once", "NAME", "Channel of one pulse a turn.")] = "",
    angle_of: Annotated[
        str, asks("--angle-of", "cam|crank", "Shaft on which encoder, wheel or pulse sit.")
    ] = "",
    teeth: Annotated[
        int | None, asks("--teeth", "N", "Teeth in one turn, with those that are missing.")
    ] = None,
    missing: Annotated[
        int,
        typer.Option(
            "--missing", metavar="N", help="Number of missing teeth at the reference mark."
        ),
    ] = 0,
    unit: Annotated[
        list[str] | None,
        asks("--unit", "QUANTITY=UNIT", "Unit of a channel: 'spring_force=kN'. Repeatable."),
    ] = None,
    calibration: Annotated[
        list[str] | None,
        asks("--calibration", "QUANTITY=VALUE", "What one unit of it stands for: '2.5 N'."),
    ] = None,
    shunt: Annotated[
        list[str] | None,
        asks("--shunt", "QUANTITY=STEP, LOAD", "Step of the channel with the shunt, its load."),
    ] = None,
    zero: Annotated[
        list[str] | None,
        asks("--zero", "QUANTITY=VALUE", "What a quantity is in the dwell: 'spring_force=240 N'."),
    ] = None,
    dwell: Annotated[
        str | None,
        asks("--dwell", "ANGLES", "First and last cam angle of the dwell: '-30, 30 deg'."),
    ] = None,
    band: Annotated[
        str | None, asks("--band", "FREQUENCY", "Highest frequency that is kept: '20 kHz'.")
    ] = None,
    angle_count: Annotated[
        int | None, asks("--angle-count", "N", "Points of a cam turn (default: as the band needs).")
    ] = None,
    sampling_rate: Annotated[
        str | None, asks("--sampling-rate", "FREQUENCY", "Where the file has no times: '100 kHz'.")
    ] = None,
    span: Annotated[
        str | None, asks("--span", "TIMES", "First and last time that are used: '2, 5 s'.")
    ] = None,
    keep_outliers: Annotated[
        bool, typer.Option("--keep-outliers", help="Keep outlier cycles too.")
    ] = False,
    case: Annotated[
        str | None, asks("--case", "CASE", "Case whose lift gives the cam angle of the mark.")
    ] = None,
    settings: SetOption = None,
    offset: Annotated[
        str | None,
        asks("--offset", "ANGLE", "Cam angle of the case at the mark, instead of by the lift."),
    ] = None,
    engine_speed: SpeedOption = None,
    spring: SpringOption = None,
    bandwidth: Annotated[
        str | None,
        asks("--bandwidth", "FREQUENCY", "Without a file: forces of the case as it records them."),
    ] = None,
    sensor: Annotated[
        str | None,
        asks(
            "--sensor",
            "WORDS",
            "The gauge: 'natural_frequency=60 kHz, damping_ratio=0.02, order=2'.",
        ),
    ] = None,
    write: Annotated[
        Path | None,
        asks("--write", "FILE", "Write the cycles too: NetCDF (.nc), or text for one channel."),
    ] = None,
    output: OutputOption = None,
    open_page: OpenOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Recordings of a test rig as cycles over the cam angle, aligned to a case by the lift; or a
    computed force as a gauge records it.
    """

    take_folder(output)
    asked = _Request(output, open_page, datetime.now(UTC).replace(microsecond=0))
    if file is None:
        if case is None or (bandwidth is None and sensor is None):
            raise InputError(
                "give the recording as a file, or a case and the gauge that shall see it (--case, --bandwidth)",
                "FILE",
            )
        return seen(
            case,
            settings,
            read_engine_speeds(engine_speed),
            read_models(spring),
            (bandwidth, sensor, sampling_rate),
            asked.deliver,
        )
    if engine_speed or bandwidth or sensor or spring:
        raise InputError(
            "speeds, spring models and gauges belong to a case without a file; leave them out, or the file",
            "--bandwidth",
        )
    from valvetrain.rig.channels import RigAnswers

    answers = RigAnswers(
        channels=read_pairs(channel, "--channel"),
        encoder=encoder,
        pulses=pulses,
        index=index,
        once=once,
        angle_of=angle_of,
        teeth=teeth,
        missing=missing,
        units=read_pairs(unit, "--unit"),
        calibration=read_pairs(calibration, "--calibration"),
        shunt=read_pairs(shunt, "--shunt"),
        zero=read_pairs(zero, "--zero"),
        dwell=_two(dwell, "angle", "--dwell"),
        band=band,
        angle_count=angle_count,
        offset=offset,
        sampling_rate=sampling_rate,
        span=_two(span, "time", "--span"),
        keep_outliers=keep_outliers,
    )
    return _answer(file, answers, case, settings, write, asked)


def read_pairs(texts: Sequence[str] | None, where: str) -> dict[str, str]:
    """``QUANTITY=WORDS`` of a repeatable option. Raises :class:`InputError` for a text without the
    sign, or a quantity named twice.
    """
    found: dict[str, str] = {}
    for given in texts or ():
        quantity, sign, words = given.partition("=")
        name = quantity.strip().replace(" ", "_")
        if (
            not sign
            or not words.strip()
            or not name.isidentifier()
            or not name.isascii()
            or len(name) > 60
        ):
            raise InputError(
                f"'{given[:40]}' is no pair; write QUANTITY=..., such as 'spring_force=...'", where
            )
        if name in found:
            raise InputError(f"{name} is given twice; give it once", where)
        found[name] = words.strip()
    return found


def _two(text: str | None, dimension: str, where: str) -> tuple[float, float] | None:
    """First and last of a stretch."""
    if text is None:
        return None
    from valvetrain.units import parse_quantities

    found = parse_quantities(text, dimension, where)
    if len(found) != 2:
        example = "-30, 30 deg" if dimension == "angle" else "2, 5 s"
        raise InputError(f"a stretch has two ends, first and last: '{example}'", where)
    return found[0], found[1]


@dataclass(frozen=True)
class _Named:
    """What the kept folder calls the run."""

    name: str


@dataclass(frozen=True)
class _Request:
    """Where an answer goes."""

    output: Path | None
    open_page: bool
    created_at: datetime

    def deliver(
        self,
        name: str,
        text: str,
        page: Page,
        data: dict[str, Any],
        write: Any,
        show: Any,
        choices: dict[str, str],
        home: Path = Path(),
    ) -> None:
        """Keep the folder (page, files, run.json) and tell."""
        from valvetrain.cli.outcome import Outcome, deliver
        from valvetrain.report.page import render
        from valvetrain.solution.atomic import write_text

        pages: list[Path] = []

        def fill(folder: Path) -> list[Path]:
            pages.append(write_text(folder / "report.html", render(page)))
            return [*write(folder), *pages]

        folder, files = keep_run(
            SavedRequest("rig", _Named(name), self.output, self.created_at, folder=home),
            text,
            choices,
            data,
            fill,
        )
        if self.open_page:
            show_page(pages[0])
        data |= {"folder": str(folder), "files": files, "page": str(pages[0])}

        def told(console: Console) -> None:
            show(console)
            console.print()
            console.print(f"results in {folder}; page: {pages[0]}", soft_wrap=True)

        deliver(Outcome(data, told, ()))


def _answer(
    file: Path,
    answers: RigAnswers,
    case: str | None,
    settings: list[str] | None,
    write: Path | None,
    asked: _Request,
) -> None:
    from hashlib import file_digest

    from valvetrain.cli.options import choose_case, folder_of
    from valvetrain.cli.progress import busy
    from valvetrain.report.files import FreeNames
    from valvetrain.rig.cycles import rig_cycles
    from valvetrain.rig.page import data_of, rig_page, write_rig
    from valvetrain.solution.atomic import check_target

    if settings and case is None:
        raise InputError("values are changed of a case; name it with --case", "--set")
    if write is not None:
        check_target(write, "--write")
    chosen: Case | None = None
    if case is not None:
        chosen = choose_case(case, settings)
    with busy("cutting the recording into cycles"):
        result = rig_cycles(file, answers, chosen)
    name = FreeNames().free(f"rig-{file.stem}")
    data = data_of(result) | {"case": chosen.name if chosen else ""}

    def files(folder: Path) -> list[Path]:
        written = write_rig(result, folder)
        if write is not None:
            from valvetrain.measured.cycles import write_cycles

            write_cycles(write, result.cycles)
        return written

    text = chosen.text if chosen is not None else f'name = "{name}"\n'
    home = folder_of(case) if case is not None else Path()
    # what was asked, and of which bytes: two kept runs are the same where these are
    given = {
        key: str(value)
        for key, value in vars(answers).items()
        if value not in (None, "", 0, False) and value != {}
    }
    with file.open("rb") as stream:
        given |= {"file": file.name, "digest": file_digest(stream, "blake2b").hexdigest()[:32]}
    asked.deliver(
        name,
        text,
        rig_page(file.name, result),
        data,
        files,
        lambda console: _show(console, result),
        given,
        home,
    )


def _show(console: Console, result: RigResult) -> None:
    from valvetrain.cli.outcome import plain_table
    from valvetrain.rig.page import HEAD, channel_rows, facts_of, sentences_of

    console.print(f"{result!r}", soft_wrap=True)
    console.print("; ".join(f"{key} {value}" for key, value in facts_of(result)), soft_wrap=True)
    console.print()
    console.print(plain_table(HEAD, channel_rows(result), right=(2, 3, 4, 6, 7)))
    console.print()
    for sentence in sentences_of(result):
        console.print(f"{sentence[:1].upper()}{sentence[1:]}.", soft_wrap=True)


def seen(
    case: str,
    settings: Sequence[str] | None,
    engine_speeds: tuple[float, ...] | None,
    spring_models: tuple[str, ...],
    gauge: tuple[str | None, str | None, str | None],
    deliver: Callable[..., None],
) -> None:
    """Run the case and tell true and recorded peaks; ``gauge``: --bandwidth, --sensor,
    --sampling-rate.
    """
    from valvetrain.cli.options import choose_case, folder_of
    from valvetrain.cli.progress import busy
    from valvetrain.rig.gauge import seen_in_case
    from valvetrain.rig.gauge_page import data_of, seen_page, sensor_words
    from valvetrain.rig.gauge_page import write_seen as write

    sensor = read_sensor(*gauge)
    chosen = choose_case(case, list(settings or ()))
    with busy("running the case for the gauge"):
        found = seen_in_case(chosen, sensor, engine_speeds or (), spring_models)
    data = data_of(found, sensor, chosen.name)
    page = seen_page(chosen.name, found, sensor)

    def files(folder: Path) -> list[Path]:
        return write(found, folder)

    def show(console: Console) -> None:
        from valvetrain.cli.outcome import plain_table
        from valvetrain.rig.gauge_page import HEAD, notes_of, seen_rows

        console.print(f"Gauge: {sensor_words(sensor)}", soft_wrap=True)
        console.print()
        console.print(plain_table(HEAD, seen_rows(found), right=(2, 3, 4, 6)))
        for sentence in notes_of(found):
            console.print(f"{sentence}.", soft_wrap=True)

    asked = {
        "gauge": sensor_words(sensor),
        "speeds": str(engine_speeds or ""),
        "models": ", ".join(spring_models),
    }
    deliver(chosen.name, chosen.text, page, data, files, show, asked, folder_of(case))
