"""What a notebook shows first of a measured lift, and of the law behind it."""

from __future__ import annotations

import numpy as np

from valvetrain.lift.page import AXES
from valvetrain.measured.lift_file import MeasuredLift
from valvetrain.measured.lift_smoothing import BAND, SmoothedLift
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Line, Marks, Panel
from valvetrain.report.page import Block, Cell, Figure, Grid

ANGLE = "cam angle (deg)"


def measured_lift_blocks(measured: MeasuredLift) -> tuple[Block, ...]:
    """What the stations mean and who said so, and the stations."""
    rows = tuple(
        ((Cell(one.question.replace("_", " ")), Cell(one.answer), Cell(one.by)), ())
        for one in measured.answers
    )
    degrees, millimetres = np.degrees(measured.cam_angles), 1e3 * measured.lifts
    marks = Marks(degrees, millimetres, "station", theme.SERIES[0], size=3.0, filled=True)
    panel = Panel(ANGLE, f"{measured.lift_of} lift (mm)", (marks,))
    chart = Chart("measured-lift", repr(measured), "", (panel,))
    return Grid(("question", "answer", "by"), rows), Figure(chart)


def smoothed_lift_blocks(law: SmoothedLift) -> tuple[Block, ...]:
    """Extremes of the law and its derivatives, and their curves with bands that hold 95 %."""
    grid = np.linspace(*law.event, 1501)
    degrees, rows, panels = np.degrees(grid), [], []
    for derivative, (label, factor) in enumerate(AXES):
        mean = law.lift(grid, derivative) * factor
        band = BAND * law.spread(grid, derivative) * factor
        ends = (mean.min(), mean.max(), band.max())
        rows.append(((Cell(label), *(Cell(f"{one:.5g}", "number") for one in ends)), ()))
        named = derivative == 0
        layers = (
            Line(degrees, mean - band, "95 % band", theme.MUTED, 0.9, in_legend=named),
            Line(degrees, mean + band, "95 % band", theme.MUTED, 0.9, in_legend=False),
            Line(degrees, mean, "law behind the stations", theme.SERIES[0], 1.6, in_legend=named),
        )
        reach = (float(degrees[0]), float(degrees[-1]))
        panels.append(Panel(ANGLE, label, layers, x_range=reach))
    heads = ("", "smallest", "largest", "band, at most")
    chart = Chart("smoothed-lift", repr(law), "", tuple(panels), 1, 900)
    return Grid(heads, tuple(rows)), Figure(chart)
