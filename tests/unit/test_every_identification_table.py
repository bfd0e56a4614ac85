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
from valvetrain.report.page import Details, Grid, Text

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


def test_what_was_found() -> None:
    (grid,) = grids(identified(), "found").values()
    assert grid.headers == (
        "quantity",
        "likeliest",
        "2.5 %",
        "97.5 %",
        "",
        "prior",
        "learned from data",
    )
    words, tones = read(grid)
    assert words == [
        ["Rate", "32", "30", "35", "N/mm", "25 to 40", "93 %"],
        ["Spring mass", "51", "47", "56", "g", "50 × 1.2", "8 %"],
    ]
    assert tones == [["", NUMBER, NUMBER, NUMBER, "", "quiet", NUMBER]] * 2


def test_branches_a_search_cut_short_and_warnings_stand_by_what_was_found() -> None:
    def said(found: Identified) -> list[tuple[str, str]]:
        return [(one.html, one.tone) for one in blocks(found, "found") if isinstance(one, Text)]

    alert = ("The data hardly determine the mass of 32000.", "alert")
    assert said(identified()) == [alert]
    assert said(identified(whole=False)) == [
        ("The search was stopped before its end; this is what it had.", "alert"),
        alert,
    ]
    two = identified(branches=(branch(0.75, 3.25, 32e3), branch(0.25, 5.5, 37e3)))
    assert said(two) == [
        ("Branch 1: probability 0.750, misfit 3.25.", ""),
        ("Branch 2: probability 0.250, misfit 5.5.", ""),
        alert,
        ("The data hardly determine the mass of 37000.", "alert"),
    ]
    tables = [read(one)[0][0][1] for one in blocks(two, "found") if isinstance(one, Grid)]
    assert tables == ["32", "37"]
    first, second, folded = blocks(two, "told")
    assert isinstance(first, Grid) and isinstance(second, Grid)
    assert isinstance(folded, Details) and folded.summary == "branch 2" and len(folded.blocks) == 2


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


def test_the_sentence_on_what_lies_far_off_names_it() -> None:
    def said(found: Identified) -> list[str]:
        return [
            one.html
            for one in blocks(found, "measured")
            if isinstance(one, Text) and one.tone == "alert"
        ]

    assert said(identified()) == [
        "Outside 2.5 to 97.5 % of their predictions: Load: force at 12 mm (99.1), Height (2.4)."
    ]
    many = tuple(
        Predicted(Datum(f"load_{place}", 1.0, 1.0), 2.0, 2.0, 2.0, 2.0, 0.1) for place in range(9)
    )
    names = ", ".join(f"Load {place} (0.1)" for place in range(8))
    computed = {one.datum.key: np.ones(4) for one in many}
    assert said(identified(predicted=many, computed=computed)) == [
        f"Outside 2.5 to 97.5 % of their predictions: {names} and more."
    ]
    assert said(identified(predicted=identified().predicted[1:2] * 2)) == []


def test_conflicts_and_predictions() -> None:
    found = grids(identified(), "measured")
    words, tones = read(found["missed"])
    assert found["missed"].headers == ("missed", "scatters", "met by", "cost", "missed instead")
    assert words == [
        ["Load: force at 12 mm", "-3.1", "17 points", "4.25", "Height (+2.2)"],
        ["Height", "+2.6", "0 points", "–", "–"],
    ]
    assert tones == [["", "number bad", NUMBER, NUMBER, ""]] * 2
    words, tones = read(found["not measured"])
    assert found["not measured"].headers == (
        "not measured",
        "likeliest",
        "2.5 %",
        "50 %",
        "97.5 %",
        "",
    )
    assert words == [["Peak force", "801", "790", "802", "815.5", "N"]] and tones == [
        ["", *[NUMBER] * 4, ""]
    ]
    bare = grids(identified(conflicts=(), predictions=()), "measured")
    assert list(bare) == ["measurement"]


def test_what_each_measurement_contributes_and_what_was_known_before() -> None:
    brought, lost = (one for one in blocks(identified(), "told") if isinstance(one, Grid))
    assert brought.headers == lost.headers == ("measurement", "rate", "spring mass")
    assert (
        "Share of each measurement" in brought.caption and "without the measurement" in lost.caption
    )
    assert read(brought) == (
        [["Load", "61", "·"], ["Height", "39", "100"]],
        [["", NUMBER, NUMBER]] * 2,
    )
    assert read(lost) == ([["Load", "52", "·"], ["Height", "17", "80"]], [["", NUMBER, NUMBER]] * 2)
    (priors,) = (one for one in blocks(identified(), "priors") if isinstance(one, Grid))
    words, tones = read(priors)
    assert priors.headers == ("quantity", "prior", "", "", "source")
    assert words == [
        ["rate", "uniform", "25 to 40", "N/mm", "drawing"],
        ["spring mass", "lognormal", "50 × 1.2", "g", ""],
    ]
    assert tones == [["", "", "", "", "quiet"]] * 2
