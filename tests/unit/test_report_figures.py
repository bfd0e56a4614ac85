"""Figures show the numbers of their tables, in both renderers, and say what their axes are."""

from __future__ import annotations

import re
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest

from synthetic_study import SPEED, study
from valvetrain.errors import InputError
from valvetrain.report.chart import Chart, HeatMap, Line, Marks, Panel, Rule, rule_levels, thin, visible_range
from valvetrain.report.figures import coils, energy, force, lift, modes, nodes, statics
from valvetrain.report.page import charts
from valvetrain.report.plotly_chart import figure, packed, to_json, unpacked
from valvetrain.report.spring_page import spring_page
from valvetrain.report.svg_chart import png, svg, ticks
from valvetrain.report.table import quoted, table

SVG = "{http://www.w3.org/2000/svg}"


def _chart(*layers, **more) -> Chart:
    return Chart("key", "title", "caption", (Panel("x (mm)", "y (N)", layers, **more),))


def _lines(chart: Chart) -> dict[str, Line]:
    return {layer.name: layer for panel in chart.panels for layer in panel.layers if isinstance(layer, Line)}


@pytest.fixture(scope="module")
def whole():
    return study()


def test_force_figure_shows_its_table(whole):
    data, published = force.force_table(whole, SPEED), force.published_forces(whole, SPEED)
    chart = force.force_chart(whole, data, SPEED)
    for model, name in (("finite-element", "finite-element rod"), ("modal-varied", "modal model with varied stiffness")):
        mine = data["run"] == model
        np.testing.assert_array_equal(_lines(chart)[name].x, data["cam angle"][mine])
        np.testing.assert_array_equal(_lines(chart)[name].y, data["force"][mine])
    marks = [layer for layer in chart.panels[0].layers if isinstance(layer, Marks)]
    marked = sorted(pair for layer in marks for pair in zip(layer.x.tolist(), layer.y.tolist(), strict=True))
    assert marked == sorted(zip(published["cam angle"].tolist(), published["force"].tolist(), strict=True))


def test_force_table_is_the_reported_cycle(whole):
    data = force.force_table(whole, SPEED)
    run = next(run for run in whole.solutions if run.model == "modal-varied")
    np.testing.assert_array_equal(data["force"][data["run"] == "modal-varied"], run.channel("seat_force")[-720:])


def test_published_force_without_angle_borrows_one_and_says_whose(whole):
    rows = {(origin, quantity): (angle, whose) for origin, quantity, angle, _, whose in force.published_forces(whole, SPEED).rows()}
    angle, whose = rows["analytical modal", "stage_3_peak_force"]
    assert (pytest.approx(240.0), "solid finite elements") == (angle, whose)
    assert rows["engine head test", "stage_2_peak_force"][1] == "engine head test"


def test_spike_figure_shows_all_that_was_recorded(whole):
    data = force.spike_table(whole, SPEED)
    assert (data["cam angle"].min(), data["cam angle"].max()) == pytest.approx((225, 320))
    chart = force.spike_chart(whole, data, SPEED)
    rod = data["run"] == "finite-element"
    assert np.sum(rod) == 4 * (2 * (320 - 225) + 1) - 3  # four substeps a sample: the fine record
    np.testing.assert_array_equal(_lines(chart)["finite-element rod"].y, data["force"][rod])
    np.testing.assert_array_equal(_lines(chart)["finite-element rod, below 10 kHz"].y, data["below 10 kHz"][rod])
    assert np.all(np.isnan(data["below 10 kHz"][data["run"] == "modal-varied"]))


def test_static_and_mode_figures_show_their_tables(whole):
    data = statics.static_table(whole.static_curve)
    chart = statics.static_chart(data, whole.case.published, 7e-3)
    np.testing.assert_array_equal(chart.panels[0].layers[0].y, data["force"])
    np.testing.assert_allclose(data["compression"], whole.static_curve.compression * 1e3)
    np.testing.assert_array_equal(chart.panels[1].layers[0].y, data["stiffness"])
    mark = chart.panels[0].layers[1]
    assert (mark.x[0], mark.y[0]) == pytest.approx((7.0, 289.0))
    assert [rule.value for rule in chart.panels[1].rules] == pytest.approx([7.0, 5.0])
    shapes, found = modes.shape_table(whole.modal_result), modes.frequency_table(whole.modal_result)
    drawn = modes.modes_chart(shapes, found, whole.case.published)
    np.testing.assert_array_equal(drawn.panels[0].layers[1].y, shapes["mode 2"])
    assert np.max(shapes["mode 1"]) == 1.0
    axial = next(layer for layer in drawn.panels[1].layers if layer.name == "axial mode")
    np.testing.assert_array_equal(axial.x, whole.modal_result.axial_frequencies)


def test_motion_figures_show_their_tables(whole):
    run = whole.solutions[0]
    heights = coils.position_table(run)
    lines = coils.position_chart(heights, SPEED).panels[0].layers
    np.testing.assert_array_equal(lines[0].y, heights.columns[1].values)
    np.testing.assert_allclose(heights["coil 2"], run.channel("axial_position")[-720:, 4] * 1e3)
    angle, coil, contact = coils.clash_table(run)
    heat = coils.clash_chart(angle, coil, contact, SPEED).panels[0].layers[0]
    np.testing.assert_array_equal(heat.z, run.channel("coil_contact_force")[-720:].T)
    motion = nodes.node_table(run)
    drawn = nodes.node_chart(motion, nodes.published_motion(whole, SPEED), SPEED)
    np.testing.assert_array_equal(drawn.panels[1].layers[1].y, motion["node 2 velocity"])
    np.testing.assert_allclose(motion["node 2 acceleration"], run.channel("axial_acceleration")[-720:, 4] / 1e3)
    assert "km/s²" in drawn.panels[2].y_label


def test_energy_spectrum_and_lift_figures_show_their_tables(whole):
    run = whole.solutions[0]
    balance = energy.energy_table(run)
    np.testing.assert_array_equal(_lines(energy.energy_chart(balance, SPEED))["work done"].y, balance["work done"])
    orders = energy.spectrum_table(whole, SPEED)
    drawn = _lines(energy.spectrum_chart(orders, np.array([630.0]), SPEED))["modal model with varied stiffness"]
    np.testing.assert_allclose(drawn.y, np.maximum(orders["amplitude"][orders["run"] == "modal-varied"], 1e-2))
    lifted = lift.lift_table(run)
    np.testing.assert_array_equal(lift.lift_chart(lifted).panels[0].layers[0].y, lifted["lift"])


def test_clash_map_thins_by_the_largest_force():
    force_map = np.zeros((400, 1500))
    force_map[123, 777] = 9.0
    thinned = coils._largest(coils._largest(force_map, 1, 720), 0, 160)
    assert thinned.shape[0] <= 160 and thinned.shape[1] <= 720 and thinned.max() == 9.0


def test_plotly_figure_holds_the_chart_numbers():
    x, y = np.linspace(0, 360, 50), np.linspace(1, 1234.5, 50)
    traces = figure(_chart(Line(x, y, "a", "#000000"), Marks(x[:2], y[:2], "b", "#000000", labels=("p", "q"))))["data"]
    np.testing.assert_allclose(unpacked(traces[0]["x"]), x, rtol=1e-6)
    np.testing.assert_allclose(unpacked(traces[0]["y"]), y, rtol=1e-6)
    assert traces[1]["text"] == ["p", "q"]
    heat = figure(_chart(HeatMap(x[:3], y[:2], np.arange(6.0).reshape(2, 3), "force", "N")))["data"][0]
    np.testing.assert_array_equal(unpacked(heat["z"]), np.arange(6.0).reshape(2, 3))
    assert packed(np.zeros((2, 3)))["shape"] == "2, 3"


def test_plotly_json_cannot_end_its_script_element():
    assert "</" not in to_json(_chart(Line(np.zeros(2), np.zeros(2), "</script><b>", "#000000")))


def test_svg_draws_the_numbers_where_they_belong():
    line = Line(np.array([0.0, 5.0, 10.0]), np.array([0.0, 50.0, 100.0]), "a", "#123456")
    tree = ElementTree.fromstring(svg(_chart(line, x_range=(0, 10), y_range=(0, 100))))
    path = next(item.get("d") for item in tree.iter(f"{SVG}path") if item.get("stroke") == "#123456" and "L" in item.get("d"))
    points = np.array([[float(part) for part in pair.split()] for pair in re.split("[ML]", path)[1:]])
    clip = next(tree.iter(f"{SVG}clipPath"))[0]
    left, top, wide, high = (float(clip.get(key)) for key in ("x", "y", "width", "height"))
    np.testing.assert_allclose(points, [[left, top + high], [left + wide / 2, top + high / 2], [left + wide, top]], atol=0.1)


def test_svg_breaks_lines_at_gaps_and_escapes_words():
    text = svg(_chart(Line(np.arange(4.0), np.array([0, 1, np.nan, 2.0]), "<a & b>", "#123456")))
    ElementTree.fromstring(text)
    assert "&lt;a &amp; b&gt;" in text
    assert any(item.get("d", "").count("M") == 2 for item in ElementTree.fromstring(text).iter(f"{SVG}path"))


def test_png_is_read_back_by_another_reader(tmp_path):
    from PIL import Image

    pixels = np.random.default_rng(1).integers(0, 256, (5, 7, 3), dtype=np.uint8)
    (tmp_path / "a.png").write_bytes(png(pixels))
    with Image.open(tmp_path / "a.png") as image:
        np.testing.assert_array_equal(np.asarray(image.convert("RGB")), pixels)


@pytest.mark.parametrize(("low", "high", "count"), [(0, 1, 5), (-3.2, 871, 6), (1e-6, 4e-6, 4), (225, 320, 8)])
def test_ticks_are_round_and_inside(low, high, count):
    values, decimals = ticks(low, high, count)
    assert 2 <= len(values) <= count + 1 and values[0] >= low - 1e-12 and values[-1] <= high * (1 + 1e-12)
    np.testing.assert_allclose(np.round(values, decimals), values, rtol=1e-9, atol=1e-15)


def test_thinning_keeps_every_spike_and_the_ends():
    x = np.arange(100_000.0)
    y = np.sin(x / 1000)
    y[54_321], y[7] = 99.0, -99.0
    few_x, few_y = thin(x, y, 1000)
    assert len(few_x) < 1100 and few_y.max() == 99.0 and few_y.min() == -99.0
    assert (few_x[0], few_x[-1]) == (0, 99_999)
    np.testing.assert_array_equal(y[few_x.astype(int)], few_y)


def test_ranges_follow_what_is_shown():
    line = Line(np.arange(10.0), np.array([0, 1, 2, 3, 4, 50, 0, 0, 0, 0.0]), "a", "#000000")
    (_, (low, high)) = visible_range(Panel("x", "y", (line,), x_range=(0, 4)))
    assert low < 0 < 4 < high < 5
    (_, (low, high)) = visible_range(Panel("x", "y", (Line(np.arange(3.0), np.full(3, 7.0), "a", "#000000"),)))
    assert low < 7 < high


def test_words_of_near_rules_stand_on_different_lines():
    rules = (Rule("x", 5.0, "b"), Rule("x", 4.5, "a"), Rule("x", 9.5, "c"))
    line = Line(np.array([0.0, 10.0]), np.zeros(2), "", "#000000")
    assert rule_levels(Panel("x", "y", (line,), rules=rules)) == [1, 0, 0]


def test_every_axis_of_the_page_says_its_unit_and_cam_degrees(whole):
    drawn = charts(spring_page(whole))
    assert len(drawn) >= 9
    for chart in drawn:
        assert chart.caption and chart.title
        for panel in chart.panels:
            assert "(" in panel.x_label or "order" in panel.x_label, panel.x_label
            if "angle" in panel.x_label:
                assert "cam degrees" in panel.x_label
            assert re.search(r"\(|shape|coil number|amplitude", panel.y_label), panel.y_label


def test_tables_write_units_and_quote():
    text = table(("a", "mm", [1.0, 0.1]), ("b, c", "", np.array(["x", 'say "y"'], dtype=object))).csv()
    assert text == 'a [mm],"b, c"\n1.0,x\n0.1,"say ""y"""\n'
    assert quoted(None) == ""
    with pytest.raises(InputError, match="length"):
        table(("a", "", [1.0]), ("b", "", [1.0, 2.0]))


def test_empty_speeds_give_empty_tables(whole):
    none = SimpleNamespace(case=whole.case, solutions=(), modal_result=None)
    assert len(force.force_table(none, SPEED)) == 0
    assert len(energy.spectrum_table(none, SPEED)) == 0


def test_order_spectrum_stands_on_a_logarithmic_axis_in_newtons(whole):
    chart = energy.spectrum_chart(energy.spectrum_table(whole, SPEED), np.array([630.0]), SPEED)
    (panel,) = chart.panels
    low, high = visible_range(panel)[1]
    assert panel.y_label == "amplitude (N, 0 to peak)" and low == pytest.approx(0.01)
    assert np.log10(high) == pytest.approx(round(np.log10(high)))
    axis = figure(chart)["layout"]["yaxis"]
    assert axis["type"] == "log" and axis["range"] == pytest.approx([np.log10(low), np.log10(high)])
    drawing = svg(chart)
    assert ">0.01<" in drawing and ">1<" in drawing and ">100<" in drawing
