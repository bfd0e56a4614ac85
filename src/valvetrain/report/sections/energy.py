"""Energy balance of every run that keeps account of it."""

from __future__ import annotations

import numpy as np

from valvetrain.quantities.energy import energy_balance
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Line, Panel, Rule, thin
from valvetrain.report.figures.common import by_speed, looks
from valvetrain.report.page import Block, SectionSpec, figure_or_gap
from valvetrain.report.words import speed_words
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study


def blocks(study: Study) -> tuple[Block, ...]:
    """A figure per run with energies."""
    known = looks(study)

    def at(engine_speed: float, runs: list[Solution], key: str) -> tuple[Block, ...]:
        found: tuple[Block, ...] = ()
        for number, run in enumerate(runs, start=1):
            title = f"Energy balance: {known[run.label].words}, {speed_words(engine_speed)}"
            found += figure_or_gap(title, energy_chart, run, f"{key}-{number}", title)
        return found

    return by_speed(study, "energy", at)


def energy_chart(run: Solution, key: str, title: str) -> Chart | None:
    """What went in, what is stored, what became heat, and what is missing, over the whole run in mJ; None for a run without energies."""
    balance = energy_balance(run)
    if balance is None:
        return None
    angle = np.degrees(balance.cam_angle)
    parts = {"work done": balance.work, "stored": balance.stored, "kinetic": balance.kinetic, "dissipated": balance.dissipated}
    lines = tuple(
        Line(*thin(angle, values * 1e3), name, colour, dash="dash" if name == "work done" else "solid")
        for (name, values), colour in zip(parts.items(), theme.SERIES, strict=False)
    )
    missing = Line(*thin(angle, balance.imbalance * 1e3), "stored + dissipated − work", theme.ALERT, in_legend=False)
    span = 1e3 * (balance.scale or 1.0)
    bound = 1.25 * max(0.01 * span, 1e3 * float(np.max(np.abs(balance.imbalance))))
    limits = tuple(Rule("y", sign * 0.01 * span, "1 % of the work done" if sign > 0 else "") for sign in (1, -1))
    x_label = "cam angle from the start (cam degrees)"
    panels = (
        Panel(x_label, "energy (mJ)", lines, "Energies"),
        Panel(x_label, "stored + dissipated − work (mJ)", (missing,), "Imbalance", rules=limits, y_range=(-bound, bound)),
    )
    return Chart(key, title, "From the first sample on. Work is done on the spring by the retainer.", panels, 2, 330)


SPEC = SectionSpec("energy", "Energy balance", blocks)
