"""Tables of a model against a test: the columns that page, CSV and JSON share, and the files of them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.compare_test.adequacy import AdequacyTest
from valvetrain.compare_test.compare import ModelAgainstTest
from valvetrain.compare_test.comparison import RunAgainstTest, ValueRow
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.measured.json import json_fields
from valvetrain.solution.atomic import write_text
from valvetrain.solution.definition import label_of
from valvetrain.views.columns import RowColumn, csv_row, json_row
from valvetrain.views.files import csv_of

Columns = tuple[RowColumn, ...]


def agreement_columns(name: str) -> Columns:
    """Nearness of a run to measured cycles of the quantity ``name``; rows: runs with an agreement."""
    amounts = (
        ("bias", "bias", name), ("rms", "rms", name), ("without bias and shift", "rest", name), ("scatter of a cycle", "scatter", name),
        ("comes later by", "shift", "cam_angle"), ("± (95 %)", "shift_reach", "cam_angle")
    )  # fmt: skip
    correlation = RowColumn("correlation", lambda run: f"{run.agreement.correlation:.5f}")
    return (
        RowColumn("model", value="label"),
        *(RowColumn(head, None, f"agreement.{key}", quantity=one) for head, key, one in amounts),
        correlation,
    )


def f_test_json(test: AdequacyTest) -> dict[str, Any]:
    """Fisher's test as plain values; variances are SI."""
    return {
        "ratio": test.ratio, "critical": test.critical, "p_value": test.p_value, "degrees_of_freedom": list(test.degrees),
        "shared_mean_squares": list(test.shared), "adequacy_variance": test.adequacy, "reproducibility_variance": test.reproducibility,
        "independent_places": test.independent, "refutable_rms": test.refutable, **json_fields(test, "adequate places repeats fitted")
    }  # fmt: skip


def value_name(row: ValueRow) -> str:
    """A measured quantity in words."""
    return f"{label_of(row.quantity)}{', angle' if row.kind == 'angle' else ''}"


def value_quantity(row: ValueRow) -> str:
    """The name in whose unit a value is shown."""
    return "cam_angle" if row.unit == "deg" else row.quantity


#: Measured values next to the model's; rows: values of a run.
VALUES: Columns = (
    RowColumn("quantity", value_name, "quantity", "quantity", "quantity"),
    RowColumn(value="kind", key="what", csv="what"),
    RowColumn("engine speed", value="engine_speed", key="engine_speed", quantity="engine_speed"),
    RowColumn(value="engine_speed", csv="engine speed [rpm]", csv_factor=30 / math.pi),
    *(
        RowColumn(one, value=one, key=one, csv=f"{one} [SI]", quantity=value_quantity)
        for one in ("model", "test", "scatter", "difference")
    ),
    RowColumn(value="unit", key="unit"),
    RowColumn("in scatters", value="in_scatters", key="in_scatters", csv="in scatters"),
)


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
    }


def _run(run: RunAgainstTest, cam_speed: float) -> dict[str, Any]:
    data: dict[str, Any] = {
        "label": run.label,
        "model": run.model,
        "without": run.without,
        "f_test": None if run.adequacy is None else f_test_json(run.adequacy),
    }
    if run.agreement is not None:
        near = json_fields(run.agreement, "bias rms rest scatter correlation shift shift_reach")
        data["agreement"] = near | {"shift_time": run.agreement.shift / cam_speed}
    if run.band is not None:
        share = float(run.band.outside.mean())
        data["band"] = {"factor": run.band.factor, "share_outside": share}
    if run.stages:
        fields = "name first last bias bias_standard_error rms share_outside"
        data["stages"] = [json_fields(stage, fields) for stage in run.stages]
    if run.values:
        data["values"] = [json_row(VALUES, row) for row in run.values]
    return data


def write_compare_test(result: ModelAgainstTest, folder: Path) -> list[Path]:
    """``curves.csv`` of measured cycles, or ``values.csv`` of a table; SI but for angles in cam degrees."""
    test = result.test
    if not result.runs:
        return []
    if not isinstance(test, MeasuredCycles):
        headings = ("run", *(column.csv for column in VALUES if column.csv))
        rows = ((run.label, *csv_row(VALUES, row)) for run in result.runs for row in run.values)
        return [write_text(folder / "values.csv", csv_of(headings, rows, 9))]
    columns = {"cam angle [deg]": np.degrees(test.cam_angle), f"test [{test.unit}]": test.mean}
    for run in result.runs:
        if run.curve is not None:
            columns[f"{run.label} [{test.unit}]"] = run.curve
        if run.band is not None:
            columns[f"{run.label} less test [{test.unit}]"] = run.band.difference
            columns[f"half width of its band [{test.unit}] ({run.label})"] = run.band.half_width
    curves = csv_of(columns, np.column_stack(list(columns.values())).tolist(), 9)
    return [write_text(folder / "curves.csv", curves)]
