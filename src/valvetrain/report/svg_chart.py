"""Charts as SVG pictures, written directly: no drawing library to load, a few milliseconds a
figure.

docs/decisions/0017-pictures.md has the timing that spoke for this against matplotlib and kaleido.
"""

from __future__ import annotations

import base64
import struct
import zlib
from html import escape

import numpy as np
from numpy.typing import NDArray

from valvetrain.report import theme
from valvetrain.report.chart import (
    Chart,
    HeatMap,
    Line,
    Marks,
    Panel,
    label_heights,
    labelled_left,
    legend_entries,
    row_weights,
    rule_levels,
    rule_place,
    shares_axis,
    visible_range,
)

Array = NDArray[np.float64]
WIDTH = 960
_TITLE, _LEGEND, _LEFT, _RIGHT, _BOTTOM, _GAP_X, _GAP_Y = 30, 24, 64, 22, 46, 74, 66
#: Side of a mark -> steps right and down in px, and the anchor of the words there.
_OFFSETS = {
    "top": (0, -9, "middle"),
    "right": (9, 4, "start"),
    "left": (-9, 4, "end"),
    "bottom": (0, 19, "middle"),
}
_DASHES = {
    "solid": "",
    "dash": ' stroke-dasharray="6 4"',
    "dot": ' stroke-dasharray="2 3"',
    "dashdot": ' stroke-dasharray="8 3 2 3"',
}


class _Frame:
    """One panel's place on the picture and the way from its numbers to pixels."""

    def __init__(self, panel: Panel, left: float, top: float, wide: float, high: float) -> None:
        self.panel, self.left, self.top, self.wide, self.high = panel, left, top, wide, high
        self.x_range, self.y_range = visible_range(panel)

    def x(self, value: Array | float) -> Array:
        low, high = self.x_range
        return self.left + (np.asarray(value, dtype=float) - low) / (high - low) * self.wide

    def y(self, value: Array | float) -> Array:
        low, high = self.y_range
        level = np.asarray(value, dtype=float)
        if self.panel.y_log:
            low, high, level = np.log10(low), np.log10(high), np.log10(np.maximum(level, 1e-300))
        return self.top + self.high - (level - low) / (high - low) * self.high


def svg(chart: Chart) -> str:
    """The chart as one SVG document without any outside reference."""
    height = chart.height + _TITLE
    maps = any(isinstance(layer, HeatMap) for panel in chart.panels for layer in panel.layers)
    right = _RIGHT + (84 if maps else 0) + (44 if maps and _labelled(chart) else 0)
    top = _TITLE + (_LEGEND if chart.legend and legend_entries(chart) else 0) + 26
    left = max(
        _LEFT,
        min(
            300,
            14
            + int(
                6.6
                * max(
                    (len(label) for panel in chart.panels for _, label in panel.y_tick_labels),
                    default=0,
                )
            ),
        ),
    )
    wide = (WIDTH - left - right - (chart.columns - 1) * _GAP_X) / chart.columns
    gap = 54 if shares_axis(chart) else _GAP_Y
    weights = row_weights(chart, chart.columns)
    unit = (height - top - _BOTTOM - (chart.rows - 1) * gap) / sum(weights)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}" '
        f'font-family="{escape(theme.FONT, quote=True)}" font-size="12" fill="{theme.INK}">',
        f'<rect width="{WIDTH}" height="{height}" fill="{theme.PAPER}"/>',
        _text(_LEFT, 21, chart.title, size=15, weight=600),
    ]
    if chart.legend:
        parts.append(_legend(chart))
    for index, panel in enumerate(chart.panels):
        row, column = divmod(index, chart.columns)
        across, down = left + column * (wide + _GAP_X), top + unit * sum(weights[:row]) + row * gap
        frame = _Frame(panel, across, down, wide, unit * weights[row])
        named = not shares_axis(chart) or index == len(chart.panels) - 1
        parts += _panel(frame, f"{chart.key}-{index}", named)
    return "\n".join([*parts, "</svg>\n"])


def _labelled(chart: Chart) -> bool:
    return any(
        isinstance(layer, Line) and layer.direct for panel in chart.panels for layer in panel.layers
    )


def ticks(low: float, high: float, count: int = 6, step: float | None = None) -> tuple[Array, int]:
    """Round tick values inside ``low`` to ``high``, two at least to show the scale, and
    the decimals they need.
    """
    raw = (high - low) / count
    if step is None:
        scale = 10.0 ** np.floor(np.log10(raw))
        nice = [size * scale for size in (0.5, 1, 2, 2.5, 5, 10)]
        place = next(place for place, size in enumerate(nice) if size >= raw)
        while place and np.floor(high / nice[place] + 1e-9) <= np.ceil(low / nice[place] - 1e-9):
            place -= 1
        step = float(nice[place])
    values = np.arange(np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9) + 1) * step
    decimals = max(0, -int(np.floor(np.log10(step) + 1e-9)))
    if abs(step * 10**decimals - round(step * 10**decimals)) > 1e-9:
        decimals += 1
    return values, decimals


def _panel(frame: _Frame, name: str, x_named: bool) -> list[str]:
    panel = frame.panel
    parts = [_bands(frame), _grid(frame, x_named)]
    parts += [
        _text(frame.left + 3, float(frame.y(value)) - 6, label, colour=theme.MUTED)
        for value, label in panel.row_labels
    ]
    parts.append(
        f'<clipPath id="{name}"><rect {_box(frame)}/></clipPath><g clip-path="url(#{name})">'
    )
    for layer in panel.layers:
        if isinstance(layer, HeatMap):
            parts.append(_heat(frame, layer))
        elif isinstance(layer, Line):
            parts.append(_line(frame, layer))
    parts.append("</g>")
    parts += [_rules(frame)]
    parts += [_marks(frame, layer) for layer in panel.layers if isinstance(layer, Marks)]
    heights = label_heights(panel)
    parts += [
        _text(
            float(frame.x(layer.x[-1])) + 4,
            float(frame.y(heights[number])) + 4,
            layer.direct,
            colour=layer.colour,
        )
        for number, layer in enumerate(panel.layers)
        if isinstance(layer, Line) and number in heights
    ]
    parts += [_colour_bar(frame, layer) for layer in panel.layers if isinstance(layer, HeatMap)]
    level, across = frame.top - (20 if panel.bands else 7), frame.left - 20
    if panel.title:
        parts.append(_text(across, level, panel.title, size=12.5, weight=600))
    parts.append(
        _text(
            across + (7.2 * len(panel.title) + 14 if panel.title else 0),
            level,
            panel.y_label,
            colour=theme.MUTED,
            size=12,
        )
    )
    return parts


def _box(frame: _Frame) -> str:
    return f'x="{frame.left:.1f}" y="{frame.top:.1f}" width="{frame.wide:.1f}" height="{frame.high:.1f}"'


def _text(
    x: float,
    y: float,
    label: str,
    *,
    size: float = 11.5,
    colour: str = theme.INK,
    anchor: str = "start",
    weight: int = 400,
    turn: bool = False,
) -> str:
    turned = f' transform="rotate(-90 {x:.1f} {y:.1f})"' if turn else ""
    look = f'font-size="{size}" fill="{colour}" text-anchor="{anchor}"' + (
        f' font-weight="{weight}"' if weight != 400 else ""
    )
    return f'<text x="{x:.1f}" y="{y:.1f}" {look}{turned}>{escape(label)}</text>'


def _grid(frame: _Frame, x_named: bool) -> str:
    parts, base = [], frame.top + frame.high
    for value, label in _y_ticks(frame):
        place = float(frame.y(value))
        parts.append(
            f'<path d="M{frame.left:.1f} {place:.1f}h{frame.wide:.1f}" stroke="{theme.GRID}"/>'
        )
        parts.append(_text(frame.left - 7, place + 4, label, colour=theme.MUTED, anchor="end"))
    values, decimals = ticks(
        *frame.x_range, count=max(3, int(frame.wide / 75)), step=frame.panel.x_step
    )
    for value, place in zip(values, frame.x(values), strict=True):
        parts.append(f'<path d="M{place:.1f} {base:.1f}v4" stroke="{theme.RULE}"/>')
        parts.append(
            _text(
                place, base + 17, f"{value + 0.0:.{decimals}f}", colour=theme.MUTED, anchor="middle"
            )
        )
    parts.append(f'<path d="M{frame.left:.1f} {base:.1f}h{frame.wide:.1f}" stroke="{theme.RULE}"/>')
    if x_named:
        middle = frame.left + frame.wide / 2
        parts.append(
            _text(
                middle, base + 36, frame.panel.x_label, colour=theme.MUTED, anchor="middle", size=12
            )
        )
    return "".join(parts)


def _y_ticks(frame: _Frame) -> list[tuple[float, str]]:
    """Values and words of the ticks up the side; whole decades on a logarithmic axis, none where
    rows have labels.
    """
    if frame.panel.row_labels:
        return []
    if frame.panel.y_tick_labels:
        return list(frame.panel.y_tick_labels)
    if frame.panel.y_log:
        low, high = (round(float(np.log10(end))) for end in frame.y_range)
        return [(10.0**power, f"{10.0**power:g}") for power in range(low, high + 1)]
    values, decimals = ticks(*frame.y_range, count=max(3, int(frame.high / 45)))
    return [(float(value), f"{value + 0.0:.{decimals}f}") for value in values]


def _bands(frame: _Frame) -> str:
    parts = []
    for band in frame.panel.bands:
        first, last = np.clip([band.first, band.last], *frame.x_range)
        left, right = float(frame.x(first)), float(frame.x(last))
        if band.shaded:
            tall = f'y="{frame.top:.1f}" height="{frame.high:.1f}"'
            parts.append(
                f'<rect x="{left:.1f}" {tall} width="{right - left:.1f}" fill="{theme.BAND}"/>'
            )
        if right - left > 20:
            parts.append(
                _text(
                    (left + right) / 2,
                    frame.top - 5,
                    band.label,
                    colour=theme.MUTED,
                    anchor="middle",
                    size=11,
                )
            )
    return "".join(parts)


def _rules(frame: _Frame) -> str:
    parts = []
    for level, rule in zip(rule_levels(frame.panel), frame.panel.rules, strict=True):
        if rule.axis == "x":
            place = float(frame.x(rule.value))
            path = f"M{place:.1f} {frame.top:.1f}v{frame.high:.1f}"
            left = labelled_left(frame.panel, rule)
            label = _text(
                place + (-4 if left else 4),
                frame.top + 13 + 15 * level,
                rule.label,
                colour=theme.MUTED,
                anchor="end" if left else "start",
            )
        else:
            place = float(frame.y(rule.value))
            path = f"M{frame.left:.1f} {place:.1f}h{frame.wide:.1f}"
            end, above = rule_place(frame.panel, rule)
            across, down = frame.left + end * frame.wide, place + (-4 if above else 13)
            label = _text(across, down, rule.label, colour=theme.MUTED, anchor="end")
        parts.append(f'<path d="{path}" stroke="{theme.MUTED}" stroke-dasharray="1.5 3"/>{label}')
    return "".join(parts)


def _line(frame: _Frame, line: Line) -> str:
    points = np.round(np.column_stack((frame.x(line.x), frame.y(line.y))), 2)
    there = np.asarray(np.isfinite(points).all(axis=1))
    begins = there.copy()
    begins[1:] &= ~there[:-1]
    # one format for all points: a call for each takes five times as long
    form = "".join("M%g %g" if begin else "L%g %g" for begin in begins[there].tolist())
    path = form % tuple(points[there].ravel().tolist())
    style = f'stroke="{line.colour}" stroke-width="{line.width}" stroke-linejoin="round"{_DASHES[line.dash]}'
    return f'<path d="{path}" fill="none" {style}/>'


def _marks(frame: _Frame, marks: Marks) -> str:
    parts = []
    labels = marks.labels or ("",) * len(marks.x)
    for x, y, label in zip(
        np.asarray(marks.x, dtype=float), np.asarray(marks.y, dtype=float), labels, strict=True
    ):
        if not (
            frame.x_range[0] <= x <= frame.x_range[1] and frame.y_range[0] <= y <= frame.y_range[1]
        ):
            continue
        across, down = float(frame.x(x)), float(frame.y(y))
        if marks.size:
            parts.append(_symbol(across, down, marks))
        if label:
            right, lower, anchor = _OFFSETS[theme.LABEL_SIDES.get(marks.symbol, "top")]
            parts.append(
                _text(
                    across + right, down + lower, label, colour=marks.colour, anchor=anchor, size=11
                )
            )
    return "".join(parts)


def _symbol(x: float, y: float, marks: Marks) -> str:
    half = marks.size / 2
    look = f'fill="{marks.colour if marks.filled else "none"}" stroke="{marks.colour}" stroke-width="1.8"'
    if marks.symbol == "circle":
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{half}" {look}/>'
    steps = {
        "diamond": [(0, -1.2), (1.2, 0), (0, 1.2), (-1.2, 0)],
        "triangle": [(0, -1.1), (1.1, 0.9), (-1.1, 0.9)],
    }.get(marks.symbol, [(-1, -1), (1, -1), (1, 1), (-1, 1)])
    points = " ".join(f"{x + half * right:.1f},{y + half * down:.1f}" for right, down in steps)
    return f'<polygon points="{points}" {look}/>'


def _legend(chart: Chart) -> str:
    parts, x, y = [], float(_LEFT), _TITLE + 14
    for entry in legend_entries(chart):
        if isinstance(entry, Line):
            style = f'stroke="{entry.colour}" stroke-width="{max(entry.width, 1.8)}"{_DASHES[entry.dash]}'
            parts.append(f'<path d="M{x:.1f} {y - 4}h20" {style}/>')
        else:
            parts.append(_symbol(x + 10, y - 4, entry))
        parts.append(_text(x + 26, y, entry.name, size=12))
        x += 26 + 6.4 * len(entry.name) + 20
    return "".join(parts)


def _heat(frame: _Frame, heat: HeatMap) -> str:
    shares = (np.nan_to_num(heat.z, nan=heat.low) - heat.low) / (heat.top - heat.low)
    pixels = _coloured(shares, heat)[::-1]
    x, y = np.asarray(heat.x, dtype=float), np.asarray(heat.y, dtype=float)
    half_x, half_y = (np.ptp(values) / max(len(values) - 1, 1) / 2 for values in (x, y))
    left, right = float(frame.x(x.min() - half_x)), float(frame.x(x.max() + half_x))
    upper, lower = float(frame.y(y.max() + half_y)), float(frame.y(y.min() - half_y))
    link = "data:image/png;base64," + base64.b64encode(png(pixels)).decode()
    box = f'x="{left:.1f}" y="{upper:.1f}" width="{right - left:.1f}" height="{lower - upper:.1f}"'
    return (
        f'<image {box} preserveAspectRatio="none" style="image-rendering:pixelated" href="{link}"/>'
    )


def _coloured(share: Array, heat: HeatMap) -> NDArray[np.uint8]:
    stops = np.array(
        [[int(colour[place : place + 2], 16) for place in (1, 3, 5)] for colour in heat.colours],
        dtype=float,
    )
    position = np.clip(share, 0, 1) ** heat.power * (len(stops) - 1)
    channels = [
        np.interp(position, np.arange(len(stops)), stops[:, channel]) for channel in range(3)
    ]
    return np.stack(channels, axis=-1).round().astype(np.uint8)


def png(pixels: NDArray[np.uint8]) -> bytes:
    """An RGB picture (row, column, 3) as PNG."""
    rows, columns, _ = pixels.shape
    raw = np.concatenate(
        [np.zeros((rows, 1), dtype=np.uint8), pixels.reshape(rows, -1)], axis=1
    ).tobytes()

    def chunk(kind: bytes, content: bytes) -> bytes:
        return (
            struct.pack(">I", len(content))
            + kind
            + content
            + struct.pack(">I", zlib.crc32(kind + content))
        )

    header = struct.pack(">IIBBBBB", columns, rows, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(raw, 6))
        + chunk(b"IEND", b"")
    )


def _colour_bar(frame: _Frame, heat: HeatMap) -> str:
    left, count = frame.left + frame.wide + (58 if heat.second is not None else 14), 60
    shares = np.linspace(1, 0, count)
    link = (
        "data:image/png;base64," + base64.b64encode(png(_coloured(shares[:, None], heat))).decode()
    )
    parts = [
        f'<image x="{left:.1f}" y="{frame.top:.1f}" width="10" height="{frame.high:.1f}" preserveAspectRatio="none" href="{link}"/>'
    ]
    values, decimals = ticks(heat.low, heat.top, count=5)
    for value in values:
        parts.append(
            _text(
                left + 14,
                frame.top + frame.high * (heat.top - value) / (heat.top - heat.low) + 4,
                f"{value + 0.0:.{decimals}f}",
                colour=theme.MUTED,
                size=11,
            )
        )
    middle = frame.top + frame.high / 2
    parts.append(
        _text(
            left + 64,
            middle,
            f"{heat.name} ({heat.unit})",
            colour=theme.MUTED,
            anchor="middle",
            turn=True,
        )
    )
    return "".join(parts)
