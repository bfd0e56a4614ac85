"""Files of a study of points: every row as CSV, the JSON answer, the page."""

from __future__ import annotations

import csv
import io
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.explore.study_answer import StudyAnswer
from valvetrain.explore.table import StudyTable
from valvetrain.findings.words import Words
from valvetrain.session import called_case
from valvetrain.solution.atomic import write_text
from valvetrain.solution.definition import definition_of
from valvetrain.solution.partial_failures import PartialFailures
from valvetrain.views.json import uncertainty_object
from valvetrain.views.results import report_answer, write_page
from valvetrain.views.study_files import StudyFiles

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
            {"output": one.output, "run": places[one.run], "rows": one.rows, "dropped": one.dropped, "leaders": list(one.leaders),
             "quantities": {
                 name: {"first": one.first[n], "first_interval": one.first_interval[n], "total": one.total[n],
                        "total_interval": one.total_interval[n]} for n, name in enumerate(one.names)}}
            for one in table.sensitivities
        ],
        "surrogates": [
            {"output": one.output, "run": places[one.run], "fitted": one.fitted, "error": one.error,
             "error_over_scatter": one.share, "within_two_deviations": one.covered} for one in table.surrogates
        ],
        "failures": list(table.failures[:MAX_ROWS]), "completed": bool(np.all(table.completed)),
    }  # fmt: skip
    data["uncertainties"] = [
        {"row": row, **uncertainty_object(one)}
        for row, bars in table.error_bars.items()
        for one in bars.values()
    ]
    # with the error bars, which decide whether the best point is resolved
    data["findings"] = [
        one.to_dict() for one in StudyAnswer(table, words=Words(case=called_case())).findings
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
        values = np.where(table.completed, table.column(name), np.nan)[table.rows_of(run)]
        values = values[np.isfinite(values)]
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
    write = partial(write_text, folder / "points.csv", points_csv(table))
    data = gaps.part("file 'points.csv'", None, write)
    page = write_page(StudyAnswer(table), folder, gaps)
    return [path for path in (data, page) if path is not None], page


def report_points(table: StudyTable, folder: Path) -> StudyFiles:
    """As :func:`write_points`. Raises :class:`RunFailedError` where a part could not be written."""
    return report_answer(
        StudyAnswer(table), folder, [write_text(folder / "points.csv", points_csv(table))]
    )
