"""The page of a study of points: what comes out first, then figures, then failed points and the
request.
"""

from __future__ import annotations

import csv
import io
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.explore.clearance import clearance_chart, over_clearance
from valvetrain.explore.doubts import doubts
from valvetrain.explore.outputs import Run
from valvetrain.explore.sensitivity import Sensitivity
from valvetrain.explore.space import Values, Varied
from valvetrain.explore.study_charts import (
    PERCENTILES,
    histogram_chart,
    map_chart,
    scatter_chart,
    sensitivity_chart,
    shown_output,
    surrogate_chart,
)
from valvetrain.explore.study_points import (
    changed_alone,
    changes_chart,
    is_chosen,
    point_table,
    values_chart,
)
from valvetrain.explore.study_verdict import judged_output
from valvetrain.explore.table import StudyTable, run_label
from valvetrain.report.json import uncertainty_object
from valvetrain.report.page import (
    Block,
    Cell,
    Details,
    Figure,
    Grid,
    Page,
    Section,
    figure_or_gap,
    render,
    text,
)
from valvetrain.report.study import StudyFiles, files_of
from valvetrain.report.text import number, unit_text
from valvetrain.report.verdict import verdict_of
from valvetrain.solution.atomic import write_text
from valvetrain.solution.definition import definition_of
from valvetrain.solution.partial_failures import PartialFailures

#: Failed points that are listed; and runs that have figures of their own.
MAX_FAILURES, MAX_RUNS = 50, 12
#: Rows of the answer that are seen at once, and those that the page holds.
LISTED, MAX_LISTED = 12, 300


def points_page(table: StudyTable) -> Page:
    """The whole page."""
    plan, named = table.plan, list[Section]()
    lines = _values_at_points(table)
    calmed = over_clearance(table)
    first = figure_or_gap("Over the clearance", clearance_chart, table, calmed) if calmed else ()
    if lines:
        picture, rest = first or lines[:1], lines if first else lines[1:]
        named += [Section("points", "Every point", rest)] if rest else []
    else:
        for place, run in enumerate(plan.runs[:MAX_RUNS]):
            blocks = _figures_of(table, run, f"run-{place}")
            if blocks:
                named.append(Section(f"run-{place}", run_label(run) or "Points", tuple(blocks)))
        picture, named = (first, named) if first else _opening(named)
    few = text(f"Figures of the first {MAX_RUNS} runs follow.", "note")
    answers = (*_answers(table), *([few] if len(plan.runs) > MAX_RUNS and not lines else []))
    sections = [Section("answers", "What comes out", answers), *named]
    if table.failures:
        sections.append(Section("failed", "Points that failed", _failed(table)))
    request = (varied_grid(table),)
    sections.append(Section("asked", "What was varied", request, folded=True))
    done = int(np.count_nonzero(table.completed))
    facts = (
        ("case", plan.case_name), ("points", f"{done} of {len(table)} completed"), ("sampler", plan.sampler.shown_name),
        ("computed", f"{table.computed} runs, {table.seconds:.0f} s"),
    )  # fmt: skip
    return Page(
        plan.title,
        "Study",
        plan.description,
        facts,
        tuple(sections),
        "" if is_chosen(table) else "Percentiles are of the points that completed.",
        verdict=verdict_of(table),
        picture=picture,
    )


def _figures_of(table: StudyTable, run: Run, key: str) -> list[Block]:
    """Figures and shares of one run, the most informative first."""
    plan, blocks = table.plan, list[Block]()
    for one in (found for found in table.sensitivities if found.run == run):
        blocks += (
            *figure_or_gap(one.output, sensitivity_chart, one, f"{key}-{one.output}"),
            shares_grid(one),
        )
    scatter = (
        figure_or_gap("scatter", histogram_chart, table, run, key)
        if plan.sampler.independent
        else ()
    )
    over_ranges = plan.kind == "surrogate"  # even draws of a range are no scatter
    blocks += () if over_ranges else scatter
    alone = changed_alone(table)
    for name in _judged_first(table):
        if alone:
            blocks += figure_or_gap(name, changes_chart, table, name, run, f"{key}-{name}")
            continue
        if len(plan.varied) == 2:
            blocks += figure_or_gap(name, map_chart, table, name, run, f"{key}-{name}")
        blocks += figure_or_gap(name, scatter_chart, table, name, run, f"{key}-{name}")
    blocks += scatter if over_ranges else ()
    for made in (found for found in table.surrogates if found.run == run):
        blocks += figure_or_gap(made.output, surrogate_chart, made, f"{key}-{made.output}")
    return blocks


def _judged_first(table: StudyTable) -> tuple[str, ...]:
    """The outputs, that of the sentence first, so that the picture shows it."""
    judged = judged_output(table)
    return tuple(sorted(table.outputs, key=lambda name: name != judged))


def _values_at_points(table: StudyTable) -> tuple[Block, ...]:
    """Of a list every output at every point; nothing where one quantity at a time is changed."""
    if table.plan.sampler.word != "list" or changed_alone(table):
        return ()
    charts = (figure_or_gap(name, values_chart, table, name, name) for name in _judged_first(table))
    return tuple(block for blocks in charts for block in blocks)


def _opening(named: list[Section]) -> tuple[tuple[Block, ...], list[Section]]:
    """The first figure as the picture, which leaves its section."""
    for place, section in enumerate(named):
        first = next((block for block in section.blocks if isinstance(block, Figure)), None)
        if first is not None:
            rest = tuple(block for block in section.blocks if block is not first)
            others = [replace(section, blocks=rest)] if rest else []
            return (first,), [*named[:place], *others, *named[place + 1 :]]
    return (), named


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
            reported = (number(None if value is None else float(value), 5) for value in values)
            rows.append(
                (
                    label[:1].upper() + label[1:],
                    run_label(run),
                    *reported,
                    unit_text(definition_of(name).unit_word),
                )
            )
    return rows


#: Heads of :func:`answer_rows`.
ANSWER_HEADS = ("", "run", "minimum", "5 %", "median", "95 %", "maximum", "")


def answer_table(
    table: StudyTable,
) -> tuple[tuple[str, ...], list[tuple[str, ...]], tuple[int, ...]]:
    """Heads, rows and columns of numbers of the answer: of random draws their percentiles, else the
    values point by point.
    """
    if is_chosen(table):
        return point_table(table)
    if len(table.plan.runs) > 1:
        return ANSWER_HEADS, answer_rows(table), (2, 3, 4, 5, 6)
    rows: list[tuple[str, ...]] = [(row[0], *row[2:]) for row in answer_rows(table)]
    return (ANSWER_HEADS[0], *ANSWER_HEADS[2:]), rows, (1, 2, 3, 4, 5)


def sentences(table: StudyTable) -> tuple[str, ...]:
    """What the numbers say: which quantity makes the spread, how good a surrogate is, how many
    points failed.
    """
    failed = int(np.count_nonzero(~table.completed))
    reported = (
        *(one.sentence for one in table.sensitivities),
        *(one.sentence for one in table.surrogates),
    )
    dropped = max((one.dropped for one in table.sensitivities), default=0)
    rows = "1 base row was" if dropped == 1 else f"{dropped} base rows were"
    left = f", and {rows} left out of the shares of variance" if dropped else ""
    plan = table.plan
    doubtful = doubts(plan.case, plan.varied, table.inputs[:: max(1, len(plan.runs))])
    counted = doubtful.sentence("points")
    return (
        *reported,
        *((f"{counted}.",) if counted else ()),
        *table.limit_notes,
        *table.not_given,
        *((f"{failed} of {len(table)} points failed{left}.",) if failed else ()),
    )


def _answers(table: StudyTable) -> tuple[Block, ...]:
    lines = tuple(text(sentence) for sentence in sentences(table))
    heads, rows, right = answer_table(table)
    cells = [
        (tuple(Cell(one, "number" if k in right else "") for k, one in enumerate(row)), ())
        for row in rows
    ]
    grid = Grid(heads, tuple(cells[:LISTED]))
    if len(cells) <= LISTED:
        return (*lines, grid)
    rest = Grid(heads, tuple(cells[LISTED:MAX_LISTED]))
    more = f"{len(rest.rows)} more rows"
    if len(cells) > MAX_LISTED:
        more += f" of {len(cells) - LISTED}; points.csv has all"
    return (*lines, grid, Details(more, (rest,)))


def shares_grid(one: Sensitivity) -> Grid:
    """Shares of an output's variance with their intervals, the largest first."""

    def reported(value: float, interval: Any) -> str:
        return f"{100 * value:.0f} ({100 * interval[0]:.0f} to {100 * interval[1]:.0f})".replace(
            "-", "−"
        )

    rows = tuple(
        (
            (
                Cell(one.names[n]),
                Cell(reported(one.total[n], one.total_interval[n]), "number"),
                Cell(reported(one.first[n], one.first_interval[n]), "number"),
            ),
            (),
        )
        for n in np.argsort(-one.total).tolist()
    )
    return Grid(("quantity", "with all it acts together with (%)", "alone (%)"), rows)


def _failed(table: StudyTable) -> tuple[Block, ...]:
    failures = table.failures
    blocks: list[Block] = [text(f"{sentence}", "alert") for sentence in failures[:MAX_FAILURES]]
    if len(failures) > MAX_FAILURES:
        blocks.append(
            text(f"And {len(failures) - MAX_FAILURES} more; points.csv has them all.", "note")
        )
    return tuple(blocks)


def varied_grid(table: StudyTable) -> Grid:
    """What is varied, over what."""
    rows = tuple(
        (
            (
                Cell(one.shown_name),
                Cell(one.key),
                Cell({"value": "its value"}.get(one.operation, one.operation)),
                Cell(distribution_text(one)),
            ),
            (),
        )
        for one in table.plan.varied
    )
    return Grid(("quantity", "key of the case", "varied by", "over"), rows)


def distribution_text(one: Varied) -> str:
    """A distribution in words, in the unit of its quantity."""
    unit = unit_text(one.unit)

    def reported(value: float) -> str:
        return f"{number(one.shown(value), 6)} {unit}".strip()

    found = one.distribution
    if isinstance(found, Values):
        listed = ", ".join(reported(value) for value in found.values)
        return listed if len(found.values) <= 12 else f"{len(found.values)} values"
    if found.flat:
        scale = " in its logarithm" if found.logarithmic else ""
        return f"even{scale} from {reported(found.low)} to {reported(found.high)}"
    bounds = (
        f", cut at {reported(found.low)} and {reported(found.high)}"
        if np.isfinite(found.low) and np.isfinite(found.high)
        else ""
    )
    if found.kind == "normal":
        return f"normal about {reported(found.centre)}, standard deviation {reported(found.spread)}{bounds}"
    factor = number(math.exp(found.spread))
    return (
        f"lognormal about {reported(found.centre)}, two thirds within a factor of {factor}{bounds}"
    )


#: Rows that the JSON answer holds whole; a larger table is in points.csv.
MAX_ROWS = 2000


def points_json(table: StudyTable) -> dict[str, Any]:
    """The JSON answer, SI."""
    plan = table.plan
    runs = [
        {"engine_speed": run[0], "spring_model": run[1], "spring_set": run[2]} for run in plan.runs
    ]
    places = {run: place for place, run in enumerate(plan.runs)}
    data: dict[str, Any] = {
        "case": plan.case_name, "title": plan.title, "kind": plan.kind, "sampler": plan.sampler.word, "points": len(table),
        "completed_points": int(np.count_nonzero(table.completed)), "computed_now": table.computed, "runs": runs,
        "varied": [
            {"name": one.name, "key": one.key, "as": one.operation, "unit": one.si_unit or "1", "label": one.shown_name} for one in plan.varied
        ],
        "outputs": {name: {"unit": definition_of(name).si_unit, "percentiles": _percentiles(table, name)} for name in table.outputs},
        "sensitivities": [
            {"output": one.output, "run": places[one.run], "rows": one.rows, "dropped": one.dropped, "sentence": one.sentence,
             "quantities": {
                 name: {"first": one.first[n], "first_interval": one.first_interval[n], "total": one.total[n],
                        "total_interval": one.total_interval[n]} for n, name in enumerate(one.names)}}
            for one in table.sensitivities
        ],
        "surrogates": [
            {"output": one.output, "run": places[one.run], "fitted": one.fitted, "error": one.error,
             "error_over_scatter": one.share, "within_two_deviations": one.covered, "sentence": one.sentence} for one in table.surrogates
        ],
        "sentences": list(sentences(table)), "failures": list(table.failures[:MAX_ROWS]), "completed": bool(np.all(table.completed)),
    }  # fmt: skip
    data["uncertainties"] = [
        {"row": row, **uncertainty_object(one)}
        for row, bars in table.error_bars.items()
        for one in bars.values()
    ]
    if len(table) <= MAX_ROWS:
        data["rows"] = [
            {
                "inputs": list(table.inputs[row]),
                "run": places[table.runs[row]],
                "outputs": list(table.values[row]),
                "status": table.statuses[row].code,
            }
            for row in range(len(table))
        ]
    return data


def _percentiles(table: StudyTable, name: str) -> list[dict[str, float | None]]:
    found = []
    for run in table.plan.runs:
        rows = table.rows_of(run)
        values = table.column(name)[rows][
            table.completed[rows] & np.isfinite(table.column(name)[rows])
        ]
        ends = np.percentile(values, (5, 50, 95)).tolist() if len(values) else [None] * 3
        found.append(dict(zip(("5", "50", "95"), ends, strict=True)))
    return found


def points_csv(table: StudyTable) -> str:
    """Every row with all digits, SI; the head gives the units."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    inputs = [f"{one.name} [{one.si_unit or '1'}]" for one in table.plan.varied]
    outputs = [f"{name} [{definition_of(name).si_unit}]" for name in table.outputs]
    writer.writerow(
        [
            *inputs,
            "run engine_speed [rad/s]",
            "spring_model",
            "spring_set",
            *outputs,
            "status",
            "sentence",
        ]
    )
    for row in range(len(table)):
        engine_speed, model, spring_set = table.runs[row]
        values = ["" if np.isnan(value) else repr(float(value)) for value in table.values[row]]
        status = table.statuses[row]
        reported = "" if status.completed else status.sentence()
        given = [repr(float(value)) for value in table.inputs[row]]
        writer.writerow(
            [
                *given,
                "" if engine_speed is None else repr(engine_speed),
                model,
                spring_set,
                *values,
                status.code,
                reported,
            ]
        )
    return stream.getvalue()


def write_points(
    table: StudyTable, folder: Path, gaps: PartialFailures
) -> tuple[list[Path], Path | None]:
    """Write table and page into ``folder``; what could not be written is in ``gaps``. The
    files, and the page.
    """
    files: list[Path] = []
    data = gaps.part(
        "file 'points.csv'", None, lambda: write_text(folder / "points.csv", points_csv(table))
    )
    page = gaps.part(
        "report page",
        None,
        lambda: write_text(folder / "report.html", render(points_page(table), gaps)),
    )
    return [*files, *(path for path in (data, page) if path is not None)], page


def report_points(table: StudyTable, folder: Path) -> StudyFiles:
    """As :func:`write_points`. Raises :class:`RunFailedError` where a part could not be written."""
    failures = PartialFailures()
    files, _ = write_points(table, folder, failures)
    return files_of(folder, files, failures.sentences)
