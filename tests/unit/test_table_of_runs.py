"""Unit: how it was computed: a row for each run and each spring at rest, on the page of a study."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synthetic_study import at_rest, own_study, rod_run
from valvetrain.registry import find
from valvetrain.report.page import Grid, Text
from valvetrain.solution.provenance import CaseRecord, Provenance
from valvetrain.solution.status import Status
from valvetrain.solution.study import Study

DIVERGED = Status("diverged", "the step is too long", 0.1)
OPTIONS = {
    "elements_per_coil": 24,
    "mass_damping": 12.5,
    "output_step": np.pi / 180,
    "seats": "planes",
    "friction": True,
    "none": None,
}


def blocks(study: Study) -> tuple:
    return find("sections", "runs").blocks(study)


def cells(grid: Grid) -> list[list[tuple[str, str]]]:
    return [[(cell.text, cell.tone) for cell in row] for row, _ in grid.rows]


def study(**changes: object) -> Study:
    """A run that ended, one that did not, and one spring at rest by two models."""
    made = Provenance(
        "own",
        "finite-element",
        5600 * np.pi / 30,
        "c0ffee",
        "1.2",
        "3.11.1",
        {"numpy": "2.0", "numba": ""},
        OPTIONS,
        "2026-01-02",
    )
    whole = replace(rod_run(), provenance=made, statistics={"peak_spring_force": 811.0})
    cut = replace(whole, status=DIVERGED, provenance=replace(made, options={}), statistics={})
    return replace(own_study((whole, cut)), record=CaseRecord("own"), **changes)


def test_every_run_and_every_spring_at_rest_has_its_row():
    grid, versions = blocks(study())
    assert isinstance(grid, Grid) and grid.headers == (
        "run",
        "engine speed",
        "ended",
        "options and statistics",
    )
    options = "elements per coil 24, mass damping 12.5 1/s, output step 1 deg, seats planes, friction true, peak spring force 811 N"
    assert cells(grid) == [
        [
            ("finite-element rod", ""),
            ("5600 rpm", "number"),
            ("completed", "good"),
            (options, "quiet long"),
        ],
        [
            ("finite-element rod", ""),
            ("5600 rpm", "number"),
            (DIVERGED.sentence(), "bad"),
            ("", "quiet long"),
        ],
        [
            ("finite-element rod", ""),
            ("at rest, spring", "number"),
            ("completed", "good"),
            ("elements per coil 24, wall time (s) 0.4", "quiet long"),
        ],
        [
            ("multi-mass chain", ""),
            ("at rest, spring", "number"),
            ("completed", "good"),
            ("", "quiet long"),
        ],
    ]
    assert isinstance(versions, Text) and versions.tone == "quiet"
    assert (
        versions.html
        == "Versions: valvetrain 1.2, Python 3.11.1, numpy 2.0. Case digest c0ffee. Computed 2026-01-02."
    )


@pytest.mark.parametrize("place", ["curve", "modes"])
def test_a_spring_at_rest_that_did_not_end_says_so(place):
    first, second = at_rest()
    broken = replace(first, **{place: replace(getattr(first, place), status=DIVERGED)})
    grid, _ = blocks(study(rest=(broken, second)))
    assert [row[2] for row in cells(grid)[2:]] == [
        (DIVERGED.sentence(), "bad"),
        ("completed", "good"),
    ]
    grid, _ = blocks(study(rest=(replace(first, curve=None, modes=None),)))
    assert cells(grid)[2][2] == ("", "good")
