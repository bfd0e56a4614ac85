"""``valvetrain rig``: recordings of a test rig as cycles over the cam angle."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from valvetrain.cli.options import (
    JsonOption,
    OpenOption,
    OutputOption,
    QuietOption,
    SetOption,
    asking,
    asks,
    choose_case,
    folder_of,
    name_case,
    take_folder,
)
from valvetrain.cli.run_answer import SavedRequest, saved_result
from valvetrain.errors import InputError

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
        Path,
        typer.Argument(
            metavar="FILE", help="Recording: text, MDF, TDMS, MAT, HDF5 or UFF58; read by content."
        ),
    ],
    case: Annotated[
        str | None, asks("--case", "CASE", "Case whose lift gives the cam angle of the mark.")
    ] = None,
    settings: SetOption = None,
    output: OutputOption = None,
    open_page: OpenOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
    *,
    answers: dict[str, Any],
) -> None:
    """Recordings of a test rig as cycles over the cam angle, aligned to a case by the lift."""
    from hashlib import file_digest

    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import busy
    from valvetrain.rig.answer import RigAnswer, data_of
    from valvetrain.rig.channels import RigAnswers
    from valvetrain.rig.cycles import rig_cycles
    from valvetrain.views.files import FreeNames

    name_case(case or "", settings)
    take_folder(output)
    if settings and case is None:
        raise InputError("values are changed of a case; name it with --case", "--set")
    chosen = None if case is None else choose_case(case, settings)
    asked = RigAnswers(**answers)
    with busy("cutting the recording into cycles"):
        result = rig_cycles(file, asked, chosen)
    name = FreeNames().free(f"rig-{file.stem}")

    # two saved runs are the same where the request and the bytes of the file are
    choices = {key: str(value) for key, value in vars(asked).items() if value}
    with file.open("rb") as stream:
        choices |= {"file": file.name, "digest": file_digest(stream, "blake2b").hexdigest()[:32]}
    home = Path() if case is None else folder_of(case)
    request = SavedRequest("rig", Path(name), output, home)
    text = f'name = "{name}"\n' if chosen is None else chosen.text
    data = data_of(result) | {"case": chosen.name if chosen else ""}
    deliver(
        saved_result(
            request,
            text,
            data,
            lambda folder: RigAnswer(result, folder=folder),
            RigAnswer(result).write,
            choices,
            open_page,
        )
    )
