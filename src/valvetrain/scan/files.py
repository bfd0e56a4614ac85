"""The files of a scanned spring: its case file and its curves."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from valvetrain.scan.answer import ScanAnswer
from valvetrain.scan.compare import ScanComparison
from valvetrain.scan.result import ScannedSpring
from valvetrain.solution.atomic import write_text
from valvetrain.views.results import report_answer
from valvetrain.views.study_files import StudyFiles

#: Headings of the table of curves.
HEADINGS = (
    "coil", "mean diameter [mm]", "standard deviation of mean diameter [mm]", "height [mm]", "standard deviation of height [mm]",
    "pitch [mm]", "standard deviation of pitch [mm]", "x [mm]", "y [mm]", "z [mm]",
)  # fmt: skip


def write_scan(answer: ScanAnswer, folder: Path) -> list[Path]:
    """``spring.toml``, and ``curves.csv``: curves over the coil with standard deviations and the
    wire axis in the frame of the file.
    """
    curves = answer.scan.curves
    columns = np.column_stack([
        curves.coil, 1e3 * curves.mean_diameter, 1e3 * curves.mean_diameter_spread, 1e3 * curves.height, 1e3 * curves.height_spread,
        1e3 * curves.pitch, 1e3 * curves.pitch_spread, 1e3 * curves.centre_line,
    ])  # fmt: skip
    lines = [",".join(HEADINGS), *(",".join(f"{value:.7g}" for value in row) for row in columns)]
    return [
        write_text(folder / "spring.toml", answer.text),
        write_text(folder / "curves.csv", "\n".join(lines) + "\n"),
    ]


def report_scan(
    scan: ScannedSpring, folder: Path, compared: ScanComparison | None = None
) -> StudyFiles:
    """The page of a scan and the files of :func:`write_scan`."""
    answer = ScanAnswer(scan, compared)
    return report_answer(answer, folder, write_scan(answer, folder))
