"""Figures of a search: how the best value went, the front of several objectives, the objective over
what is varied.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.measure import Measure
from valvetrain.explore.optimum import Optimum
from valvetrain.explore.space import Varied
from valvetrain.explore.trial import Trial
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Marks, Panel
from valvetrain.report.text import unit_text

Array = NDArray[np.float64]
#: Height (px) of a row of panels.
ROW = 260
FEASIBLE, MISSES, CASE, BEST = theme.SERIES[0], theme.RULE, theme.SERIES[1], theme.SERIES[2]


def measure_label(one: Measure) -> str:
    """A measure with its unit, as an axis bears it."""
    return f"{one.label} ({unit_text(one.unit)})" if one.unit else one.label


def convergence_chart(found: Optimum) -> Chart | None:
    """The best feasible value after each trial, of every seed, and the trials."""
    goal = found.plan.objectives[0]
    if len(found.plan.objectives) > 1 or not found.feasible:
        return None
    one, layers = goal.measure, list[Layer]()
    for index, seed in enumerate(found.seeds):
        history = np.array([one.shown(float(value)) for value in found.history(seed)])
        there = np.flatnonzero(np.isfinite(history))
        if not len(there):
            continue
        name = "best so far" if len(found.seeds) == 1 else f"best so far, seed {seed}"
        x, y = np.repeat(there, 2)[1:].astype(float), np.repeat(history[there], 2)[:-1]
        layers.append(Line(x, y, name, theme.SERIES[(2, 3, 5, 6, 7)[index % 5]], 2.0))
    first = [one for one in found.trials if one.seed in (found.seeds[0], -1)]
    for feasible, name, colour in (
        (False, "trial that misses a bound", MISSES),
        (True, "trial that meets every bound", FEASIBLE),
    ):
        some = [
            (at, trial)
            for at, trial in enumerate(first)
            if trial.feasible is feasible and np.isfinite(trial.objectives[0])
        ]
        if some:
            y = np.array([one.shown(float(trial.objectives[0])) for _, trial in some])
            layers.insert(
                0,
                Marks(
                    np.array([float(at) for at, _ in some]), y, name, colour, filled=True, size=5.0
                ),
            )
    if found.case.feasible:
        layers.append(
            Marks(
                np.zeros(1),
                np.array([one.shown(float(found.case.objectives[0]))]),
                "the case",
                CASE,
                "diamond",
                filled=True,
            )
        )
    caption = "Trial 0 is the case itself. Trials whose objective was not computed, because they miss a bound already, are not drawn."
    panel = Panel("trial", measure_label(one), tuple(layers))
    return Chart("convergence", "How the best value went", caption, (panel,), 1, 340)


def front_chart(found: Optimum) -> Chart | None:
    """Every pair of objectives: all trials, the front, the case and the chosen design."""
    goals = found.plan.objectives
    if len(goals) < 2 or not found.feasible:
        return None
    panels = []
    for number, (first, second) in enumerate(itertools.combinations(range(len(goals)), 2)):
        layers = _clouds(found, partial(_objective, found, index=first), second, number == 0)
        if len(goals) == 2:
            x, y = (
                np.array([_objective(found, trial, at) for trial in found.front])
                for at in (first, second)
            )
            layers.insert(
                -2 if found.case.feasible else -1,
                Line(x, y, "front", FEASIBLE, 1.6, in_legend=number == 0),
            )
        panels.append(
            Panel(
                measure_label(goals[first].measure),
                measure_label(goals[second].measure),
                tuple(layers),
            )
        )
    columns = min(2, len(panels))
    caption = "On the front, no objective can be bettered without another getting worse. The balanced design is nearest to the best of all."
    return Chart(
        "front",
        "What one objective costs in the other",
        caption,
        tuple(panels),
        columns,
        400 * -(-len(panels) // columns),
    )


def over_chart(found: Optimum, index: int) -> Chart | None:
    """One objective over each varied quantity: trials that meet and that miss the bounds."""
    goal, varied = found.plan.objectives[index], found.plan.varied
    if sum(bool(np.isfinite(one.objectives[index])) for one in found.trials) < 2:
        return None
    panels = []
    for at, one in enumerate(varied):
        layers = _clouds(found, partial(_shown, one, index=at), index, at == 0)
        panels.append(Panel(one.axis_label, measure_label(goal.measure), tuple(layers)))
    columns = min(3, len(panels)) if len(panels) != 4 else 2
    title = f"{goal.measure.label[:1].upper()}{goal.measure.label[1:]} over what is varied"
    caption = (
        "Where the best design is at an end of its range, a wider range may hold a better one."
    )
    return Chart(
        f"over-{index}",
        title,
        caption,
        tuple(panels),
        columns,
        ROW * -(-len(panels) // columns) + 70,
    )


def _clouds(
    found: Optimum, across: Callable[[Trial], float], up: int, in_legend: bool
) -> list[Layer]:
    """Trials that miss bounds, those that meet them, the case and the best, over a number of each."""
    kinds: Sequence[tuple[list[Trial], str, str, str, float]] = (
        (
            [one for one in found.trials if not one.feasible],
            "trial that misses a bound",
            MISSES,
            "circle",
            5.0,
        ),
        (
            [one for one in found.trials if one.feasible],
            "trial that meets every bound",
            FEASIBLE,
            "circle",
            5.0,
        ),
        ([found.case], "the case", CASE, "diamond", 10.0),
        (
            [found.best.trial] if found.best else [],
            "best" if len(found.plan.objectives) == 1 else "balanced",
            BEST,
            "square",
            10.0,
        ),
    )
    layers: list[Layer] = []
    for trials, name, colour, symbol, size in kinds:
        pairs = [(across(one), _objective(found, one, up)) for one in trials]
        points = np.array(
            [pair for pair in pairs if all(map(np.isfinite, pair))], dtype=float
        ).reshape(-1, 2)
        if len(points):
            layers.append(
                Marks(
                    points[:, 0],
                    points[:, 1],
                    name,
                    colour,
                    symbol,
                    filled=True,
                    size=size,
                    in_legend=in_legend,
                )
            )
    return layers


def _objective(found: Optimum, trial: Trial, index: int) -> float:
    return found.plan.objectives[index].measure.shown(float(trial.objectives[index]))


def _shown(one: Varied, trial: Trial, index: int) -> float:
    return one.shown(float(trial.values[index]))
