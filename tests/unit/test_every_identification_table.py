"""Unit: every table of the page of an identification, cell by cell with its tone, beside made-up
numbers.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from valvetrain.explore.draws import Information
from valvetrain.explore.identification_page import identification_page
from valvetrain.explore.identified import (
    Branch,
    Conflict,
    Identified,
    Interval,
    Predicted,
    Prediction,
)
from valvetrain.explore.posterior import Datum, Unknown
from valvetrain.explore.space import Prior
from valvetrain.report.page import Grid

NUMBER = "number"
RATE = Unknown("rate", Prior("uniform", 25e3, 40e3, source="drawing"), "N/mm")
MASS = Unknown("spring_mass", Prior("lognormal", centre=0.05, spread=np.log(1.2)), "g")
LOAD = Datum("force_at_12_mm", 388.0, 4.0, "load", unit="N")
RINGING = Datum("surge", 430.0, 5.0, used=False, unit="Hz")
HEIGHT = Datum("height", 0.0521, 1e-4, unit="mm")
LOST = Datum("lost", 7e-3, 1e-3, unit="mm")


def branch(share: float, misfit: float, rate: float) -> Branch:
    information = Information(
        ("load", "height"), np.array([0.93, 0.08]), np.array([[0.61, 0.004], [0.39, 0.996]]), np.array([[0.52, 0.0], [0.17, 0.8]]),
        np.eye(2), (f"the data hardly determine the mass of {rate:.0f}",),
    )  # fmt: skip
    intervals = {
        "rate": Interval(rate, rate, 1e3, rate - 2e3, rate + 3e3),
        "spring_mass": Interval(0.051, 0.05, 2e-3, 0.047, 0.056),
    }
    return Branch(share, misfit, intervals, np.eye(2), information)


def identified(**changes: object) -> Identified:
    draws = np.array([[32e3, 0.051], [33e3, 0.049], [31e3, 0.052], [34e3, 0.05]])
    found = Identified(
        "nested",
        (RATE, MASS),
        (branch(0.75, 3.25, 32e3),),
        draws,
        np.full(4, 0.25),
        np.zeros(4, dtype=np.int64),
        (
            Predicted(LOAD, 384.0, 380.5, 385.0, 391.0, 99.1),
            Predicted(RINGING, 431.0, 420.0, 432.0, 444.0, 48.6),
            Predicted(HEIGHT, 0.0522, 0.0519, 0.0521, 0.0524, 2.4),
            Predicted(LOST, np.nan, np.nan, np.nan, np.nan, np.nan),
        ),
        (Prediction("peak_force", "N", 801.0, 790.0, 802.0, 815.5),),
        {
            "force_at_12_mm": draws[:, 0] * 0.012,
            "surge": draws[:, 1] * 8e3,
            "height": draws[:, 1],
            "lost": np.full(4, np.nan),
        },
        conflicts=(
            Conflict(LOAD, -3.1, 17, 4.25, ((HEIGHT, 2.2),)),
            Conflict(HEIGHT, 2.6, 0, np.nan, ()),
        ),
    )
    return replace(found, **changes)


def blocks(found: Identified, key: str) -> tuple:
    (section,) = (
        one for one in identification_page("Two unknowns", found).sections if one.key == key
    )
    return section.blocks


def grids(found: Identified, key: str) -> dict[str, Grid]:
    """Tables of a section by the first of their heads."""
    return {one.headers[0]: one for one in blocks(found, key) if isinstance(one, Grid)}


def read(grid: Grid) -> tuple[list[list[str]], list[list[str]]]:
    """Words and tones of the cells; there is a cell under every head."""
    assert all(len(row) == len(grid.headers) for row, _ in grid.rows)
    return [[cell.text for cell in row] for row, _ in grid.rows], [
        [cell.tone for cell in row] for row, _ in grid.rows
    ]


def test_measured_beside_predicted() -> None:
    """Red are percentiles beyond 2.5 and 97.5 only: a value that no draw computes has none."""
    grid = grids(identified(), "measured")["measurement"]
    assert grid.headers == (
        "measurement",
        "measured",
        "±",
        "computed",
        "2.5 %",
        "97.5 %",
        "",
        "percentile",
        "use",
    )
    words, tones = read(grid)
    assert words == [
        ["Load: force at 12 mm", "388", "4", "384", "380.5", "391", "N", "99.1", "fitted"],
        ["Surge", "430", "5", "431", "420", "444", "Hz", "48.6", "compared"],
        ["Height", "52.1", "0.1", "52.2", "51.9", "52.4", "mm", "2.4", "fitted"],
        ["Lost", "7", "1", "–", "–", "–", "mm", "–", "fitted"],
    ]
    usual = ["", NUMBER, "number quiet", NUMBER, NUMBER, NUMBER, ""]
    assert tones == [[*usual, last, "tag"] for last in ("number bad", NUMBER, "number bad", NUMBER)]
    assert grid.filters == ("use",) and [row[1] for row in grid.rows] == [
        ("fitted",),
        ("compared",),
        ("fitted",),
        ("fitted",),
    ]
