"""``valvetrain rig``: recordings of a test rig as cycles over the cam angle; a run as a gauge
records it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from valvetrain.cli.options import (
    JsonOption,
    OpenOption,
    OutputOption,
    QuietOption,
    SetOption,
    SpeedOption,
    SpringOption,
    asking,
    asks,
    choose_case,
    folder_of,
    name_case,
    read_engine_speeds,
    read_models,
    read_sensor,
    take_folder,
)
from valvetrain.cli.run_answer import SavedRequest, saved_result
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from valvetrain.measured.sensor import Sensor
    from valvetrain.parameters.case import Case
    from valvetrain.rig.channels import RigAnswers
    from valvetrain.views.shown import Shown


#: Field of :class:`RigAnswers` -> its option, what follows that, and its help.
ASKED = {
    "channels": (
        "--channel",
        "QUANTITY=NAME",
        "Channel of it: 'spring_force=Force 1'. Repeatable.",
    ),
    "encoder": ("--encoder", "NAME", "Channel of an encoder's angle."),
    "pulses": ("--pulses", "NAME", "Channel of a toothed wheel or encoder track; needs --teeth."),
    "index": ("--index", "NAME", "Channel that marks one position of that wheel."),
    "once": ("--once", "NAME", "Channel of one pulse per revolution."),
    "angle_of": ("--angle-of", "cam|crank", "Shaft on which encoder, wheel or pulse sit."),
    "teeth": ("--teeth", "N", "Teeth of the wheel, with those that are missing."),
    "missing": ("--missing", "N", "Number of missing teeth at the reference mark."),
    "units": ("--unit", "QUANTITY=UNIT", "Unit of a channel: 'spring_force=kN'. Repeatable."),
    "calibration": ("--calibration", "QUANTITY=VALUE", "Value of one unit of it: '2.5 N'."),
    "shunt": ("--shunt", "QUANTITY=STEP, LOAD", "Step of the channel with the shunt, its load."),
    "zero": ("--zero", "QUANTITY=VALUE", "Value of a quantity in the dwell: 'spring_force=240 N'."),
    "dwell": ("--dwell", "ANGLES", "First and last cam angle of the dwell: '-30, 30 deg'."),
    "band": ("--band", "FREQUENCY", "Highest frequency to retain: '20 kHz'."),
    "angle_count": (
        "--angle-count",
        "N",
        "Points per cam revolution (default: as the band needs).",
    ),
    "offset": ("--offset", "ANGLE", "Cam angle of the case at the mark, instead of by the lift."),
    "sampling_rate": ("--sampling-rate", "FREQUENCY", "Where the file has no times: '100 kHz'."),
    "span": ("--span", "TIMES", "First and last time that are used: '2, 5 s'."),
    "keep_outliers": ("--keep-outliers", "", "Retain outlier cycles too."),
}


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("rig")(asking(rig, ASKED))


def rig(
    file: Annotated[
        Path | None,
        typer.Argument(
            metavar="[FILE]", help="Recording: text, MDF, TDMS, MAT, HDF5, NetCDF, UFF58."
        ),
    ] = None,
    case: Annotated[
        str | None, asks("--case", "CASE", "Case whose lift gives the cam angle of the mark.")
    ] = None,
    settings: SetOption = None,
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
    *,
    answers: dict[str, Any],
) -> None:
    """Recordings of a test rig as cycles over the cam angle, aligned to a case by the lift; or a
    computed force as a gauge records it.
    """
    from valvetrain.cli.outcome import deliver

    name_case(case or "", settings)
    take_folder(output)
    if settings and case is None:
        raise InputError("values are changed of a case; name it with --case", "--set")
    chosen = None if case is None else choose_case(case, settings)
    if file is None:
        if chosen is None or (bandwidth is None and sensor is None):
            raise InputError(
                "give the recording as a file, or a case and the gauge that shall record it (--case, --bandwidth)",
                "FILE",
            )
        gauge = read_sensor(bandwidth, sensor, answers.get("sampling_rate"))
        speeds, models = read_engine_speeds(engine_speed) or (), read_models(spring)
        saved = _case_answer(chosen, speeds, models, gauge)
    else:
        if engine_speed or bandwidth or sensor or spring:
            raise InputError(
                "speeds, spring models and gauges belong to a case without a file; leave them out, or the file",
                "--bandwidth",
            )
        from valvetrain.rig.channels import RigAnswers

        saved = _recording_answer(file, RigAnswers(**answers), chosen, write)
    now = datetime.now(UTC).replace(microsecond=0)
    home = Path() if case is None else folder_of(case)
    request = SavedRequest("rig", saved, output, now, home)
    deliver(saved_result(request, *saved[1:], open_page))


class _Saved(NamedTuple):
    """What is saved of an answer under a ``name``: the other fields are those of :func:`saved_result`."""

    name: str
    text: str
    data: dict[str, Any]
    show: Callable[[Path], Shown]
    write: Callable[[Path], list[Path]]
    choices: dict[str, str]


def _recording_answer(
    file: Path, answers: RigAnswers, case: Case | None, write: Path | None
) -> _Saved:
    """Cycles of a recording."""
    from hashlib import file_digest

    from valvetrain.cli.progress import busy
    from valvetrain.measured.cycles import write_cycles
    from valvetrain.rig.answer import RigAnswer
    from valvetrain.rig.cycles import rig_cycles
    from valvetrain.rig.files import data_of, write_rig
    from valvetrain.solution.atomic import check_target
    from valvetrain.views.files import FreeNames

    if write is not None:
        check_target(write, "--write")
    with busy("cutting the recording into cycles"):
        result = rig_cycles(file, answers, case)
    name = FreeNames().free(f"rig-{file.stem}")

    def write_files(folder: Path) -> list[Path]:
        files = write_rig(result, folder)
        if write is not None:
            write_cycles(write, result.cycles)
        return files

    # two saved runs are the same where the request and the bytes of the file are
    choices = {key: str(value) for key, value in vars(answers).items() if value}
    with file.open("rb") as stream:
        choices |= {"file": file.name, "digest": file_digest(stream, "blake2b").hexdigest()[:32]}
    return _Saved(
        name,
        f'name = "{name}"\n' if case is None else case.text,
        data_of(result) | {"case": case.name if case else ""},
        lambda folder: RigAnswer(result, folder=folder),
        write_files,
        choices,
    )


def _case_answer(
    case: Case, speeds: Sequence[float], models: Sequence[str], sensor: Sensor
) -> _Saved:
    """True and recorded peaks of the runs of a case."""
    from valvetrain.cli.progress import busy
    from valvetrain.rig.gauge import case_response
    from valvetrain.rig.gauge_answer import GaugeAnswer, data_of, sensor_text, write_responses

    with busy("running the case for the gauge"):
        responses = case_response(case, sensor, speeds, models)
    return _Saved(
        case.name,
        case.text,
        data_of(responses, sensor, case.name),
        lambda folder: GaugeAnswer(case.name, responses, sensor),
        lambda folder: write_responses(responses, folder),
        {"gauge": sensor_text(sensor), "speeds": str(speeds), "models": ", ".join(models)},
    )
