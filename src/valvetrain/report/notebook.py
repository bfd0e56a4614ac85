"""Results in a notebook: verdict and picture of a result's page, below them its first table; the
picture by plotly as well.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from html import escape
from typing import TYPE_CHECKING

from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.report import plotly_chart
from valvetrain.report.chart import Chart, HeatMap
from valvetrain.report.page import Block, Figure, Grid, Page, Text
from valvetrain.report.svg_chart import svg
from valvetrain.report.verdict import verdict_of
from valvetrain.solution.display import heading, table

if TYPE_CHECKING:
    import plotly.graph_objects as go

#: Room in px above the panels of a figure that carries its title, and below them for its legend.
_TITLE, _LEGEND = 64, 90


def html_of(result: object) -> str:
    """Verdict, picture, text and first table of a result; a part that cannot be shown is left out."""
    blocks = _shown(result)
    grid = next((one for one in blocks if isinstance(one, Grid)), None)
    rows = [[cell.text for cell in cells] for cells, _ in grid.rows] if grid else []
    text = repr(result).removeprefix(verdict_of(result)).strip()
    return _opening(result, blocks) + table(text, grid.headers if grid else (), rows)


def picture_of(result: object) -> str:
    """Verdict and first figure (SVG) of a result; what it does not have is left out."""
    return _opening(result, _shown(result))


def figure_of(result: object) -> go.Figure:
    """The first figure of a result by plotly.

    Raises :class:`InputError` where the result holds nothing to draw, with the reason.
    """
    blocks = list(_blocks(result))
    chart = _first_chart(blocks)
    if chart is None:
        reasons = [one.html for one in blocks if isinstance(one, Text) and one.gap]
        reason = reasons[0] if reasons else f"this {type(result).__name__} holds nothing to draw"
        raise InputError(reason)
    return plotly_figure(chart, heading(result))


def plotly_figure(chart: Chart, title: str) -> go.Figure:
    """A chart as a figure for use alone: with title, legend and labels of the axes."""
    import plotly.graph_objects as go

    drawn, named = plotly_chart.figure(chart), set[str]()
    layers = [layer for panel in chart.panels for layer in panel.layers]
    for layer, trace in zip(layers, drawn["data"], strict=True):
        trace |= {"x": layer.x, "y": layer.y}
        if isinstance(layer, HeatMap):
            trace |= {"z": layer.z}
            continue
        trace["showlegend"] = layer.in_legend and bool(layer.name) and layer.name not in named
        named.add(layer.name)
    layout = drawn["layout"]
    notes = layout["annotations"]  # what is level above a panel on the page goes along its axis
    layout["annotations"] = [note for note in notes if note.get("xref") != "paper"]
    for index, panel in enumerate(chart.panels):
        label = f"{panel.title}: {panel.y_label}" if panel.title else panel.y_label
        axis = layout[f"yaxis{index + 1 if index else ''}"]
        axis |= {"title": {"text": plotly_chart.plain(label)}, "automargin": True}
    margin = layout["margin"]
    layout |= {
        "title": {"text": plotly_chart.plain(title), "font": {"size": 14}},
        "showlegend": True,
        "legend": {"orientation": "h", "yref": "container", "y": 0, "yanchor": "bottom"},
        "height": layout["height"] + _TITLE + _LEGEND,
        "margin": margin | {"t": margin["t"] + _TITLE, "b": margin["b"] + _LEGEND},
    }
    return go.Figure({"data": drawn["data"], "layout": layout})


def _blocks(result: object) -> Iterator[Block]:
    """Blocks of the page of a result, in their order."""
    made = registry.find("results", type(result).__name__)(result)
    if isinstance(made, Page):
        yield from made.picture
        for section in made.sections:
            yield from section.blocks
    else:
        yield from made


def _shown(result: object) -> list[Block]:
    """The same; none where they cannot be made, for a display must never cost the result."""
    try:
        return list(_blocks(result))
    except Exception:
        return []


def _first_chart(blocks: list[Block]) -> Chart | None:
    return next((one.chart for one in blocks if isinstance(one, Figure)), None)


def _opening(result: object, blocks: list[Block]) -> str:
    sentence = verdict_of(result)
    return (f"<p><strong>{escape(sentence)}</strong></p>" if sentence else "") + _picture(blocks)


def _picture(blocks: list[Block]) -> str:
    chart = _first_chart(blocks)
    with suppress(Exception):  # as in _shown
        return "" if chart is None else f'<div style="max-width:60em">{svg(chart)}</div>'
    return ""
