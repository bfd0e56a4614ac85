"""Charts as Plotly figures: plain JSON for the page, numbers packed in binary so that the page
stays small.
"""

from __future__ import annotations

import base64
import json
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.report import theme
from valvetrain.report.chart import (
    LABEL_TOP,
    Chart,
    HeatMap,
    Layer,
    Line,
    Marks,
    Panel,
    label_heights,
    label_line,
    labelled_left,
    range_below_labels,
    row_weights,
    rule_levels,
    rule_place,
    shares_axis,
    visible_range,
)

_SYMBOLS = {"circle": "circle", "diamond": "diamond", "triangle": "triangle-up", "square": "square"}
_SIDES = {
    "top": "top center",
    "right": "middle right",
    "left": "middle left",
    "bottom": "bottom center",
}
#: Margins in px around the panels of a figure: left for tick words, right for half of the last tick's number
#: (which is left out where it would be cut), below for tick and axis words,
#: above for a panel's own words.
_LEFT, _RIGHT, _BOTTOM, _ABOVE, _BAR = 54, 26, 46, 26, 92
#: Space in px for words in place of numbers along y, at most.
NAMES_WIDTH = 372
#: Space in px between panels, and the width in px of a plot area of two columns at its narrowest
#: (page.js changes over below it).
_GAP_X, _MIN_WIDTH = 60, 620
#: Letters of a panel's words that one line of a narrow page holds; a title beyond them gets a
#: line of its own.
_MAX_LETTERS = 40
#: Height in px of a panel on a narrow page, where all are in one column: of one of two, what each
#: further one takes off, and the least.
NARROW_PANEL, _NARROW_STEP, _MIN_NARROW = 220, 20, 150
#: Height in px of all panels together of the figure that opens a narrow page, as far as none is lower
#: than the least, and that of each of more than three; the space between two of them that share an axis, whose
#: ticks the last one names.
_OPENING, _ONE_OF_MANY, _NAMELESS = 250, 95, 10
#: Height in px of a row on a narrow page, whose label is this far above its marks; and share of
#: its height on a wide page that a figure has at most for that.
NARROW_ROW, _ABOVE_MARKS, _MORE_HEIGHT = 32, 11, 1.4


def figure(chart: Chart, opening: bool = False) -> dict[str, Any]:
    """``data``, ``layout`` and ``narrow`` (the layout of a narrow page) of a chart for Plotly;
    arrays are packed (:func:`packed`). ``opening``: it opens a page, so its panels are as low there as
    the first screen needs.
    """
    data: list[dict[str, Any]] = []
    for index, panel in enumerate(chart.panels):
        suffix = "" if index == 0 else str(index + 1)
        for layer in panel.layers:
            scale = (
                {"coloraxis": f"coloraxis{suffix}"}
                if isinstance(layer, HeatMap)
                else {"showlegend": False}
            )
            data.append(
                _trace(layer)
                | {"meta": _columns(panel, layer)}
                | {"xaxis": f"x{suffix}", "yaxis": f"y{suffix}"}
                | scale
            )
    return {
        "data": data,
        "layout": _layout(chart, chart.columns, 0),
        "narrow": _layout(chart, 1, _narrow_panel(chart, opening)),
    }


def _narrow_panel(chart: Chart, opening: bool) -> int:
    """Height in px of a panel of weight 1 on a narrow page: less where there are many."""
    height = NARROW_PANEL - _NARROW_STEP * max(len(chart.panels) - 2, 0)
    many = 3 if shares_axis(chart, 1) else 2  # with an axis of its own each takes more
    if opening and len(chart.panels) > many:
        return _ONE_OF_MANY
    if opening:
        height = min(height, int(_OPENING / sum(row_weights(chart, 1))))
    return max(height, _MIN_NARROW)


def _height_of_rows(panel: Panel) -> int:
    """Height in px in which the labels of rows do not touch each other's marks."""
    places = np.sort([value for value, _ in panel.y_tick_labels])
    if len(places) < 2:
        return 0
    return int(NARROW_ROW * np.ptp(visible_range(panel)[1]) / np.diff(places).min())


def _columns(panel: Panel, layer: Layer) -> list[str]:
    """Column headings of the data of a layer: its x and y, and the colour of a map."""
    named = f"{panel.title}, {layer.name}" if panel.title else layer.name
    if isinstance(layer, HeatMap):
        return [
            f"{named}: {panel.x_label}",
            f"{named}: {layer.y_tick_labels}",
            f"{layer.name} ({layer.unit})",
        ]
    return [f"{named}: {panel.x_label}", f"{named}: {panel.y_label}"]


def _layout(chart: Chart, columns: int, panel_height: int) -> dict[str, Any]:
    """Layout with ``columns``; ``panel_height`` (px) sets the height of the figure, 0 leaves the
    chart's own.
    """
    narrow, rows = panel_height > 0, -(-len(chart.panels) // columns)
    shared = shares_axis(chart, columns)
    worded = [
        max((len(label) for _, label in panel.y_tick_labels), default=0) for panel in chart.panels
    ]
    maps = any(isinstance(layer, HeatMap) for panel in chart.panels for layer in panel.layers)
    direct = any(
        isinstance(layer, Line) and layer.direct for panel in chart.panels for layer in panel.layers
    )
    left = (
        20
        if narrow and max(worded, default=0)
        else max(_LEFT, min(NAMES_WIDTH, 14 + int(6.6 * max(worded, default=0))))
    )
    right = (58 if direct else _RIGHT) + (_BAR - _RIGHT if maps and not narrow else 0)
    bottom = _BOTTOM + (60 if maps and narrow else 0)
    parted = narrow and any(
        panel.title and len(panel.title + panel.y_label) > _MAX_LETTERS for panel in chart.panels
    )
    panels = _bands_named_once(chart.panels) if shared else chart.panels
    above, inner = (
        _ABOVE + (16 if any(map(_has_named_bands, some)) else 0) + (16 if parted else 0)
        for some in (panels, panels[1:])
    )
    gap = inner + _NAMELESS if shared else above + _BOTTOM
    if narrow and max(worded, default=0):
        own = chart.height - above - _BOTTOM
        rows_of_names = max(map(_height_of_rows, chart.panels))
        panel_height = max(own, min(rows_of_names, int(_MORE_HEIGHT * own)))
    weights = row_weights(chart, columns)
    height = (
        int(sum(weights) * panel_height) + (rows - 1) * gap + above + bottom
        if narrow
        else chart.height
    )
    inside = float(height - above - bottom)
    layout = _base(chart) | {
        "height": height,
        "margin": {"l": left, "r": right, "t": above, "b": bottom, "pad": 0},
    }
    wide = (1 - (columns - 1) * _GAP_X / _MIN_WIDTH) / columns
    unit = (inside - (rows - 1) * gap) / sum(weights) / inside
    for index, panel in enumerate(panels):
        row, column = divmod(index, columns)
        start, high = column * (wide + _GAP_X / _MIN_WIDTH), unit * weights[row]
        top = 1 - unit * sum(weights[:row]) - row * gap / inside
        x_domain, y_domain = [start, min(start + wide, 1.0)], [max(top - high, 0.0), min(top, 1.0)]
        named = not shared or index == len(panels) - 1
        for heat in (layer for layer in panel.layers if isinstance(layer, HeatMap)):
            layout[f"coloraxis{index + 1 if index else ''}"] = _colour_axis(heat, narrow)
        _add_axes(
            layout,
            panel,
            "" if index == 0 else str(index + 1),
            x_domain,
            y_domain,
            narrow,
            named,
            shared and index > 0,
            parted,
        )
        if not named:
            layout[f"xaxis{index + 1 if index else ''}"]["showticklabels"] = False
    return layout


def _bands_named_once(panels: tuple[Panel, ...]) -> tuple[Panel, ...]:
    """Panels over one axis; those below the first do not name the bands that it names."""
    first, *others = panels
    bare = tuple(replace(band, label="") for band in first.bands)
    return first, *(replace(one, bands=bare) if one.bands == first.bands else one for one in others)


def _has_named_bands(panel: Panel) -> bool:
    return any(band.label for band in panel.bands)


def to_json(chart: Chart, opening: bool = False) -> str:
    """The figure as JSON text that is safe in a script element; ``opening`` as in :func:`figure`."""
    return in_script(json.dumps(figure(chart, opening), separators=(",", ":"), allow_nan=False))


def in_script(text: str) -> str:
    """JSON text, equal once read, that no HTML parser takes for the end of its script element or
    for a comment in it.
    """
    for sign in "<>&\u2028\u2029":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return text


def packed(values: ArrayLike) -> dict[str, str]:
    """Numbers as Plotly's typed-array form (32-bit floats, about seven digits)."""
    array = np.ascontiguousarray(np.asarray(values, dtype="<f4"))
    form = {"dtype": "f4", "bdata": base64.b64encode(array.tobytes()).decode()}
    return form | {"shape": ", ".join(map(str, array.shape))} if array.ndim > 1 else form


def unpacked(form: dict[str, str]) -> np.ndarray:
    """The numbers in a packed array, for whoever reads a figure back."""
    array = np.frombuffer(base64.b64decode(form["bdata"]), dtype="<f4")
    return (
        array.reshape([int(part) for part in form["shape"].split(",")])
        if "shape" in form
        else array
    )


def _base(chart: Chart) -> dict[str, Any]:
    return {
        "autosize": True,
        "paper_bgcolor": theme.PAPER,
        "plot_bgcolor": theme.PAPER,
        "hovermode": "closest",
        "dragmode": "zoom",
        "font": {"family": theme.FONT, "size": 13, "color": theme.INK},
        "hoverlabel": {
            "bgcolor": "#ffffff",
            "bordercolor": theme.RULE,
            "font": {"family": theme.FONT, "size": 12, "color": theme.INK},
        },
        "showlegend": False,
        "annotations": [],
        "shapes": [],
    }


def _add_axes(
    layout: dict[str, Any],
    panel: Panel,
    suffix: str,
    x_domain: list[float],
    y_domain: list[float],
    narrow: bool,
    named: bool,
    tied: bool,
    parted: bool,
) -> None:
    x_range, y_range = visible_range(panel)[0], range_below_labels(panel, narrow)
    common = {
        "gridcolor": theme.GRID, "linecolor": theme.RULE, "tickcolor": theme.RULE, "zeroline": False, "ticks": "outside", "ticklen": 4,
        "tickfont": {"size": 12, "color": theme.MUTED}, "automargin": False, "exponentformat": "none", "tickangle": 0,
    }  # fmt: skip
    title = {
        "font": {"size": 12.5, "color": theme.MUTED},
        "standoff": 6,
        "text": plain(panel.x_label) if named else "",
    }
    x_axis = {
        "domain": x_domain,
        "anchor": f"y{suffix}",
        "range": list(x_range),
        "showgrid": False,
        "showline": True,
        "title": title,
    }
    if panel.x_step:
        x_axis |= {"dtick": panel.x_step * (2 if narrow else 1), "tick0": 0}
    elif narrow:
        x_axis |= {"nticks": 6}
    layout[f"xaxis{suffix}"] = common | x_axis | ({"matches": "x"} if tied else {})
    y_axis = {
        "domain": y_domain,
        "anchor": f"x{suffix}",
        "range": list(y_range),
        "showline": False,
        "nticks": 6,
    }
    if panel.y_log:
        y_axis |= {"type": "log", "range": [float(np.log10(end)) for end in y_range], "dtick": 1}
    if panel.y_tick_labels:
        places, label = zip(*panel.y_tick_labels, strict=True)
        y_axis |= {
            "tickmode": "array",
            "tickvals": list(places),
            "ticktext": [plain(one) for one in label],
        }
    # On a narrow page there is no space next to the lines, so each label has a line of its own.
    inside = panel.row_labels or (panel.y_tick_labels if narrow else ())
    if inside:
        y_axis |= {"showticklabels": False, "ticks": ""}
        layout["annotations"] += [
            {
                "xref": f"x{suffix} domain", "yref": f"y{suffix}", "x": 0, "y": at, "xanchor": "left", "yanchor": "bottom",
                "yshift": 4 if panel.row_labels else _ABOVE_MARKS, "showarrow": False, "text": plain(one), "borderpad": 0,
                "bgcolor": theme.PAPER, "font": {"size": 10.5 if narrow else 11.5, "color": theme.MUTED},
            }
            for at, one in inside
        ]  # fmt: skip
    layout[f"yaxis{suffix}"] = common | y_axis
    _add_furniture(layout, panel, suffix, x_domain, y_domain, narrow, parted)


def _add_furniture(
    layout: dict[str, Any],
    panel: Panel,
    suffix: str,
    x_domain: list[float],
    y_domain: list[float],
    narrow: bool,
    parted: bool,
) -> None:
    notes, shapes, across = (
        layout["annotations"],
        layout["shapes"],
        {"xref": f"x{suffix}", "yref": f"y{suffix} domain"},
    )
    small = {"showarrow": False, "font": {"size": 11.5, "color": theme.MUTED}}
    for band in panel.bands:
        if band.shaded:
            box = {
                "type": "rect",
                "x0": band.first,
                "x1": band.last,
                "y0": 0,
                "y1": 1,
                "fillcolor": theme.BAND,
            }
            shapes.append(across | box | {"line": {"width": 0}, "layer": "below"})
        if band.label:
            notes.append(
                across
                | small
                | {
                    "x": (band.first + band.last) / 2,
                    "y": 1,
                    "yanchor": "bottom",
                    "text": plain(band.label),
                }
            )
    for level, rule in zip(rule_levels(panel, narrow), panel.rules, strict=True):
        thin_line = {
            "type": "line",
            "layer": "below",
            "line": {"color": theme.MUTED, "width": 1, "dash": "dot"},
        }
        if rule.axis == "x":
            shapes.append(
                across | thin_line | {"x0": rule.value, "x1": rule.value, "y0": 0, "y1": 1}
            )
            left_of_it = labelled_left(panel, rule, narrow)
            place: dict[str, Any] = across | {
                "x": rule.value,
                "y": LABEL_TOP - label_line(narrow) * level,
                "xanchor": "right" if left_of_it else "left",
                "yanchor": "top",
                "xshift": -3 if left_of_it else 3,
            }
        else:
            along = {"xref": f"x{suffix} domain", "yref": f"y{suffix}"}
            shapes.append(
                along | thin_line | {"x0": 0, "x1": 1, "y0": rule.value, "y1": rule.value}
            )
            end, above = rule_place(panel, rule, narrow)
            side = {"xanchor": "right", "yanchor": "bottom" if above else "top"}
            place = along | side | {"x": end, "y": rule.value}
        if rule.label:
            notes.append(place | small | {"text": plain(rule.label)})
    heights = label_heights(panel)
    for number, layer in enumerate(panel.layers):
        if isinstance(layer, Line) and number in heights:
            place = {
                "xref": f"x{suffix}",
                "yref": f"y{suffix}",
                "x": float(layer.x[-1]),
                "y": heights[number],
            }
            sentence = {"text": plain(layer.direct), "font": {"size": 12, "color": layer.colour}}
            notes.append(place | sentence | {"showarrow": False, "xanchor": "left", "xshift": 4})
    # The y label is set above the panel, level: a long word up the side of a low panel
    # would be cut off.
    corner = {
        "xref": "paper",
        "yref": "paper",
        "x": x_domain[0],
        "y": y_domain[1],
        "xanchor": "left",
        "yanchor": "bottom",
        "xshift": -20,
    }
    head = {
        "showarrow": False,
        "yshift": 20 if _has_named_bands(panel) else 5,
        "font": {"size": 12.5, "color": theme.MUTED},
        "align": "left",
    }
    parting = "<br>" if parted else "   "
    title = (
        f'<b><span style="color:{theme.INK}">{plain(panel.title)}</span></b>{parting}'
        if panel.title
        else ""
    )
    notes.append(corner | head | {"text": title + plain(panel.y_label)})


def plain(label: str) -> str:
    """Text with Plotly's markup escaped."""
    return label.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def _spaced(label: str, side: str) -> str:
    """Text next to a mark with a distance from it."""
    return {"middle right": f"  {label}", "middle left": f"{label}  "}.get(side, label)


def _trace(layer: Layer) -> dict[str, Any]:
    place = {"x": packed(layer.x), "y": packed(layer.y), "name": plain(layer.name)}
    if isinstance(layer, Line):
        style = {"color": layer.colour, "width": layer.width, "dash": layer.dash, "simplify": False}
        # Lines stay in SVG: a page with many WebGL contexts loses the first ones.
        return place | {
            "type": "scatter",
            "mode": "lines",
            "line": style,
            "hovertemplate": "%{x:.2f}, %{y:.4g}",
        }
    if isinstance(layer, Marks):
        symbol = _SYMBOLS.get(layer.symbol, "circle") + ("" if layer.filled else "-open")
        side = _SIDES[theme.LABEL_SIDES.get(layer.symbol, "top")]
        marker = {
            "symbol": symbol,
            "size": layer.size,
            "color": layer.colour,
            "line": {"width": 1.8, "color": layer.colour},
        }
        text_options = {
            "mode": "markers+text",
            "text": [_spaced(plain(label), side) for label in layer.labels],
            "textposition": side,
        }
        text = text_options if any(layer.labels) else {"mode": "markers"}
        text |= {} if layer.size else {"mode": "text"}
        caption = {"textfont": {"size": 11.5, "color": layer.colour}, "cliponaxis": False}
        return place | {"type": "scatter", "marker": marker, **_hover(layer)} | text | caption
    hover = f"%{{x:.1f}}, {plain(layer.y_tick_labels)} %{{y:.4g}}: %{{z:.4g}} {layer.unit}"
    second = {} if layer.second is None else {"customdata": packed(layer.second)}
    more = f" (%{{customdata:.4g}} {layer.second_unit})" if second else ""
    return (
        place
        | {"type": "heatmap", "z": packed(layer.z), "zsmooth": False, "hovertemplate": hover + more}
        | second
    )


def _colour_axis(heat: HeatMap, narrow: bool) -> dict[str, Any]:
    """Scale of a map: next to it on a wide page, below it on a narrow one."""
    stops = [
        [(index / (len(heat.colours) - 1)) ** (1 / heat.power), colour]
        for index, colour in enumerate(heat.colours)
    ]
    title = {
        "text": plain(f"{heat.name} ({heat.unit})"),
        "side": "top" if narrow else "right",
        "font": {"size": 12},
    }
    place = (
        {"orientation": "h", "y": 0, "yanchor": "top", "ypad": 50, "len": 1.0}
        if narrow
        else {"x": 1.0, "len": 0.9}
    )
    bar = place | {
        "title": title,
        "thickness": 10,
        "outlinewidth": 0,
        "tickfont": {"size": 11, "color": theme.MUTED},
    }
    room = {} if narrow else {"xpad": 54}  # names of lines are between the map and its scale
    return {"colorscale": stops, "cmin": heat.low, "cmax": heat.top, "colorbar": bar | room}


def _hover(marks: Marks) -> dict[str, Any]:
    if not marks.hints:
        return {"hovertemplate": "%{x:.2f}, %{y:.4g}"}
    return {"customdata": [plain(label) for label in marks.hints], "hovertemplate": "%{customdata}"}
