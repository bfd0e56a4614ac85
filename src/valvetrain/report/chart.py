"""Description of a figure, independent of any drawing library: panels of lines, marks and maps,
rendered by ``plotly_chart`` for the page and by ``svg_chart`` for files.

Two renderers read it: ``plotly_chart`` for the page and ``svg_chart`` for the picture files, so
both show the same data.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.report import theme

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Line:
    """A curve; ``dash`` is solid, dash, dot or dashdot; ``direct`` is written next to its end."""

    x: Array
    y: Array
    name: str
    colour: str
    width: float = 1.7
    dash: str = "solid"
    in_legend: bool = True
    direct: str = ""


@dataclass(frozen=True, eq=False)
class Marks:
    """Single points, published values or events, each with a text next to it (empty for none) and
    ``hints`` read on hover; of size 0 the text alone.
    """

    x: Array
    y: Array
    name: str
    colour: str
    symbol: str = "circle"
    labels: tuple[str, ...] = ()
    in_legend: bool = True
    filled: bool = False
    size: float = 9.0
    hints: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class HeatMap:
    """``z`` (y, x) as colour from ``low``; the colour scale is stretched at small values, the numbers
    are not.

    ``second`` (y, x) is read on hover too, in words such as ``{:.0f} Hz`` given by ``second_unit``.
    """

    x: Array
    y: Array
    z: Array
    name: str
    unit: str
    power: float = 0.5
    y_tick_labels: str = "coil"
    second: Array | None = None
    second_unit: str = ""
    colours: tuple[str, ...] = theme.SEQUENTIAL
    low: float = 0.0

    @property
    def top(self) -> float:
        """The value that has the last colour."""
        top = float(np.nanmax(self.z, initial=self.low))
        return top if top > self.low else self.low + 1.0


Layer = Line | Marks | HeatMap


@dataclass(frozen=True, slots=True)
class Band:
    """A lightly shaded interval of the x axis with a label on top."""

    first: float
    last: float
    label: str
    shaded: bool = True


@dataclass(frozen=True, slots=True)
class Rule:
    """A thin line across the panel at ``value`` of axis ``x`` or ``y``, with a label."""

    axis: str
    value: float
    label: str = ""


@dataclass(frozen=True, eq=False)
class Panel:
    """One pair of axes. Ranges are (low, high) or None for what the data need; labels carry the
    unit. ``y_log``: y in decades.

    ``y_tick_labels``: (value, words) in place of numbers along y. ``row_labels``: the same, written
    inside the panel above their rows. ``weight``: height relative to other panels of the chart.
    """

    x_label: str
    y_label: str
    layers: tuple[Layer, ...]
    title: str = ""
    bands: tuple[Band, ...] = ()
    rules: tuple[Rule, ...] = ()
    x_range: tuple[float, float] | None = None
    y_range: tuple[float, float] | None = None
    x_step: float | None = None
    y_log: bool = False
    y_tick_labels: tuple[tuple[float, str], ...] = ()
    row_labels: tuple[tuple[float, str], ...] = ()
    weight: float = 1.0


def row_weights(chart: Chart, columns: int) -> list[float]:
    """Relative height of each row of panels in ``columns``, that of its tallest panel."""
    weights = [panel.weight for panel in chart.panels]
    return [max(weights[first : first + columns]) for first in range(0, len(weights), columns)]


#: Share of the width of a panel that a letter of a label takes: of one of two columns and of one
#: column of a wide page, and of a narrow page.
WIDE_LETTER, ALONE_LETTER, NARROW_LETTER = 0.0145, 0.009, 0.023


def rule_levels(panel: Panel, narrow: bool = False) -> list[int]:
    """Line on which the label of each vertical rule is written, so that no two overlap."""
    (low, high), levels = visible_range(panel)[0], [0] * len(panel.rules)
    letter = (NARROW_LETTER if narrow else WIDE_LETTER) * (high - low)
    written: list[tuple[int, float, float]] = []
    upright = sorted(
        (rule.value, index)
        for index, rule in enumerate(panel.rules)
        if rule.axis == "x" and rule.label
    )
    for value, index in upright:
        wide = letter * (len(panel.rules[index].label) + 1)
        left = value - wide if labelled_left(panel, panel.rules[index], narrow) else value
        taken = {level for level, start, end in written if start < left + wide and left < end}
        levels[index] = next(level for level in range(len(upright)) if level not in taken)
        written.append((levels[index], left, left + wide))
    return levels


#: Where the label of an upright rule begins below the top of a panel, and its height, as shares of that, on
#: a narrow page of its lower panels.
LABEL_TOP, LABEL_LINE, NARROW_LINE = 0.98, 0.08, 0.11


def label_line(narrow: bool) -> float:
    """Height of the label of an upright rule as a share of that of its panel."""
    return NARROW_LINE if narrow else LABEL_LINE


def range_below_labels(panel: Panel, narrow: bool = False) -> tuple[float, float]:
    """The visible range of y, widened upwards where a curve would run through the label of an upright rule."""
    (left, right), (low, high) = visible_range(panel)
    levels, letter = rule_levels(panel, narrow), NARROW_LETTER if narrow else ALONE_LETTER
    line = label_line(narrow)
    lines = [_shares(panel, one.x, one.y) for one in panel.layers if isinstance(one, Line)]
    covered, lowest = False, LABEL_TOP
    for rule, level in zip(panel.rules, levels, strict=True):
        if rule.axis != "x" or not rule.label or panel.y_log:
            continue
        wide, at = letter * (len(rule.label) + 1), (rule.value - left) / (right - left)
        begin = at - wide if labelled_left(panel, rule, narrow) else at
        top = LABEL_TOP - line * level
        box = begin, begin + wide, top - line, top
        covered = covered or any(_crossings(x, y, *box) for x, y in lines)
        lowest = min(lowest, top - line)
    return (low, low + (high - low) / lowest) if covered else (low, high)


#: Least distance of labels at the ends of lines, as a share of the panel's height, and share of its
#: width within which they are placed above each other.
LABEL_STEP, LABEL_REACH = 0.055, 0.15


def label_heights(panel: Panel) -> dict[int, float]:
    """Place of a line among the layers -> height at which the label at its end is written, moved up
    or down where labels of neighbours would overlap.
    """
    (left, right), (low, high) = visible_range(panel)
    ends = {
        place: (float(layer.x[-1]), float(layer.y[-1]))
        for place, layer in enumerate(panel.layers)
        if isinstance(layer, Line) and layer.direct and len(layer.x)
    }
    step = LABEL_STEP * (high - low)
    order = sorted(ends, key=lambda place: ends[place][1])
    heights = {place: y for place, (_, y) in ends.items()}
    for places, sign, bound in ((order, 1.0, -np.inf), (order[::-1], -1.0, -high)):
        done = list[int]()  # upwards from the lowest, then down again from the top of the panel
        for place in places:
            near = [
                other
                for other in done
                if abs(ends[other][0] - ends[place][0]) < LABEL_REACH * (right - left)
            ]
            bounds = [bound, *(sign * heights[other] + step for other in near)]
            heights[place] = sign * max(sign * heights[place], *bounds)
            done.append(place)
    return heights


def labelled_left(panel: Panel, rule: Rule, narrow: bool = False) -> bool:
    """Whether the label of a vertical rule is written left of it: near the right end, or where on the
    right alone another rule would run through it.
    """
    low, high = visible_range(panel)[0]
    room = max(0.1, (NARROW_LETTER if narrow else ALONE_LETTER) * len(rule.label))
    if rule.value > high - room * (high - low):
        return True
    wide = (NARROW_LETTER if narrow else WIDE_LETTER) * (len(rule.label) + 1) * (high - low)
    steps = [one.value - rule.value for one in panel.rules if one.axis == "x"]
    left = any(-wide < step < 0 for step in steps) or rule.value - wide < low
    return any(0 < step < wide for step in steps) and not left


#: Height of a label of a level rule as a share of the panel, and how close to its rule a curve may run.
LABEL_HEIGHT, ALONG_RULE = 0.1, 0.01


def rule_place(panel: Panel, rule: Rule, narrow: bool = False) -> tuple[float, bool]:
    """Share of the width at which the label of a level rule ends, and whether it is above the rule:
    where the fewest curves run through it, of equal places the furthest right.
    """
    level = float(_shares(panel, np.zeros(1), np.array([rule.value]))[1][0])
    wide = min(1.0, (NARROW_LETTER if narrow else WIDE_LETTER) * (len(rule.label) + 1))
    lines = [_shares(panel, one.x, one.y) for one in panel.layers if isinstance(one, Line)]
    best, fewest = (1.0, True), math.inf
    for above in (True, False):
        base = level + (ALONG_RULE if above else -LABEL_HEIGHT)
        top = level + (LABEL_HEIGHT if above else -ALONG_RULE)
        if top > 1.0 + ALONG_RULE or base < -ALONG_RULE:
            continue
        for end in np.linspace(1.0, wide, 25):
            crossed = sum(_crossings(x, y, end - wide, end, base, top) for x, y in lines)
            if crossed < fewest:
                best, fewest = (float(end), above), crossed
    return best


def _shares(panel: Panel, x: Array, y: Array) -> tuple[Array, Array]:
    """Points as shares of the width and the height of a panel."""
    (left, right), (low, high) = visible_range(panel)
    across, level = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    if panel.y_log:
        low, high, level = np.log10(low), np.log10(high), np.log10(np.maximum(level, 1e-300))
    return (across - left) / (right - left), (level - low) / (high - low)


def _crossings(x: Array, y: Array, left: float, right: float, low: float, high: float) -> int:
    """How many strokes of a line run through a box."""
    there = np.isfinite(x[:-1] + x[1:] + y[:-1] + y[1:])
    near = there & (np.fmin(x[:-1], x[1:]) <= right) & (np.fmax(x[:-1], x[1:]) >= left)
    begin, base, run, rise = x[:-1][near], y[:-1][near], np.diff(x)[near], np.diff(y)[near]
    upright = run == 0
    ends = (np.array([[left], [right]]) - begin) / np.where(upright, 1.0, run)
    ends = np.where(upright, np.array([[0.0], [1.0]]), np.clip(ends, 0.0, 1.0))
    height = base + ends * rise
    return int(np.count_nonzero((height.min(axis=0) < high) & (height.max(axis=0) > low)))


def shares_axis(chart: Chart, columns: int | None = None) -> bool:
    """True when panels are above each other over one x axis, which is then labelled once, at the
    bottom.
    """
    labels, ranges = (
        {getattr(panel, name) for panel in chart.panels} for name in ("x_label", "x_range")
    )
    return (
        (columns or chart.columns) == 1
        and len(chart.panels) > 1
        and len(labels) == 1
        and len(ranges) == 1
        and None not in ranges
    )


@dataclass(frozen=True, eq=False)
class Chart:
    """A figure: ``panels`` filled row by row into ``columns``; ``height`` in pixels of the page."""

    key: str
    title: str
    caption: str
    panels: tuple[Panel, ...]
    columns: int = 1
    height: int = 380
    legend: bool = True

    @property
    def rows(self) -> int:
        """Rows of panels."""
        return -(-len(self.panels) // self.columns)


def visible_range(panel: Panel) -> tuple[tuple[float, float], tuple[float, float]]:
    """Axis ranges of a panel: as specified, else fitted to its layers (y with a margin)."""
    x_values = [np.asarray(layer.x, dtype=float) for layer in panel.layers]
    x_range = panel.x_range or _limits(x_values, 0.0)
    if panel.y_range is not None:
        return x_range, panel.y_range
    y_values = []
    for layer, x in zip(panel.layers, x_values, strict=True):
        y = np.asarray(layer.y, dtype=float)
        y_values.append(
            y if isinstance(layer, HeatMap) else y[(x >= x_range[0]) & (x <= x_range[1])]
        )
    maps = any(isinstance(layer, HeatMap) for layer in panel.layers)
    if panel.y_log:
        decades = [np.log10(y[y > 0]) for y in y_values]
        below, above = _limits(decades, 0.0)
        return x_range, (
            10.0 ** np.floor(below + 1e-9),
            10.0 ** max(np.ceil(above - 1e-9), np.floor(below + 1e-9) + 1),
        )
    low, high = _limits(y_values, 0.0 if maps else 0.07)
    worded = any(isinstance(layer, Marks) and any(layer.labels) for layer in panel.layers)
    return x_range, (low, high + 0.05 * (high - low) if worded else high)


def _limits(arrays: list[Array], margin: float) -> tuple[float, float]:
    joined = (
        np.concatenate([array[np.isfinite(array)].ravel() for array in arrays])
        if arrays
        else np.zeros(0)
    )
    if joined.size == 0:
        return 0.0, 1.0
    low, high = float(joined.min()), float(joined.max())
    room = (high - low) * margin
    if high - low <= 1e-12 * max(abs(high), abs(low), 1e-300):
        room = 0.5 * abs(high) or 1.0
    return low - room, high + room


def legend_entries(chart: Chart) -> list[Line | Marks]:
    """The lines and marks that need a key, each name once."""
    seen: dict[str, Line | Marks] = {}
    for panel in chart.panels:
        for layer in panel.layers:
            if isinstance(layer, (Line, Marks)) and layer.in_legend and layer.name:
                seen.setdefault(layer.name, layer)
    return list(seen.values())


def thin(x: Array, y: Array, limit: int = 2000) -> tuple[Array, Array]:
    """At most about ``limit`` points of a curve that include the extremes of every interval, so no
    spike is lost.
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    if len(x) <= limit:
        return x, y
    size = int(np.ceil(2 * len(x) / limit))
    starts = np.arange(0, len(x), size)
    keep = [np.array([0, len(x) - 1])]
    full = [start for start in starts if np.any(np.isfinite(y[start : start + size]))]
    for pick in (np.nanargmin, np.nanargmax):
        keep.append(np.array([start + int(pick(y[start : start + size])) for start in full]))
    index = np.unique(np.concatenate(keep).astype(int))
    return x[index], y[index]


def stems(x: Array, y: Array, base: float = 0.0) -> tuple[Array, Array]:
    """Upright strokes from ``base`` to each ``y``, as one broken line; drawn wide they are bars."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    gap = np.full_like(x, np.nan)
    return np.stack([x, x, gap], axis=1).ravel(), np.stack(
        [np.full_like(y, base), y, gap], axis=1
    ).ravel()
