"""What a notebook shows first of a result of the core: its table and its figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.parameters.summary import number, unit_text
from valvetrain.report import theme
from valvetrain.report.chart import (
    Chart,
    Layer,
    Line,
    Marks,
    Panel,
    Rule,
    stems,
    thin,
    visible_range,
)
from valvetrain.report.page import Block, Cell, Figure, Grid
from valvetrain.report.text import quantity_label
from valvetrain.solution.comparison import Comparison
from valvetrain.solution.critical import CriticalSpeeds, places_text
from valvetrain.solution.cycle_view import angle_within, first_revolution
from valvetrain.solution.display import SHOWN_UNITS, heading, value_text
from valvetrain.solution.modes import ModalResult, TrainModes
from valvetrain.solution.result import Solution
from valvetrain.solution.static import StaticCurve

Blocks = tuple[Block, ...]
RPM = np.pi / 30
ANGLE, COMPRESSION = "cam angle (deg)", "compression (mm)"
#: Lines of one figure at most.
MAX_LINES = 8


def _from_its_revolution(run: Solution) -> NDArray[np.float64]:
    """Cam angle (deg) of every sample from the start of the revolution in which they begin."""
    return np.degrees(angle_within(run.cam_angle, first_revolution(run.cam_angle)))


def static_curve_blocks(curve: StaticCurve) -> Blocks:
    """Force above tangent stiffness over compression."""
    x = curve.compression * 1e3
    force = _panel(COMPRESSION, "force (N)", [("force", x, curve.force)])
    rate = [("stiffness", x, curve.stiffness * 1e-3)]
    return (_figure(curve, force, _panel(COMPRESSION, "stiffness (N/mm)", rate)),)


def modes_blocks(modes: ModalResult) -> Blocks:
    """Axial displacement of up to eight axial modes over the coils."""
    lines = [
        (f"{modes.natural_frequency[n]:.5g} Hz", modes.coil_number, modes.shape[n, :, 2])
        for n in modes.axial_modes
    ]
    return (_figure(modes, _panel("coil number", "axial displacement", lines)),)


def train_modes_blocks(modes: TrainModes) -> Blocks:
    """Share of every part in the energy of each mode, a row for each with its frequency."""
    rows = np.arange(len(modes.natural_frequency), 0.0, -1.0)
    count, layers = len(modes.parts), list[Layer]()
    for place, part in enumerate(modes.parts):
        y = rows - 0.7 * ((place + 0.5) / count - 0.5)
        along, share = stems(y, 100 * modes.energy_share[:, place])
        layers.append(Line(share, along, part, theme.SERIES[place % len(theme.SERIES)], 5.0))
    panel = Panel(
        "share of kinetic energy (%)",
        "",
        tuple(layers),
        x_range=(0.0, 100.0),
        y_range=(0.4, len(rows) + 0.6),
        y_tick_labels=tuple(
            (float(at), f"{frequency:.4g} Hz")
            for at, frequency in zip(rows, modes.natural_frequency, strict=True)
        ),
    )
    return (_figure(modes, panel),)


def critical_speeds_blocks(found: CriticalSpeeds) -> Blocks:
    """Where control is lost, in rpm, with the range that was searched."""
    rows = [(one.label, one.kind, f"{one.text} rpm", places_text(*one.places)) for one in found]
    grid = _grid(("run", "kind", "engine speed", "first at"), rows)
    if not len(found):
        return (grid,)
    layers: list[Layer] = []
    for height, one in enumerate(reversed(found.rows)):
        ends = np.array([one.first_engine_speed, one.last_engine_speed]) / RPM
        level = np.full(2, float(height))
        layers.append(Line(ends, level, "searched", theme.RULE, 1.2, in_legend=height == 0))
        if one.found:
            at = np.array([one.engine_speed / RPM])
            layers.append(Marks(at, level[:1], "lost from here", theme.SERIES[1], filled=True))
    named = tuple(
        (float(height), f"{one.label}, {one.kind}")
        for height, one in enumerate(reversed(found.rows))
    )
    panel = Panel(
        "engine speed (rpm)",
        "critical speed (kind)",
        tuple(layers),
        y_range=(-0.6, len(found) - 0.4),
        y_tick_labels=named,
    )
    return grid, _figure(found, panel)


def comparison_blocks(row: Comparison) -> Blocks:
    """The published value with its tolerance next to the computed one, on one row."""
    speed = "" if row.engine_speed is None else value_text(row.engine_speed, "rad/s")
    texts = [
        "" if value is None else f"{value:.5g} {row.unit}".strip()
        for value in (row.published, row.computed, row.difference)
    ]
    heads = ("quantity", "engine speed", "model", "published", "computed", "difference", "verdict")
    cells = (quantity_label(row.quantity), speed, row.model, *texts, row.verdict)
    one, layers = np.ones(1), list[Layer]()
    if row.tolerance is not None:
        ends = row.published + np.array([-row.tolerance, row.tolerance])
        layers.append(Line(ends, np.ones(2), "tolerance", theme.MUTED, 4.0))
    published = Marks(one * row.published, one, f"published ({row.origin})", theme.INK)
    layers.append(published)
    if row.computed is not None:
        value = one * row.computed
        layers.append(Marks(value, one, f"computed by {row.model}", theme.SERIES[0], "diamond"))
    label = _with_unit(quantity_label(row.quantity), row.unit)
    panel = Panel(label, "", tuple(layers), y_range=(0.5, 1.5), y_tick_labels=((1.0, row.model),))
    panel = replace(panel, x_range=_wider(visible_range(panel)[0]))
    return _grid(heads, [cells]), _figure(row, panel)


def cycles_blocks(cycles: MeasuredCycles) -> Blocks:
    """Single cycles and their mean, with the extremes of the mean."""
    unit, factor = SHOWN_UNITS.get(cycles.unit, (cycles.unit, 1.0))
    angle, label = np.degrees(cycles.cam_angle), cycles.quantity.replace("_", " ")
    mean = cycles.mean * factor
    rows = [
        (name, number(float(mean[at]), 5), unit_text(unit), f"{angle[at]:.2f} deg")
        for name, at in (("largest", np.nanargmax(mean)), ("smallest", np.nanargmin(mean)))
    ]
    layers: list[Layer] = [
        Line(*thin(angle, one * factor), "single cycles", theme.RULE, 0.9, in_legend=not index)
        for index, one in enumerate(cycles.values[:20])
    ]
    layers.append(Line(*thin(angle, mean), "mean", theme.SERIES[0]))
    panel = Panel(ANGLE, _with_unit(label, unit), tuple(layers), x_range=(0.0, 360.0))
    return _grid((label, "mean of the cycles", "", "cam angle"), rows), _figure(cycles, panel)


def _panel(
    x_label: str,
    y_label: str,
    lines: Sequence[tuple[str, ArrayLike, ArrayLike]],
    colour: str = "",
    rules: tuple[Rule, ...] = (),
) -> Panel:
    """Lines of (name, x, y) in the colours of a series; a single one is named by its axis."""
    layers = tuple(
        Line(
            _floats(x),
            _floats(y),
            name,
            colour or theme.SERIES[place % len(theme.SERIES)],
            in_legend=len(lines) > 1,
        )
        for place, (name, x, y) in enumerate(lines[:MAX_LINES])
    )
    panel = Panel(x_label, y_label, layers, rules=rules)
    return replace(panel, x_range=visible_range(panel)[0])


def _with_unit(label: str, unit: str) -> str:
    """A label of an axis; what has no dimension has no unit behind it."""
    return label if unit in ("", "1") else f"{label} ({unit})"


def _wider(ends: tuple[float, float]) -> tuple[float, float]:
    """A range with a margin at both ends, so that marks there stay whole."""
    room = 0.08 * (ends[1] - ends[0])
    return ends[0] - room, ends[1] + room


def _figure(result: object, *panels: Panel) -> Figure:
    title, named = heading(result), len(panels[0].y_tick_labels)
    height = max(240 * len(panels), 24 * named) + 90
    return Figure(Chart("result", title, "", panels, 1, height))


def _figures(chart: Chart | None) -> Blocks:
    return () if chart is None else (Figure(chart),)


def _grid(heads: tuple[str, ...], rows: Sequence[Sequence[str]]) -> Grid:
    return Grid(heads, tuple((tuple(map(Cell, row)), ()) for row in rows))


def _floats(values: ArrayLike) -> NDArray[np.float64]:
    return np.asarray(values, dtype=np.float64)
