"""What ``study`` shows: the best point or what moves an output, its outputs side by side, figures, and every point."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from valvetrain.explore.results import (
    MAX_ROWS,
    ExploreAnswer,
    Write,
    csv_writer,
    fields_of,
    range_text,
    rows_of,
    varied_of,
)
from valvetrain.explore.study_facts import PERCENTILES, Effect, StudyFacts
from valvetrain.explore.study_figures import figures_of_study
from valvetrain.explore.study_rules import RULES, per_cent
from valvetrain.explore.table import StudyTable, run_label
from valvetrain.findings.words import Amount
from valvetrain.solution.definition import label_of
from valvetrain.views.json import uncertainty_object
from valvetrain.views.style import FigureSpec
from valvetrain.views.table import Line, TextTable

#: Rows of the first table, its columns, points that a page lists, and listed values that are named.
ROWS, COLUMNS, LISTED, NAMED = 12, 5, 300, 12


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
        """Each output over what is varied, and what moves it."""
        return figures_of_study(self.facts)

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
        """Every point with its status, the outputs of every run, and what was varied."""
        table, plan = self.result, self.result.plan
        names = getattr(plan.options, "names", ()) or [str(k + 1) for k in range(len(table))]
        points = tuple(
            (
                names[row // len(plan.runs)], run_label(table.runs[row]),
                *(one.value_text(float(value)) for one, value in zip(plan.varied, table.inputs[row], strict=True)),
                *(self._cell(name, self.facts.column(name)[row]) for name in table.outputs),
                "" if table.statuses[row].completed else table.statuses[row].sentence(),
            )
            for row in range(min(LISTED, len(table)))
        )  # fmt: skip
        runs = tuple(
            (label_of(name), run_label(run), *(self._cell(name, one) for one in np.percentile(values, (0, *PERCENTILES, 100))))
            for run in plan.runs for name in self.facts.outputs if len(values := self.facts.finite(name, run))
        )  # fmt: skip
        varied = tuple((one.shown_name, one.key, one.operation, range_text(one)) for one in plan.varied)  # fmt: skip
        heads = ("point", "run", *(one.shown_name for one in plan.varied), *map(label_of, table.outputs), "status")  # fmt: skip
        of = "" if len(table) <= LISTED else f" of {len(table)}, which points.csv has"
        return {
            "points": TextTable(f"Points{of}", heads, points),
            "runs": TextTable("Outputs of every run", ("output", "run", "least", "5 %", "50 %", "95 %", "largest"), runs),
            "varied": TextTable("What was varied", ("quantity", "key of the case", "as", "over"), varied),
        }  # fmt: skip

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
            "case": plan.case_name, "title": plan.title, "kind": plan.kind, "sampler": plan.sampler.word, "points": len(table),
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

    @property
    def text(self) -> str:
        """The case file."""
        return "" if self.result.plan.case is None else self.result.plan.case.text


def _effect(one: Effect | None) -> str:
    """``98 % of the variance (95 to 99 %), rises with it``."""
    if one is None:
        return ""
    low, high = (f"{100 * min(max(0.0, end), 1.0):.0f}" for end in (one.low, one.high))
    sign = {1: ", rises with it", -1: ", falls with it", 0: ""}[one.rises]
    return f"{per_cent(min(1.0, one.share))} of the variance ({low} to {high} %){sign}"
