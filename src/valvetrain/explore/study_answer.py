"""What ``study`` shows: the best point or what moves an output, its outputs side by side, figures, and every point."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from valvetrain.arrays import Array
from valvetrain.explore.results import (
    MAX_ROWS,
    ExploreAnswer,
    Write,
    csv_writer,
    fields_of,
    rows_of,
    varied_of,
)
from valvetrain.explore.study_facts import PERCENTILES, Effect, StudyFacts
from valvetrain.explore.study_rules import RULES, per_cent
from valvetrain.explore.table import StudyTable
from valvetrain.findings.words import Amount, speed_text
from valvetrain.solution.definition import definition_of, label_of, shown
from valvetrain.views.json import uncertainty_object
from valvetrain.views.style import LEAD, OK, OTHER, SPEEDS, FigureSpec, styled
from valvetrain.views.table import Line, TextTable

#: Rows of the first table, its columns, and points that a page lists.
ROWS, COLUMNS, LISTED = 12, 5, 300
#: Dots of a cloud, lines of a figure, points of a list and letters of a name.
DOTS, LINES, POINTS, LETTERS = 1500, 6, 40, 42


@dataclass(frozen=True)
class StudyAnswer(ExploreAnswer):
    """What is shown of a study of points, in the units of the reader by default.

    >>> import valvetrain as vt
    >>> table = vt.study('''
    ... case = "job-c"
    ... engine_speeds = "4000 rpm"
    ... spring_models = "massless"
    ... outputs = "peak_spring_force"
    ... points = { sampler = "grid", levels = 3 }
    ... vary = [{ key = "spring.precompression", low = "6 mm", high = "8 mm" }]
    ... ''')
    >>> StudyAnswer(table).verdict.code
    'J113'
    """

    rules = RULES

    result: StudyTable

    @property
    def title(self) -> str:
        """The title of the study."""
        return self.result.plan.title

    @cached_property
    def facts(self) -> StudyFacts:
        """The study as rules read it."""
        return StudyFacts(self.result, self.words.case)

    def figures(self) -> Mapping[str, FigureSpec]:
        """Each output over what is varied, and what moves it: the one that shows the verdict first."""
        facts = self.facts
        several = len(facts.changing) > 1 and not facts.listed
        specs: dict[str, FigureSpec] = {}
        for name in facts.outputs:
            label = label_of(name)
            over = FigureSpec(
                f"{label[:1].upper()}{label[1:]}",
                "",
                partial(_over, name=name),
            )
            effects = FigureSpec(
                f"What moves {label}",
                "shares of the variance with their 95 % intervals",
                partial(_effects, name=name),
            )
            both = {name: over} | ({f"{name}-effects": effects} if several else {})
            specs |= both if facts.chosen else dict(reversed(both.items()))
        return specs

    @property
    def headings(self) -> list[str]:
        """Columns of the first table: outputs or points, of many points the best ones, of draws percentiles."""
        return self._first[0]

    @property
    def lines(self) -> list[Line]:
        """The first table."""
        return self._first[1]

    @cached_property
    def _first(self) -> tuple[list[str], list[Line]]:
        """Columns and rows of the first table: few points with all outputs, else outputs and what is varied."""
        facts, designs = self.facts, len(self.facts.designs)
        if not facts.outputs:
            return [""], []
        if facts.chosen and 1 < designs <= ROWS:
            return self._matrix(designs)
        ends = facts.ends if facts.chosen else {f"{one:.0f} %": 0 for one in PERCENTILES}
        effects = {one.varied: one for one in facts.effects(facts.outputs[0])}
        rows = list[Line]()
        for name in facts.outputs[: ROWS // 2]:
            values = facts.worst(name)[list(ends.values())]
            if not facts.chosen:
                values = np.percentile(facts.finite(name, facts.run), PERCENTILES)
            rows.append(Line(label_of(name), tuple(self._cell(name, one) for one in values)))
        for one in effects or facts.table.plan.varied:
            column = facts.table.column(one.name)[:: len(facts.table.plan.runs)]
            at = column[[facts.designs[k][0] for k in ends.values()]] if facts.chosen else np.percentile(column, PERCENTILES)  # fmt: skip
            cells = tuple(one.value_text(float(value), 4) for value in at)
            rows.append(Line(one.shown_name, cells, "", _effect(effects.get(one))))
        return list(ends), rows[:ROWS]

    def _matrix(self, designs: int) -> tuple[list[str], list[Line]]:
        """A row for each point and a column for each output, or the other way round for few points with many outputs."""
        facts, best = self.facts, self.facts.ends.get("best", -1)
        points = [facts.label(k) for k in range(designs)]
        for one in () if facts.listed else facts.table.plan.varied:  # a name is said once
            points[1:] = [text.replace(f"{one.shown_name} ", "") for text in points[1:]]
        cells = {name: [self._cell(name, one) for one in facts.worst(name)] for name in facts.outputs}  # fmt: skip
        if designs < COLUMNS and designs < len(cells):
            rows = [Line(label_of(name), tuple(cells[name])) for name in facts.outputs[:ROWS]]
            return points, rows
        names = facts.outputs[:COLUMNS]
        marked = best if self.findings[0].code == "J113" else -1
        return [label_of(name) for name in names], [
            Line(points[k], tuple(cells[name][k] for name in names), *(("ok", "best") if k == marked else ()))
            for k in range(designs)
        ]  # fmt: skip

    def _cell(self, name: str, value: float) -> str:
        if not np.isfinite(value):
            return "–"
        return self.words.amount(Amount(name, float(value)), 4)

    def tables(self) -> Mapping[str, TextTable]:
        """Every point with its status."""
        table, plan = self.result, self.result.plan
        names = getattr(plan.options, "names", ()) or [str(k + 1) for k in range(len(table))]
        points = tuple(
            (
                names[row // len(plan.runs)], table.runs[row].label,
                *(one.value_text(float(value)) for one, value in zip(plan.varied, table.inputs[row], strict=True)),
                *(self._cell(name, self.facts.column(name)[row]) for name in table.outputs),
                "" if table.statuses[row].completed else table.statuses[row].sentence(),
            )
            for row in range(min(LISTED, len(table)))
        )  # fmt: skip
        heads = ("point", "run", *(one.shown_name for one in plan.varied), *map(label_of, table.outputs), "status")  # fmt: skip
        of = "" if len(table) <= LISTED else f" of {len(table)}, which points.csv has"
        return {"points": TextTable(f"Points{of}", heads, points)}

    @property
    def stopped(self) -> bool:
        """Whether it was stopped before its end."""
        return any(one.code == "interrupted" for one in self.result.statuses)

    @property
    def failures(self) -> tuple[str, ...]:
        """Points that were lost with their worker, or why none completed: that some cannot be built is part of the answer."""
        table = self.result
        if not table.completed.any():
            return table.failures[:1]
        lost = (row for row, one in enumerate(table.statuses) if one.code == "worker-lost")
        return tuple(f"{table.row_label(row)}: {table.statuses[row].sentence()}" for row in lost)[
            :5
        ]

    def data(self) -> dict[str, Any]:
        """Plan, indices, error bars and rows."""
        table, plan = self.result, self.result.plan
        bars = [
            {"row": row, **uncertainty_object(one)}
            for row, each in ({} if self.stopped else table.error_bars).items()
            for one in each.values()
        ]
        return {
            "case": plan.case_name, "title": plan.title, "sampler": plan.sampler.word, "points": len(table),
            "completed_points": int(np.count_nonzero(table.completed)), "computed": table.computed, "varied": varied_of(plan.varied),
            "sensitivities": fields_of(table.sensitivities), "uncertainties": bars,
            "failures": list(table.failures[:MAX_ROWS]),
            "completed": bool(table.completed.all()), **rows_of(table.to_pandas()),
        }  # fmt: skip

    def files(self) -> Mapping[str, Write]:
        """Every row as CSV."""
        return {"points.csv": csv_writer(self.result.to_pandas())}

    def computed(self) -> Iterator[str]:
        """Points, sampler, and what the percentiles and shares are of."""
        table, plan = self.result, self.result.plan
        if plan.description:
            yield plan.description
        done = int(np.count_nonzero(table.completed))
        yield f"{done} of {len(table)} points completed, by the sampler {plan.sampler.shown_name}."
        yield f"{table.computed} were computed now in {table.seconds:.0f} s, the others were stored before."
        for one in table.sensitivities[:1]:
            yield f"Shares are total Sobol indices of {one.rows} base rows; {one.dropped} were left out because a point of them failed."
        if not table.sensitivities:
            yield "Shares of the variance are squared correlations of ranks."


def _effect(one: Effect | None) -> str:
    """``98 % of the variance (95 to 99 %), rises with it``."""
    if one is None:
        return ""
    low, high = (f"{100 * min(max(0.0, end), 1.0):.0f}" for end in (one.low, one.high))
    sign = {1: ", rises with it", -1: ", falls with it", 0: ""}[one.rises]
    return f"{per_cent(min(1.0, one.share))} of the variance ({low} to {high} %){sign}"


def _axis(name: str) -> str:
    row = definition_of(name)
    return f"{row.label}, {row.unit_word}" if row.shown_unit else row.label


def _values(facts: StudyFacts, name: str) -> Array:
    return np.asarray(shown(name, facts.column(name))[0])


def _over(facts: StudyFacts, name: str) -> go.Figure | None:
    """An output at the points of a list, over two quantities of a grid as colour, else over the quantity that moves it most.

    Points of a list are in their order, each with its name.
    """
    table, y, speeds = facts.table, _values(facts, name), len(facts.designs[0])
    if np.count_nonzero(np.isfinite(y)) < 2 or not facts.changing:
        return None
    if table.plan.sampler.word == "grid" and len(facts.changing) == 2 and (speeds > LINES or len(facts.along) == 2):  # fmt: skip
        return _map(facts, name)
    order = [one.varied for one in facts.effects(name)] or [table.plan.varied[facts.changing[0]]]
    wanted = [table.plan.varied[k] for k in facts.along or facts.changing]
    varied = next((one for one in order if one in wanted), wanted[0])
    x = table.column(varied.name) * varied.shown(1.0)
    fig, title = go.Figure(), varied.axis_label
    if facts.listed:
        x, title = np.repeat(1.0 + np.arange(len(facts.draws)), len(table.plan.runs)), "point"
    lines = facts.chosen and len(facts.along or facts.changing) == 1
    for place, (label, rows) in enumerate(_series(facts).items()):
        rows = rows[np.argsort(x[rows], kind="stable")][:: max(1, len(rows) // DOTS)]
        fig.add_trace(go.Scatter(
            x=x[rows].astype(np.float32), y=y[rows].astype(np.float32), name=label, mode="lines+markers" if lines else "markers",
            marker={"color": SPEEDS[place % len(SPEEDS)], "size": 7 if lines else 4}, showlegend=bool(label), hovertemplate="%{y:.4~g}",
        ))  # fmt: skip
    _mark(fig, facts, name, x, y)
    styled(fig, title, (_axis(name),), 400)
    if facts.listed and len(facts.designs) == len(facts.draws) <= POINTS:
        labels = [facts.label(k) for k in range(len(facts.designs))]
        names = [one if len(one) <= LETTERS else f"point {k + 1}" for k, one in enumerate(labels)]
        fig.update_xaxes(tickvals=np.unique(x), ticktext=names, automargin=True)
    return fig


def _mark(fig: go.Figure, facts: StudyFacts, name: str, x: NDArray[Any], y: NDArray[Any]) -> None:
    """A star at the best point, at its worst run, by its row in x and y; none of other outputs and without a best point."""
    if (
        name == facts.outputs[0]
        and "best" in facts.ends
        and not (facts.within_bar or facts.over_speed)
    ):
        k = facts.worst_row(facts.ends["best"])
        star = {"color": OK, "size": 14, "symbol": "star"}
        fig.add_scatter(x=[x[k]], y=[y[k]], mode="markers", name="best", marker=star, showlegend=True)  # fmt: skip


def _series(facts: StudyFacts) -> dict[str, NDArray[np.intp]]:
    """What is drawn as one line -> its rows: the points of a run, or those of an engine speed that is varied."""
    table, count = facts.table, len(facts.table.plan.runs)
    if len(facts.designs[0]) > 1 and count == 1:
        speeds = table.column("engine_speed")
        return {speed_text(one): np.flatnonzero(speeds == one) for one in np.unique(speeds)}
    return {run.label * (count > 1): table.rows_of(run) for run in table.plan.runs}


def rows_figure(names: Sequence[str], at: Array, colours: list[str], title: str, ends: tuple[float, float]) -> go.Figure:  # fmt: skip
    """A dot with its bar in each row, from the top; ``at`` (rows, 3 or 4): value, low, high and, where there is one, the start,
    cut off at the ``ends``.
    """
    names = [one if len(one) <= LETTERS else f"{one[:18]} … {one[-18:]}" for one in names]
    best, low, high, *start = np.clip(at, *ends).T
    bars = {"array": high - best, "arrayminus": best - low, "color": "#a9c4e4", "thickness": 5, "width": 0}  # fmt: skip
    stroke = {"color": OTHER, "size": 12, "symbol": "line-ns-open", "line": {"width": 2}}
    dots = {"color": colours, "size": 11}
    fig = go.Figure([
        go.Scatter(x=x, y=names, name=name, mode="markers", marker=marker, error_x=error, hovertemplate="%{y}: %{x:.3~g}")
        for name, x, marker, error in (*(("start", one, stroke, None) for one in start), ("identified" if start else "", best, dots, bars))
    ])  # fmt: skip
    styled(fig, title, ("",), 125 + 28 * len(names))
    fig.update_layout(hovermode="closest", margin={"l": max(110, 7 * max(map(len, names)) + 20)})
    return fig.update_yaxes(autorange="reversed", dtick=1).update_xaxes(range=ends)


def _map(facts: StudyFacts, name: str) -> go.Figure:
    """An output over the two varied quantities of a grid as colour, by the run that decides."""
    varied, rows = [facts.table.plan.varied[k] for k in facts.changing], facts.table.rows_of(facts.run)  # fmt: skip
    x, y = (facts.table.column(one.name) * one.shown(1.0) for one in varied)
    bar = {"title": {"text": _axis(name), "side": "right"}}
    z = _values(facts, name)[rows]
    fig = go.Figure(go.Heatmap(x=x[rows], y=y[rows], z=z, colorscale="Viridis", colorbar=bar, hovertemplate="%{z:.4~g}"))  # fmt: skip
    _mark(fig, facts, name, x, y)
    return styled(fig, varied[0].axis_label, (varied[1].axis_label,), 420)


def _effects(facts: StudyFacts, name: str) -> go.Figure | None:
    """Shares of the variance (per cent) by varied quantity with their 95 % intervals, the largest first."""
    effects = facts.effects(name)
    if not effects:
        return None
    at = 100 * np.clip([(one.share, one.low, one.high) for one in effects], 0, 1.2)
    names = [one.varied.shown_name for one in effects]
    return rows_figure(names, at, [LEAD] * len(at), "share of the variance, %", (-3, max(103.0, float(at.max()) + 3)))  # fmt: skip
