"""Charts in both renderers: the numbers given are the numbers drawn, words are escaped, narrow
pages get one column.
"""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from valvetrain.errors import InputError
from valvetrain.report.chart import (
    Band,
    Chart,
    HeatMap,
    Line,
    Marks,
    Panel,
    Rule,
    labelled_left,
    rule_levels,
    stems,
    thin,
    visible_range,
)
from valvetrain.report.plotly_chart import figure, packed, to_json, unpacked
from valvetrain.report.svg_chart import png, svg, ticks
from valvetrain.report.table import quoted, table

SVG = "{http://www.w3.org/2000/svg}"


def _chart(*layers, **more) -> Chart:
    return Chart("key", "title", "caption", (Panel("x (mm)", "y (N)", layers, **more),))


def test_plotly_figure_holds_the_chart_numbers():
    x, y = np.linspace(0, 360, 50), np.linspace(1, 1234.5, 50)
    traces = figure(
        _chart(Line(x, y, "a", "#000000"), Marks(x[:2], y[:2], "b", "#000000", labels=("p", "q")))
    )["data"]
    np.testing.assert_allclose(unpacked(traces[0]["x"]), x, rtol=1e-6)
    np.testing.assert_allclose(unpacked(traces[0]["y"]), y, rtol=1e-6)
    assert traces[1]["text"] == ["p", "q"]
    heat = figure(_chart(HeatMap(x[:3], y[:2], np.arange(6.0).reshape(2, 3), "force", "N")))[
        "data"
    ][0]
    np.testing.assert_array_equal(unpacked(heat["z"]), np.arange(6.0).reshape(2, 3))
    assert packed(np.zeros((2, 3)))["shape"] == "2, 3"


def test_plotly_json_cannot_end_its_script_element():
    assert "</" not in to_json(_chart(Line(np.zeros(2), np.zeros(2), "</script><b>", "#000000")))


def test_svg_draws_the_numbers_where_they_belong():
    line = Line(np.array([0.0, 5.0, 10.0]), np.array([0.0, 50.0, 100.0]), "a", "#123456")
    tree = ElementTree.fromstring(svg(_chart(line, x_range=(0, 10), y_range=(0, 100))))
    path = next(
        item.get("d")
        for item in tree.iter(f"{SVG}path")
        if item.get("stroke") == "#123456" and "L" in item.get("d")
    )
    points = np.array(
        [[float(part) for part in pair.split()] for pair in re.split("[ML]", path)[1:]]
    )
    clip = next(tree.iter(f"{SVG}clipPath"))[0]
    left, top, wide, high = (float(clip.get(key)) for key in ("x", "y", "width", "height"))
    np.testing.assert_allclose(
        points,
        [[left, top + high], [left + wide / 2, top + high / 2], [left + wide, top]],
        atol=0.1,
    )


def test_svg_breaks_lines_at_gaps_and_escapes_words():
    text = svg(_chart(Line(np.arange(4.0), np.array([0, 1, np.nan, 2.0]), "<a & b>", "#123456")))
    ElementTree.fromstring(text)
    assert "&lt;a &amp; b&gt;" in text
    assert any(
        item.get("d", "").count("M") == 2
        for item in ElementTree.fromstring(text).iter(f"{SVG}path")
    )


def test_png_is_read_back_by_another_reader(tmp_path):
    from PIL import Image

    pixels = np.random.default_rng(1).integers(0, 256, (5, 7, 3), dtype=np.uint8)
    (tmp_path / "a.png").write_bytes(png(pixels))
    with Image.open(tmp_path / "a.png") as image:
        np.testing.assert_array_equal(np.asarray(image.convert("RGB")), pixels)


@pytest.mark.parametrize(
    ("low", "high", "count"),
    [
        (0, 1, 5),
        (-3.2, 871, 6),
        (1e-6, 4e-6, 4),
        (225, 320, 8),
        (-0.0158, 0.0158, 3),
        (565.3, 1325.4, 3),
    ],
)
def test_ticks_are_round_and_inside(low, high, count):
    values, decimals = ticks(low, high, count)
    assert (
        2 <= len(values) <= count + 1
        and values[0] >= low - 1e-12
        and values[-1] <= high * (1 + 1e-12)
    )
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
    (_, (low, high)) = visible_range(
        Panel("x", "y", (Line(np.arange(3.0), np.full(3, 7.0), "a", "#000000"),))
    )
    assert low < 7 < high


@pytest.mark.parametrize(
    ("values", "decades"),
    [
        ((3.0, 4e4), (0, 5)),
        ((1.0, 1e3), (0, 3)),
        ((2e-7, 5e-7, 0.0), (-7, -6)),
        ((0.02, 30.0, np.nan), (-2, 2)),
    ],
)
def test_an_axis_of_decades_is_one_on_the_page_and_in_the_picture(values, decades):
    """Whole decades about the positive values, evenly spaced, the line at the logarithms of its
    values.
    """
    low, high = decades
    x, y = np.arange(float(len(values))), np.array(values)
    chart = _chart(Line(x, y, "a", "#123456"), y_log=True)
    drawn = figure(chart)
    for layout in (drawn["layout"], drawn["narrow"]):
        assert (layout["yaxis"]["type"], layout["yaxis"]["dtick"]) == ("log", 1)
        assert layout["yaxis"]["range"] == pytest.approx([low, high])
    assert unpacked(drawn["data"][0]["y"]) == pytest.approx(y, nan_ok=True), (
        "values, not logarithms"
    )
    tree = ElementTree.fromstring(svg(chart))
    told = {one.text: float(one.get("y")) for one in tree.iter(f"{SVG}text")}
    places = np.array([told[f"{10.0**power:g}"] for power in range(low, high + 1)])
    assert np.diff(places) == pytest.approx(
        np.full(high - low, (places[-1] - places[0]) / (high - low)), abs=0.11
    )
    (path,) = [
        one.get("d")
        for one in tree.iter(f"{SVG}path")
        if one.get("stroke") == "#123456" and "L" in one.get("d")
    ]
    (first, second) = (
        float(words.split()[-1].split(",")[-1]) for words in re.split("[ML]", path)[1:3]
    )
    per_decade = (places[0] - places[-1]) / (high - low)
    assert first - second == pytest.approx(per_decade * np.log10(y[1] / y[0]), abs=0.3)


@pytest.mark.parametrize("y_log", [False, True])
def test_only_an_axis_that_is_asked_for_has_decades(y_log):
    layout = figure(
        _chart(Line(np.arange(3.0), np.array([1.0, 10.0, 100.0]), "a", "#000000"), y_log=y_log)
    )["layout"]
    assert (layout["yaxis"].get("type") == "log") == y_log and layout["xaxis"].get("type") != "log"


def test_words_of_near_rules_stand_on_different_lines():
    rules = (Rule("x", 5.0, "bounce"), Rule("x", 4.5, "float"), Rule("x", 5.5, "surge"))
    line = Line(np.array([0.0, 10.0]), np.zeros(2), "", "#000000")
    near = Panel("x", "y", (line,), rules=rules)
    assert rule_levels(near) == [0, 0, 1]
    # labels that are written towards each other, from a rule on the left and one near the end
    facing = Panel(
        "x", "y", (line,), rules=(Rule("x", 5.5, "contact 6970"), Rule("x", 9.0, "float 8539"))
    )
    assert rule_levels(facing) == [0, 0] and rule_levels(facing, narrow=True) == [0, 1]
    assert labelled_left(facing, Rule("x", 8.7, "spring (2) contact 5892"))  # else it is cut off


def test_no_rule_runs_through_the_label_of_the_one_before():
    """Contract: "full lift" stood on the rule of the solid spring, whose label stood on that of the full
    lift.
    """
    line = Line(np.array([0.0, 28.3]), np.zeros(2), "", "#000000")
    rules = tuple(
        Rule("x", value, label)
        for value, label in ((8.3, "installed"), (22.6, "full lift"), (24.8, "solid"))
    )
    panel = Panel("x", "y", (line,), rules=rules)
    for narrow in (False, True):
        assert [labelled_left(panel, rule, narrow) for rule in rules] == [False, True, False]
        assert rule_levels(panel, narrow) == [0, 0, 0]


def test_tables_write_units_and_quote():
    text = table(
        ("a", "mm", [1.0, 0.1]), ("b, c", "", np.array(["x", 'say "y"'], dtype=object))
    ).csv()
    assert text == 'a [mm],"b, c"\n1.0,x\n0.1,"say ""y"""\n'
    assert quoted(None) == ""
    with pytest.raises(InputError, match="length"):
        table(("a", "", [1.0]), ("b", "", [1.0, 2.0]))


def test_lines_keep_every_vertex():
    traces = figure(_chart(Line(np.arange(5.0), np.arange(5.0), "a", "#000000")))["data"]
    assert traces[0]["line"]["simplify"] is False


def test_a_narrow_page_has_all_panels_in_one_column_and_room_for_ticks():
    line = Line(np.arange(3.0), np.arange(3.0), "a", "#000000")
    drawn = figure(
        Chart(
            "key",
            "t",
            "c",
            tuple(Panel("x", f"y{n}", (line,)) for n in range(4)),
            columns=2,
            height=500,
        )
    )
    wide, narrow = drawn["layout"], drawn["narrow"]
    assert wide["xaxis"]["domain"][1] < wide["xaxis2"]["domain"][0]
    assert all(narrow[f"xaxis{n}"]["domain"] == [0.0, 1.0] for n in ("", "2", "3", "4"))
    tops = [narrow[f"yaxis{n}"]["domain"][1] for n in ("", "2", "3", "4")]
    assert tops == sorted(tops, reverse=True) and narrow["height"] > wide["height"]
    assert wide["margin"]["l"] >= 50 and narrow["margin"]["l"] >= 50


def test_a_panel_of_half_the_weight_has_half_the_height_in_every_form():
    """Property: what a reader compares first gets the room."""
    line = Line(np.arange(3.0), np.arange(3.0), "a", "#000000")
    chart = Chart("key", "t", "c", (Panel("x", "y", (line,)), Panel("x", "z", (line,), weight=0.5)))
    drawn = figure(chart)
    for layout in (drawn["layout"], drawn["narrow"]):
        first, second = (np.ptp(layout[f"yaxis{n}"]["domain"]) for n in ("", "2"))
        assert second == pytest.approx(first / 2) and layout["yaxis2"]["domain"][0] < 1e-9
    boxes = ElementTree.fromstring(svg(chart)).iter(f"{SVG}clipPath")
    first, second = (float(box[0].get("height")) for box in boxes)
    assert second == pytest.approx(first / 2, abs=0.1)


def test_names_of_rows_stand_inside_their_panel_in_every_form():
    line = Line(np.array([0.0, 9.0]), np.zeros(2), "a", "#000000")
    chart = _chart(line, row_labels=((0.0, "float <b>"),), y_range=(-0.5, 0.5))
    drawn = figure(chart)
    for layout in (drawn["layout"], drawn["narrow"]):
        assert "float &lt;b&gt;" in [note["text"] for note in layout["annotations"]]
        assert layout["yaxis"]["showticklabels"] is False
    words = [one.text for one in ElementTree.fromstring(svg(chart)).iter(f"{SVG}text")]
    assert "float <b>" in words and "0.0" not in words


def test_a_narrow_figure_of_many_panels_is_lower_for_each():
    """Property: six panels of a phone need less than three times what two need."""
    line = Line(np.arange(3.0), np.arange(3.0), "a", "#000000")

    def height(count: int) -> int:
        panels = tuple(Panel("x", f"y{n}", (line,)) for n in range(count))
        return figure(Chart("key", "t", "c", panels))["narrow"]["height"]

    assert height(2) < height(6) < 2.6 * height(2)


def test_panels_over_one_axis_name_its_ticks_and_bands_once():
    """Contract: the first screen of a phone held the lift and half of the force."""
    line = Line(np.array([0.0, 360.0]), np.arange(2.0), "a", "#000000")
    band = (Band(100.0, 250.0, "lift event"),)
    panels = tuple(
        Panel("cam angle", name, (line,), bands=band, x_range=(0, 360), weight=weight)
        for name, weight in (("lift", 0.6), ("force", 1.0))
    )
    drawn = figure(Chart("opening", "t", "c", panels), opening=True)
    for layout in (drawn["layout"], drawn["narrow"]):
        assert [note["text"] for note in layout["annotations"]].count("lift event") == 1
        assert layout["xaxis"]["showticklabels"] is False
        assert "showticklabels" not in layout["xaxis2"]
        assert sum(shape["type"] == "rect" for shape in layout["shapes"]) == 2
    assert drawn["narrow"]["height"] < 400 < figure(Chart("x", "t", "c", panels))["narrow"]["height"]  # fmt: skip


def test_four_panels_over_one_axis_end_on_the_first_screen():
    """Contract: lift to jerk of a measured lobe, whose axis alone names its ticks."""
    line = Line(np.array([0.0, 360.0]), np.arange(2.0), "a", "#000000")
    panels = tuple(Panel("cam angle", f"y{n}", (line,), x_range=(0, 360)) for n in range(4))
    chart = Chart("key", "t", "c", panels)
    assert figure(chart, opening=True)["narrow"]["height"] < 570
    assert figure(chart)["narrow"]["height"] > 700


def test_three_panels_with_axes_of_their_own_end_on_the_first_screen():
    """Contract: the third quantity of an identification began below a phone's first screen, of which title and sentence
    take 325 of 844 px.
    """
    line = Line(np.arange(3.0), np.arange(3.0), "a", "#000000")
    panels = tuple(Panel(f"quantity {n}", "density", (line,)) for n in range(3))
    chart = Chart("marginals", "t", "c", panels, 3)
    assert figure(chart, opening=True)["narrow"]["height"] <= 844 - 325
    assert figure(chart)["narrow"]["height"] > 700


def test_a_mark_without_size_is_its_text_alone():
    """Contract: numbers of orders stood beside rings."""
    text = Marks(np.array([5.0]), np.array([1.0]), "", "#000000", labels=("12",), size=0)
    chart = _chart(Line(np.array([0.0, 9.0]), np.zeros(2), "a", "#000000"), text)
    assert figure(chart)["data"][1]["mode"] == "text"
    assert "<circle" not in svg(chart) and ">12<" in svg(chart)


def test_words_from_outside_are_no_markup_in_a_figure():
    mark = Marks(
        np.ones(1), np.ones(1), "<!--<script>", "#000000", labels=("<b>x</b>",), hints=("<i>h</i>",)
    )
    drawn = figure(_chart(mark, title="<img src=x>"))
    assert drawn["data"][0]["name"] == "&lt;!--&lt;script&gt;" and drawn["data"][0]["text"] == [
        "&lt;b&gt;x&lt;/b&gt;"
    ]
    assert drawn["data"][0]["customdata"] == ["&lt;i&gt;h&lt;/i&gt;"]
    assert any("&lt;img" in note["text"] for note in drawn["layout"]["annotations"])


def test_stems_reach_from_their_base_to_the_value():
    x, y = stems(np.array([1.0, 2.0]), np.array([5.0, -3.0]))
    np.testing.assert_array_equal(x, [1, 1, np.nan, 2, 2, np.nan])
    np.testing.assert_array_equal(y, [0, 5, np.nan, 0, -3, np.nan])
