"""A plotly figure as an SVG picture: lines, marks, bars and maps over rows of panels, drawn by the renderer of the reports."""

from __future__ import annotations

import numpy as np

from valvetrain.report import theme
from valvetrain.report.chart import Chart, HeatMap, Layer, Line, Marks, Panel, stems, thin
from valvetrain.report.svg_chart import svg

#: Kinds of traces that are drawn.
DRAWN = {"scatter", "scattergl", "bar", "heatmap"}


def svg_of(figure) -> str:
    """The picture. Raises ValueError for a kind of trace or axis that is not drawn here."""
    layout, panels = figure.layout, []
    unknown = {trace.type for trace in figure.data} - DRAWN
    if unknown:
        raise ValueError(f"traces of kind {', '.join(sorted(unknown))} are not drawn")
    for suffix in sorted(
        {(trace.yaxis or "y")[1:] for trace in figure.data}, key=lambda text: int(text or 1)
    ):
        traces = [
            (place, trace)
            for place, trace in enumerate(figure.data)
            if (trace.yaxis or "y")[1:] == suffix
        ]
        panels.append(
            _panel(traces, _axis(layout, "xaxis", suffix, figure), layout[f"yaxis{suffix}"], layout)
        )
    title = layout.title.text or ""
    return svg(
        Chart(
            "figure",
            title,
            "",
            tuple(panels),
            height=layout.height or 430,
            legend=layout.showlegend is not False,
        )
    )


def _axis(layout, kind: str, suffix: str, figure):
    """The x axis of a panel: its own where it is named, else the one it is tied to."""
    axis = layout[f"{kind}{suffix}"]
    if not axis.title.text and axis.matches:
        named = [layout[one] for one in layout if one.startswith(kind) and layout[one].title.text]
        return named[-1] if named else axis
    return axis


def _panel(traces, x_axis, y_axis, layout) -> Panel:
    layers: list[Layer] = []
    words: tuple[str, ...] = ()
    for place, trace in traces:
        colour = theme.SERIES[place % len(theme.SERIES)]
        if trace.type == "bar" and isinstance(trace.x[0], str):
            words = tuple(trace.x)
        layers += _layers(trace, colour)
    y_log = y_axis.type == "log"
    if x_axis.type == "log":
        raise ValueError("a logarithmic x axis is not drawn")
    x_range = tuple(x_axis.range) if x_axis.range else None
    if words:
        x_range = (0.4, len(words) + 0.6)
    y_range = tuple(y_axis.range) if y_axis.range and not y_log else None
    x_label = x_axis.title.text or ""
    if words:
        x_label = (x_label + ": " if x_label else "") + ", ".join(
            f"{place} {word}" for place, word in enumerate(words, 1)
        )
    return Panel(
        x_label,
        y_axis.title.text or "",
        tuple(layers),
        x_range=x_range,
        x_step=1.0 if words else None,
        y_range=y_range,
        y_log=y_log,
    )


def _layers(trace, colour: str) -> list[Layer]:
    name = trace.name or ""
    if trace.type == "heatmap":
        bar = trace.colorbar.title.text or ""
        words, _, unit = bar.rstrip(")").partition(" (")
        return [
            HeatMap(
                _numbers(trace.x),
                _numbers(trace.y),
                np.asarray(trace.z, dtype=float),
                words,
                unit or "1",
            )
        ]
    if trace.type == "bar":
        x = np.arange(1.0, len(trace.x) + 1) if isinstance(trace.x[0], str) else _numbers(trace.x)
        along, up = stems(x, _numbers(trace.y))
        return [Line(along, up, name, trace.marker.color or colour, width=28.0)]
    mode = trace.mode or "lines"
    x, y = _numbers(trace.x), _numbers(trace.y)
    shown = trace.showlegend is not False
    dash = trace.line.dash if trace.line.dash in ("dash", "dot", "dashdot") else "solid"
    line = Line(
        *thin(x, y),
        name,
        trace.line.color or colour,
        width=trace.line.width or 1.7,
        dash=dash,
        in_legend=shown,
    )
    texts = (
        tuple(str(one) for one in trace.text) if trace.text is not None and "text" in mode else ()
    )
    own = {}
    if trace.marker.symbol is not None:
        own = {"symbol": trace.marker.symbol, "size": trace.marker.size or 8.0, "filled": True}
    marks = Marks(
        x,
        y,
        name,
        trace.marker.color or trace.line.color or colour,
        **own,
        labels=texts,
        in_legend=shown and "lines" not in mode,
    )
    return [one for word, one in (("lines", line), ("markers", marks)) if word in mode]


def _numbers(values) -> np.ndarray:
    return np.asarray(values, dtype=float)
