"""Figures of an identification: unknowns within their priors, and computed less measured."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from valvetrain.explore.fit import MET
from valvetrain.explore.identification_rules import IdentificationFacts, data_name, plain_name
from valvetrain.views.style import BAD, LEAD, OTHER, SECOND, FigureSpec, styled

Array = NDArray[np.float64]
#: Rows of a figure.
ROWS = 24
#: Least scatters that a figure reaches to.
NEAR = 4.0


def figures_of(first: str) -> dict[str, FigureSpec]:
    """The figures by name, the one called ``first`` in front."""
    specs = {
        "unknowns": FigureSpec(
            "What the data leave of each unknown", "width of the figure: the prior; bars: 95 % intervals; red: not determined", unknowns
        ),
        "data": FigureSpec("Computed less measured", "bars: 95 % of the computed values; dashed: two scatters; orange: met, not used", data),
    }  # fmt: skip
    return {first: specs.pop(first)} | specs


def rows_figure(names: Sequence[str], at: Array, colours: list[str], title: str, ends: tuple[float, float]) -> go.Figure:  # fmt: skip
    """A dot with its bar in each row, and the start; ``at`` (rows, 4): value, low, high, start, cut off at the ``ends``."""
    names = [one if len(one) < 40 else f"{one[:18]} … {one[-18:]}" for one in names]
    best, low, high, start = np.clip(at, *ends).T
    bars = {"array": high - best, "arrayminus": best - low, "color": "#a9c4e4", "thickness": 5, "width": 0}  # fmt: skip
    stroke = {"color": OTHER, "size": 12, "symbol": "line-ns-open", "line": {"width": 2}}
    looks = {"start": stroke, "identified": {"color": colours, "size": 11}}
    fig = go.Figure([
        go.Scatter(x=x, y=names, name=name, mode="markers", marker=looks[name], error_x=error, hovertemplate="%{y}: %{x:.3~g}")
        for name, x, error in (("start", start, None), ("identified", best, bars))
    ])  # fmt: skip
    styled(fig, title, ("",), 130 + 26 * len(names))
    fig.update_layout(hovermode="closest", margin={"l": max(110, 7 * max(map(len, names)) + 20)})
    return fig.update_yaxes(autorange="reversed", dtick=1).update_xaxes(range=ends)


def unknowns(facts: IdentificationFacts) -> go.Figure:
    """Start, value and interval of each unknown as shares (per cent) of the range of its prior, the vaguest first."""
    result = facts.result
    order = np.argsort(facts.first.information.determined, kind="stable")[:ROWS].tolist()
    rows, colours = [], []
    for one in (result.unknowns[place] for place in order):
        low, high = one.prior.work_bounds if one.prior.flat else one.prior.work(one.prior.at([0.005, 0.995]))  # fmt: skip
        found = facts.first.quantities[one.name]
        values = np.array([found.best, found.low, found.high, result.start.get(one.name, np.nan)])
        rows.append(100 * (one.prior.work(values) - low) / (high - low))
        colours.append(BAD if facts.states[one.name] in ("tied", "open") else LEAD)
    names = [plain_name(result.names[place]) for place in order]
    return rows_figure(names, np.array(rows), colours, "share of the range of the prior, %", (-3, 103))  # fmt: skip


def data(facts: IdentificationFacts) -> go.Figure:
    """Computed less measured in scatters, at the start too, those that are missed most first."""
    chosen = sorted(facts.data(True) + facts.data(False), key=lambda one: -abs(one.off))[:ROWS]
    off = np.array([one.datum.deviation(np.array([one.best, one.low, one.high, one.start])) for one in chosen])  # fmt: skip
    reach = max(1.15 * abs(chosen[0].off), NEAR)
    colours = [BAD if abs(one.off) > MET else LEAD if one.datum.used else SECOND for one in chosen]
    names = [data_name(one.datum) for one in chosen]
    fig = rows_figure(names, off, colours, "computed less measured, scatters", (-reach, reach))
    for at in (-MET, MET):
        fig.add_vline(at, line={"color": OTHER, "width": 1, "dash": "dash"})
    return fig
