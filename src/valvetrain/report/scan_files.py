"""Files of a scanned spring: wire axis and curves as a table, the spring as the block of a case."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from valvetrain.measurements.spring_scan.result import ScannedSpring
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.report.spring_files import spring_text
from valvetrain.solution.atomic import write_text

#: Headings of the table of curves.
HEADINGS = (
    "coil", "mean diameter [mm]", "standard deviation of mean diameter [mm]", "height [mm]", "standard deviation of height [mm]",
    "pitch [mm]", "standard deviation of pitch [mm]", "x [mm]", "y [mm]", "z [mm]",
)  # fmt: skip


def scan_text(scan: ScannedSpring, installed: InstalledSpring | None = None) -> str:
    """A case that holds nothing but the scanned spring, as ``installed`` or free."""
    return spring_text("scan", installed or InstalledSpring(wire=scan.definition), "from a scan")


def write_scan(scan: ScannedSpring, folder: Path, text: str) -> list[Path]:
    """``spring.toml``, and ``curves.csv``: curves over the coil with standard deviations and the wire axis in the frame of the file."""
    curves = scan.curves
    columns = np.column_stack([
        curves.coil, 1e3 * curves.mean_diameter, 1e3 * curves.mean_diameter_spread, 1e3 * curves.height, 1e3 * curves.height_spread,
        1e3 * curves.pitch, 1e3 * curves.pitch_spread, 1e3 * curves.centre_line,
    ])  # fmt: skip
    lines = [",".join(HEADINGS), *(",".join(f"{value:.7g}" for value in row) for row in columns)]
    return [write_text(folder / "spring.toml", text), write_text(folder / "curves.csv", "\n".join(lines) + "\n")]
