"""Tables of a model against a test: the columns that page, CSV and JSON share, and the files of them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.compare_test.adequacy import chance_text
from valvetrain.compare_test.compare import ModelAgainstTest
from valvetrain.compare_test.comparison import RunAgainstTest, ValueRow
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.solution.atomic import write_text
from valvetrain.solution.definition import label_of
from valvetrain.views.columns import RowColumn, csv_row, json_row
from valvetrain.views.files import csv_of

Columns = tuple[RowColumn, ...]
MODEL = RowColumn("model", value="label")


def agreement_columns(name: str = "", cam_speed: float = math.nan) -> Columns:
    """Nearness of a run to measured cycles of the quantity ``name``; rows: runs with an agreement."""
    amounts = (
        ("bias", "bias"),
        ("rms", "rms"),
        ("rest", "without bias and shift"),
        ("scatter", "scatter of a cycle"),
    )
    return (
        MODEL,
        *(
            RowColumn(heading, value=f"agreement.{key}", key=key, quantity=name)
            for key, heading in amounts
        ),
        RowColumn(
            "correlation",
            lambda run: f"{run.agreement.correlation:.5f}",
            "agreement.correlation",
            "correlation",
        ),
        RowColumn("comes later by", value="agreement.shift", key="shift", quantity="cam_angle"),
        RowColumn(
            "± (95 %)", value="agreement.shift_reach", key="shift_reach", quantity="cam_angle"
        ),
        RowColumn(value=lambda run: run.agreement.shift / cam_speed, key="shift_time"),
    )


#: Fisher's test; rows: runs with an adequacy test. Variances are SI.
ADEQUACY: Columns = (
    MODEL,
    RowColumn("F", value="adequacy.ratio", key="ratio"),
    RowColumn("critical F", value="adequacy.critical", key="critical"),
    RowColumn("p", lambda run: chance_text(run.adequacy.p_value), "adequacy.p_value", "p_value"),
    RowColumn(value=lambda run: list(run.adequacy.degrees), key="degrees_of_freedom"),
    RowColumn(value=lambda run: list(run.adequacy.shared), key="shared_mean_squares"),
    *(
        RowColumn(heading, value=f"adequacy.{name}", key=key or name)
        for name, heading, key in (
            ("adequacy", "variance of adequacy, SI", "adequacy_variance"), ("reproducibility", "of reproducibility", "reproducibility_variance"),
            ("adequate", "agrees", ""), ("places", "places", ""), ("independent", "independent", "independent_places"), ("repeats", "repeats", ""),
            ("fitted", "fitted", ""),
            ("refutable", "", "refutable_rms")
        )
    )
)  # fmt: skip


def stage_columns(name: str = "") -> Columns:
    """Errors by stage of the revolution of the quantity ``name``."""
    return (
        RowColumn("stretch", value="name", key="name"),
        *(RowColumn(one, value=one, key=one, quantity="cam_angle") for one in ("first", "last")),
        RowColumn("bias", value="bias", key="bias", quantity=name),
        RowColumn(
            "± (standard error)", value="bias_error", key="bias_standard_error", quantity=name
        ),
        RowColumn("rms", value="rms", key="rms", quantity=name),
        RowColumn("share outside the band", value="share_outside", key="share_outside"),
    )


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
        "f_test": None if run.adequacy is None else json_row(ADEQUACY, run),
    }
    if run.agreement is not None:
        data["agreement"] = json_row(agreement_columns("", cam_speed), run)
    if run.band is not None:
        share = float(run.band.outside.mean())
        data["band"] = {"factor": run.band.factor, "share_outside": share}
    for key, columns in (
        ("stages", stage_columns()),
        ("values", VALUES),
    ):
        if rows := getattr(run, key):
            data[key] = [json_row(columns, row) for row in rows]
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
