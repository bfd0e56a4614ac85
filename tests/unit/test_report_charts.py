"""Charts in both renderers: the numbers given are the numbers drawn, and words are escaped."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from valvetrain.errors import InputError
from valvetrain.report.chart import (
    Chart,
    HeatMap,
    Line,
    Marks,
    Panel,
    thin,
)
from valvetrain.report.plotly_chart import figure, packed, to_json, unpacked
from valvetrain.report.svg_chart import svg
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


def test_thinning_keeps_every_spike_and_the_ends():
    x = np.arange(100_000.0)
    y = np.sin(x / 1000)
    y[54_321], y[7] = 99.0, -99.0
    few_x, few_y = thin(x, y, 1000)
    assert len(few_x) < 1100 and few_y.max() == 99.0 and few_y.min() == -99.0
    assert (few_x[0], few_x[-1]) == (0, 99_999)
    np.testing.assert_array_equal(y[few_x.astype(int)], few_y)


def test_tables_write_units_and_quote():
    text = table(
        ("a", "mm", [1.0, 0.1]), ("b, c", "", np.array(["x", 'say "y"'], dtype=object))
    ).csv()
    assert text == 'a [mm],"b, c"\n1.0,x\n0.1,"say ""y"""\n'
    assert quoted(None) == ""
    with pytest.raises(InputError, match="length"):
        table(("a", "", [1.0]), ("b", "", [1.0, 2.0]))
