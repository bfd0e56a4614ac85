"""Files of a measured lift: curves with their spread, a case with the lift alone, tables in the forms of the trade."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.measurements.lift_formats.contract import LiftFormat, LiftTable
from valvetrain.parameters.case import Case
from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.toml_text import resolved, toml_text
from valvetrain.report.lift_page import LobeResult
from valvetrain.solution.atomic import write_bytes, write_text

#: Cam degrees between the rows of the curves.
STEP = 0.25


def lift_parameters(lobe: LobeResult, noise: float | None = None, band: float | None = None) -> LiftLawParameters:
    """The measured law of a lobe as a case says it."""
    values = {
        "cam_angles": tuple(map(float, lobe.measured.cam_angles)), "lifts": tuple(map(float, lobe.measured.lifts)), "noise": noise or 0.0,
        "band": band or 0.0, "draw": 0,
    }  # fmt: skip
    return LiftLawParameters("measured", values, lobe.measured.lift_of, lobe.measured.zero)  # type: ignore[arg-type]


def lift_case(name: str, lobe: LobeResult) -> Case:
    """A case that holds nothing but the lift of ``lobe``; its text can be put into any case file."""
    text = toml_text({"name": name, **resolved({"lift_law": {}}, lift_parameters(lobe))})
    return parse_case(text, name)


def write_lift(lobes: Sequence[LobeResult], folder: Path) -> list[Path]:
    """``lift.csv`` (or ``intake.csv``, ``exhaust.csv``): lift to jerk and standard deviations; and the lift as part of a case file."""
    files = []
    for lobe in lobes:
        name = lobe.measured.name
        first, last = np.degrees(lobe.smoothed.event)
        degrees = np.arange(np.ceil(first / STEP), np.floor(last / STEP) + 1) * STEP
        angles = np.radians(degrees)
        columns, heads = [degrees], ["cam angle [deg]"]
        for derivative, (quantity, unit) in enumerate(
            (("lift", "mm"), ("velocity", "mm/rad"), ("acceleration", "mm/rad2"), ("jerk", "mm/rad3"))
        ):
            heads += [f"{quantity} [{unit}]", f"standard deviation of {quantity} [{unit}]"]
            columns += [1e3 * lobe.smoothed.lift(angles, derivative), 1e3 * lobe.smoothed.spread(angles, derivative)]
        lines = [",".join(heads), *(",".join(f"{value:.9g}" for value in row) for row in np.column_stack(columns))]
        files.append(write_text(folder / f"{name}.csv", "\n".join(lines) + "\n"))
        files.append(write_text(folder / f"{name}.toml", toml_text(resolved({"lift_law": {}}, lift_parameters(lobe)))))
    return files


def write_table(lobes: Sequence[LobeResult], path: Path, form: str) -> Path:
    """The smoothed lifts at whole cam degrees in one of the forms. Raises :class:`InputError` for a form that cannot be written."""
    found: LiftFormat = registry.find("lift_formats", form, "--write-form")
    if found.write is None:
        raise InputError(f"lifts are not written in the form '{form}'; use columns", "--write-form")
    first = min(lobe.smoothed.event[0] for lobe in lobes)
    degrees = np.ceil(np.degrees(first)) - 1 + np.arange(360.0)
    lifts = np.column_stack([lobe.smoothed.lift(np.radians(degrees)) for lobe in lobes])
    lead = lobes[0].measured
    table = LiftTable(np.radians(degrees), lifts, tuple(lobe.measured.name for lobe in lobes), lead.lift_of, lead.zero)
    return write_bytes(path, found.write(table))
