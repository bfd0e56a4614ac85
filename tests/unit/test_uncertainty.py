"""Uncertainty: the convergence formulas on made-up series, a coarse job, the file that ships."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import load_case
from valvetrain.runs import stored_error_bars
from valvetrain.runs.api import simulate
from valvetrain.runs.error_bars import (
    DECLARED_ORDER,
    UncertaintyStudy,
    convergence,
    grid_convergence,
    observed_order,
)
from valvetrain.runs.refine import refined
from valvetrain.solution.definition import is_defined

RPM, DEG = 2 * np.pi / 60, np.pi / 180


def series(
    limit: float, factor: float, order: float, sizes: tuple[float, ...]
) -> tuple[float, ...]:
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
    """Celik et al. 2008, table 1, first column: phi 6.063, 5.972, 5.863 on r = 1.5, 1.333; p 1.53,
    extrapolated 6.1685, GCI 2.2 %.
    """
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


def meshed(name: str, elements_per_coil: int) -> Case:
    """A library case on another mesh."""
    case = load_case(name)
    return case.replace(
        springs=(
            case.springs[0].with_options("finite-element", elements_per_coil=elements_per_coil),
        )
    )


@pytest.fixture(scope="module")
def coarse() -> UncertaintyStudy:
    """Job T at 3000 rpm of the crank, where its coils do not meet, on 16, 24 and 36 elements per
    coil, one cycle.
    """
    case = meshed("job-t", 16)
    return refined(
        case.replace(operation=replace(case.operation, cycles=1)), (3000 * RPM,), workers=2
    )


def test_statics_modes_and_forces_of_a_smooth_spring_converge_at_second_order(coarse):
    """Without contact nothing disturbs the declared order; a case of one's own gets general names
    and no other.
    """
    rows = {row.quantity: row for row in coarse.rows}
    names = (
        "preload",
        "mode_1_frequency",
        "peak_spring_force",
        "raw_peak_spring_force",
        "peak_shear_stress",
    )
    for name in names:
        order = rows[name].observed_order
        assert order is not None and order == pytest.approx(2.0, abs=0.25), name
    assert "minimum_spring_force" in rows and coarse.elements_per_coil == (16, 24, 36)
    assert not any(name.startswith(("main_clash", "stage_")) for name in rows)
    assert all(is_defined(name) for name in rows)


@pytest.mark.long
def test_stated_uncertainty_covers_what_a_finer_mesh_changes(coarse):
    case = meshed("job-t", 64)
    study = simulate(
        case.replace(operation=replace(case.operation, cycles=1)),
        engine_speeds=(3000 * RPM,),
        models=("finite-element",),
    )
    fine = {key.name: value for key, value in study.quantities.items()}
    rows = {row.quantity: row for row in coarse.rows}
    for name in (
        "peak_spring_force",
        "raw_peak_spring_force",
        "mode_1_frequency",
    ):
        assert (
            0.5 * rows[name].numerical < abs(fine[name] - rows[name].value) <= rows[name].numerical
        ), name


def test_contact_constants_do_nothing_without_contact(coarse):
    for row in coarse.rows:
        assert row.contact_stiffness == pytest.approx((row.value, row.value), rel=1e-9)


@pytest.mark.long
def test_stiffer_contact_clashes_harder():
    """Raw height of the main clash of the beehive at 8000 rpm, coarse: rises with the contact
    stiffness, all else named alike.

    The case re-runs a published study, so the forces of that study's own table are headline numbers
    too.
    """
    told = []
    study = refined(
        meshed("gu2021-beehive-blind", 12),
        (8000 * RPM,),
        workers=2,
        progress=lambda share, words: told.append(share),
    )
    names = ("contact stiffness 1", "mesh 1", "contact stiffness 2")
    soft, own, stiff = (study.values[name][8000 * RPM]["main_clash_peak_force"] for name in names)
    assert soft < own < stiff
    rows = {row.quantity: row for row in study.rows}
    assert rows["main_clash_peak_force"].contact_stiffness == (soft, stiff)
    assert {
        "peak_spring_force",
        "stage_2_peak_force",
        "stage_3_below_5_khz_peak_force",
    } <= rows.keys()
    assert told == sorted(told) and told[-1] == 1.0


def test_shipped_file_belongs_to_its_case_and_to_no_other():
    case = load_case("gu2021-beehive-blind")
    rows = stored_error_bars.load_uncertainty(case.record())
    assert {"preload", "main_clash_peak_force", "peak_spring_force"} <= {
        row.quantity for row in rows
    }
    assert all(
        row.numerical >= 0 and row.contact_stiffness[0] <= row.value <= row.contact_stiffness[1]
        for row in rows
    )
    for other in (
        meshed("gu2021-beehive-blind", 30),
        case.replace(springs=(replace(case.springs[0], precompression=6.9e-3),)),
        case.replace(name="own-spring"),
    ):
        assert stored_error_bars.load_uncertainty(other.record()) == ()


def test_shipped_preload_and_mode_are_those_of_this_version():
    """Fails when rod or case have changed since scripts/write_uncertainty.py was run; run it again
    then.
    """
    from valvetrain.springs.finite_element import modal_result
    from valvetrain.springs.spec import spring_model

    case = load_case("gu2021-beehive-blind")
    rows = {row.quantity: row.value for row in stored_error_bars.load_uncertainty(case.record())}
    rod = spring_model("finite-element").build(case.springs[0])
    assert rod.installed.retainer_force == pytest.approx(rows["preload"], rel=1e-6)
    assert modal_result(rod).axial_frequencies[0] == pytest.approx(
        rows["mode_1_frequency"], rel=1e-6
    )


def test_a_case_without_a_lift_law_is_refused():
    with pytest.raises(InputError, match="lift_law"):
        refined(load_case("uniform-spring"))


@pytest.mark.parametrize(
    ("finer", "expected"),
    [
        ((10.2, 10.1), None),
        ((10.2, None), 3 * 0.2 * 1.5**2 / (1.5**2 - 1)),
        ((None, 10.1), 3 * 0.1 * 2.25**2 / (2.25**2 - 1)),
    ],
)
def test_a_missing_mesh_leaves_two_grids_of_their_own_ratio(finer, expected):
    """Roache's factor of three for two grids; with all three the same as the series of three."""
    found = convergence(10.0, finer, (1.0, 1.5, 2.25))
    if expected is None:
        assert found == grid_convergence((10.0, *finer), (1.0, 1 / 1.5, 1 / 2.25))
    else:
        assert found.uncertainty == pytest.approx(expected) and found.observed_order is None
    assert convergence(10.0, (None, None), (1.0, 1.5, 2.25)) is None
