"""A table of quantities with one row: the mean spring force."""

from __future__ import annotations

import numpy as np

from valvetrain.solution.definition import row
from valvetrain.solution.result import Solution


def mean_spring_force(run: Solution) -> float | None:
    """Mean of the seat force (N) over the samples of the run; None for a run without it."""
    return float(np.mean(run.channel("seat_force"))) if run.has("seat_force") else None


ROWS = (
    row(
        "mean_spring_force",
        "mean spring force",
        "Mean force of all springs on the cylinder head.",
        systems=("spring", "train"),
        topic="Spring force and coil bind",
        uses=("brief", "sweep", "curve", "study"),
        compute=mean_spring_force,
    ),
)
