"""First picture of a refinement: sizes of error bars."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from valvetrain.report import theme
from valvetrain.report.chart import Chart, Marks, Panel
from valvetrain.report.text import quantity_label, speed_text
from valvetrain.solution.uncertainty import Uncertainty

#: Rows of the figure at most.
MAX_ROWS = 16
#: Letters of the name of a row.
MAX_LETTERS = 54


def error_bar_chart(every: Sequence[Uncertainty]) -> Chart | None:
    """Numerical error of every number as a share of its value, the largest above; None without any."""
    rows = [row for row in every if row.value]
    if not rows:
        return None
    rows = sorted(rows, key=lambda row: -abs(row.numerical / row.value))[:MAX_ROWS]
    sizes = np.array([abs(100 * row.numerical / row.value) for row in rows])
    height = np.arange(len(rows), dtype=float)[::-1]
    named = _names(rows)
    hints = tuple(f"{name}: {size:.2g} %" for name, size in zip(named, sizes, strict=True))
    marks = Marks(sizes, height, "numerical error", theme.SERIES[0], filled=True, hints=hints)
    names = tuple((float(level), _cut(name)) for name, level in zip(named, height, strict=True))
    panel = Panel(
        "numerical error, share of the value (%)",
        "",
        (marks,),
        y_range=(-0.6, len(rows) - 0.4),
        y_tick_labels=names,
    )
    most = float(sizes.max()) or 1.0
    panel = replace(panel, x_range=(-0.02 * most, 1.08 * most))
    known = sum(bool(row.value) for row in every)
    caption = f"The {len(rows)} largest of {known}." if known > len(rows) else ""
    height_px = max(240, 24 * len(rows) + 110)
    return Chart("opening", "Size of the error bars", caption, (panel,), 1, height_px, legend=False)


def _names(rows: Sequence[Uncertainty]) -> list[str]:
    """Quantity, with speed and label where they differ among the rows."""
    speeds, labels = {row.engine_speed for row in rows}, {row.label for row in rows}
    names = []
    for row in rows:
        parts = [quantity_label(row.quantity)]
        if len(speeds) > 1 and row.engine_speed is not None:
            parts.append(speed_text(row.engine_speed))
        if len(labels) > 1 and row.label:
            parts.append(row.label)
        names.append(", ".join(parts))
    return names


def _cut(name: str) -> str:
    """A name that fits next to the figure; the mark shows it in full."""
    return name if len(name) <= MAX_LETTERS else f"{name[: MAX_LETTERS - 1]}…"
