"""Figures of a search: the designs that were computed, and the progress."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import plotly.graph_objects as go

from valvetrain.explore.optimum_facts import SearchFacts
from valvetrain.views.style import LEAD, OK, OTHER, FigureSpec, panels, styled


def figures(facts: SearchFacts) -> Mapping[str, FigureSpec]:
    """The figures by name; the one that shows the verdict first."""
    return {
        "designs": FigureSpec("Designs that were computed", "", _designs),
        "progress": FigureSpec("Best value after each trial", "", _progress),
    }


def _designs(facts: SearchFacts) -> go.Figure | None:
    """Two objectives of the designs; else the objective over the one quantity that was varied, or in colour over two."""
    found, plan, several = facts.found, facts.found.plan, facts.several
    trials = [one for one in found.trials if np.all(np.isfinite([*one.values, *one.objectives]))]
    goals = [
        (_axis(facts, k), [facts.number(each.measure, float(one.objectives[k])) for one in trials])
        for k, each in enumerate(plan.objectives)
    ]
    axes = [
        (each.axis_label, [each.shown(float(one.values[k])) for one in trials])
        for k, each in enumerate(plan.varied)
    ]  # fmt: skip
    if len(trials) < 2 or (len(axes) > 2 and not several):
        return None
    (across, x), (up, y) = goals[:2] if several else [*axes, *goals][:2]
    fig, met = panels((1.0,)), np.array([one.feasible for one in trials])
    for name, at, colour in (("misses a bound", ~met, "#c9ced4"), ("meets every bound", met, LEAD)):
        marker: dict[str, Any] = {"color": colour, "size": 6}
        if len(axes) == 2 and not several and colour == LEAD:
            label, heights = goals[0]
            marker |= {"color": np.array(heights)[at], "colorscale": "Viridis", "colorbar": {"title": {"text": label, "side": "right"}}}  # fmt: skip
        if at.any():
            fig.add_scatter(x=np.array(x)[at], y=np.array(y)[at], name=name, mode="markers", marker=marker)  # fmt: skip
    if several and found.best is not None:
        order = [trials.index(one) for one in found.front]
        fig.add_scatter(x=[x[k] for k in order], y=[y[k] for k in order], name="front", mode="lines", line={"color": LEAD})  # fmt: skip
    for name, trial, colour, symbol in (("case", found.case, OTHER, "diamond"), (facts.name, facts.trial, OK, "star")):  # fmt: skip
        if trial in trials:
            k = trials.index(trial)
            fig.add_scatter(x=[x[k]], y=[y[k]], name=name, mode="markers", marker={"color": colour, "size": 13, "symbol": symbol})  # fmt: skip
    return styled(fig, across, (up,), 380).update_layout(hovermode="closest")


def _axis(facts: SearchFacts, place: int = 0) -> str:
    one = facts.found.plan.objectives[place].measure
    return f"{one.label}, {one.unit}".rstrip(", ") if facts.found.plan.case is not None else one.label  # fmt: skip


def _progress(facts: SearchFacts) -> go.Figure | None:
    """The best value that meets every bound after each trial."""
    found = facts.found
    if facts.several or not found.feasible:
        return None
    fig = panels((1.0,))
    values = [facts.number(facts.goal, float(one)) for one in found.history()]
    fig.add_scatter(y=values, mode="lines", line={"color": LEAD, "shape": "hv"})
    return styled(fig, "trial", (_axis(facts),), 300)
