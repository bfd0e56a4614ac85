"""Spring force on the cylinder head and on the retainer over the cam angle, at rest beside it."""

from __future__ import annotations

from valvetrain.report.chart import Chart, Line
from valvetrain.report.figures.common import STILL_WORDS, angle_panels, panels_chart, runs_at
from valvetrain.report.page import Block, SectionSpec, figure_or_gap
from valvetrain.report.words import speed_words
from valvetrain.solution.study import Study

#: Channel -> (key, title, words of the axis).
FORCES = {
    "seat_force": ("force-seat", "Spring force on the cylinder head", "force on the cylinder head"),
    "retainer_force": ("force-retainer", "Spring force on the retainer", "force on the retainer"),
}


def blocks(study: Study) -> tuple[Block, ...]:
    """A figure per end of the spring, a panel per engine speed."""
    return tuple(block for channel, words in FORCES.items() for block in figure_or_gap(words[1], force_chart, study, channel))


def force_chart(study: Study, channel: str) -> Chart | None:
    """One channel of force by engine speed with the force at rest at the same lift; None where no run has it."""
    key, title, words = FORCES[channel]
    panels = []
    for engine_speed in study.engine_speeds:
        panels += angle_panels(study, runs_at(study, engine_speed), channel, words, speed_words(engine_speed), "static_retainer_force")
    still = any(isinstance(layer, Line) and layer.name == STILL_WORDS for panel in panels for layer in panel.layers)
    caption = "All springs together over the reported cam cycle, compressive positive."
    caption += " Dashed: what springs without inertia would give." if still else ""
    return panels_chart(key, title, caption, panels, 270)


SPEC = SectionSpec("force", "Spring force", blocks)
