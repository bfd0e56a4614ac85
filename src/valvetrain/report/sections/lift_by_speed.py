"""Dynamic over kinematic valve lift, engine speeds above each other, as a Spintron shows it."""

from __future__ import annotations

import numpy as np

from valvetrain.quantities.cycle import reported_cycle
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Panel, Rule, thin
from valvetrain.report.page import Block, SectionSpec, Tabs, figure_or_gap
from valvetrain.report.run_charts import ANGLE_LABEL, drawable, event_bands, line_styles
from valvetrain.report.text import amount, number, speed_text
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

#: Engine speeds above each other; of more, evenly picked ones.
MAX_STACKED = 10


def blocks(study: Study) -> tuple[Block, ...]:
    """A figure per label, behind tabs where there are several; nothing below two engine speeds."""
    known, items = line_styles(study), []
    for place, label in enumerate(study.labels, start=1):
        title = f"Valve lift against rigid parts: {known[label].label}"
        found = figure_or_gap(title, stacked_chart, study, label, f"lift-by-speed-{place}", title)
        if found:
            items.append((known[label].label, found))
    if len(items) < 2:
        return items[0][1] if items else ()
    return (Tabs(tuple(items), "lift-by-speed"),)


def picked(runs: list[Solution]) -> list[Solution]:
    """At most :data:`MAX_STACKED` of ``runs``, the first and the last among them."""
    places = np.linspace(0, len(runs) - 1, min(len(runs), MAX_STACKED)).round().astype(int)
    return [runs[place] for place in places]


def stacked_chart(study: Study, label: str, key: str, title: str) -> Chart | None:
    """Lift and its difference to the rigid one (mm) of every engine speed, each shifted up; None for
    fewer than two speeds.
    """
    names = ("valve_lift", "rigid_valve_lift")
    runs = picked([run for run in study.runs(label) if drawable(run) and run.has(*names)])
    if len(runs) < 2:
        return None
    cycles = [reported_cycle(run) for run in runs]
    lifts = [tuple(1e3 * cycle.channel(name) for name in names) for cycle in cycles]
    top = max(float(np.max(rigid)) for _, rigid in lifts)
    off = max(float(np.max(np.abs(lift - rigid))) for lift, rigid in lifts)
    step, step_off = 0.35 * top or 1.0, 1.1 * off or 1.0
    colours = theme.ramp(len(runs), "#66a3d2", "#12294f")
    stacks: tuple[list[Layer], list[Layer]] = ([], [])
    for place, (cycle, (lift, rigid)) in enumerate(zip(cycles, lifts, strict=True)):
        angle, first = np.degrees(cycle.cam_angle), place == 0
        for values, name, colour, dash in (
            (rigid, "rigid parts", theme.MUTED, "dash"),
            (lift, "valve lift", colours[place], "solid"),
        ):
            x, y = thin(angle, values + place * step)
            stacks[0].append(Line(x, y, name, colour, 1.3, dash, in_legend=first))
        x, y = thin(angle, lift - rigid + place * step_off)
        stacks[1].append(Line(x, y, "difference", colours[place], 1.3, in_legend=False))
    panels = tuple(
        Panel(
            ANGLE_LABEL,
            label,
            tuple(layers),
            heading,
            event_bands(study),
            x_range=(0, 360),
            x_step=60,
            y_range=(low - 0.3 * apart, (len(runs) - 1) * apart + high),
            rules=tuple(
                Rule("y", place * apart, speed_text(run.engine_speed))
                for place, run in enumerate(runs)
            ),
            y_tick_labels=((0.0, "0"), (mark, f"{number(mark, 3)}")),
        )
        for layers, apart, mark, low, high, label, heading in (
            (stacks[0], step, top, 0.0, 1.1 * top, "lift (mm), each engine speed on its own zero", "Valve lift"),
            (stacks[1], step_off, off, -off, 1.3 * off, "lift less rigid lift (mm)", "Difference to rigid parts"),
        )
    )  # fmt: skip
    caption = (
        f"Each engine speed begins on its own zero. Largest difference to rigid parts: {amount(off, 'mm', 3)}; above zero over the nose the "
        "valve is lofted, below it parts give way; after closing it bounces."
    )
    return Chart(key, title, caption, panels, 2, 200 + 36 * len(runs))


SPEC = SectionSpec("lift-by-speed", "Valve lift by engine speed", blocks)
