"""The lift law as it was run: lift, velocity, acceleration over the cam angle."""

from __future__ import annotations

import numpy as np

from valvetrain.quantities.cycle import reported_cycle
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Line, Panel, thin
from valvetrain.report.figures.force import ANGLE_LABEL, stage_bands
from valvetrain.report.table import Table, table
from valvetrain.solution.result import Solution


def lift_table(run: Solution) -> Table | None:
    """``cam angle`` (deg), ``lift`` (mm), ``velocity`` (mm/deg) and ``acceleration`` (mm/deg2) by differences; None without a lift."""
    if not run.has("valve_lift") or len(run.time) < 5:
        return None
    cycle = reported_cycle(run)
    angle, lift = np.degrees(cycle.cam_angle), cycle.channel("valve_lift") * 1e3
    if len(angle) < 5:
        return None
    velocity = np.gradient(lift, angle)
    derivatives = (("velocity", "mm/deg", velocity), ("acceleration", "mm/deg²", np.gradient(velocity, angle)))
    return table(("cam angle", "deg", angle), ("lift", "mm", lift), *derivatives)


def lift_chart(data: Table) -> Chart:
    """Three panels over one cam angle axis."""
    panels = []
    labels = {"lift": "valve lift (mm)", "velocity": "velocity (mm/deg)", "acceleration": "acceleration (mm/deg²)"}
    for index, (name, label) in enumerate(labels.items()):
        bands = stage_bands() if index == 0 else tuple(type(band)(band.first, band.last, "", band.shaded) for band in stage_bands())
        line = Line(*thin(data["cam angle"], data[name]), name, theme.INK, width=1.5)
        panels.append(Panel(ANGLE_LABEL, label, (line,), bands=bands, x_range=(0, 360), x_step=30))
    caption = "Lift law as run, with its derivatives by the cam angle, taken by differences from the recorded lift."
    return Chart("lift", "Lift law", caption, tuple(panels), height=600, legend=False)
