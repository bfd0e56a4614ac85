"""Results that are data alone, without a verdict: static curves, modes, critical speeds, measured cycles."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import plotly.graph_objects as go

from valvetrain.findings.engine import Findings
from valvetrain.findings.words import RPM
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.solution.critical import CriticalSpeeds, places_text
from valvetrain.solution.display import SHOWN_UNITS
from valvetrain.solution.modes import ModalResult, TrainModes
from valvetrain.solution.static import StaticCurve
from valvetrain.views.shown import Shown
from valvetrain.views.style import ANGLE, BAD, LEAD, OTHER, SPEEDS, FigureSpec, line, panels, styled
from valvetrain.views.table import Line, TextTable

#: Lines of one figure, and cycles of a measurement that it shows, at most.
LINES, CYCLES = 8, 20


@dataclass(frozen=True)
class DataAnswer(Shown):
    """What is shown of data: a figure and, where the text of the result is not enough, a table.

    Parameters
    ----------
    result : the data
    draw : makes the figure
    table : its table
    """

    result: Any
    draw: Callable[[Any], go.Figure | None]
    table: TextTable | None = None

    @property
    def facts(self) -> Any:
        """The data."""
        return self.result

    @property
    def findings(self) -> Findings:
        """None: nothing is judged."""
        return Findings()

    @property
    def title(self) -> str:
        """The first line of the text of the result."""
        return repr(self.result).partition("\n")[0]

    @property
    def lines(self) -> list[Line]:
        """None."""
        return []

    def figures(self) -> Mapping[str, FigureSpec]:
        """The one figure."""
        return {"data": FigureSpec(self.title, "", self.draw)}

    def tables(self) -> Mapping[str, TextTable]:
        """The one table."""
        return {} if self.table is None else {"data": self.table}


def static_curve(result: StaticCurve) -> DataAnswer:
    """Force above tangent stiffness over compression."""

    def draw(curve: StaticCurve) -> go.Figure:
        fig, at = panels((0.5, 0.5)), 1e3 * curve.compression
        fig.add_trace(line(at, curve.force, "force", LEAD), 1, 1)
        fig.add_trace(line(at, 1e-3 * curve.stiffness, "stiffness", SPEEDS[1]), 2, 1)
        return styled(fig, "compression, mm", ("force, N", "stiffness, N/mm"), 480)

    return DataAnswer(result, draw)


def modes(result: ModalResult) -> DataAnswer:
    """Axial displacement of the first axial modes over the coils."""

    def draw(found: ModalResult) -> go.Figure:
        fig = panels((1.0,))
        for mode, colour in zip(found.axial_modes[:LINES], SPEEDS * 2, strict=False):
            name = f"{found.natural_frequency[mode]:.5g} Hz"
            fig.add_trace(line(found.coil_number, found.shape[mode, :, 2], name, colour))
        return styled(fig, "coil number", ("axial displacement",))

    return DataAnswer(result, draw)


def train_modes(result: TrainModes) -> DataAnswer:
    """Share of every part in the energy of each mode."""

    def draw(found: TrainModes) -> go.Figure:
        fig, names = panels((1.0,)), [f"{one:.4g} Hz" for one in found.natural_frequency]
        for place, part in enumerate(found.parts):
            share = 100 * found.energy_share[:, place]
            fig.add_trace(go.Bar(x=share, y=names, name=part, orientation="h"))
        styled(fig, "share of kinetic energy, %", ("",), 120 + 24 * len(names))
        return fig.update_yaxes(autorange="reversed", automargin=True)

    return DataAnswer(result, draw)


def critical_speeds(result: CriticalSpeeds) -> DataAnswer:
    """Where control is lost, with the range that was searched."""

    def draw(found: CriticalSpeeds) -> go.Figure | None:
        if not len(found):
            return None
        fig = panels((1.0,))
        for row in found:
            name = [f"{row.label}, {row.kind}"]
            ends = np.array([row.first_engine_speed, row.last_engine_speed]) / RPM
            searched = go.Scatter(x=ends, y=name * 2, mode="lines", line={"color": OTHER}, name="searched", showlegend=False)  # fmt: skip
            fig.add_trace(searched)
            if row.found:
                lost = {"color": BAD, "size": 10}
                fig.add_trace(go.Scatter(
                    x=[row.engine_speed / RPM], y=name, mode="markers", marker=lost, name="lost from here", showlegend=False,
                ))  # fmt: skip
        styled(fig, "engine speed, rpm", ("",), 120 + 24 * len(found))
        return fig.update_yaxes(automargin=True)

    rows = [(one.label, one.kind, f"{one.text} rpm", places_text(*one.places)) for one in result]
    heads = ("run", "kind", "engine speed", "first at")
    return DataAnswer(result, draw, TextTable("Critical engine speeds", heads, tuple(rows)))


def measured_cycles(result: MeasuredCycles) -> DataAnswer:
    """Single cycles and their mean, with the extremes of the mean."""
    unit, factor = SHOWN_UNITS.get(result.unit, (result.unit, 1.0))
    angle, name = np.degrees(result.cam_angle), result.quantity.replace("_", " ")
    mean = result.mean * factor

    def draw(cycles: MeasuredCycles) -> go.Figure:
        fig = panels((1.0,))
        for place, values in enumerate(cycles.values[:CYCLES]):
            fig.add_trace(line(angle, values * factor, "single cycles", OTHER, showlegend=not place))  # fmt: skip
        fig.add_trace(line(angle, mean, "mean", LEAD))
        return styled(fig, ANGLE, (", ".join(filter(None, (name, unit))),))

    ends = (("largest", int(np.nanargmax(mean))), ("smallest", int(np.nanargmin(mean))))
    rows = [(word, f"{mean[at]:.5g} {unit}".strip(), f"{angle[at]:.2f} deg") for word, at in ends]
    return DataAnswer(result, draw, TextTable(name, (name, "mean of the cycles", "cam angle"), tuple(rows)))  # fmt: skip
