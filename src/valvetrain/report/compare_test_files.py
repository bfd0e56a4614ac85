"""Files of a model against a test: curves and rows as CSV, the whole answer as JSON."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.measurements.measured_cycles import MeasuredCycles
from valvetrain.quantities.adequacy import AdequacyTest
from valvetrain.report.compare_test_words import verdict_sentences
from valvetrain.solution.atomic import write_text
from valvetrain.studies.against_test import RunAgainstTest
from valvetrain.studies.compare_test import ModelAgainstTest


def compare_test_json(found: ModelAgainstTest) -> dict[str, Any]:
    """The answer as plain values, SI, angles in rad."""
    test = found.test
    return {
        "case": found.study.record.name, "quantity": found.quantity, "synthetic": test.synthetic, "source": test.source,
        "repeats": len(test.values) if isinstance(test, MeasuredCycles) else test.repeats,
        "verdict": verdict_sentences(found) if found.runs else [], "notes": list(found.notes),
        "runs": [_run(one, found.study.engine_speeds[0] / 2) for one in found.runs],
        "closer": [
            {"first": one.first, "second": one.second, "first_mean_square": one.first_square, "second_mean_square": one.second_square,
             "student": one.student, "p_value": one.p_value, "sentence": one.sentence}
            for one in found.closer
        ],
    }  # fmt: skip


def _run(one: RunAgainstTest, cam_speed: float) -> dict[str, Any]:
    near = one.agreement
    data: dict[str, Any] = {"label": one.label, "model": one.model, "sentence": one.sentence, "f_test": _test(one.adequacy)}
    if near is not None:
        data["agreement"] = {
            name: getattr(near, name) for name in ("bias", "rms", "correlation", "shift", "shift_reach", "rest", "scatter")
        } | {"shift_time": near.shift / cam_speed}  # fmt: skip
    if one.band is not None:
        data["band"] = {"factor": one.band.factor, "level": one.band.level, "share_outside": float(one.band.outside.mean())}
    if one.events:
        data["events"] = [
            {"event": row.name, "what": row.dimension, "model": row.model, "seen": row.seen, "test": row.test, "difference": row.difference,
             "scatter": row.scatter, "in_standard_errors": row.in_errors, "outside": row.outside}
            for row in one.events
        ]  # fmt: skip
    if one.stages:
        data["stages"] = [
            {"name": row.name, "first": row.first, "last": row.last, "bias": row.bias, "bias_standard_error": row.bias_error,
             "rms": row.rms, "share_outside": row.share_outside}
            for row in one.stages
        ]  # fmt: skip
    if one.values:
        data["values"] = [
            {"quantity": row.quantity, "what": row.kind, "engine_speed": row.engine_speed, "unit": row.unit, "model": row.model,
             "test": row.test, "scatter": row.scatter, "difference": row.difference, "in_scatters": row.in_scatters}
            for row in one.values
        ]  # fmt: skip
    return data


def _test(test: AdequacyTest | None) -> dict[str, Any] | None:
    if test is None:
        return None
    return {
        "adequacy_variance": test.adequacy, "reproducibility_variance": test.reproducibility, "ratio": test.ratio,
        "degrees_of_freedom": list(test.degrees), "critical": test.critical, "p_value": test.p_value, "adequate": test.adequate,
        "places": test.places, "independent_places": test.independent, "repeats": test.repeats, "fitted": test.fitted, "level": test.level,
        "p_value_if_every_place_counted": test.counted_p_value, "refutable_rms": test.refutable, "shared_mean_squares": list(test.shared),
    }  # fmt: skip


def write_compare_test(found: ModelAgainstTest, folder: Path) -> list[Path]:
    """``curves.csv`` and ``events.csv`` of measured cycles, or ``values.csv`` of a table; SI but for angles in cam degrees."""
    test = found.test
    heads: tuple[str, ...]
    if not isinstance(test, MeasuredCycles):
        rows: list[tuple[Any, ...]] = [
            (one.label, row.quantity, row.kind, row.engine_speed * 30 / math.pi, row.model, row.test, row.scatter, row.difference,
             row.in_scatters)
            for one in found.runs for row in one.values
        ]  # fmt: skip
        heads = (
            "run",
            "quantity",
            "what",
            "engine speed [rpm]",
            "model [SI]",
            "test [SI]",
            "scatter [SI]",
            "difference [SI]",
            "in scatters",
        )
        return [_write(folder / "values.csv", heads, rows)]
    columns: dict[str, np.ndarray[Any, Any]] = {
        "cam angle [deg]": np.degrees(test.cam_angle),
        f"test [{test.unit}]": test.values.mean(axis=0),
    }
    for one in found.runs:
        if one.curve is not None:
            columns[f"{one.label} [{test.unit}]"] = one.curve
        if one.band is not None:
            columns[f"{one.label} less test [{test.unit}]"] = one.band.difference
            columns[f"half width of its band [{test.unit}] ({one.label})"] = one.band.half_width
    made = [_write(folder / "curves.csv", tuple(columns), zip(*(column.tolist() for column in columns.values()), strict=True))]
    heads = ("run", "event", "what", "model", "seen", "test", "difference", "scatter of one cycle", "in standard errors", "outside")
    told = [
        (one.label, row.name, row.dimension, row.model, row.seen, row.test, row.difference, row.scatter, row.in_errors, row.outside)
        for one in found.runs for row in one.events
    ]  # fmt: skip
    return [*made, _write(folder / "events.csv", heads, told)]


def _write(path: Path, heads: tuple[str, ...], rows: Iterable[tuple[Any, ...]]) -> Path:
    memory = io.StringIO()
    writer = csv.writer(memory, lineterminator="\n")
    writer.writerow(heads)
    for row in rows:
        writer.writerow(
            ["" if isinstance(cell, float) and math.isnan(cell) else f"{cell:.9g}" if isinstance(cell, float) else cell for cell in row]
        )
    return write_text(path, memory.getvalue())


def _cell(cell: Any) -> Any:
    if not isinstance(cell, float):
        return cell
    return "" if math.isnan(cell) else f"{cell:.9g}"
