"""Displacement, velocity and acceleration of the wire at the ends of coils 1 and 2."""

from __future__ import annotations

import numpy as np

from valvetrain.quantities.compare import same_speed
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.stages import Stages
from valvetrain.quantities.study import SpringStudy
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Marks, Panel, thin
from valvetrain.report.figures.force import ANGLE_LABEL, stage_bands
from valvetrain.report.table import Table, table
from valvetrain.report.words import rpm, speed_words
from valvetrain.solution.result import Solution

_COLOURS = {1: theme.MODEL_COLOURS["massless"], 2: theme.MODEL_COLOURS["finite-element"]}
#: channel -> (column word, unit shown, factor, axis label)
_MOTIONS = {
    "axial_displacement": ("displacement", "mm", 1e3, "displacement (mm)"),
    "axial_velocity": ("velocity", "m/s", 1.0, "velocity (m/s)"),
    "axial_acceleration": ("acceleration", "km/s²", 1e-3, "acceleration (km/s²)"),
}


def node_table(run: Solution) -> Table | None:
    """``cam angle`` (deg), ``node 1 displacement`` (mm), ``node 1 velocity`` (m/s), ``node 1 acceleration`` (km/s2), the same of node 2.

    None without wire points. The displacement of node 2 is zero where coil 2 touches coil 1 (its gap), as in the beehive's source.
    """
    cycle = reported_cycle(run)
    columns: list = [("cam angle", "deg", np.degrees(cycle.cam_angle))]
    for channel, (word, unit, factor, _) in _MOTIONS.items():
        for node in (1, 2):
            values = cycle.at_coil(channel, float(node))
            gap = cycle.at_coil("coil_gap", 2.0) if (channel, node) == ("axial_displacement", 2) else None
            if gap is not None and np.all(np.isfinite(gap)):
                values = gap
            if values is not None:
                columns.append((f"node {node} {word}", unit, values * factor))
    return table(*columns) if len(columns) > 1 else None


def published_motion(study: SpringStudy, engine_speed: float) -> Table:
    """Published extremes with an angle: ``node``, ``motion``, ``cam angle`` (deg), ``value`` (unit of the figure)."""
    values = {value.quantity: value for value in study.case.published if same_speed(value.engine_speed, engine_speed)}
    rows = []
    for name, value in values.items():
        angle = values.get(f"{name}_cam_angle")
        motion = next((entry for entry in _MOTIONS.values() if name.endswith(f"_{entry[0]}")), None)
        if angle is not None and motion is not None and name.startswith("node_"):
            rows.append((int(name.split("_")[1]), motion[0], float(np.degrees(angle.value)), value.value * motion[2], value.model))
    columns = list(zip(*rows, strict=True)) or [(), (), (), (), ()]
    return table(
        ("node", "", np.array(columns[0], dtype=int)), ("motion", "", np.array(columns[1], dtype=object)),
        ("cam angle", "deg", np.array(columns[2], dtype=float)), ("value", "", np.array(columns[3], dtype=float)),
        ("origin", "", np.array(columns[4], dtype=object)),
    )  # fmt: skip


def node_chart(data: Table, published: Table, engine_speed: float, stages: Stages | None = Stages()) -> Chart:
    """Three panels over one cam angle axis; published extremes marked."""
    panels: list[Panel] = []
    worded = stage_bands(stages)
    for word, _, _, label in _MOTIONS.values():
        layers: list[Layer] = []
        for node in (1, 2):
            name = f"node {node} {word}"
            if name in data:
                layers.append(Line(*thin(data["cam angle"], data[name]), f"node {node} (end of coil {node})", _COLOURS[node], width=1.3))
        for origin in dict.fromkeys(published["origin"].tolist()):
            mine = (published["motion"] == word) & (published["origin"] == origin)
            sign, words, colour, symbol = theme.origin_style(origin)
            labels = tuple(f"{sign} node {node}" if node == 1 else sign for node in published["node"][mine].tolist())
            if np.any(mine):
                layers.append(Marks(published["cam angle"][mine], published["value"][mine], words, colour, symbol, labels))
        if layers:
            bands = worded if not panels else tuple(type(band)(band.first, band.last, "", band.shaded) for band in worded)
            panels.append(Panel(ANGLE_LABEL, label, tuple(layers), bands=bands, x_range=(0, 360), x_step=30))
    speed = speed_words(engine_speed)
    caption = (
        f"Axial motion at {speed} of the wire at the ends of coil 1 and coil 2, seat to retainer positive. Displacement of node 2 is "
        "counted from where coil 2 touches coil 1; that of node 1 from the installed state."
    )
    return Chart(f"nodes-{rpm(engine_speed):g}", f"Nodes 1 and 2 at {speed}", caption, tuple(panels), height=760)
