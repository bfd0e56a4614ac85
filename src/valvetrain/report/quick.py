"""Quick figures of single results for a notebook or a script: what ``.plot()`` of a result returns."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.errors import InputError
from valvetrain.report import theme
from valvetrain.solution.display import SHOWN_UNITS
from valvetrain.solution.modes import ModalResult
from valvetrain.solution.quantity import unit_of
from valvetrain.solution.result import Solution
from valvetrain.solution.static import StaticCurve
from valvetrain.solution.study import Study

if TYPE_CHECKING:
    import plotly.graph_objects as go

_FORCES = ("seat_force", "retainer_force", "static_retainer_force")


def plot_solution(solution: Solution) -> go.Figure:
    """Spring forces (N) above the valve lift (mm) over the cam angle (deg).

    Raises :class:`InputError` for a reduced solution, which has no channels.
    """
    names = [name for name in _FORCES if solution.has(name)]
    if not names:
        raise InputError(
            f"this {solution.label or 'unnamed'} run keeps no force channel to draw; run it whole, not reduced"
        )
    figure = _figure(str(solution).partition("\n")[0], rows=2 if solution.has("valve_lift") else 1)
    cam_angle = np.degrees(solution.cam_angle)
    for name in names:
        _line(figure, cam_angle, solution.channel(name), name.replace("_", " "))
    if solution.has("valve_lift"):
        _line(figure, cam_angle, solution.channel("valve_lift") * 1e3, "valve lift", row=2)
        figure.update_yaxes(title_text="valve lift (mm)", row=2, col=1)
        figure.update_xaxes(title_text="cam angle (deg)", row=2, col=1)
    else:
        figure.update_xaxes(title_text="cam angle (deg)")
    figure.update_yaxes(title_text="force (N)", row=1, col=1)
    return figure


def plot_study(study: Study) -> go.Figure:
    """Peak force of every label over engine speed where several speeds were run, else the forces of
    the runs over the cam angle (deg).

    Raises :class:`InputError` for a study without runs.
    """
    if not study.solutions:
        raise InputError(
            f"the study of {study.record.name} holds no runs to draw; draw its springs at rest instead"
        )
    title = str(study).partition("\n")[0]
    if len(study.engine_speeds) == 1 and any(run.has("seat_force") for run in study.solutions):
        figure = _figure(title)
        for run in (run for run in study.solutions if run.has("seat_force")):
            _line(figure, np.degrees(run.cam_angle), run.channel("seat_force"), run.label)
        figure.update_xaxes(title_text="cam angle (deg)")
        figure.update_yaxes(title_text="seat force (N)")
        return figure
    name = _speaking_quantity(study)
    unit, factor = SHOWN_UNITS.get(unit_of(name), (unit_of(name), 1.0))
    figure = _figure(title)
    for label in study.labels:
        engine_speeds, values = study.series(label, name)
        _line(figure, engine_speeds * 30 / np.pi, values * factor, label, mode="lines+markers")
    figure.update_xaxes(title_text="engine speed (rpm)")
    figure.update_yaxes(title_text=f"{name.replace('_', ' ')} ({unit})")
    return figure


def plot_static_curve(curve: StaticCurve) -> go.Figure:
    """Force (N) above tangent stiffness (N/mm) over compression (mm)."""
    figure = _figure(str(curve).partition("\n")[0], rows=2)
    _line(figure, curve.compression * 1e3, curve.force, "force")
    _line(figure, curve.compression * 1e3, curve.stiffness * 1e-3, "stiffness", row=2)
    figure.update_yaxes(title_text="force (N)", row=1, col=1)
    figure.update_yaxes(title_text="stiffness (N/mm)", row=2, col=1)
    figure.update_xaxes(title_text="compression (mm)", row=2, col=1)
    return figure


def plot_modes(modes: ModalResult) -> go.Figure:
    """Axial displacement of up to eight axial modes over the coil number, each named by its natural
    frequency (Hz).
    """
    figure = _figure(str(modes).partition("\n")[0])
    for index in modes.axial_modes[:8]:
        _line(
            figure,
            modes.coil_number,
            modes.shape[index, :, 2],
            f"{modes.natural_frequency[index]:.5g} Hz",
        )
    figure.update_xaxes(title_text="coil number")
    figure.update_yaxes(title_text="axial displacement (1)")
    return figure


def _speaking_quantity(study: Study) -> str:
    """The first peak force among the numbers of the runs, else the first number."""
    names = list(dict.fromkeys(name for run in study.solutions for name in run.quantities))
    peaks = [
        name
        for name in names
        if unit_of(name) == "N" and name.startswith("peak") and "clash" not in name
    ]
    if not names:
        raise InputError(
            f"the runs of the study of {study.record.name} hold no quantities to draw; evaluate them first"
        )
    return (peaks or names)[0]


def _figure(title: str, rows: int = 1) -> go.Figure:
    from plotly.subplots import make_subplots

    figure = make_subplots(rows=rows, cols=1, shared_xaxes=True, vertical_spacing=0.06)
    figure.update_layout(
        title={"text": escape(title), "font": {"size": 14}},
        font={"family": theme.FONT, "size": 13, "color": theme.INK},
        paper_bgcolor=theme.PAPER,
        plot_bgcolor=theme.PAPER,
        colorway=theme.SERIES,
        showlegend=True,
    )
    figure.update_xaxes(showgrid=False, linecolor=theme.RULE, zeroline=False)
    figure.update_yaxes(gridcolor=theme.GRID, zeroline=False)
    return figure


def _line(
    figure: go.Figure, x: ArrayLike, y: ArrayLike, name: str, row: int = 1, mode: str = "lines"
) -> None:
    figure.add_scatter(
        x=np.asarray(x), y=np.asarray(y), name=escape(name), mode=mode, row=row, col=1
    )
