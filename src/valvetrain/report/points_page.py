"""The page of a study of points: what comes out first, then figures, then what failed and what was
asked.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from valvetrain.report.page import Block, Cell, Grid, Page, Section, figure_or_gap, text
from valvetrain.report.points_charts import (
    PERCENTILES,
    histogram_chart,
    map_chart,
    scatter_chart,
    sensitivity_chart,
    shown_output,
    surrogate_chart,
)
from valvetrain.report.words import number, unit_words
from valvetrain.solution.definition import definition_of
from valvetrain.studies.points.distributions import LogNormal, Normal, Uniform, Values
from valvetrain.studies.points.sensitivity import Sensitivity
from valvetrain.studies.points.table import StudyTable, run_words
from valvetrain.studies.points.varied import Varied

#: Failed points that are listed; and runs that have figures of their own.
MOST_FAILURES, MOST_RUNS = 50, 12


def points_page(table: StudyTable) -> Page:
    """The whole page."""
    plan = table.plan
    sections = [Section("answers", "What comes out", _answers(table))]
    for place, run in enumerate(plan.runs[:MOST_RUNS]):
        key = f"run-{place}"
        blocks: list[Block] = []
        for one in (found for found in table.sensitivities if found.run == run):
            blocks += (
                *figure_or_gap(one.output, sensitivity_chart, one, f"{key}-{one.output}"),
                shares_grid(one),
            )
        if plan.sampler.independent:
            blocks += figure_or_gap("scatter", histogram_chart, table, run, key)
        for name in table.outputs:
            if len(plan.varied) == 2:
                blocks += figure_or_gap(name, map_chart, table, name, run, f"{key}-{name}")
            blocks += figure_or_gap(name, scatter_chart, table, name, run, f"{key}-{name}")
        for made in (found for found in table.surrogates if found.run == run):
            blocks += figure_or_gap(made.output, surrogate_chart, made, f"{key}-{made.output}")
        sections.append(Section(key, run_words(run) or "Points", tuple(blocks)))
    if len(plan.runs) > MOST_RUNS:
        sections[0] = Section(
            "answers",
            "What comes out",
            (*sections[0].blocks, text(f"Figures of the first {MOST_RUNS} runs follow.", "note")),
        )
    if table.failures:
        sections.append(Section("failed", "Points that failed", _failed(table)))
    sections.append(Section("asked", "What was varied", (varied_grid(table),)))
    done = int(np.count_nonzero(table.completed))
    facts = (
        ("case", plan.case.name), ("points", f"{done} of {len(table)} completed"), ("sampler", plan.sampler.words),
        ("computed now", f"{table.computed} in {table.seconds:.0f} s"),
    )  # fmt: skip
    return Page(
        plan.title,
        "Study",
        plan.description,
        facts,
        tuple(sections),
        "Percentiles are of the points that completed.",
    )


def answer_rows(table: StudyTable) -> list[tuple[str, ...]]:
    """Output, run, least, percentiles, largest and unit, as people read them: the rows of page and
    terminal.
    """
    rows = []
    for run in table.plan.runs:
        places = table.rows_of(run)
        for name in table.outputs:
            found = shown_output(table, name)[places]
            found = found[np.isfinite(found)]
            label = definition_of(name).label
            values = (
                [np.min(found), *np.percentile(found, PERCENTILES), np.max(found)]
                if len(found)
                else [None] * 5
            )
            told = (number(None if value is None else float(value), 5) for value in values)
            rows.append(
                (
                    label[:1].upper() + label[1:],
                    run_words(run),
                    *told,
                    unit_words(definition_of(name).shown_unit),
                )
            )
    return rows


#: Heads of :func:`answer_rows`.
ANSWER_HEADS = ("", "run", "least", "5 %", "half", "95 %", "largest", "")


def sentences(table: StudyTable) -> tuple[str, ...]:
    """What the numbers say: which quantity makes the spread, how good a surrogate is, how many
    points failed.
    """
    failed = int(np.count_nonzero(~table.completed))
    told = (
        *(one.sentence for one in table.sensitivities),
        *(one.sentence for one in table.surrogates),
    )
    dropped = max((one.dropped for one in table.sensitivities), default=0)
    rows = "1 base row was" if dropped == 1 else f"{dropped} base rows were"
    left = f", and {rows} left out of the shares of variance" if dropped else ""
    return (
        *told,
        *table.not_given,
        *((f"{failed} of {len(table)} points failed{left}.",) if failed else ()),
    )


def _answers(table: StudyTable) -> tuple[Block, ...]:
    several = len(table.plan.runs) > 1
    rows = []
    for label, run, *values, unit in answer_rows(table):
        cells = [
            Cell(label),
            *([Cell(run)] if several else []),
            *(Cell(value, "number") for value in values),
            Cell(unit),
        ]
        rows.append((tuple(cells), ()))
    heads = tuple(head for place, head in enumerate(ANSWER_HEADS) if several or place != 1)
    heads = ("output", *heads[1:])
    return (*(text(sentence) for sentence in sentences(table)), Grid(heads, tuple(rows)))


def shares_grid(one: Sensitivity) -> Grid:
    """Shares of an output's variance with their intervals, the largest first."""

    def told(value: float, interval: Any) -> str:
        return f"{100 * value:.0f} ({100 * interval[0]:.0f} to {100 * interval[1]:.0f})".replace(
            "-", "−"
        )

    rows = tuple(
        (
            (
                Cell(one.names[n]),
                Cell(told(one.total[n], one.total_interval[n]), "number"),
                Cell(told(one.first[n], one.first_interval[n]), "number"),
            ),
            (),
        )
        for n in np.argsort(-one.total).tolist()
    )
    return Grid(("quantity", "with all it acts together with (%)", "alone (%)"), rows)


def _failed(table: StudyTable) -> tuple[Block, ...]:
    failures = table.failures
    blocks: list[Block] = [text(f"{sentence}", "alert") for sentence in failures[:MOST_FAILURES]]
    if len(failures) > MOST_FAILURES:
        blocks.append(
            text(f"And {len(failures) - MOST_FAILURES} more; points.csv has them all.", "note")
        )
    return tuple(blocks)


def varied_grid(table: StudyTable) -> Grid:
    """What is varied, over what."""
    rows = tuple(
        (
            (
                Cell(one.words),
                Cell(one.key),
                Cell({"value": "its value"}.get(one.operation, one.operation)),
                Cell(distribution_words(one)),
            ),
            (),
        )
        for one in table.plan.varied
    )
    return Grid(("quantity", "key of the case", "varied by", "over"), rows)


def distribution_words(one: Varied) -> str:
    """A distribution in words, in the unit of its quantity."""
    unit = unit_words(one.unit)

    def told(value: float) -> str:
        return f"{number(one.shown(value), 6)} {unit}".strip()

    found = one.distribution
    if isinstance(found, Uniform):
        return f"even from {told(found.low)} to {told(found.high)}"
    if isinstance(found, Normal):
        bounds = (
            f", cut at {told(found.low)} and {told(found.high)}"
            if np.isfinite(found.low) and np.isfinite(found.high)
            else ""
        )
        return f"normal about {told(found.mean)}, standard deviation {told(found.standard_deviation)}{bounds}"
    if isinstance(found, LogNormal):
        return f"lognormal about {told(found.median)}, two thirds within a factor of {number(found.factor)}"
    if isinstance(found, Values) and len(found.values) <= 12:
        return ", ".join(told(value) for value in found.values)
    return f"{len(getattr(found, 'values', ()))} values"
