"""Pictures and page figures read back by their own axes: points are turned into numbers by the
ticks beside them, words are looked for.
"""

from __future__ import annotations

import base64
import io
import re
from dataclasses import dataclass
from functools import cache
from xml.etree import ElementTree

import numpy as np
import pytest

from known_figures import STUDIES
from valvetrain.report.chart import (
    Chart,
    HeatMap,
    Line,
    Marks,
    legend_entries,
    row_weights,
    shares_axis,
    visible_range,
)
from valvetrain.report.page import charts
from valvetrain.report.plotly_chart import figure, unpacked
from valvetrain.report.study import study_page
from valvetrain.report.svg_chart import svg

SVG = "{http://www.w3.org/2000/svg}"


@cache
def drawn(name: str) -> tuple[Chart, ...]:
    """One chart of each kind on a page."""
    kinds = {re.sub(r"\d", "", chart.key): chart for chart in charts(study_page(STUDIES[name]()))}
    return tuple(kinds.values())


@dataclass
class Box:
    """Place of a panel in the picture (px)."""

    left: float
    top: float
    wide: float
    high: float

    def holds(self, x: float, y: float) -> bool:
        return (
            self.left - 1 <= x <= self.left + self.wide + 1
            and self.top - 1 <= y <= self.top + self.high + 1
        )


def texts(tree: ElementTree.Element) -> list[tuple[float, float, str, str]]:
    return [
        (float(one.get("x")), float(one.get("y")), one.get("text-anchor"), one.text or "")
        for one in tree.iter(f"{SVG}text")
    ]


def number(words: str) -> float | None:
    try:
        return float(words)
    except ValueError:
        return None


def scale(pairs: list[tuple[float, float]]) -> np.ndarray:
    """Slope and offset from pixels to numbers, by the ticks."""
    assert len(pairs) >= 2
    return np.polyfit(*np.array(pairs).T, 1)


def scales(
    tree: ElementTree.Element, box: Box, worded: bool
) -> tuple[np.ndarray, np.ndarray | None]:
    words, base = texts(tree), box.top + box.high
    across = [
        (x, value)
        for x, y, anchor, text in words
        if anchor == "middle"
        and abs(y - base - 17) < 2
        and box.left - 1 <= x <= box.left + box.wide + 1
        and (value := number(text)) is not None
    ]
    up = [
        (y - 4, value)
        for x, y, anchor, text in words
        if anchor == "end"
        and abs(x - box.left + 7) < 2
        and box.top - 1 <= y - 4 <= base + 1
        and (value := number(text)) is not None
    ]
    return scale(across), None if worded else scale(up)


def path_points(path: str) -> np.ndarray:
    return np.array([[float(part) for part in pair.split()] for pair in re.split("[ML]", path)[1:]])


def panels_of(tree: ElementTree.Element) -> list[tuple[Box, ElementTree.Element]]:
    groups = [group for group in tree.iter(f"{SVG}g") if group.get("clip-path")]
    boxes = [
        Box(*(float(clip[0].get(key)) for key in ("x", "y", "width", "height")))
        for clip in tree.iter(f"{SVG}clipPath")
    ]
    return list(zip(boxes, groups, strict=True))


@pytest.mark.parametrize("name", STUDIES)
def test_a_picture_read_by_its_ticks_gives_the_numbers_back(name):
    for chart in drawn(name):
        tree = ElementTree.fromstring(svg(chart))
        for panel, (box, group) in zip(chart.panels, panels_of(tree), strict=True):
            x_scale, y_scale = scales(tree, box, bool(panel.y_tick_labels or panel.row_labels))
            (low, high), (least, most) = visible_range(panel)
            assert np.polyval(x_scale, [box.left, box.left + box.wide]) == pytest.approx(
                [low, high], abs=0.004 * (high - low)
            )
            shown = [layer for layer in panel.layers if not isinstance(layer, Marks)]
            for layer, element in zip(shown, list(group), strict=True):
                if isinstance(layer, HeatMap):
                    check_map(layer, element, x_scale, y_scale)
                    continue
                assert element.get("stroke") == layer.colour
                points = path_points(element.get("d"))
                x, y = np.asarray(layer.x, dtype=float), np.asarray(layer.y, dtype=float)
                good = np.isfinite(x) & np.isfinite(y)
                assert len(points) == good.sum(), (chart.key, layer.name)
                np.testing.assert_allclose(
                    np.polyval(x_scale, points[:, 0]),
                    x[good],
                    atol=0.004 * (high - low),
                    err_msg=chart.key,
                )
                if y_scale is not None:
                    np.testing.assert_allclose(
                        np.polyval(y_scale, points[:, 1]),
                        y[good],
                        atol=0.008 * (most - least),
                        err_msg=chart.key,
                    )


def check_map(
    layer: HeatMap, image: ElementTree.Element, x_scale: np.ndarray, y_scale: np.ndarray
) -> None:
    """The map's cells lie about their numbers and the darkest is the largest."""
    from PIL import Image

    left, top, wide, high = (float(image.get(key)) for key in ("x", "y", "width", "height"))
    pixels = np.asarray(
        Image.open(io.BytesIO(base64.b64decode(image.get("href").partition(",")[2]))).convert("RGB")
    ).astype(float)
    assert pixels.shape[:2] == layer.z.shape
    across = np.polyval(x_scale, left + (np.arange(pixels.shape[1]) + 0.5) * wide / pixels.shape[1])
    up = np.polyval(y_scale, top + (np.arange(pixels.shape[0]) + 0.5) * high / pixels.shape[0])[
        ::-1
    ]
    np.testing.assert_allclose(across, layer.x, atol=0.01 * np.ptp(layer.x))
    np.testing.assert_allclose(up, layer.y, atol=0.02 * np.ptp(layer.y))
    none, most = layer.z == 0, layer.z == layer.z.max()
    if layer.z.max() > 0:
        ends = [
            [int(colour[n : n + 2], 16) for n in (1, 3, 5)]
            for colour in (layer.colours[0], layer.colours[-1])
        ]
        assert np.all(pixels[::-1][none] == ends[0]) and np.all(pixels[::-1][most] == ends[1])


@pytest.mark.parametrize("name", STUDIES)
def test_a_picture_says_every_word_of_its_chart(name):
    for chart in drawn(name):
        words = [text for *_, text in texts(ElementTree.fromstring(svg(chart)))]
        wanted = [
            chart.title,
            *(panel.y_label for panel in chart.panels),
            *(panel.title for panel in chart.panels if panel.title),
        ]
        wanted += [rule.label for panel in chart.panels for rule in panel.rules if rule.label]
        wanted += [band.label for panel in chart.panels for band in panel.bands if band.label]
        wanted += [entry.name for entry in legend_entries(chart)] if chart.legend else []
        wanted += [
            layer.direct
            for panel in chart.panels
            for layer in panel.layers
            if isinstance(layer, Line) and layer.direct
        ]
        wanted += [
            f"{layer.name} ({layer.unit})"
            for panel in chart.panels
            for layer in panel.layers
            if isinstance(layer, HeatMap)
        ]
        assert not [one for one in wanted if one not in words], chart.key
        first = chart.panels[0].x_label
        alike = sum(panel.x_label == first for panel in chart.panels)
        assert sum(text == first for text in words) == (1 if shares_axis(chart) else alike)


def test_marks_stand_at_their_numbers_with_their_labels():
    chart = next(
        chart
        for chart in drawn("published")
        if chart.key.endswith("force")
        and any(isinstance(layer, Marks) for layer in chart.panels[0].layers)
    )
    tree = ElementTree.fromstring(svg(chart))
    (box, _), marks = (
        panels_of(tree)[0],
        next(layer for layer in chart.panels[0].layers if isinstance(layer, Marks)),
    )
    x_scale, y_scale = scales(tree, box, False)
    (circle,) = [
        one
        for one in tree.iter(f"{SVG}circle")
        if box.holds(float(one.get("cx")), float(one.get("cy")))
    ]
    assert np.polyval(x_scale, float(circle.get("cx"))) == pytest.approx(marks.x[0], abs=1.0)
    assert np.polyval(y_scale, float(circle.get("cy"))) == pytest.approx(marks.y[0], abs=3.0)
    assert marks.labels[0] in [text for *_, text in texts(tree)]


@pytest.mark.parametrize("name", STUDIES)
def test_rules_and_bands_stand_at_their_numbers(name):
    for chart in drawn(name):
        tree = ElementTree.fromstring(svg(chart))
        shapes = figure(chart)["layout"]["shapes"]
        for index, (panel, (box, _)) in enumerate(zip(chart.panels, panels_of(tree), strict=True)):
            x_scale, y_scale = scales(tree, box, bool(panel.y_tick_labels or panel.row_labels))
            axis = "" if index == 0 else str(index + 1)
            mine = [
                one
                for one in shapes
                if one["xref"].split()[0] == f"x{axis}" and one["yref"].split()[0] == f"y{axis}"
            ]
            dotted = [
                path_points(one.get("d").replace("v", "L").replace("h", "L").split("L")[0])[0]
                for one in tree.iter(f"{SVG}path")
                if one.get("stroke-dasharray") == "1.5 3"
            ]
            inside = [place for place in dotted if box.holds(*place)]
            for rule in panel.rules:
                ends = ("x0", "x1") if rule.axis == "x" else ("y0", "y1")
                assert any(
                    [one[end] for end in ends] == [rule.value] * 2
                    for one in mine
                    if one["type"] == "line"
                ), (chart.key, rule)
                if rule.axis == "x" or y_scale is not None:
                    upright = rule.axis == "x"
                    places = np.polyval(
                        x_scale if upright else y_scale,
                        [place[0 if upright else 1] for place in inside],
                    )
                    assert np.min(np.abs(places - rule.value)) < 0.01 * np.ptp(
                        visible_range(panel)[rule.axis == "y"]
                    ), (chart.key, rule)
            shaded = [band for band in panel.bands if band.shaded]
            assert [(one["x0"], one["x1"]) for one in mine if one["type"] == "rect"] == [
                (band.first, band.last) for band in shaded
            ]
            grey = [
                one
                for one in tree.iter(f"{SVG}rect")
                if one.get("fill") == "#f4f6f9" and box.holds(float(one.get("x")), box.top)
            ]
            grey = [one for one in grey if abs(float(one.get("y")) - box.top) < 1]
            for band, one in zip(shaded, grey, strict=True):
                edges = np.polyval(
                    x_scale, [float(one.get("x")), float(one.get("x")) + float(one.get("width"))]
                )
                assert edges == pytest.approx([band.first, band.last], abs=1.0)


@pytest.mark.parametrize("name", STUDIES)
def test_the_figure_of_a_page_holds_its_layers_in_their_panels(name):
    for chart in drawn(name):
        made = figure(chart)
        layers = [
            (index, layer) for index, panel in enumerate(chart.panels) for layer in panel.layers
        ]
        for (index, layer), trace in zip(layers, made["data"], strict=True):
            suffix = "" if index == 0 else str(index + 1)
            assert (trace["xaxis"], trace["yaxis"]) == (f"x{suffix}", f"y{suffix}")
            np.testing.assert_allclose(unpacked(trace["x"]), layer.x, rtol=1e-6)
            np.testing.assert_allclose(unpacked(trace["y"]), layer.y, rtol=1e-6)
            assert (
                trace["name"].replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
                == layer.name
            )
            if isinstance(layer, HeatMap):
                np.testing.assert_allclose(unpacked(trace["z"]), layer.z, rtol=1e-6)
                bar = made["layout"][f"coloraxis{suffix}"]
                assert bar["cmin"] == 0 and bar["cmax"] == (
                    pytest.approx(layer.z.max()) if layer.z.max() > 0 else 1.0
                )
                assert (
                    bar["colorbar"]["title"]["text"] == f"{layer.name} ({layer.unit})"
                    and trace["coloraxis"] == f"coloraxis{suffix}"
                )
                assert trace["hovertemplate"].startswith(
                    f"%{{x:.1f}}, {layer.y_tick_labels} %{{y:.4g}}: %{{z:.4g}} {layer.unit}"
                )
                if layer.second is not None:
                    np.testing.assert_allclose(
                        unpacked(trace["customdata"]), layer.second, rtol=1e-6
                    )
                    assert trace["hovertemplate"].endswith(
                        f" (%{{customdata:.4g}} {layer.second_unit})"
                    )
            elif isinstance(layer, Line):
                assert (trace["mode"], trace["line"]["color"], trace["line"]["dash"]) == (
                    "lines",
                    layer.colour,
                    layer.dash,
                )
            else:
                assert [words.strip() for words in trace.get("text", [])] == list(
                    layer.labels if any(layer.labels) else ()
                )
                assert (
                    len(trace.get("customdata", [])) == len(layer.hints)
                    and ("-open" in trace["marker"]["symbol"]) is not layer.filled
                )
        for layout, columns in ((made["layout"], chart.columns), (made["narrow"], 1)):
            notes = " ".join(note["text"] for note in layout["annotations"])
            places = []
            for index, panel in enumerate(chart.panels):
                suffix = "" if index == 0 else str(index + 1)
                x, y = layout[f"xaxis{suffix}"], layout[f"yaxis{suffix}"]
                places.append((tuple(x["domain"]), tuple(y["domain"])))
                across, (base, top) = visible_range(panel)
                assert tuple(x["range"]) == across and y["range"][0] == base
                # more only above, where a mark has its label on the way of a curve
                marked = any(rule.axis == "x" and rule.label for rule in panel.rules)
                assert y["range"][1] >= top if marked else y["range"][1] == top
                named = not shares_axis(chart, columns) or index == len(chart.panels) - 1
                assert x["title"]["text"] == (panel.x_label if named else "")
                assert (x["anchor"], y["anchor"]) == (f"y{suffix}", f"x{suffix}")
                assert (
                    panel.y_label.replace("<", "&lt;") in notes
                    and panel.title.replace("<", "&lt;") in notes
                )
                if panel.y_tick_labels:
                    assert list(zip(y["tickvals"], y["ticktext"], strict=True)) == list(
                        panel.y_tick_labels
                    )
            assert len(set(places)) == len(places)
            for place, ((left, right), (low, high)) in enumerate(places):
                assert 0 <= left < right <= 1 and 0 <= low < high <= 1
                for (left2, right2), (low2, high2) in places[place + 1 :]:
                    assert right <= left2 or right2 <= left or high2 <= low or high <= low2


@pytest.mark.parametrize("name", STUDIES)
def test_panels_lie_within_the_picture_and_apart_from_each_other(name):
    """Of as many rows and columns as the chart has: all alike wide, and high by the weights of their
    rows.
    """
    for chart in drawn(name):
        tree = ElementTree.fromstring(svg(chart))
        wide, high = (float(tree.get(key)) for key in ("width", "height"))
        boxes = [box for box, _ in panels_of(tree)]
        assert len(boxes) == len(chart.panels)
        weights = row_weights(chart, chart.columns)
        for place, box in enumerate(boxes):
            assert (
                0 < box.left < box.left + box.wide < wide
                and 0 < box.top < box.top + box.high < high
            ), chart.key
            share = weights[place // chart.columns] / weights[0]
            assert box.wide == boxes[0].wide and min(box.wide, box.high) > 40, chart.key
            assert box.high == pytest.approx(share * boxes[0].high, abs=0.2), chart.key
        for place, box in enumerate(boxes):
            row, column = divmod(place, chart.columns)
            for other in boxes[:place]:
                beside, below = (
                    box.left >= other.left + other.wide,
                    box.top >= other.top + other.high,
                )
                assert beside or below or other.left >= box.left + box.wide, chart.key
            assert (box.top == boxes[0].top) == (row == 0) and (box.left == boxes[0].left) == (
                column == 0
            ), chart.key
