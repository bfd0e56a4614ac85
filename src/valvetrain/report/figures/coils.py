"""Motion of the coils over the cam angle, and where and when coil meets coil."""

from __future__ import annotations

import numpy as np

from valvetrain.quantities.cycle import reported_cycle
from valvetrain.report import theme
from valvetrain.report.chart import Chart, HeatMap, Line, Panel, thin
from valvetrain.report.figures.force import ANGLE_LABEL, stage_bands
from valvetrain.report.table import Table, table
from valvetrain.report.words import rpm, speed_words
from valvetrain.solution.result import Solution

MOST_COLUMNS, MOST_ROWS = 720, 160


def position_table(run: Solution, spacing: float = 0.5) -> Table | None:
    """``cam angle`` (deg) and the height (mm) of the wire every ``spacing`` turns, columns ``coil 1``, ``coil 1.5``...

    None for a model that has no wire points.
    """
    if not run.has("axial_position"):
        return None
    cycle = reported_cycle(run)
    coils = np.asarray(run.channels["coil_number"].values)
    columns: list = [("cam angle", "deg", np.degrees(cycle.cam_angle))]
    for coil in np.arange(np.ceil(coils.min() / spacing) * spacing, coils.max() + 1e-9, spacing):
        height = cycle.at_coil("axial_position", float(coil), reach=0.5)
        if height is not None:
            columns.append((f"coil {coil:g}", "mm", height * 1e3))
    return table(*columns)


def position_chart(data: Table, engine_speed: float) -> Chart:
    """Heights of the wire over one cam cycle, one line every half turn, labelled at the right where whole."""
    names = [column.name for column in data.columns[1:]]
    lines = []
    for name, colour in zip(names, theme.ramp(len(names)), strict=True):
        whole = float(name.split()[1]) % 1 == 0
        x, y = thin(data["cam angle"], data[name])
        lines.append(Line(x, y, name, colour, width=1.7 if whole else 0.9, in_legend=False, direct=name.split()[1] if whole else ""))
    y_label = "height of the wire axis above the seat (mm)"
    panel = Panel(ANGLE_LABEL, y_label, tuple(lines), bands=stage_bands(), x_range=(0, 360), x_step=30)
    speed = speed_words(engine_speed)
    caption = f"Coil positions at {speed}: the wire every half turn, whole coil numbers labelled. Waves run up and down between the coils."
    return Chart(f"coils-{rpm(engine_speed):g}", f"Coil positions at {speed}", caption, (panel,), height=430, legend=False)


def clash_table(run: Solution) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Cam angle (deg), coil number of the upper partner, contact force (N; coil, angle); None without coil pairs.

    Finer data are thinned by the largest force in each cell, so that no clash is lost.
    """
    if not run.has("coil_contact_force"):
        return None
    cycle = reported_cycle(run)
    force, coil = cycle.channel("coil_contact_force").T, np.asarray(run.channels["upper_coil"].values)
    if force.size == 0:
        return None
    order = np.argsort(coil)
    force, coil, angle = force[order], coil[order], np.degrees(cycle.cam_angle)
    force, angle = _largest(force, 1, MOST_COLUMNS), _middle(angle, MOST_COLUMNS)
    return angle, _middle(coil, MOST_ROWS), _largest(force, 0, MOST_ROWS)


def _starts(count: int, most: int) -> np.ndarray:
    return np.arange(0, count, int(np.ceil(count / most)))


def _largest(values: np.ndarray, axis: int, most: int) -> np.ndarray:
    return np.maximum.reduceat(values, _starts(values.shape[axis], most), axis=axis)


def _middle(values: np.ndarray, most: int) -> np.ndarray:
    starts = _starts(len(values), most)
    return np.add.reduceat(values, starts) / np.diff(np.append(starts, len(values)))


def clash_chart(cam_angle: np.ndarray, coil: np.ndarray, force: np.ndarray, engine_speed: float) -> Chart:
    """Contact force by cam angle and place along the wire."""
    panel = Panel(
        ANGLE_LABEL, "coil number of the upper coil", (HeatMap(cam_angle, coil, force, "contact force", "N"),),
        bands=tuple(type(band)(band.first, band.last, band.words, False) for band in stage_bands()), x_range=(0, 360), x_step=30,
    )  # fmt: skip
    speed = speed_words(engine_speed)
    caption = (
        f"Clash map at {speed}: where along the wire a turn presses on the one below (coil number 2 means the end of coil 2 on coil 1), "
        "when and how hard. Streaks are rest, blots are clashes. Force per contact point of the mesh."
    )
    return Chart(f"clash-{rpm(engine_speed):g}", f"Clash map at {speed}", caption, (panel,), height=400, legend=False)
