"""Figures of a study of points: an output over what is varied, and what moves it."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from valvetrain.explore.study_facts import StudyFacts
from valvetrain.explore.table import run_label
from valvetrain.findings.words import speed_text
from valvetrain.solution.definition import definition_of, label_of, shown
from valvetrain.views.style import LEAD, OK, OTHER, SPEEDS, FigureSpec, styled

Array = NDArray[np.float64]
#: Dots of a cloud, lines of a figure, points of a list and letters of a name.
DOTS, LINES, POINTS, LETTERS = 1500, 6, 40, 42


def figures_of_study(facts: StudyFacts) -> dict[str, FigureSpec]:
    """Two figures of each output, the one that shows the verdict first: of draws what moves it, of chosen points the output
    over what is varied.
    """
    several = len(facts.changing) > 1 and not facts.listed
    specs: dict[str, FigureSpec] = {}
    for name in facts.outputs:
        label = label_of(name)
        over = FigureSpec(
            f"{label[:1].upper()}{label[1:]}",
            "dashed: the first point" if facts.listed else "",
            partial(_over, name=name),
        )
        effects = FigureSpec(
            f"What moves {label}",
            "shares of the variance with their 95 % intervals",
            partial(_effects, name=name),
        )
        both = {name: over} | ({f"{name}-effects": effects} if several else {})
        specs |= both if facts.chosen else dict(reversed(both.items()))
    return specs


def _axis(name: str) -> str:
    row = definition_of(name)
    return f"{row.label}, {row.unit_word}" if row.shown_unit else row.label


def _values(facts: StudyFacts, name: str) -> Array:
    return np.asarray(shown(name, facts.column(name))[0])


def _over(facts: StudyFacts, name: str) -> go.Figure | None:
    """An output at the points of a list, over two quantities of a grid as colour, else over the quantity that moves it most."""
    table, y, speeds = facts.table, _values(facts, name), len(facts.designs[0])
    if np.count_nonzero(np.isfinite(y)) < 2 or not facts.changing:
        return None
    if facts.listed:
        return _points(facts, name)
    if table.plan.sampler.word == "grid" and len(facts.changing) == 2 and (speeds > LINES or len(facts.along) == 2):  # fmt: skip
        return _map(facts, name)
    order = [one.varied for one in facts.effects(name)] or [table.plan.varied[facts.changing[0]]]
    wanted = [table.plan.varied[k] for k in facts.along or facts.changing]
    varied = next((one for one in order if one in wanted), wanted[0])
    x = table.column(varied.name) * varied.shown(1.0)
    fig = go.Figure()
    lines = facts.chosen and len(facts.along or facts.changing) == 1
    for place, (label, rows) in enumerate(_series(facts).items()):
        rows = rows[np.argsort(x[rows], kind="stable")][:: max(1, len(rows) // DOTS)]
        fig.add_trace(go.Scatter(
            x=x[rows].astype(np.float32), y=y[rows].astype(np.float32), name=label, mode="lines+markers" if lines else "markers",
            marker={"color": SPEEDS[place % len(SPEEDS)], "size": 7 if lines else 4}, showlegend=bool(label), hovertemplate="%{y:.4~g}",
        ))  # fmt: skip
    _mark(fig, facts, name, x, y)
    return styled(fig, varied.axis_label, (_axis(name),), 400)


def _mark(fig: go.Figure, facts: StudyFacts, name: str, x: NDArray[Any], y: NDArray[Any]) -> None:
    """A star at the best point, at its worst run, by its row in x and y; none of other outputs and without a best point."""
    if (
        name == facts.outputs[0]
        and "best" in facts.ends
        and not (facts.within_bar or facts.over_speed)
    ):
        rows = (
            np.arange(len(facts.table))
            .reshape(len(facts.draws), -1)[facts.designs[facts.ends["best"]]]
            .ravel()
        )
        k = rows[np.argmin(facts.sign(name) * facts.column(name)[rows])]
        star = {"color": OK, "size": 14, "symbol": "star"}
        fig.add_scatter(x=[x[k]], y=[y[k]], mode="markers", name="best", marker=star, showlegend=True)  # fmt: skip


def _series(facts: StudyFacts) -> dict[str, NDArray[np.intp]]:
    """What is drawn as one line -> its rows: the points of a run, or those of an engine speed that is varied."""
    table, count = facts.table, len(facts.table.plan.runs)
    if len(facts.designs[0]) > 1 and count == 1:
        speeds = table.column("engine_speed")
        return {speed_text(one): np.flatnonzero(speeds == one) for one in np.unique(speeds)}
    return {run_label(run) * (count > 1): table.rows_of(run) for run in table.plan.runs}


def _points(facts: StudyFacts, name: str) -> go.Figure | None:
    """The value at every point of a list, a dot for each run."""
    table, count = facts.table, len(facts.draws)
    if not 2 <= count <= POINTS or len(facts.designs) != count:
        return None
    names, values = [_short(facts.label(k), k) for k in range(count)], _values(facts, name)
    fig = go.Figure([
        go.Scatter(x=values[table.rows_of(run)], y=names, mode="markers", name=run_label(run), showlegend=len(table.plan.runs) > 1,
                   marker={"color": SPEEDS[place % len(SPEEDS)], "size": 11}, hovertemplate="%{x:.4~g}")
        for place, run in enumerate(table.plan.runs)
    ])  # fmt: skip
    _mark(fig, facts, name, values, np.repeat(names, len(table.plan.runs)))
    if np.isfinite(values[0]):
        fig.add_vline(float(values[0]), line={"color": OTHER, "width": 1, "dash": "dash"})
    return _named_rows(fig, _axis(name), count)


def _short(label: str, place: int) -> str:
    return label if len(label) <= LETTERS else f"point {place + 1}"


def _named_rows(fig: go.Figure, x: str, count: int) -> go.Figure:
    """A figure whose rows have names, from the top."""
    styled(fig, x, ("",), 120 + 30 * count)
    fig.update_layout(hovermode="closest", margin={"l": 260})
    return fig.update_yaxes(autorange="reversed", dtick=1, automargin=True)


def _map(facts: StudyFacts, name: str) -> go.Figure:
    """An output over the two varied quantities of a grid as colour, by the run that decides."""
    varied, rows = [facts.table.plan.varied[k] for k in facts.changing], facts.table.rows_of(facts.run)  # fmt: skip
    x, y = (facts.table.column(one.name) * one.shown(1.0) for one in varied)
    bar = {"title": {"text": _axis(name), "side": "right"}}
    z = _values(facts, name)[rows]
    fig = go.Figure(go.Heatmap(x=x[rows], y=y[rows], z=z, colorscale="Viridis", colorbar=bar, hovertemplate="%{z:.4~g}"))  # fmt: skip
    _mark(fig, facts, name, x, y)
    return styled(fig, varied[0].axis_label, (varied[1].axis_label,), 420)


def _effects(facts: StudyFacts, name: str) -> go.Figure | None:
    """Shares of the variance (per cent) by varied quantity with their 95 % intervals, the largest first."""
    effects = facts.effects(name)
    if not effects:
        return None
    shares, low, high = 100 * np.clip([(one.share, one.low, one.high) for one in effects], 0, 1.2).T
    fig = go.Figure(go.Scatter(
        x=shares, y=[_short(one.varied.shown_name, k) for k, one in enumerate(effects)], mode="markers", hovertemplate="%{x:.2~g} %",
        marker={"color": LEAD, "size": 11}, error_x={"symmetric": False, "array": high - shares, "arrayminus": shares - low, "color": OTHER},
    ))  # fmt: skip
    fig.update_xaxes(range=[-3, max(103.0, float(high.max()) + 3)])
    return _named_rows(fig, "share of the variance, %", len(effects))
