"""The one look of all figures: colours by meaning, lines in single precision, panels that share an axis."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import ArrayLike

from valvetrain.arrays import Array
from valvetrain.findings.facts import Facts, over_turn
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.solution.result import Solution
from valvetrain.units.reader import reader_factor, reader_text, reader_unit

#: Colours by meaning: what decides, what stands next to it, rigid parts, the second quantity, and the marks.
LEAD, OTHER, RIGID, SECOND, BAD, OK = (
    "#1f5fa8", "#8a8f98", "#a9b0b9", "#e07b28", "#c62f2f", "#2f8f4e",
)  # fmt: skip
#: Colours of engine speeds or variants, in order.
SPEEDS = ("#1f5fa8", "#e07b28", "#7a3fa0", "#2f8f4e", "#b23a48", "#5b6b7a")
ANGLE = "cam angle, deg (2 crank deg each)"
#: Share of the lift from which a window over the cam angle begins, and room (deg) before and behind it.
SHUT, BEFORE, BEHIND = 0.004, 18.0, 34.0


@dataclass(frozen=True)
class FigureSpec:
    """A declared figure: its ``title``, a ``hint`` on what it shows, and its maker from the facts of an answer, which gives
    None without data.
    """

    title: str
    hint: str
    make: Callable[[Any], go.Figure | None]


#: Letters of an axis title that a narrow page has for the zero of its angle.
ROOM = 20


def angle_title(facts: Facts, run: Solution) -> str:
    """Title of an axis of cam angles: where lift is full, and what zero is as far as the case says it."""
    zero = facts.study.record.zero_of_angle.replace(
        "cam deg before top dead centre", "before TDC"
    ).partition(";")[0]
    nose = math.degrees(facts.nose(run).value)
    return f"cam angle, deg (full lift {nose:.0f}{f'; 0: {zero}' if 0 < len(zero) <= ROOM else ''})"


def panels(heights: tuple[float, ...]) -> go.Figure:
    """An empty figure with panels below each other that share their x axis; ``heights`` are shares."""
    from plotly.subplots import make_subplots  # loads all of the library; many answers draw nothing

    return make_subplots(
        len(heights), 1, shared_xaxes=True, row_heights=list(heights), vertical_spacing=0.06
    )


def styled(fig: go.Figure, x: str, y: tuple[str, ...], height: int = 360) -> go.Figure:
    """The figure with axis titles and the look of all: no box, a light grid, no ground of its own.

    Parameters
    ----------
    fig : with a panel per title in ``y``
    x : title of the x axis of the lowest panel
    y : titles of the y axes, from the top
    height : px
    """
    fig.update_layout(
        template="none", height=height, margin={"l": 62, "r": 14, "t": 30, "b": 44}, hovermode="x unified",
        font={"family": "system-ui, sans-serif", "size": 13, "color": "#333"}, paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)", legend={"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0},
    )  # fmt: skip
    fig.update_xaxes(
        gridcolor="#e6e8eb", zeroline=False, ticks="outside", ticklen=4, tickcolor="#c4c8cd"
    )
    fig.update_yaxes(gridcolor="#e6e8eb", zeroline=False, nticks=6)
    for place, title in enumerate(y):
        fig.layout[f"yaxis{place + 1 if place else ''}"].title.update(text=title, font={"size": 12})
    fig.layout[f"xaxis{len(y) if len(y) > 1 else ''}"].title.update(text=x, font={"size": 12})
    return fig


def red_line(fig: go.Figure, engine_speed: float, word: str = "red line") -> None:
    """Mark the highest ``engine_speed`` in use (rpm) across all panels; nothing where it is not finite."""
    if math.isfinite(engine_speed):
        fig.add_vline(engine_speed, line={"color": BAD, "width": 1.4, "dash": "dash"})
        fig.add_annotation(
            x=engine_speed, y=1.0, yref="paper", yanchor="bottom", text=word, showarrow=False, font={"size": 11, "color": BAD},
        )  # fmt: skip


def line(
    x: ArrayLike, y: ArrayLike, name: str, colour: str, dash: str = "solid", **more: Any
) -> go.Scatter:
    """A line in single precision, which halves a page; of many samples the extremes of every interval."""
    at, values = thinned(np.asarray(x, np.float64), np.asarray(y, np.float64))
    return go.Scatter(
        x=at.astype(np.float32), y=values.astype(np.float32), name=name, mode="lines",
        line={"color": colour, "dash": dash, "width": 1.8}, hovertemplate="%{y:.4~g}", **more,
    )  # fmt: skip


def dots(x: ArrayLike, y: ArrayLike, name: str, colour: str) -> go.Scatter:
    """Single points, as :func:`line`."""
    return line(x, y, name, colour).update(mode="markers", marker={"color": colour, "size": 3})


def band(
    x: ArrayLike, low: ArrayLike, high: ArrayLike, name: str, colour: str = OTHER
) -> tuple[go.Scatter, go.Scatter]:
    """The ground between two curves, named ``name``; both traces belong to one panel and come first."""
    edge = {"color": colour, "width": 0}
    ends = line(x, low, "", colour), line(x, high, name, colour)
    ends[0].update(line=edge, showlegend=False, hoverinfo="skip", hovertemplate=None)
    ends[1].update(line=edge, fill="tonexty", opacity=0.5, hoverinfo="skip", hovertemplate=None)
    return ends


def thinned(x: Array, y: Array, most: int = 3000) -> tuple[Array, Array]:
    """At most about ``most`` points of a curve, with the least and the largest value of every interval.

    >>> x, y = thinned(np.arange(10000.0), np.sin(np.arange(10000.0)), 100)
    >>> len(x) <= 102, bool(y.max() > 0.99)
    (True, True)
    """
    if len(x) <= most:
        return x, y
    size = -(-2 * len(x) // most)
    whole = len(x) // size * size
    blocks = np.nan_to_num(y[:whole]).reshape(-1, size)
    starts = np.arange(0, whole, size)
    chosen = (starts + blocks.argmin(1), starts + blocks.argmax(1), np.array([0, len(x) - 1]))
    places = np.unique(np.concatenate(chosen))
    return x[places], y[places]


def degrees(run: Solution) -> Array:
    """Cam angle (deg) of the samples of a run's cycle."""
    return np.asarray(np.degrees(reported_cycle(run).cam_angle))


def window(run: Solution) -> tuple[float, float]:
    """Cam angles (deg) between which the valve is open, with some room."""
    lift, angle = over_turn(run, "valve_lift"), degrees(run)
    there = angle[lift > SHUT * lift.max()]
    if not there.size:
        return 0.0, 360.0
    return max(0.0, float(there.min()) - BEFORE), min(360.0, float(there.max()) + BEHIND)


def in_reader_units(fig: go.Figure) -> go.Figure:
    """The figure with every axis in the units of the reader, by the unit at the end of its title; what is drawn and
    written at it too.
    """
    factors = {f"{xy}{axis.plotly_name[5:]}": reader_factor(_unit(fig, axis))
               for xy, axes in (("x", fig.select_xaxes()), ("y", fig.select_yaxes())) for axis in axes}  # fmt: skip
    for trace in fig.select_traces():
        for key in "xy":
            factor = factors.get(getattr(trace, f"{key}axis") or key, 1.0)
            if factor != 1 and trace[key] is not None:
                values = np.asarray(trace[key], float) * factor
                trace.update({key: values.astype(np.float32)})
        if trace.type == "heatmap" and (unit := trace.colorbar.title.text):
            trace.z = (np.asarray(trace.z, float) * reader_factor(unit)).astype(np.float32)
            trace.colorbar.title.text = reader_unit(unit)
        if isinstance(trace.text, tuple | list):
            trace.text = [reader_text(str(one)) for one in trace.text]
        trace.name = trace.name and reader_text(trace.name)
    for one in (*fig.layout.shapes, *fig.layout.annotations):
        for key in ("x", "x0", "x1", "y", "y0", "y1"):
            factor = factors.get(one[f"{key[0]}ref"] or key[0], 1.0)
            if factor != 1 and key in one and one[key] is not None:
                one[key] *= factor
    for one in fig.layout.annotations:
        one.text = reader_text(one.text or "")
    for axis in (*fig.select_xaxes(), *fig.select_yaxes()):
        head, comma, unit = (axis.title.text or "").rpartition(", ")
        factor = reader_factor(_unit(fig, axis))
        if axis.range and factor != 1:
            axis.range = [float(end) * factor for end in axis.range]
        axis.title.text = f"{head}{comma}{reader_unit(unit)}"
    return fig


def _unit(fig: go.Figure, axis: Any) -> str:
    """The unit at the end of the title of an axis, or of the one that it goes along with."""
    title = axis.title.text or ""
    if not title and axis.matches:
        title = fig.layout[f"{axis.matches[0]}axis{axis.matches[1:]}"].title.text or ""
    return str(title.rpartition(", ")[2])
