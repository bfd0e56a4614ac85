"""Values point by point of a study whose points are chosen, as a list or a grid, not drawn at
random; and changes from the first point of a list that changes one quantity at a time.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.outputs import Run
from valvetrain.explore.study_charts import (
    output_label,
    shown_input,
    shown_output,
    titled,
)
from valvetrain.explore.table import StudyTable, run_label
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Marks, Panel, Rule
from valvetrain.report.text import number, unit_text
from valvetrain.solution.definition import definition_of

Array = NDArray[np.float64]
#: Points that appear as columns side by side; more are rows.
MAX_SIDE = 5
#: Points and runs of a figure with a line for each point, and height (px) of a line.
MAX_LINES, MAX_SERIES, LINE = 40, 6, 26
#: Letters of a point's label that fit next to its line.
MAX_LETTERS = 50


def is_chosen(table: StudyTable) -> bool:
    """Whether every point was chosen, so that percentiles over them would be no real scatter."""
    return not table.plan.sampler.independent


def draws_of(table: StudyTable) -> Array:
    """Values (draws, d) of the varied quantities, SI; a point of the study each."""
    return table.inputs[:: max(1, len(table.plan.runs))]


def changing(table: StudyTable) -> list[int]:
    """Varied quantities that are not the same at every point."""
    return [index for index, column in enumerate(draws_of(table).T) if np.any(column != column[:1])]


def changed_alone(table: StudyTable) -> dict[int, int]:
    """Point -> the one quantity that differs there from the first point; empty unless the points
    are a list in which that holds of each, for two quantities or more.
    """
    draws = draws_of(table)
    if table.plan.sampler.word != "list" or len(draws) < 3:
        return {}
    differs = ~np.isclose(draws[1:], draws[0], rtol=1e-12, atol=0.0)
    if np.any(differs.sum(axis=1) != 1) or np.count_nonzero(differs.any(axis=0)) < 2:
        return {}
    return {1 + row: int(np.argmax(one)) for row, one in enumerate(differs)}


def point_names(table: StudyTable) -> tuple[str, ...]:
    """The names that the points of a list have in their file; empty where they have none."""
    return tuple(getattr(table.plan.options, "names", ()))


def point_label(table: StudyTable, point: int, without: tuple[int, ...] = ()) -> str:
    """Label that distinguishes a point (from 0) from the others: its name, else the quantities that change, with
    their values, those of ``without`` left out.
    """
    if names := point_names(table):
        return names[point]
    alone = changed_alone(table)
    if alone and point == 0:
        return "first point"
    indices = [alone[point]] if alone else changing(table)
    parts = []
    for index in (one for one in indices if one not in without):
        parts.append(table.plan.varied[index].text(float(draws_of(table)[point, index])))
    return ", ".join(parts) or f"point {point + 1}"


def _short_label(table: StudyTable, point: int) -> str:
    """The number of a point and, where they fit, its values without their names."""
    values = [
        table.plan.varied[index].value_text(float(draws_of(table)[point, index]))
        for index in changing(table)
    ]
    label = f"point {point + 1}: {', '.join(values)}"
    return label if len(label) <= MAX_LETTERS else f"point {point + 1}"


def point_table(
    table: StudyTable,
) -> tuple[tuple[str, ...], list[tuple[str, ...]], tuple[int, ...]]:
    """Heads, rows and columns of numbers of the values point by point: up to :data:`MAX_SIDE`
    points side by side, more below each other.
    """
    runs, varied = table.plan.runs, changing(table)
    several = len(runs) > 1
    inputs = [shown_input(table, index)[:: len(runs)] for index in varied]
    outputs = {name: shown_output(table, name).reshape(-1, len(runs)) for name in table.outputs}
    count = len(draws_of(table))
    rows: list[tuple[str, ...]] = []
    if count <= MAX_SIDE:
        for index, values in zip(varied, inputs, strict=True):
            one = table.plan.varied[index]
            own = [number(float(value), 5) for value in values]
            unit = "× case" if one.operation == "factor" else unit_text(one.unit)
            rows.append((one.shown_name, *([""] * several), *own, unit))
        for place, run in enumerate(runs):
            for name in table.outputs:
                row, texts = definition_of(name), _texts(outputs[name][:, place])
                label = f"{row.label[:1].upper()}{row.label[1:]}"
                head = (label, *([run_label(run)] * several))
                rows.append((*head, *texts, unit_text(row.unit_word)))
        heads = (
            "",
            *(["run"] * several),
            *(point_names(table) or (f"point {k + 1}" for k in range(count))),
            "",
        )
        return heads, rows, tuple(range(1 + several, 1 + several + count))
    names = point_names(table)
    for point in range(count):
        own = [number(float(values[point]), 5) for values in inputs]
        for place, run in enumerate(runs):
            texts = _texts(np.array([outputs[name][point, place] for name in table.outputs]))
            name = names[point] if names else str(point + 1)
            rows.append((name, *own, *([run_label(run)] * several), *texts))
    heads = (
        "point",
        *(table.plan.varied[index].axis_label for index in varied),
        *(["run"] * several),
        *map(output_label, table.outputs),
    )
    first = 1 + len(varied)
    texts_at = ({first} if several else set()) | ({0} if names else set())
    return heads, rows, tuple(k for k in range(len(heads)) if k not in texts_at)


def _texts(values: Array) -> tuple[str, ...]:
    return tuple(number(float(value) if np.isfinite(value) else None, 4) for value in values)


def values_chart(table: StudyTable, name: str, key: str) -> Chart | None:
    """The value of an output at every point, a line of the figure each, one mark a run; None for
    too many points.
    """
    runs, count = table.plan.runs[:MAX_SERIES], len(draws_of(table))
    values = shown_output(table, name).reshape(count, -1)
    if not 2 <= count <= MAX_LINES or not np.any(np.isfinite(values)):
        return None
    height: Array = np.arange(count, dtype=float)[::-1]
    layers: list[Layer] = []
    for place, run in enumerate(runs):
        there = np.isfinite(values[:, place])
        colour = theme.SERIES[place % len(theme.SERIES)]
        label, known = run_label(run) or definition_of(name).label, values[there, place]
        layers.append(Marks(known, height[there], label, colour, filled=True, size=9.0))
    panel = _lines(table, output_label(name), layers, list(range(count)), height)
    title, every = definition_of(name).label, len(table.plan.runs)
    return Chart(
        f"{key}-values",
        f"{title[:1].upper()}{title[1:]} at every point",
        f"The first {MAX_SERIES} of {every} runs." if every > MAX_SERIES else "",
        (panel,),
        1,
        110 + LINE * count,
        len(runs) > 1,
    )


def changes_chart(table: StudyTable, name: str, run: Run, key: str) -> Chart | None:
    """The change of an output from the first point where one quantity alone is changed, a bar for
    each point.
    """
    alone, values = changed_alone(table), shown_output(table, name)[table.rows_of(run)]
    if not alone or not np.isfinite(values[0]) or len(values) > MAX_LINES:
        return None
    points = sorted(alone, key=lambda point: (alone[point], point))
    change = np.array([values[point] - values[0] for point in points])
    height: Array = np.arange(len(points), dtype=float)[::-1]
    there = np.isfinite(change)
    strokes = np.column_stack([np.zeros_like(change), change, np.full_like(change, np.nan)])[there]
    layers: list[Layer] = [
        Line(strokes.ravel(), np.repeat(height[there], 3), "", theme.SERIES[0], 6.0, in_legend=False),
        Marks(change[there], height[there], "", theme.SERIES[0], in_legend=False, filled=True, size=7.0),
    ]  # fmt: skip
    row = definition_of(name)
    panel = _lines(table, f"change of the {output_label(name)}", layers, points, height, 0.0)
    unit = unit_text(row.unit_word)
    caption = f"Each point changes one quantity of the first, which has {number(float(values[0]), 4)} {unit}".strip()
    title = titled(f"Change of the {row.label} from the first point", table, run)
    return Chart(
        f"{key}-changes", title, f"{caption}.", (panel,), 1, 110 + LINE * len(points), False
    )


def _reach(layers: list[Layer], zero: float | None) -> tuple[float, float] | None:
    """The values with a margin on both sides for their marks; None where all are one."""
    values = np.concatenate([np.asarray(layer.x, dtype=float) for layer in layers])
    values = np.append(values[np.isfinite(values)], [] if zero is None else [zero])
    room = 0.06 * float(np.ptp(values))
    return (float(values.min()) - room, float(values.max()) + room) if room > 0 else None


def _lines(
    table: StudyTable,
    label: str,
    layers: list[Layer],
    points: list[int],
    height: Array,
    zero: float | None = None,
) -> Panel:
    labels = [point_label(table, point) for point in points]
    if max(map(len, labels)) > MAX_LETTERS:
        labels = [_short_label(table, point) for point in points]
    ticks = tuple((float(at), label) for at, label in zip(height, labels, strict=True))
    return Panel(
        label,
        "",
        tuple(layers),
        x_range=_reach(layers, zero),
        y_range=(-0.7, len(points) - 0.3),
        y_tick_labels=ticks,
        rules=() if zero is None else (Rule("x", zero),),
    )
