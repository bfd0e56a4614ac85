"""Figures in the units of the reader: axes whose label ends with a metric unit, scaled."""

from __future__ import annotations

import re
from dataclasses import replace

from valvetrain.report.chart import Chart, HeatMap, Layer, Panel
from valvetrain.report.text import number
from valvetrain.units.reader import reader_factor, reader_unit, shown_system

_UNIT = re.compile(r"\(([^()]+)\)\Z|\(([^()]+)\)(?=,)")


def chart_for_reader(chart: Chart) -> Chart:
    """The figure with its axes in the units requested; the same object where they are SI."""
    if shown_system() == "si":
        return chart
    return replace(chart, panels=tuple(map(_panel, chart.panels)))


def _axis(label: str) -> tuple[str, float]:
    """A label with the reader's unit, and what its numbers are multiplied with."""
    found = _UNIT.search(label)
    if found is None:
        return label, 1.0
    unit = found[1] or found[2]
    start, end = found.span(1 if found[1] else 2)
    return f"{label[:start]}{reader_unit(unit)}{label[end:]}", reader_factor(unit)


def _panel(panel: Panel) -> Panel:
    (x_label, x), (y_label, y) = _axis(panel.x_label), _axis(panel.y_label)
    scale = {"x": x, "y": y}
    return replace(
        panel,
        x_label=x_label,
        y_label=y_label,
        layers=tuple(_layer(one, x, y) for one in panel.layers),
        bands=tuple(replace(one, first=one.first * x, last=one.last * x) for one in panel.bands),
        rules=tuple(replace(one, value=one.value * scale[one.axis]) for one in panel.rules),
        x_range=_range(panel.x_range, x),
        y_range=_range(panel.y_range, y),
        x_step=panel.x_step if x == 1.0 else None,
        y_tick_labels=tuple(
            (value * y, _tick(value, y, text)) for value, text in panel.y_tick_labels
        ),
        row_labels=tuple((value * y, text) for value, text in panel.row_labels),
    )


def _tick(value: float, factor: float, text: str) -> str:
    """The words of a tick; a number is that of the scaled axis."""
    return number(value * factor, 3) if text == number(value, 3) else text


def _layer(layer: Layer, x: float, y: float) -> Layer:
    moved = replace(layer, x=layer.x * x, y=layer.y * y)
    if isinstance(moved, HeatMap):
        factor = reader_factor(moved.unit)
        moved = replace(
            moved, z=moved.z * factor, low=moved.low * factor, unit=reader_unit(moved.unit)
        )
    return moved


def _range(bounds: tuple[float, float] | None, factor: float) -> tuple[float, float] | None:
    return None if bounds is None else (bounds[0] * factor, bounds[1] * factor)
