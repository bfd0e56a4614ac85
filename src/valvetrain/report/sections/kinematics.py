"""What the geometry of a train asks for before any dynamics: its rigid channels."""

from __future__ import annotations

from valvetrain.report import theme
from valvetrain.report.chart import Chart, Line, Panel, thin
from valvetrain.report.figures.common import ANGLE_LABEL, by_speed, event_bands, over_angle, panels_chart, unit_of_channel
from valvetrain.report.page import Block, SectionSpec, figure_or_gap
from valvetrain.report.words import speed_words
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study


def blocks(study: Study) -> tuple[Block, ...]:
    """Every channel ``rigid_...``, by engine speed."""

    def at(engine_speed: float, runs: list[Solution], key: str) -> tuple[Block, ...]:
        title = f"Rigid parts at {speed_words(engine_speed)}"
        return figure_or_gap(title, rigid_chart, study, runs, key, title)

    return by_speed(study, "kinematics", at)


def rigid_chart(study: Study, runs: list[Solution], key: str, title: str) -> Chart | None:
    """A panel per rigid channel; runs of one train share them, so one line stands for all."""
    panels = []
    for name in dict.fromkeys(str(name) for run in runs for name in run.arrays.variables if str(name).startswith("rigid_")):
        run = next(run for run in runs if run.has(name))
        found, (unit, factor) = over_angle(run, name), unit_of_channel(run, name)
        if found is not None:
            words = name.removeprefix("rigid_").replace("_", " ")
            line = Line(*thin(found[0], found[1] * factor), words, theme.INK, 1.4, in_legend=False)
            label = f"{words} ({unit})" if unit else words
            panels.append(Panel(ANGLE_LABEL, label, (line,), bands=event_bands(study), x_range=(0, 360), x_step=30))
    return panels_chart(key, title, "Rigid parts, closed contacts, no surge: quasi-static values at this engine speed.", panels, 190)


SPEC = SectionSpec("kinematics", "Rigid parts", blocks)
