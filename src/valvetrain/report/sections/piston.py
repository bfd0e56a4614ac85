"""Clearance of valve and piston over the crank angle from top dead centre."""

from __future__ import annotations

import numpy as np

from valvetrain.report.chart import Chart, Line, Panel, Rule, thin
from valvetrain.report.page import Block, SectionSpec, figure_or_gap
from valvetrain.report.run_charts import (
    MAX_LINES,
    Array,
    by_speed,
    line_styles,
    over_angle,
    panels_chart,
)
from valvetrain.report.text import amount, number, speed_text
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

#: Crank degrees shown on either side of top dead centre.
SHOWN = 90.0


def blocks(study: Study) -> tuple[Block, ...]:
    """A figure per engine speed, behind tabs; nothing without a crank."""

    def at(engine_speed: float, runs: list[Solution], key: str) -> tuple[Block, ...]:
        title = f"Valve and piston at {speed_text(engine_speed)}"
        return figure_or_gap(title, clearance_chart, study, runs, key, title)

    return by_speed(study, "piston", at)


def around_top(run: Solution) -> tuple[Array, Array] | None:
    """Crank degrees from top dead centre of gas exchange, rising, and clearance (m); None without
    a crank.
    """
    clearance, crank = over_angle(run, "piston_clearance"), over_angle(run, "crank_angle")
    if clearance is None or crank is None:
        return None
    order = np.argsort(crank[1])
    return np.degrees(crank[1][order]), clearance[1][order]


def clearance_chart(study: Study, runs: list[Solution], key: str, title: str) -> Chart | None:
    """Clearance (mm) of every run around top dead centre; None without any."""
    known = line_styles(study)
    shown = [(run, *found) for run in runs if (found := around_top(run)) is not None]
    panels, least = [], []
    for start in range(0, len(shown), MAX_LINES):
        layers, heights = [], [0.0]
        for run, angle, clearance in shown[start : start + MAX_LINES]:
            look, near = known[run.label], np.abs(angle) <= SHOWN
            layers.append(
                Line(*thin(angle[near], 1e3 * clearance[near]), look.label, look.colour, 1.5, look.dash)
            )  # fmt: skip
            heights += (1e3 * clearance[near & np.isfinite(clearance)]).tolist()
            place = int(np.argmin(clearance))
            least.append((float(clearance[place]), float(angle[place])))
        low, high = min(heights), max(heights)
        room = 0.07 * (high - low) or 1.0
        panels.append(
            Panel(
                "crank angle from top dead centre (crank degrees)",
                "clearance (mm)",
                tuple(layers),
                rules=(Rule("y", 0.0, "they touch"),),
                x_range=(-SHOWN, SHOWN),
                x_step=30,
                y_range=(low - room, high + room),  # the rule of touching is inside
            )
        )
    if not least:
        return None
    gap, at = min(least)
    side = "after" if at >= 0 else "before"
    caption = (
        "Distance of valve and piston crown along the cylinder about top dead centre of gas exchange. Least: "
        f"{amount(1e3 * gap, 'mm')} at {number(abs(at), 3)} crank degrees {side} it."
    )
    return panels_chart(key, title, caption, panels, 270)


SPEC = SectionSpec("piston", "Valve and piston", blocks)
