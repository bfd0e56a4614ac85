"""Charts as Plotly figures: plain JSON for the page, numbers packed in binary so that the page stays small."""

from __future__ import annotations

import base64
import json
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.report import theme
from valvetrain.report.chart import Chart, HeatMap, Layer, Line, Marks, Panel, legend_entries, rule_levels, shares_axis, visible_range

_SYMBOLS = {"circle": "circle", "diamond": "diamond", "triangle": "triangle-up", "square": "square"}
_SIDES = {"top": "top center", "right": "middle right", "left": "middle left", "bottom": "bottom center"}
_TOP, _BOTTOM, _LEFT, _RIGHT, _GAP_X, _GAP_Y, _GAP_SHARED = 50, 46, 64, 22, 74, 64, 34


def figure(chart: Chart) -> dict[str, Any]:
    """``data`` and ``layout`` of a chart for ``Plotly.newPlot``; numpy arrays are packed (see :func:`packed`)."""
    data: list[dict[str, Any]] = []
    layout = _base(chart)
    shown: set[str] = set()
    for index, panel in enumerate(chart.panels):
        suffix = "" if index == 0 else str(index + 1)
        _add_axes(layout, chart, panel, index, suffix)
        for layer in panel.layers:
            trace = _trace(layer) | {"xaxis": f"x{suffix}", "yaxis": f"y{suffix}"}
            if not isinstance(layer, HeatMap):
                trace |= {"legendgroup": layer.name, "showlegend": layer.in_legend and bool(layer.name) and layer.name not in shown}
                shown.add(layer.name if layer.in_legend else "")
            data.append(trace)
    return {"data": data, "layout": layout}


def to_json(chart: Chart) -> str:
    """The figure as JSON text that may stand inside a script element."""
    return json.dumps(figure(chart), separators=(",", ":"), allow_nan=False).replace("</", "<\\/")


def packed(values: ArrayLike) -> dict[str, str]:
    """Numbers as Plotly's typed-array form (32-bit floats, about seven digits)."""
    array = np.ascontiguousarray(np.asarray(values, dtype="<f4"))
    form = {"dtype": "f4", "bdata": base64.b64encode(array.tobytes()).decode()}
    return form | {"shape": ", ".join(map(str, array.shape))} if array.ndim > 1 else form


def unpacked(form: dict[str, str]) -> np.ndarray:
    """The numbers in a packed array, for whoever reads a figure back."""
    array = np.frombuffer(base64.b64decode(form["bdata"]), dtype="<f4")
    return array.reshape([int(part) for part in form["shape"].split(",")]) if "shape" in form else array


def _base(chart: Chart) -> dict[str, Any]:
    return {
        "height": chart.height, "margin": {"l": 0, "r": 0, "t": 0, "b": 0, "pad": 0}, "autosize": True,
        "paper_bgcolor": theme.PAPER, "plot_bgcolor": theme.PAPER, "hovermode": "closest", "dragmode": "zoom",
        "font": {"family": theme.FONT, "size": 13, "color": theme.INK},
        "hoverlabel": {"bgcolor": "#ffffff", "bordercolor": theme.RULE, "font": {"family": theme.FONT, "size": 12, "color": theme.INK}},
        "showlegend": chart.legend and len(legend_entries(chart)) > 0,
        "legend": {
            "orientation": "h", "x": 0, "xanchor": "left", "y": 1, "yanchor": "top", "bgcolor": "rgba(0,0,0,0)",
            "font": {"size": 12.5}, "itemsizing": "trace", "yref": "container", "xref": "container",
        },
        "annotations": [], "shapes": [],
    }  # fmt: skip


def _domain(chart: Chart, index: int) -> tuple[list[float], list[float]]:
    """Where a panel stands, as shares of the page width (taken as 960 px) and of the chart's height."""
    row, column = divmod(index, chart.columns)
    width, height = 960.0, float(chart.height)
    right = _RIGHT + (70 if any(isinstance(layer, HeatMap) for panel in chart.panels for layer in panel.layers) else 0)
    wide = (width - _LEFT - right - (chart.columns - 1) * _GAP_X) / chart.columns
    above = 10 if any(panel.title for panel in chart.panels) else 0 if any(panel.bands for panel in chart.panels) else -12
    top = (_TOP if chart.legend else _TOP - 26) + above
    gap = _GAP_SHARED if shares_axis(chart) else _GAP_Y
    high = (height - top - _BOTTOM - (chart.rows - 1) * gap) / chart.rows
    left, upper = _LEFT + column * (wide + _GAP_X), top + row * (high + gap)
    return [left / width, (left + wide) / width], [1 - (upper + high) / height, 1 - upper / height]


def _add_axes(layout: dict[str, Any], chart: Chart, panel: Panel, index: int, suffix: str) -> None:
    x_domain, y_domain = _domain(chart, index)
    x_range, y_range = visible_range(panel)
    common = {
        "gridcolor": theme.GRID, "linecolor": theme.RULE, "tickcolor": theme.RULE, "zeroline": False, "ticks": "outside", "ticklen": 4,
        "tickfont": {"size": 12, "color": theme.MUTED}, "automargin": False,
    }  # fmt: skip
    title = {"font": {"size": 12.5, "color": theme.MUTED}, "standoff": 6}
    layout[f"xaxis{suffix}"] = common | {
        "domain": x_domain, "anchor": f"y{suffix}", "range": list(x_range), "showgrid": False, "showline": True,
        "title": title | {"text": "" if shares_axis(chart) and index < len(chart.panels) - 1 else panel.x_label},
    }  # fmt: skip
    if panel.x_step:
        layout[f"xaxis{suffix}"] |= {"dtick": panel.x_step, "tick0": 0}
    if index and shares_axis(chart):
        layout[f"xaxis{suffix}"]["matches"] = "x"
    layout[f"yaxis{suffix}"] = common | {
        "domain": y_domain,
        "anchor": f"x{suffix}",
        "range": list(y_range),
        "showline": False,
        "title": title | {"text": panel.y_label},
    }
    if panel.y_log:
        decades = [float(np.log10(end)) for end in y_range]
        layout[f"yaxis{suffix}"] |= {"type": "log", "range": decades, "dtick": 1, "exponentformat": "none"}
    _add_furniture(layout, panel, suffix, x_domain, y_domain)


def _add_furniture(layout: dict[str, Any], panel: Panel, suffix: str, x_domain: list[float], y_domain: list[float]) -> None:
    notes, shapes, across = layout["annotations"], layout["shapes"], {"xref": f"x{suffix}", "yref": f"y{suffix} domain"}
    small = {"showarrow": False, "font": {"size": 11.5, "color": theme.MUTED}}
    for band in panel.bands:
        if band.shaded:
            box = {"type": "rect", "x0": band.first, "x1": band.last, "y0": 0, "y1": 1, "fillcolor": theme.BAND}
            shapes.append(across | box | {"line": {"width": 0}, "layer": "below"})
        if band.words:
            notes.append(across | small | {"x": (band.first + band.last) / 2, "y": 1, "yanchor": "bottom", "text": band.words})
    for level, rule in zip(rule_levels(panel), panel.rules, strict=True):
        thin_line = {"type": "line", "layer": "below", "line": {"color": theme.MUTED, "width": 1, "dash": "dot"}}
        if rule.axis == "x":
            shapes.append(across | thin_line | {"x0": rule.value, "x1": rule.value, "y0": 0, "y1": 1})
            place = across | {"x": rule.value, "y": 0.98 - 0.08 * level, "xanchor": "left", "yanchor": "top", "xshift": 3}
        else:
            along = {"xref": f"x{suffix} domain", "yref": f"y{suffix}"}
            shapes.append(along | thin_line | {"x0": 0, "x1": 1, "y0": rule.value, "y1": rule.value})
            place = along | {"x": 1, "y": rule.value, "xanchor": "right", "yanchor": "bottom"}
        if rule.words:
            notes.append(place | small | {"text": rule.words})
    for layer in panel.layers:
        if isinstance(layer, Line) and layer.direct and len(layer.x):
            place = {"xref": f"x{suffix}", "yref": f"y{suffix}", "x": float(layer.x[-1]), "y": float(layer.y[-1])}
            words = {"text": layer.direct, "font": {"size": 12, "color": layer.colour}}
            notes.append(place | words | {"showarrow": False, "xanchor": "left", "xshift": 4})
    if panel.title:
        place = {"xref": "paper", "yref": "paper", "x": x_domain[0], "y": y_domain[1], "xanchor": "left", "yanchor": "bottom"}
        bold = {"showarrow": False, "yshift": 17 if panel.bands else 5, "font": {"size": 13.5, "color": theme.INK}}
        notes.append(place | bold | {"text": f"<b>{panel.title}</b>"})


def _spaced(label: str, side: str) -> str:
    """Words beside a mark keep clear of it."""
    return {"middle right": f"  {label}", "middle left": f"{label}  "}.get(side, label)


def _trace(layer: Layer) -> dict[str, Any]:
    place = {"x": packed(layer.x), "y": packed(layer.y), "name": layer.name}
    if isinstance(layer, Line):
        style = {"color": layer.colour, "width": layer.width, "dash": layer.dash}
        # Lines stay in SVG: a page with many WebGL contexts loses the first ones.
        return place | {"type": "scatter", "mode": "lines", "line": style, "hovertemplate": "%{x:.2f}, %{y:.4g}"}
    if isinstance(layer, Marks):
        symbol = _SYMBOLS.get(layer.symbol, "circle") + ("" if layer.filled else "-open")
        side = _SIDES[theme.LABEL_SIDES.get(layer.symbol, "top")]
        marker = {"symbol": symbol, "size": layer.size, "color": layer.colour, "line": {"width": 1.8, "color": layer.colour}}
        words_shown = {"mode": "markers+text", "text": [_spaced(label, side) for label in layer.labels], "textposition": side}
        text = words_shown if any(layer.labels) else {"mode": "markers"}
        words = {"textfont": {"size": 11.5, "color": layer.colour}, "cliponaxis": False}
        return place | {"type": "scatter", "marker": marker, "hovertemplate": "%{x:.2f}, %{y:.4g}"} | text | words
    top = float(np.nanmax(layer.z, initial=0.0))
    stops = [[(index / (len(layer.colours) - 1)) ** (1 / layer.power), colour] for index, colour in enumerate(layer.colours)]
    bar = {"title": {"text": f"{layer.name} ({layer.unit})", "side": "right"}, "thickness": 10, "outlinewidth": 0, "len": 0.9, "x": 1.0}
    scale = {"colorscale": stops, "zmin": 0.0, "zmax": top or 1.0, "colorbar": bar | {"tickfont": {"size": 11, "color": theme.MUTED}}}
    hover = {"hovertemplate": f"%{{x:.1f}}, coil %{{y:.2f}}: %{{z:.4g}} {layer.unit}"}
    return place | {"type": "heatmap", "z": packed(layer.z), "zsmooth": False} | scale | hover
