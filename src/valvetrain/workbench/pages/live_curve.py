"""The curve that follows a slider, and the numbers next to it."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from valvetrain.parameters.summary import number
from valvetrain.views.page import figure_content
from valvetrain.views.style import ANGLE, LEAD, OTHER, SECOND, panels, styled
from valvetrain.workbench.live_result import LiveResult

#: A line of a figure of plotly as plain values.
Trace = dict[str, Any]


def live_lines(
    base: LiveResult, moved: LiveResult | None, rod: LiveResult | None, label: str = ""
) -> list[Trace]:
    """Lines of the figure; ``label``: where the quantity was moved to."""
    lines = [_line(base, f"the case, {base.model}", OTHER, "dash")]
    for result, colour in ((moved, LEAD), (rod, SECOND)):
        if result is not None and result.angle_deg:
            lines.append(_line(result, f"{label}, {result.model}", colour))
    return lines


def live_figure(lines: Sequence[Trace]) -> dict[str, Any]:
    """The figure as plain values, for ``valvetrainFigures.draw``; the frame of every one is the same."""
    return {**_frame(), "data": list(lines)} if lines else {}


@cache
def _frame() -> Mapping[str, Any]:
    fig = styled(panels((1.0,)), ANGLE, ("force on the retainer, N",), 300)
    return figure_content(fig.update_xaxes(range=[0, 360], dtick=60))


def _line(result: LiveResult, name: str, colour: str, dash: str = "solid") -> Trace:
    x, y = ({"dtype": "f4", "bdata": base64.b64encode(np.asarray(one, "f4").tobytes()).decode()}
            for one in (result.angle_deg, result.force_N))  # fmt: skip
    look = {"color": colour, "dash": dash, "width": 1.8}
    return {"type": "scatter", "mode": "lines", "name": name, "line": look, "x": x, "y": y, "hovertemplate": "%{y:.4~g}"}  # fmt: skip


def live_numbers(base: LiveResult, moved: LiveResult | None) -> list[dict[str, str]]:
    """Numbers of the moved case with the change from the case itself."""
    seen = moved if moved is not None and moved.quantities else base
    rows = []
    for label, (value, unit) in seen.quantities.items():
        change = value - base.quantities.get(label, (value, ""))[0]
        if abs(change) > 1e-9 * abs(value):
            unit += f" ({'+' if change > 0 else '−'}{number(abs(change), 3)})"
        rows.append({"label": label[:1].upper() + label[1:], "value": number(value), "unit": unit})
    return rows


def float_text(engine_speed: float | None, of_case: float | None, sentence: str) -> str:
    """A float speed (rpm) in tens, with the change from that ``of_case``; else the sentence.

    >>> float_text(8524.0, 8401.0, ""), float_text(None, None, "no float up to 9000 rpm")
    ('8520 rpm (+120)', 'no float up to 9000 rpm')
    """
    if engine_speed is None:
        return sentence
    change = 0 if of_case is None else 10 * (round(engine_speed / 10) - round(of_case / 10))
    more = f" ({'+' if change > 0 else '−'}{abs(change)})" if change else ""
    return f"{10 * round(engine_speed / 10)} rpm{more}"
