"""The files of a film: measured cycles, peaks and tracks as CSV, and the answer as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.film.answer import FilmAnswer
from valvetrain.film.model import FilmedModel
from valvetrain.film.result import CoilMotion
from valvetrain.film.tables import LINE_COLUMNS, PEAK_COLUMNS, line_table, peak_table
from valvetrain.measured.cycles import MeasuredCycles, write_cycles
from valvetrain.measured.json import json_estimate, json_fields
from valvetrain.solution.atomic import write_text
from valvetrain.views.columns import csv_row, csv_text, json_row
from valvetrain.views.results import report_answer
from valvetrain.views.study_files import StudyFiles


def named_cycles(motion: CoilMotion, model: FilmedModel | None) -> tuple[MeasuredCycles, ...]:
    """Measured cycles of every coil; as a run has them, under the names that the same curves have there."""
    if model is None:
        return motion.cycles
    return tuple(
        replace(cycles, quantity=name)
        for cycles, name in zip(motion.cycles, model.quantities, strict=True)
    )


def write_film(motion: CoilMotion, model: FilmedModel | None, folder: Path) -> list[Path]:
    """``displacement-coil-N.csv`` (measured cycles), ``peaks.csv``, ``tracks.csv`` and, with a
    model, ``model.csv``.
    """
    files = [
        write_cycles(folder / f"displacement-coil-{coil}.csv", cycles)
        for coil, cycles in enumerate(named_cycles(motion, model), start=1)
    ]
    coils = range(1, motion.coils + 1)
    columns = [
        1e3 * motion.time,
        *(() if motion.phase is None else (np.degrees(motion.phase.cam_angle),)),
    ]
    heads = ["time [ms]", *(() if motion.phase is None else ("cam angle [deg]",))]
    kinds = (
        ("displacement of coil", "mm"),
        ("place of coil", "px"),
        ("standard deviation of coil", "px"),
    )
    heads += [f"{word} {coil} [{unit}]" for word, unit in kinds for coil in coils]
    tracks = np.column_stack([*columns, 1e3 * motion.displacement, motion.places, motion.spread])
    tables: dict[str, tuple[Sequence[str], Sequence[Sequence[float]]]] = {}
    tables["tracks.csv"] = heads, tracks.tolist()
    if motion.peaks:
        head = [column.csv for column in PEAK_COLUMNS if column.csv]
        rows = [csv_row(PEAK_COLUMNS, row) for row in peak_table(motion, None)]
        tables["peaks.csv"] = head, rows
    if model is not None:
        named = (
            f"coil {coil}, turn {turn:.2f} [mm]"
            for coil, turn in zip(coils, model.turns, strict=True)
        )
        curves = np.column_stack([np.degrees(model.cam_angle), 1e3 * model.displacement])
        tables["model.csv"] = ("cam angle [deg]", *named), curves.tolist()
    return files + [write_text(folder / name, csv_text(*table)) for name, table in tables.items()]


def film_json(motion: CoilMotion, model: FilmedModel | None) -> dict[str, Any]:
    """The JSON answer, SI."""
    line = motion.seen.line
    data: dict[str, Any] = {
        "command": "film", "case": "" if model is None else model.case, "completed": True, "frames": len(motion.places),
        "coils": motion.coils,
        "frame_rate": motion.seen.frame_rate, "line": {"start": list(line.start), "end": list(line.end), "unit": "px"},
        "metres_per_pixel": json_estimate((motion.metres_per_pixel, motion.scale_spread)),
        "place_standard_deviation": {"value": float(np.nanmedian(motion.spread)), "unit": "px"},
        "camera_drift": {"value": float(np.ptp(motion.drift)), "unit": "px"},
        "cam_speed": None if motion.phase is None else {
            "value": motion.phase.cam_speed, "standard_deviation": motion.phase.spread, "by": motion.phase.by},
        "dwell": None if motion.dwell is None else list(motion.dwell),
        "peaks": [json_row(PEAK_COLUMNS, row) for row in peak_table(motion, None)],
        "surge_lines": [json_row(LINE_COLUMNS, row) for row in line_table(motion)],
        "notes": list(motion.notes)
    }  # fmt: skip
    if model is not None:
        data["model"] = {
            **json_fields(model, "model spring turns quantities peaks apart surge_frequency shift notes"),
            "surge_lines": [json_fields(line, "natural_frequency damping_ratio") for line in (() if model.surge is None else model.surge.lines)]
        }  # fmt: skip
    return data


def report_film(motion: CoilMotion, folder: Path, model: FilmedModel | None = None) -> StudyFiles:
    """The page of a film and the files of :func:`write_film`."""
    answer = FilmAnswer(motion, model, folder=str(folder))
    return report_answer(answer, folder, write_film(motion, model, folder))
