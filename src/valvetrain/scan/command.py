"""``valvetrain scan``: a point cloud or mesh of a spring in, its definition out, and its design
next to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from valvetrain.cli.request import FolderLine, command_of
from valvetrain.errors import InputError
from valvetrain.runs.request_fields import (
    Answers,
    option,
    read_case,
    read_count,
    read_path,
    read_switch,
    read_text,
)

if TYPE_CHECKING:
    from valvetrain.parameters.case import Case
    from valvetrain.scan.compare import ScanComparison
    from valvetrain.scan.result import ScannedSpring


@dataclass(frozen=True, kw_only=True)
class ScanRequest(Answers):
    """The spring of a scan, next to its design where one is given."""

    command = "scan"

    file: Path = option(
        read_path,
        "Point cloud or mesh: PLY, STL, OBJ or text with x, y, z; read by content.",
        metavar="FILE",
    )
    unit: str = option(
        read_text,
        "Unit of the coordinates: mm, m, inch, where the file gives none.",
        "--unit",
        "UNIT",
        default="",
    )
    material: str = option(
        read_text,
        "Wire by name (default: the design's, else EN 10270-2 VDSiCr).",
        "--material",
        "NAME",
        default="",
    )
    name: str = option(
        read_text, "Name of the spring in the results.", "--name", "NAME", default="spring"
    )
    turn_over: bool = option(
        read_switch,
        "Swap the ends: the end taken as upper becomes the lower one.",
        "--turn-over",
        default=False,
    )
    points: int = option(
        partial(read_count, 1500, 2_000_000),
        "Largest number of points in the fit, drawn evenly.",
        "--points",
        "N",
        default="100000",
    )
    design: Case | None = option(
        read_case,
        "Case of the design: sizes, curves, statics, modes next to it.",
        "--design",
        "CASE",
    )

    def __post_init__(self) -> None:
        """Raise :class:`InputError` for what a design decides itself."""
        super().__post_init__()
        for name, why in (
            ("turn_over", "the curves of both decide which end is up"),
            ("material", "the wire is of its material"),
        ):
            if self.design is not None and getattr(self, name):
                raise InputError(f"with a design {why}; leave --{name.replace('_', '-')} out", name)


def scan(request: ScanRequest, line: FolderLine, _: Path) -> None:
    """Spring definition from a 3-D scan: wire axis, section, diameter and pitch with their scatter;
    compared with its design.
    """
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import announce_compilation, busy
    from valvetrain.cli.run_answer import SavedRequest, saved_result
    from valvetrain.findings.words import Words
    from valvetrain.parameters.loading import parse_case
    from valvetrain.parameters.material import material_by_name
    from valvetrain.scan.answer import ScanAnswer
    from valvetrain.scan.compare import compare_scan, design_spring
    from valvetrain.scan.reconstruct import spring_from_scan

    case, compared = request.design, None
    if case is not None:
        design_spring(case)
    with busy("fitting the wire to the points"):
        scanned = spring_from_scan(
            request.file,
            unit=request.unit,
            material=material_by_name(request.material) if request.material else None,
            name=request.name,
            turn_over=request.turn_over,
            points=request.points,
        )
    if case is not None:
        announce_compilation("statics")
        with busy("design and scan at rest"):
            compared = compare_scan(scanned, case)
        scanned = compared.scan

    def show(folder: Path) -> ScanAnswer:
        words = Words(case=str(folder / "spring.toml"))
        return ScanAnswer(scanned, compared, words=words)

    answer = ScanAnswer(scanned, compared)
    saved = SavedRequest("scan", parse_case(answer.text, "scan"), line.output)
    data = _data(scanned, compared)
    failures = () if compared is None else compared.failures
    deliver(
        saved_result(
            saved, answer.text, data, show, answer.write, request.given, line.open_page, failures
        )
    )


register = command_of(ScanRequest, FolderLine, scan)


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
