"""Figures of a study of points: every output over every varied quantity, its scatter, maps, shares
of its variance, surrogates.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.outputs import Run
from valvetrain.explore.sensitivity import Sensitivity
from valvetrain.explore.surrogate import Surrogate
from valvetrain.explore.table import StudyTable, run_label
from valvetrain.report import theme
from valvetrain.report.chart import Chart, HeatMap, Layer, Line, Marks, Panel, Rule
from valvetrain.report.text import number, unit_text
from valvetrain.solution.definition import definition_of, shown

Array = NDArray[np.float64]
#: Dots of one panel, pieces of the line through their means, bars of a histogram, cells of a map
#: along each axis, height (px) of a row.
MAX_DOTS, PIECES, BARS, CELLS, ROW = 1500, 12, 30, 41, 250
#: Estimated shares of a variance beyond this are drawn at it.
MAX_SHARE = 1.2
PERCENTILES = (5.0, 50.0, 95.0)


def output_label(name: str) -> str:
    """An output with its unit, as an axis bears it."""
    row = definition_of(name)
    return f"{row.label} ({unit_text(row.unit_word)})" if row.shown_unit else row.label


def shown_input(table: StudyTable, index: int) -> Array:
    """Values (n,) of a varied quantity in its unit."""
    return np.array([table.plan.varied[index].shown(value) for value in table.inputs[:, index]])


def shown_output(table: StudyTable, name: str) -> Array:
    """Values (n,) of an output in the unit that tables print, nan where a point did not complete."""
    return np.asarray(shown(name, np.where(table.completed, table.column(name), np.nan))[0])


def scatter_chart(table: StudyTable, name: str, run: Run, key: str) -> Chart | None:
    """An output over each varied quantity: a dot per point and the mean along it."""
    rows = table.rows_of(run)
    y = shown_output(table, name)[rows]
    if np.count_nonzero(np.isfinite(y)) < 2:
        return None
    panels, single = list[Panel](), False
    changing = [
        index
        for index in range(len(table.plan.varied))
        if np.ptp(table.inputs[:, index]) > 0 or len(table.plan.varied) == 1
    ]
    # in a list of points, other quantities change along each as well, so a mean would mix them
    mixed = table.plan.sampler.word == "list" and len(changing) > 1
    for index in changing:
        x = shown_input(table, index)[rows]
        there = np.flatnonzero(np.isfinite(y))
        few = there[:: max(1, len(there) // MAX_DOTS)]
        colour = theme.mix(theme.SERIES[0], theme.PAPER, 0.45)
        layers: list[Layer] = [
            Marks(
                x[few],
                y[few],
                "point",
                colour,
                filled=True,
                size=4.0,
                in_legend=index == changing[0],
            )
        ]
        means = None if mixed else _means(x[there], y[there])
        if means is not None:
            # where each value has one point alone, the line is no mean
            single = len(means[0]) == len(there)
            label, seen = "mean of the points there", index == changing[0]
            layers.append(Line(*means, label, theme.SERIES[1], 2.0, in_legend=seen))
        ends, room = (float(np.min(x[there])), float(np.max(x[there]))), 0.015 * np.ptp(x[there])
        panels.append(
            Panel(
                table.plan.varied[index].axis_label,
                output_label(name),
                tuple(layers),
                x_range=(ends[0] - room, ends[1] + room)
                if room
                else None,  # whole dots at the ends
            )
        )
    if not panels:
        return None
    columns = min(3, len(panels)) if len(panels) != 4 else 2
    caption = (
        ""
        if single and len(panels) == 1
        else "A line that rises or falls shows that the output follows this quantity; a cloud about a level line, that it does not."
    )
    label = definition_of(name).label
    over = table.plan.varied[changing[0]].shown_name if len(panels) == 1 else "what is varied"
    title = f"{label[:1].upper()}{label[1:]} over {over}"
    return Chart(
        f"{key}-over",
        titled(title, table, run),
        caption,
        tuple(panels),
        columns,
        ROW * -(-len(panels) // columns) + 60,
        bool(caption),
    )


def _means(x: Array, y: Array) -> tuple[Array, Array] | None:
    """Means along x: of each level where there are few, else of pieces with as many points each."""
    levels = np.unique(x)
    if len(levels) < 2:
        return None
    if len(levels) <= PIECES:
        return levels, np.array([np.mean(y[x == level]) for level in levels])
    parts = np.array_split(np.argsort(x, kind="stable"), min(PIECES, max(2, len(x) // 8)))
    return np.array([np.mean(x[part]) for part in parts]), np.array(
        [np.mean(y[part]) for part in parts]
    )


def histogram_chart(table: StudyTable, run: Run, key: str) -> Chart | None:
    """How every output scatters, with its 5th, 50th and 95th percentile."""
    rows, panels = table.rows_of(run), []
    for name in table.outputs:
        found = shown_output(table, name)[rows]
        found = found[np.isfinite(found)]
        if len(found) < 3 or not np.ptp(found) > 0:
            continue
        counts, edges = np.histogram(found, bins=min(BARS, max(5, int(np.sqrt(len(found))))))
        x, y = (
            np.repeat(edges, 2),
            np.concatenate(([0.0], np.repeat(counts.astype(float), 2), [0.0])),
        )
        marks = np.percentile(found, PERCENTILES)
        rules = tuple(Rule("x", float(at), number(float(at), 4)) for at in marks)
        line = Line(x, y, "points", theme.SERIES[0], 1.6, in_legend=False)
        panels.append(
            Panel(
                output_label(name),
                "points",
                (line,),
                rules=rules,
                y_range=(0.0, 1.3 * float(np.max(counts))),
            )
        )
    if not panels:
        return None
    columns = min(2, len(panels))
    caption = "Vertical lines: 5, 50 and 95 % of the points are below."
    return Chart(
        f"{key}-scatter",
        titled("How the outputs scatter", table, run),
        caption,
        tuple(panels),
        columns,
        ROW * -(-len(panels) // columns) + 60,
        False,
    )


def map_chart(table: StudyTable, name: str, run: Run, key: str) -> Chart | None:
    """An output over two varied quantities as colour, straight between the points."""
    from scipy.interpolate import griddata
    from scipy.spatial import QhullError

    rows = table.rows_of(run)
    z = shown_output(table, name)[rows]
    x, y = (shown_input(table, index)[rows] for index in (0, 1))
    there = np.isfinite(z)
    if np.count_nonzero(there) < 4 or not (
        np.ptp(x[there]) > 0 and np.ptp(y[there]) > 0 and np.ptp(z[there]) > 0
    ):
        return None
    across, up = (np.linspace(np.min(one[there]), np.max(one[there]), CELLS) for one in (x, y))
    points = np.column_stack([(x - across[0]) / np.ptp(x[there]), (y - up[0]) / np.ptp(y[there])])[
        there
    ]
    request = np.stack(
        np.meshgrid((across - across[0]) / np.ptp(across), (up - up[0]) / np.ptp(up)), axis=-1
    )
    try:
        found = griddata(points, z[there], request, method="linear")
    except QhullError:  # all points on one line
        return None
    least, row = float(np.min(z[there])), definition_of(name)
    # colours begin at zero; where that would hide the differences, at the least value
    low = 0.0 if 0 <= least < 0.7 * float(np.max(z[there])) else least
    heat = HeatMap(
        across,
        up,
        np.maximum(np.nan_to_num(found, nan=low), low),
        row.label,
        unit_text(row.unit_word),
        1.0,
        table.plan.varied[1].axis_label,
        low=low,
    )
    dots = Marks(x[~there], y[~there], "point that failed", theme.ALERT, size=6.0, filled=True)
    layers: tuple[Layer, ...] = (heat, dots) if np.any(~there) else (heat,)
    panel = Panel(
        table.plan.varied[0].axis_label,
        table.plan.varied[1].axis_label,
        layers,
        x_range=_ends(across),
        y_range=_ends(up),
    )
    title = f"{row.label[:1].upper()}{row.label[1:]} over both quantities"
    caption = f"Colour: {output_label(name)}, straight between {np.count_nonzero(there)} points."
    return Chart(f"{key}-map", titled(title, table, run), caption, (panel,), 1, 420)


def _ends(axis: Array) -> tuple[float, float]:
    return float(axis[0]), float(axis[-1])


def sensitivity_chart(one: Sensitivity, key: str) -> Chart:
    """Shares of the variance by varied quantity: alone, and with all it acts together with, each
    with its interval.
    """
    order = np.argsort(one.total)
    indices = np.arange(len(order), dtype=float)
    layers: list[Layer] = []
    kinds = (
        ("with all it acts together with", one.total, one.total_interval, theme.SERIES[0], 0.12),
        ("alone", one.first, one.first_interval, theme.SERIES[1], -0.12),
    )
    for phrase, values, interval, colour, shift in kinds:
        for at, index in enumerate(order):
            ends = 100 * np.clip(interval[index], 0.0, MAX_SHARE)
            layers.append(
                Line(ends, np.full(2, at + shift), "95 % interval", colour, 1.4, in_legend=False)
            )
        layers.append(
            Marks(
                100 * np.clip(values[order], 0.0, MAX_SHARE),
                indices + shift,
                phrase,
                colour,
                filled=True,
                size=8.0,
            )
        )
    names = tuple((float(at), one.names[index]) for at, index in enumerate(order))
    high = 100 * float(np.clip(np.max(one.total_interval), 1.0, MAX_SHARE))
    panel = Panel(
        "share of the variance (%)",
        "",
        tuple(layers),
        x_range=(-3.0, high + 3.0),
        y_range=(-0.6, len(order) - 0.4),
        y_tick_labels=names,
    )
    caption = "Lines: 95 % intervals by bootstrap over the base rows. Shares are between 0 and 100 %; their estimates may be slightly outside."
    phrase = definition_of(one.output).label
    reported = run_label(one.run)
    title = f"What makes the spread of the {phrase}{f', {reported}' if reported else ''}"
    return Chart(f"{key}-shares", title, caption, (panel,), 1, 110 + 44 * len(order))


def surrogate_chart(one: Surrogate, key: str) -> Chart:
    """Prediction of each run by the surrogate from the other runs, against the run."""
    computed, predicted = (
        np.asarray(shown(one.output, values)[0]) for values in (one.computed, one.predicted)
    )
    ends = np.array([min(computed.min(), predicted.min()), max(computed.max(), predicted.max())])
    layers: tuple[Layer, ...] = (
        Line(ends, ends, "agreement", theme.MUTED, 1.0, "dash"),
        Marks(computed, predicted, "from the other points", theme.SERIES[0], filled=True, size=5.0),
    )
    label = output_label(one.output)
    panel = Panel(
        f"computed: {label}", "surrogate", layers, x_range=_ends(ends), y_range=_ends(ends)
    )
    title = f"Surrogate of the {definition_of(one.output).label}"
    return Chart(f"{key}-surrogate", title, one.sentence, (panel,), 1, 360)


def titled(title: str, table: StudyTable, run: Run) -> str:
    """A title with the run where it has a name."""
    phrase = run_label(run)
    return f"{title}, {phrase}" if phrase else title
