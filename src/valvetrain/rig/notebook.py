"""What a notebook shows first of a recording."""

from __future__ import annotations

from valvetrain.report.page import Block, Figure
from valvetrain.rig.page import COLUMNS, cycles_chart, peak_rows
from valvetrain.rig.result import RigResult
from valvetrain.views.columns import grid


def rig_result_blocks(result: RigResult) -> tuple[Block, ...]:
    """Peaks of every channel, and the cycles."""
    charts = (Figure(cycles_chart(one)) for one in result.channels)
    return grid(COLUMNS, peak_rows(result)), *charts
