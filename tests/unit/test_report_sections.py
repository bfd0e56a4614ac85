"""Every figure of the page carries the series, unit and sign that it names: distinct known numbers
are drawn and read back.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synthetic_study import (
    EVENT,
    at_rest,
    modal_run,
    own_study,
    published_study,
    rod_run,
    sweep_study,
)
from valvetrain.registry import find
from valvetrain.report.chart import Chart, Line, Marks
from valvetrain.report.headlines import headline_rows
from valvetrain.report.page import Grid, charts
from valvetrain.report.sections import sweep
from valvetrain.report.study import study_page
from valvetrain.solution.study import Study

DEGREES = np.arange(720) / 2
LIFT = 9e-3 * np.where(np.abs(DEGREES - 180) < 53, np.cos(np.pi * (DEGREES - 180) / 106) ** 2, 0.0)


def drawn(study: Study) -> dict[str, Chart]:
    return {chart.key: chart for chart in charts(study_page(study))}


def lines(chart: Chart, panel: int = 0) -> dict[str, Line]:
    return {layer.name: layer for layer in chart.panels[panel].layers if isinstance(layer, Line)}


@pytest.fixture(scope="module")
def own() -> dict[str, Chart]:
    return drawn(own_study())


@pytest.mark.parametrize(
    ("key", "channel", "words"),
    [
        ("force-seat", "seat_force", "cylinder head"),
        ("force-retainer", "retainer_force", "retainer"),
    ],
)
def test_spring_force_by_speed_and_model_with_rest_dashed(own, key, channel, words):
    chart = own[key]
    assert [panel.title for panel in chart.panels] == ["4200 rpm", "5600 rpm"]
    assert all(
        panel.y_label == f"force on the {words} (N)" and "cam degrees" in panel.x_label
        for panel in chart.panels
    )
    mine = lines(chart, 1)
    np.testing.assert_array_equal(mine["finite-element rod"].y, rod_run().channel(channel)[-720:])
    np.testing.assert_array_equal(
        mine["modal model with varied stiffness"].y, modal_run().channel(channel)[-720:]
    )
    still = mine["at rest, same lift"]
    assert still.dash == "dash"
    np.testing.assert_allclose(still.y, 300 + 40e3 * LIFT, atol=1e-6)
    band = chart.panels[0].bands[0]
    assert (band.first, band.last) == pytest.approx(tuple(np.degrees((EVENT.start, EVENT.end))))


def test_static_curves_by_model_with_their_marks(own):
    chart, curve = own["static-1"], at_rest()[0].curve
    force, stiffness, apart = (lines(chart, place) for place in range(3))
    np.testing.assert_array_equal(force["finite-element rod"].y, curve.force)
    np.testing.assert_allclose(force["multi-mass chain"].x, 1e3 * curve.compression)
    np.testing.assert_allclose(stiffness["finite-element rod"].y, 41.0)
    np.testing.assert_allclose(apart["multi-mass chain"].y[1:], -2.0)
    rules = {rule.label: rule.value for rule in chart.panels[0].rules}
    assert rules == pytest.approx({"installed": 7.0, "full lift": 16.0, "solid": 17.25})


def test_modes_and_frequencies_side_by_side(own):
    chart = own["modes-1"]
    shape = at_rest()[0].modes.shape[2, :, 2]
    np.testing.assert_allclose(lines(chart)["mode 2"].y, shape / shape[np.argmax(np.abs(shape))])
    axial = next(layer for layer in chart.panels[1].layers if layer.name == "axial mode")
    np.testing.assert_array_equal(axial.x, [631, 1120, 1639])
    grid = next(
        block
        for block in find("sections", "at-rest").blocks(own_study())
        if isinstance(block, Grid)
    )
    assert [cell.text for cell in grid.rows[0][0]] == ["1", "631", "620", "−1.7"]


def test_stress_along_the_wire_and_over_the_cycle(own):
    chart, shear = (
        own["stress-2-1-spring"],
        1e-6 * rod_run().channel("inner_fibre_shear_stress")[-720:],
    )
    np.testing.assert_allclose(lines(chart)["largest"].y, shear.max(axis=0))
    np.testing.assert_allclose(lines(chart)["minimum"].y, shear.min(axis=0))
    np.testing.assert_allclose(lines(chart, 1)["largest"].y, shear[:, 7])
    np.testing.assert_allclose(
        lines(chart, 1)["static curve at the same lift"].y, 41e3 * (7e-3 + LIFT), rtol=1e-6
    )


def test_energy_balance_is_millijoules_and_signed(own):
    run, chart = rod_run(), own["energy-2-1"]
    np.testing.assert_allclose(
        lines(chart)["work done"].y[[0, -1]],
        1e3 * (run.channel("work_done")[[0, -1]] - run.channel("work_done")[0]),
    )
    missing = chart.panels[1].layers[0]
    expected = 1e3 * (run.channel("elastic_energy") - run.channel("work_done"))
    assert missing.y.min() == pytest.approx((expected - expected[0]).min()) and missing.y.min() < 0


def test_sweep_curves_and_order_map():
    study = sweep_study()
    shown = drawn(study)
    panels = {panel.y_label: panel for panel in shown["sweep-2"].panels}
    speeds, values = study.series("stock", "clash_energy")
    line = next(layer for layer in panels["clash energy (mJ)"].layers if layer.name == "stock")
    np.testing.assert_allclose(line.x, speeds * 30 / np.pi, atol=1e-6)
    np.testing.assert_allclose(line.y, 1e3 * values)
    restless = [layer for layer in panels["clash energy (mJ)"].layers if isinstance(layer, Marks)]
    assert [layer.x.tolist() for layer in restless] == [[8000.0], [8000.0]]
    heat = shown["order-map-1"].panels[0].layers[0]
    speeds, _, sizes = sweep.order_table(study, "stock")
    np.testing.assert_array_equal(heat.z, sizes)
    np.testing.assert_allclose(heat.second[7], 8 * speeds / (4 * np.pi))
    surge = next(layer for layer in shown["order-map-1"].panels[0].layers if layer.name == "surge")
    np.testing.assert_allclose(surge.y * surge.x / 120, 560.0)
    assert any(layer.name.endswith(" Hz") for layer in shown["order-map-1"].panels[0].layers)


def test_lines_of_equal_frequency_at_a_top_of_just_below_a_power_of_ten():
    """A quarter of it is 999.9999999999999 Hz, whose logarithm rounds to 3: no figure was drawn."""
    assert sweep._round_steps(np.nextafter(4000.0, 0.0)) == [1000.0, 2000.0, 3000.0]


def test_a_sweep_answers_with_the_worst_value_and_its_speed():
    rows = {row.name: row for row in headline_rows(sweep_study())}
    assert rows["peak_spring_force"].values[0] == pytest.approx(740.0)
    least = rows["minimum_spring_force"]
    assert least.values[0] == pytest.approx(217.0) and least.beyond.values[0] == pytest.approx(
        181.0
    )
    assert least.beyond.engine_speeds[0] * 30 / np.pi == pytest.approx(8000)
    assert rows["surge_frequency"].engine_speeds == (None, None) and rows[
        "float_engine_speed"
    ].values[0] == pytest.approx(701 * 30 / np.pi)


def test_figures_of_a_source_are_drawn_for_its_case_only():
    source = find("sections", "source-readings")
    assert source.blocks(own_study()) == ()
    assert source.blocks(replace(published_study(), comparisons=(), findings=())) == ()
    shown = drawn(published_study())
    assert {"source-2-force", "source-2-spikes", "source-2-points-1"} <= set(shown)
    marks = [
        layer for layer in shown["source-2-force"].panels[0].layers if isinstance(layer, Marks)
    ]
    assert [(layer.x.tolist(), layer.y.tolist()) for layer in marks] == [
        ([pytest.approx(np.degrees(3.1))], [790.0])
    ]
    assert [band.label for band in shown["source-2-force"].panels[0].bands] == [
        "Stage I",
        "Stage II",
        "Stage III",
    ]
    spikes = lines(shown["source-2-spikes"])["finite-element rod"]
    assert spikes.x[[0, -1]] == pytest.approx([225, 320], abs=0.6) and len(spikes.x) > 4 * 180


def test_what_is_nothing_but_rounding_is_shown_as_nil():
    study = own_study()
    runs = tuple(
        replace(run, quantities={**run.quantities, "surge_amplitude_force": 4e-15})
        for run in study.solutions
    )
    row = next(
        row
        for row in headline_rows(replace(study, solutions=runs))
        if row.name == "surge_amplitude_force"
    )
    assert set(row.values) == {0.0}
