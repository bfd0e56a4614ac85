"""What a notebook shows first of a run compared with a film."""

from __future__ import annotations

import numpy as np

from valvetrain.film.model import FilmedModel
from valvetrain.film.page import coil_colour
from valvetrain.report.chart import Chart, Line, Panel
from valvetrain.report.page import Block, Cell, Figure, Grid


def filmed_model_blocks(model: FilmedModel) -> tuple[Block, ...]:
    """Peak of every coil and how far film and model are apart, and the motion of the coils."""
    rows = []
    for coil, (turn, peak, apart) in enumerate(
        zip(model.turns, model.peaks, model.apart, strict=True)
    ):
        texts = (f"{turn:.2f}", f"{1e3 * peak:.3f}", f"{1e3 * apart:.3f}")
        rows.append(((Cell(str(coil + 1)), *(Cell(one, "number") for one in texts)), ()))
    heads = ("coil", "turn", "peak (mm)", "film less model, root mean square (mm)")
    degrees = np.degrees(model.cam_angle)
    layers = tuple(
        Line(degrees, 1e3 * model.displacement[:, coil], f"coil {coil + 1}", coil_colour(coil))
        for coil in range(len(model.turns))
    )
    label = "displacement towards the seat (mm)"
    panel = Panel("cam angle (deg)", label, layers, x_range=(0.0, 360.0), x_step=60.0)
    return Grid(heads, tuple(rows)), Figure(Chart("model", repr(model), "", (panel,), 1, 460))
