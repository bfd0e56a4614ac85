"""Figures of a search: the case and the best design, the front, the objective over what is varied, and the progress."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import plotly.graph_objects as go

from valvetrain.explore.optimum_facts import SearchFacts
from valvetrain.findings.words import RPM, speed_text
from valvetrain.solution.definition import definition_of, shown
from valvetrain.views.style import (
    ANGLE,
    BAD,
    BEFORE,
    BEHIND,
    LEAD,
    OK,
    OTHER,
    SPEEDS,
    FigureSpec,
    line,
    panels,
    styled,
)

#: Names of the x axes of the curves, with what a value (SI) is divided by.
AXES = {"engine_speed": ("engine speed, rpm", RPM), "cam_angle": (ANGLE, np.pi / 180), "compression": ("compression, mm", 1e-3)}  # fmt: skip
#: Room above the forces but for short peaks; share of the lift from which a valve counts as open.
ROOM, OPEN = 1.3, 0.02


def figures(facts: SearchFacts) -> Mapping[str, FigureSpec]:
    """The figures by name; the one that shows the verdict first."""
    speed = next((one.engine_speed for one in facts.found.curves if one.engine_speed), 0.0)
    hint = f"at {speed_text(speed)}" if speed else ""
    first = {
        "compared": FigureSpec(f"The case and the {facts.name} design", hint, _compared),
        "designs": FigureSpec("Designs that were computed", "", _designs),
    }  # fmt: skip
    if facts.several or facts.slight:
        first = dict(reversed(first.items()))
    return first | {"progress": FigureSpec("Best value after each trial", "", _progress)}


def _compared(facts: SearchFacts) -> go.Figure | None:
    """The curves that the search kept of the case and of the best design, each quantity in a panel."""
    curves, plan = facts.found.curves, facts.found.plan
    if not curves:
        return None
    names = list(dict.fromkeys(one.quantity for one in curves))
    axis, size = AXES[curves[0].across]
    fig = panels((0.62, 0.38)[: len(names)])
    for one in curves:
        colour, dash = (OTHER, "dash") if one.design == "case" else (LEAD, "solid")
        row, y = names.index(one.quantity), shown(one.quantity, one.y)[0]
        fig.add_trace(line(one.x / size, y, one.design, colour, dash, legendgroup=one.design, showlegend=not row), row + 1, 1)  # fmt: skip
    bounds = [facts.found.bound_of_limit(one) for one in plan.measures if one.limit is not None]
    bounds += [one.bound for one in plan.constraints if one.measure.quantity.endswith(f"_{names[0]}")]  # fmt: skip
    for bound in filter(np.isfinite, bounds[:2]):
        fig.add_hline(float(shown(names[0], bound)[0]), line={"color": BAD, "width": 1, "dash": "dash"}, row=1)  # fmt: skip
    styled(fig, axis, tuple(f"{definition_of(one).label}, {definition_of(one).unit_word}" for one in names), 400)  # fmt: skip
    if curves[0].across == "cam_angle":
        top = ROOM * float(np.percentile(np.concatenate([one.y for one in curves[::len(names)]]), 99))  # fmt: skip
        fig.update_yaxes(range=[-0.04 * top, top], row=1, col=1)
        there = np.concatenate([one.x[one.y > OPEN * one.y.max()] for one in curves if one.quantity == names[-1]])  # fmt: skip
        low, high = np.degrees([there.min(), there.max()])
        fig.update_xaxes(range=[max(0.0, low - BEFORE), min(360.0, high + BEHIND)])
    return fig


def _designs(facts: SearchFacts) -> go.Figure | None:
    """Two objectives of the designs; else the objective over the one quantity that was varied, or in colour over two."""
    found, plan, several = facts.found, facts.found.plan, facts.several
    trials = [one for one in found.trials if np.all(np.isfinite([*one.values, *one.objectives]))]
    goals = [
        (_axis(facts, k), [facts.number(each.measure, float(one.objectives[k])) for one in trials])
        for k, each in enumerate(plan.objectives)
    ]
    axes = [
        (each.axis_label.replace(" (", ", ").rstrip(")"), [each.shown(float(one.values[k])) for one in trials])
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
    """The best value that meets every bound after each trial, a line for each seed."""
    found = facts.found
    if facts.several or not found.feasible:
        return None
    fig = panels((1.0,))
    for seed, colour in zip(found.seeds, SPEEDS * len(found.seeds), strict=False):
        values = [facts.number(facts.goal, float(one)) for one in found.history(seed)]
        fig.add_scatter(y=values, name=f"seed {seed}", mode="lines", line={"color": colour, "shape": "hv"})  # fmt: skip
    return styled(fig, "trial", (_axis(facts),), 300)
