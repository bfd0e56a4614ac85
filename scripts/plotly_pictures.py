"""Pictures of the documentation by plotly, in the look of the pages: panels of curves with thin lines at values that matter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import plotly.graph_objects as go
from numpy.typing import ArrayLike
from plotly.subplots import make_subplots

from valvetrain.views.style import LEAD, OTHER, line, styled

#: Width of a picture and height of a row of panels (px).
WIDTH, HEIGHT = 900, 300


@dataclass(frozen=True)
class Panel:
    """Traces over titled axes; ``rules``: axis, value and text of each thin line; ranges where plotly's own do not do."""

    x: str
    y: str
    traces: Sequence[go.Scatter | go.Bar]
    title: str = ""
    rules: Sequence[tuple[str, float, str]] = ()
    x_range: tuple[float, float] | None = None
    y_range: tuple[float, float] | None = None


def curve(
    x: ArrayLike, y: ArrayLike, name: str = "", colour: str = LEAD, dash: str = "solid"
) -> go.Scatter:
    """A curve, in the key where it has a name."""
    return line(x, y, name, colour, dash, showlegend=bool(name))


def dots(x: ArrayLike, y: ArrayLike, name: str, colour: str) -> go.Scatter:
    """Marks without a line."""
    return go.Scatter(x=x, y=y, name=name, mode="markers", marker={"color": colour, "size": 8})


def drawn(title: str, panels: Sequence[Panel]) -> go.Figure:
    """A figure of one panel, or of panels in two columns."""
    columns = min(2, len(panels))
    rows = -(-len(panels) // columns)
    titles = [one.title for one in panels]
    fig = make_subplots(rows, columns, subplot_titles=titles, vertical_spacing=0.38 / rows)
    styled(fig, "", ("",), 110 + HEIGHT * rows)
    named = set[str]()
    for place, one in enumerate(panels):
        where = {"row": place // columns + 1, "col": place % columns + 1}
        for trace in one.traces:
            trace.showlegend = bool(trace.name) and trace.name not in named
            named.add(trace.name or "")
            fig.add_trace(trace, **where)
        for axis, at, text in one.rules:
            add = fig.add_vline if axis == "x" else fig.add_hline
            add(at, line={"color": OTHER, "width": 1, "dash": "dot"}, annotation={"text": text, "font": {"size": 11}}, **where)  # fmt: skip
        fig.update_xaxes(title={"text": one.x, "font": {"size": 12}}, range=one.x_range, **where)
        fig.update_yaxes(title={"text": one.y, "font": {"size": 12}}, range=one.y_range, **where)
    return fig.update_layout(
        title={"text": title, "font": {"size": 15}, "x": 0.01, "y": 1, "yanchor": "top", "pad": {"t": 12}},
        margin={"l": 64, "r": 20, "t": 84, "b": 48}, legend={"y": 0.93, "yref": "container", "yanchor": "top"},
    )  # fmt: skip


def save(figure: go.Figure, path: Path) -> None:
    """Write a figure on white ground, which reads on a dark page too."""
    figure.update_layout(paper_bgcolor="white").write_image(path, width=WIDTH)
