"""The curve that follows a slider: the case, the moved quantity by the chain, and by the rod where it ran."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from valvetrain.parameters.words import number
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Line, Panel
from valvetrain.report.figures.common import ANGLE_LABEL
from valvetrain.report.plotly_chart import to_json
from valvetrain.workbench.live import LiveResult

#: The model that answers while the slider moves, and the one that answers when it rests.
QUICK, SLOW = "multi-mass", "finite-element"


def live_lines(base: LiveResult, moved: LiveResult | None, rod: LiveResult | None, words: str = "") -> list[Line]:
    """Lines of the figure; ``words``: where the quantity was moved to."""
    lines = [_line(base, "the case", theme.MUTED, "dash")]
    if moved is not None and moved.angle_deg:
        lines.append(_line(moved, f"{words}, {theme.model_words(QUICK)}", theme.model_colour(QUICK)))
    if rod is not None and rod.angle_deg:
        lines.append(_line(rod, f"{words}, {theme.model_words(SLOW)}", theme.model_colour(SLOW)))
    return lines


def live_figure(lines: Sequence[Line]) -> str:
    """The figure as JSON."""
    forces = np.concatenate([line.y for line in lines])
    low, high = float(forces.min()), float(forces.max())
    room = 0.06 * (high - low or 1.0)
    panel = Panel(ANGLE_LABEL, "force on the retainer (N)", tuple(lines), x_range=(0, 360), x_step=30, y_range=(low - room, high + room))
    return to_json(Chart("live", "Spring force", "", (panel,), height=300, legend=False))


def live_key(lines: Sequence[Line]) -> list[dict[str, str]]:
    """What each line is, for the key below the figure."""
    return [{"words": line.name, "colour": line.colour, "dash": "6 4" if line.dash == "dash" else ""} for line in lines]


def live_numbers(base: LiveResult, moved: LiveResult | None) -> list[dict[str, str]]:
    """Numbers of the moved case with the change from the case itself."""
    seen = moved if moved is not None and moved.quantities else base
    found = []
    for words, (value, unit) in seen.quantities.items():
        change = value - base.quantities[words][0] if seen is not base and words in base.quantities else 0.0
        told = f"{unit} ({'+' if change > 0 else '−'}{number(abs(change), 3)})" if abs(change) > 1e-9 * abs(value) else unit
        found.append({"label": words[:1].upper() + words[1:], "value": number(value), "unit": told})
    return found


def _line(result: LiveResult, name: str, colour: str, dash: str = "solid") -> Line:
    return Line(np.asarray(result.angle_deg), np.asarray(result.force_N), name, colour, 1.7 if dash == "solid" else 1.3, dash)
