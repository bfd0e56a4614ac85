"""Model against test as files: JSON and CSV."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.compare_test.compare import ModelAgainstTest
from valvetrain.compare_test.comparison import RunAgainstTest
from valvetrain.compare_test.tables import (
    ADEQUACY,
    CLOSER,
    VALUES,
    Columns,
    agreement_columns,
    event_columns,
    stage_columns,
)
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.solution.atomic import write_text
from valvetrain.views.columns import csv_row, csv_text, json_row


def compare_test_json(result: ModelAgainstTest) -> dict[str, Any]:
    """The answer as plain values, SI, angles in rad."""
    test = result.test
    return {
        "case": result.study.record.name,
        "quantity": result.quantity,
        "synthetic": test.synthetic,
        "source": test.source,
        "repeats": len(test.values) if isinstance(test, MeasuredCycles) else test.repeats,
        "notes": list(result.notes),
        "runs": [_run(run, result.study.engine_speeds[0] / 2) for run in result.runs],
        "closer": [json_row(CLOSER, row) for row in result.closer],
    }


def _run(run: RunAgainstTest, cam_speed: float) -> dict[str, Any]:
    data: dict[str, Any] = {
        "label": run.label,
        "model": run.model,
        "without": run.without,
        "f_test": None if run.adequacy is None else json_row(ADEQUACY, run),
    }
    if run.agreement is not None:
        data["agreement"] = json_row(agreement_columns("", cam_speed), run)
    if run.band is not None:
        share = float(run.band.outside.mean())
        data["band"] = {"factor": run.band.factor, "level": run.band.level, "share_outside": share}
    for key, columns in (
        ("events", event_columns()),
        ("stages", stage_columns()),
        ("values", VALUES),
    ):
        if rows := getattr(run, key):
            data[key] = [json_row(columns, row) for row in rows]
    return data


def write_compare_test(result: ModelAgainstTest, folder: Path) -> list[Path]:
    """``curves.csv`` and ``events.csv`` of measured cycles, or ``values.csv`` of a table; SI but
    for angles in cam degrees.
    """
    test = result.test
    if not result.runs:
        return []
    if not isinstance(test, MeasuredCycles):
        return [_write_rows(folder / "values.csv", VALUES, result, "values")]
    columns = {"cam angle [deg]": np.degrees(test.cam_angle), f"test [{test.unit}]": test.mean}
    for run in result.runs:
        if run.curve is not None:
            columns[f"{run.label} [{test.unit}]"] = run.curve
        if run.band is not None:
            columns[f"{run.label} less test [{test.unit}]"] = run.band.difference
            columns[f"half width of its band [{test.unit}] ({run.label})"] = run.band.half_width
    curves = csv_text(columns, np.column_stack(list(columns.values())).tolist())
    events = _write_rows(folder / "events.csv", event_columns(), result, "events")
    return [write_text(folder / "curves.csv", curves), events]


def _write_rows(path: Path, columns: Columns, result: ModelAgainstTest, key: str) -> Path:
    """The rows of all runs, the label of the run in the first column."""
    headings = ("run", *(column.csv for column in columns if column.csv))
    rows = ((run.label, *csv_row(columns, row)) for run in result.runs for row in getattr(run, key))
    return write_text(path, csv_text(headings, rows))
