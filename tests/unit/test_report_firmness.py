"""Sections of the spring page on wire stress and on uncertainty: tables equal what was computed, and vanish where nothing was."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from valvetrain.quantities.study import SpringStudy
from valvetrain.studies.spring_study import run_spring_study

from synthetic_study import study as synthetic
from valvetrain.parameters.loading import load_case
from valvetrain.report.figures import stress
from valvetrain.report.page import Figure, Grid
from valvetrain.report.stress_section import stress_blocks
from valvetrain.report.uncertainty_section import uncertainty_blocks, uncertainty_table
from valvetrain.solution.quantity import Quantity
from valvetrain.studies.uncertainty_file import load_uncertainty

SPEED = 8000 * 2 * np.pi / 60


@pytest.fixture(scope="module")
def study() -> SpringStudy:
    case = load_case("gu2021-beehive")
    return run_spring_study(case.replace(rod=replace(case.rod, elements_per_coil=12)), engine_speeds=(SPEED,), models=("finite-element",))


def test_stress_figure_shows_the_named_quantities(study):
    along, over = stress.wire_table(study, study.solutions[0]), stress.worst_table(study, study.solutions[0])
    assert along is not None and over is not None
    data, coil = over

    def named(name: str) -> float:
        return study.quantities[Quantity(name, SPEED, "finite-element")]

    assert 1e6 * along["largest"].max() == pytest.approx(named("peak_shear_stress"))
    assert 1e6 * data["shear"].max() == pytest.approx(named("peak_shear_stress"))
    assert coil == named("peak_shear_stress_coil_number")
    assert 1e6 * along["quasi-static"].max() == pytest.approx(named("quasi_static_peak_shear_stress"))
    kinds = [type(block) for block in stress_blocks(study)]
    assert Grid in kinds and Figure in kinds


def test_no_section_without_section_loads():
    assert stress_blocks(synthetic()) == ()


def test_uncertainty_of_another_mesh_is_not_printed(study):
    """12 elements per coil are not the 24 that were refined."""
    assert uncertainty_blocks(study) == ()


def test_uncertainty_stands_beside_the_values_it_belongs_to():
    case = load_case("gu2021-beehive")
    rows = load_uncertainty(case)
    own = {Quantity(row.quantity, row.engine_speed, "" if row.engine_speed is None else "finite-element"): row.value for row in rows}
    grid = uncertainty_blocks(SpringStudy(case, quantities=own))[1]
    assert isinstance(grid, Grid)
    assert sum(len(cells) > 1 for cells, _ in grid.rows) == len(rows)
    wrong = {key: 2 * value for key, value in own.items()}
    assert uncertainty_blocks(SpringStudy(case, quantities=wrong)) == ()
    assert uncertainty_table(rows)["value"].tolist() == [row.value for row in rows]
