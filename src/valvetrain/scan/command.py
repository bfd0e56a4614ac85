"""``valvetrain scan``: a point cloud or mesh of a spring in, its definition out, and its design
next to it.
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
    from valvetrain.scan.compare import ScanComparison
    from valvetrain.scan.result import ScannedSpring

#: Argument of :func:`spring_from_scan` -> its option, what follows that, and its help.
ASKED = {
    "unit": ("--unit", "UNIT", "Unit of the coordinates: mm, m, inch, where the file gives none."),
    "material": ("--material", "NAME", "Wire by name (default: the design's, else EN 10270-2 VDSiCr)."),
    "name": ("--name", "NAME", "Name of the spring in the results."),
    "turn_over": ("--turn-over", "", "Swap the ends: the end taken as upper becomes the lower one."),
    "points": ("--points", "N", "Largest number of points in the fit, drawn evenly (100 000)."),
    "design": ("--design", "CASE", "Case of the design: sizes, curves, statics, modes next to it."),
}  # fmt: skip


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("scan")(asking(scan, ASKED))


def scan(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="Point cloud or mesh: PLY, STL, OBJ or text with x, y, z; read by content.",
        ),
    ],
    output: OutputOption = None,
    open_page: OpenOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
    *,
    answers: dict[str, Any],
) -> None:
    """Spring definition from a 3-D scan: wire axis, section, diameter and pitch with their scatter;
    compared with its design.
    """
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import announce_compilation, busy
    from valvetrain.findings.words import Words
    from valvetrain.parameters.loading import load_case, parse_case
    from valvetrain.parameters.material import material_by_name
    from valvetrain.scan.answer import ScanAnswer
    from valvetrain.scan.compare import compare_scan, design_spring
    from valvetrain.scan.reconstruct import spring_from_scan
    from valvetrain.units.reader import shown_system

    take_folder(output)
    choices = {name: str(value) for name, value in answers.items()}
    case = load_case(answers.pop("design")) if "design" in answers else None
    if case is not None:
        design_spring(case)
        for name, why in (
            ("turn_over", "the curves of both decide which end is up"),
            ("material", "the wire is of its material"),
        ):
            if name in answers:
                flag = ASKED[name][0]
                raise InputError(f"with a design {why}; leave {flag} out", flag)
    if "material" in answers:
        answers["material"] = material_by_name(answers["material"])
    with busy("fitting the wire to the points"):
        scanned = spring_from_scan(file, **answers)
    compared = None
    if case is not None:
        announce_compilation("statics")
        with busy("design and scan at rest"):
            compared = compare_scan(scanned, case)
        scanned = compared.scan

    def show(folder: Path) -> ScanAnswer:
        words = Words(shown_system(), case=str(folder / "spring.toml"))
        return ScanAnswer(scanned, compared, words=words)

    answer = ScanAnswer(scanned, compared)
    request = SavedRequest("scan", parse_case(answer.text, "scan"), output)
    data = _data(scanned, compared)
    failures = () if compared is None else compared.failures
    deliver(
        saved_result(request, answer.text, data, show, answer.write, choices, open_page, failures)
    )


def _data(scanned: ScannedSpring, compared: ScanComparison | None) -> dict[str, Any]:
    """The JSON answer, SI."""
    from valvetrain.measured.json import json_estimate, json_fields

    section, wire = scanned.section, scanned.definition
    data: dict[str, Any] = {
        "command": "scan",
        "case": "",
        "completed": compared is None or not compared.failures,
        **json_fields(
            scanned, "form unit points_read points_fitted points_on_wire noise hand notes"
        ),
        "total_coils": json_estimate(scanned.total_coils),
        "free_length": json_estimate(scanned.free_length),
        "wire_diameter": json_estimate(section.diameter),
        "long_axis": json_estimate(section.long_axis),
        "short_axis": json_estimate(section.short_axis),
        **json_fields(section, "ovate inclination"),
        "axis": {"point": scanned.axis_point, "direction": scanned.axis_direction},
        "ends": {
            word: json_fields(end, "kind ground_coils")
            for word, end in (("lower", wire.lower_end), ("upper", wire.upper_end))
        },
        "curves": json_fields(
            scanned.curves,
            "coil mean_diameter mean_diameter_spread height height_spread pitch pitch_spread centre_line",
        ),
        "turns": [
            dict(zip(("coil", "wire_diameter", "standard_deviation", "points"), row, strict=True))
            for row in section.turns.tolist()
        ],
    }
    if compared is not None:
        data["design"] = compared.cases[0].name
        data["compared"] = [
            json_fields(number, "quantity design scanned") for number in compared.numbers
        ]
        data["failures"] = compared.failures
    return data
