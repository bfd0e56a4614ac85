"""Uncertainty: the convergence formulas on made-up series, a coarse job, the file that ships."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from valvetrain.studies.spring_runs import run_finite_element

from valvetrain.cam.build import build_lift_law
from valvetrain.cam.event import find_lift_event
from valvetrain.errors import InputError
from valvetrain.parameters.loading import load_case
from valvetrain.quantities.evaluate import evaluate
from valvetrain.quantities.frame import Frame
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.quantity import Quantity
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.studies import uncertainty_file
from valvetrain.studies.grid_convergence import DECLARED_ORDER, grid_convergence, observed_order
from valvetrain.studies.uncertainty import UncertaintyStudy, uncertainty_study

RPM = 2 * np.pi / 60


def series(limit: float, factor: float, order: float, sizes: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(limit + factor * size**order for size in sizes)


@pytest.mark.parametrize("order", [0.8, 1.0, 2.0, 3.7])
@pytest.mark.parametrize("sizes", [(2.25, 1.5, 1.0), (4.0, 1.5, 1.0), (1 / 16, 1 / 24, 1 / 36)])
def test_order_of_a_made_up_series_is_recovered(order, sizes):
    assert observed_order(series(10.0, 0.3, order, sizes), sizes) == pytest.approx(order, rel=1e-6)


@pytest.mark.parametrize("order", [0.8, 2.0])
def test_limit_and_error_of_a_made_up_series(order):
    sizes = (2.25, 1.5, 1.0)
    found = grid_convergence(series(10.0, 0.3, order, sizes), sizes)
    assert found.trusted and found.extrapolated == pytest.approx(10.0)
    assert found.uncertainty == pytest.approx(1.25 * 0.3 * 2.25**order)
    assert found.finest_index == pytest.approx(1.25 * 0.3)


def test_index_of_the_worked_example_of_celik():
    """Celik et al. 2008, table 1, first column: phi 6.063, 5.972, 5.863 on r = 1.5, 1.333; p 1.53, extrapolated 6.1685, GCI 2.2 %."""
    found = grid_convergence((5.863, 5.972, 6.063), (2.0, 1.5, 1.0))
    assert found.observed_order == pytest.approx(1.53, abs=0.01)
    assert found.extrapolated == pytest.approx(6.1685, abs=0.001)
    assert found.finest_index / 6.063 == pytest.approx(0.022, abs=0.0005)


def test_a_series_that_swings_gets_a_wide_bound():
    found = grid_convergence((1.0, 1.2, 1.1), (2.25, 1.5, 1.0))
    assert found.observed_order is None and not found.trusted
    assert found.extrapolated == 1.1 and found.uncertainty == pytest.approx(3 * 0.2 / 1.25)


def test_faster_than_declared_counts_as_declared():
    sizes = (2.25, 1.5, 1.0)
    found = grid_convergence(series(10.0, 0.3, 4.0, sizes), sizes)
    assert found.observed_order == pytest.approx(4.0) and DECLARED_ORDER < 4.0
    assert found.uncertainty > 1.25 * 0.3 * 2.25**4


def test_meshes_out_of_order_are_refused():
    with pytest.raises(InputError, match="coarse to fine"):
        grid_convergence((1.0, 2.0, 3.0), (1.0, 1.5, 2.25))


@pytest.fixture(scope="module")
def coarse() -> UncertaintyStudy:
    """Job T at 3000 rpm of the crank, where its coils do not meet, on 16, 24 and 36 elements per coil, one cycle."""
    case = load_case("job-t")
    small = case.replace(rod=replace(case.rod, elements_per_coil=16), operation=replace(case.operation, cycles=1))
    return uncertainty_study(small, engine_speeds=(3000 * RPM,), workers=2)


def test_statics_and_modes_of_a_smooth_spring_converge_at_second_order(coarse):
    """Statics, mode and forces of the transient; without contact nothing disturbs the declared order."""
    rows = {row.quantity: row for row in coarse.rows}
    for name in ("preload", "mode_1_frequency", "stage_2_peak_force", "stage_3_peak_force", "peak_shear_stress"):
        order = rows[name].observed_order
        assert order is not None and order == pytest.approx(2.0, abs=0.25), name
    assert "main_clash_peak_force" not in rows


def test_stated_uncertainty_covers_what_a_finer_mesh_changes(coarse):
    case = coarse.case
    model = FiniteElementRod.from_case(case, elements_per_coil=64)
    run = run_finite_element(case, model, 3000 * RPM, Provenance("job-t", model.name, engine_speed=3000 * RPM))
    frame = Frame(lift_event=find_lift_event(build_lift_law(case.lift_law), case.lift_law), source="gu2021")
    fine = {**evaluate(run, frame).quantities, "preload": model.installed.retainer_force}
    rows = {row.quantity: row for row in coarse.rows}
    for name in ("preload", "stage_2_peak_force", "stage_3_peak_force", "stage_3_below_10_khz_peak_force"):
        assert 0.5 * rows[name].numerical < abs(fine[name] - rows[name].value) <= rows[name].numerical, name


def test_contact_constants_do_nothing_without_contact(coarse):
    for row in coarse.rows:
        # Contact stiffness enters the stable step, and so the error of the step, without a touch.
        assert row.contact_stiffness == pytest.approx((row.value, row.value), rel=1e-6)
        assert row.contact_damping == pytest.approx((row.value, row.value), rel=1e-9)


def test_stiffer_contact_clashes_harder():
    """Raw height of the main clash of the beehive at 8000 rpm, coarse: rises with the contact stiffness, all else named alike."""
    case = load_case("gu2021-beehive")
    small = case.replace(rod=replace(case.rod, elements_per_coil=12))
    study = uncertainty_study(small, engine_speeds=(8000 * RPM,), workers=2)
    names = ("contact stiffness 1", "mesh 1", "contact stiffness 2")
    soft, own, stiff = (study.values[name][8000 * RPM]["main_clash_peak_force"] for name in names)
    assert soft < own < stiff
    row = next(row for row in study.rows if row.quantity == "main_clash_peak_force")
    assert row.contact_stiffness == (soft, stiff)


def test_shipped_file_belongs_to_its_case_and_to_no_other():
    case = load_case("gu2021-beehive")
    rows = uncertainty_file.load_uncertainty(case)
    assert {"preload", "main_clash_below_10_khz_peak_force"} <= {row.quantity for row in rows}
    assert all(row.numerical >= 0 and row.contact_stiffness[0] <= row.value <= row.contact_stiffness[1] for row in rows)
    assert uncertainty_file.load_uncertainty(case.replace(rod=replace(case.rod, elements_per_coil=30))) == ()
    assert uncertainty_file.load_uncertainty(case.replace(installation=replace(case.installation, precompression=6.9e-3))) == ()
    sentences = uncertainty_file.uncertainty_sentences(rows, uncertainty_file.meshes_of(case))
    assert len(sentences) == 3 and all("main clash" in sentence for sentence in sentences)


def test_file_says_what_the_study_says(coarse):
    import tomllib

    content = tomllib.loads(uncertainty_file.uncertainty_text(coarse))
    rows = [uncertainty_file._row(name, label, numbers) for label, table in content.items() if label not in ("refined", "meshes")
            for name, numbers in table.items()]  # fmt: skip
    assert [row.quantity for row in rows] == [row.quantity for row in coarse.rows]
    for read, made in zip(rows, coarse.rows, strict=True):
        assert read.value == pytest.approx(made.value, rel=1e-6) and read.numerical == pytest.approx(made.numerical, rel=1e-6)
        assert (read.observed_order is None) == (made.observed_order is None)
        assert Quantity(read.quantity).unit != "1" or read.quantity.endswith("number")


@pytest.mark.parametrize(("case", "message"), [("uniform-spring", "lift_law")])
def test_a_case_without_lift_is_refused(case, message):
    with pytest.raises(InputError, match=message):
        uncertainty_study(load_case(case))
