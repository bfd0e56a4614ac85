"""Every table of every page says the number, unit and sign that it names: made-up numbers are read
back cell by cell.
"""

from __future__ import annotations

import numpy as np

from numbered_studies import STUDIES
from synthetic_study import (
    own_study,
)
from valvetrain.registry import find
from valvetrain.report.page import Grid
from valvetrain.solution.comparison import Comparison
from valvetrain.solution.study import Study

RPM = np.pi / 30
NAMES = ("finite-element rod", "modal model with varied stiffness")


def four(value: float | None) -> str:
    """Four significant digits, no zeros at the end, a real minus; a dash for nothing."""
    if value is None:
        return "–"
    text = f"{value:.4g}"
    return (text.rstrip("0").rstrip(".") if "." in text else text).replace("-", "−")


def blocks(section: str, study: Study) -> tuple:
    return find("sections", section).blocks(study)


def cells(grid: Grid) -> list[list[str]]:
    return [[cell.text for cell in row] for row, _ in grid.rows]


def the(kind: type, found: tuple):
    (one,) = (block for block in found if isinstance(block, kind))
    return one


def test_frequencies_and_their_differences_in_percent():
    grid = the(Grid, blocks("at-rest", own_study()))
    assert grid.headers == (
        "axial mode",
        f"{NAMES[0]} (Hz)",
        "multi-mass chain (Hz)",
        "difference (%)",
    )
    assert cells(grid) == [
        ["1", "631", "620", "−1.7"],
        ["2", "1120", "1210", "8"],
        ["3", "1639", "–", "–"],
    ]


def test_stresses_in_megapascal_by_run():
    study = STUDIES["own"]()
    grid = the(Grid, blocks("stress", study))
    assert grid.headers[:2] == ("", "unit") and grid.headers[2:] == tuple(
        f"{name}, {speed} rpm" for name in NAMES for speed in (4200, 5600)
    )
    for row, name in zip(
        cells(grid),
        (
            "peak_shear_stress",
            "minimum_shear_stress",
            "open_nominal_shear_stress",
            "closed_nominal_shear_stress",
        ),
        strict=True,
    ):
        values = [run.quantities.get(name) for run in study.solutions]
        assert row[1:] == [
            "MPa",
            *(four(None if value is None else value * 1e-6) for value in values),
        ], name


def row(
    quantity: str, unit: str, given: float, computed: float | None, verdict: str, **more
) -> Comparison:
    difference = None if computed is None else computed - given
    known = {
        "engine_speed": 5600 * RPM,
        "model": "finite-element",
        "origin": "engine head test",
        "role": "prediction",
        "tolerance": None,
    }
    return Comparison(
        quantity=quantity,
        unit=unit,
        published=given,
        computed=computed,
        difference=difference,
        verdict=verdict,
        **(known | more),
    )


COMPARED = (
    row("stage_2_peak_force", "N", 790.0, 805.0, "within tolerance", tolerance=24.0, source="table 3"),
    row("coil_1_2_installed_gap", "mm", 2e-3, 1.5e-3, "misses by -25.0 %, tolerance 3.0 %", engine_speed=None, role="calibration",
        used_for="the pitch"),
    row("stage_2_peak_cam_angle", "deg", np.radians(170), np.radians(171.5), "differs by +1.5 deg", model="modal-varied",
        origin="solid finite elements"),
    row("preload", "N", 280.0, None, "not computed", engine_speed=None, model=""),
    row("largest_clash_impulse", "mN s", 0.031, 0.031, "differs by +0.0 %", engine_speed=4200 * RPM),
)  # fmt: skip
