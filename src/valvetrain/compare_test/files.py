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


def compare_test_json(found: ModelAgainstTest) -> dict[str, Any]:
    """The answer as plain values, SI, angles in rad."""
    test = found.test
    return {
        "case": found.study.record.name,
        "quantity": found.quantity,
        "synthetic": test.synthetic,
        "source": test.source,
        "repeats": len(test.values) if isinstance(test, MeasuredCycles) else test.repeats,
        "notes": list(found.notes),
        "runs": [_run(one, found.study.engine_speeds[0] / 2) for one in found.runs],
        "closer": [json_row(CLOSER, one) for one in found.closer],
    }


def _run(one: RunAgainstTest, cam_speed: float) -> dict[str, Any]:
    data: dict[str, Any] = {
        "label": one.label,
        "model": one.model,
        "without": one.without,
        "f_test": None if one.adequacy is None else json_row(ADEQUACY, one),
    }
    if one.agreement is not None:
        data["agreement"] = json_row(agreement_columns("", cam_speed), one)
    if one.band is not None:
        share = float(one.band.outside.mean())
        data["band"] = {"factor": one.band.factor, "level": one.band.level, "share_outside": share}
    for key, columns in (
        ("events", event_columns()),
        ("stages", stage_columns()),
        ("values", VALUES),
    ):
        if rows := getattr(one, key):
            data[key] = [json_row(columns, row) for row in rows]
    return data


def write_compare_test(found: ModelAgainstTest, folder: Path) -> list[Path]:
    """``curves.csv`` and ``events.csv`` of measured cycles, or ``values.csv`` of a table; SI but
    for angles in cam degrees.
    """
    test = found.test
    if not found.runs:
        return []
    if not isinstance(test, MeasuredCycles):
        return [_write_rows(folder / "values.csv", VALUES, found, "values")]
    columns = {"cam angle [deg]": np.degrees(test.cam_angle), f"test [{test.unit}]": test.mean}
    for one in found.runs:
        if one.curve is not None:
            columns[f"{one.label} [{test.unit}]"] = one.curve
        if one.band is not None:
            columns[f"{one.label} less test [{test.unit}]"] = one.band.difference
            columns[f"half width of its band [{test.unit}] ({one.label})"] = one.band.half_width
    curves = csv_text(columns, np.column_stack(list(columns.values())).tolist())
    events = _write_rows(folder / "events.csv", event_columns(), found, "events")
    return [write_text(folder / "curves.csv", curves), events]


def _write_rows(path: Path, columns: Columns, found: ModelAgainstTest, key: str) -> Path:
    """The rows of all runs, the label of the run in the first column."""
    headings = ("run", *(column.csv for column in columns if column.csv))
    rows = ((one.label, *csv_row(columns, row)) for one in found.runs for row in getattr(one, key))
    return write_text(path, csv_text(headings, rows))
