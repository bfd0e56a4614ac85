"""Motion of the valve: lift, velocity, acceleration over the cam angle."""

from __future__ import annotations

from valvetrain.report.figures.common import angle_panels, by_speed, panels_chart
from valvetrain.report.page import Block, SectionSpec, figure_or_gap
from valvetrain.report.words import speed_words
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

#: Words of the axis -> channels, the first that a run has.
MOTIONS = {
    "valve lift": ("valve_lift",), "velocity, opening positive": ("valve_velocity", "retainer_velocity"),
    "acceleration, opening positive": ("valve_acceleration", "retainer_acceleration"),
}  # fmt: skip


def blocks(study: Study) -> tuple[Block, ...]:
    """Three panels per engine speed; where all runs are told the same motion, one line stands for them."""

    def at(engine_speed: float, runs: list[Solution], key: str) -> tuple[Block, ...]:
        told = all(run.provenance.system == "prescribed-spring" for run in runs)
        shown = runs[:1] if told else runs
        title = f"{'Prescribed motion' if told else 'Valve motion'} at {speed_words(engine_speed)}"
        panels = []
        for words, channels in MOTIONS.items():
            channel = next((one for one in channels if any(run.has(one) for run in shown)), "")
            panels += angle_panels(study, shown, channel, words) if channel else []
        caption = "The prescribed motion of the retainer." if told else "Motion over the steady cycle."
        return figure_or_gap(title, panels_chart, key, title, caption, panels, 190)

    return by_speed(study, "motion", at)


SPEC = SectionSpec("motion", "Valve motion", blocks)
