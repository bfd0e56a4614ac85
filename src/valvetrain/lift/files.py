"""The files of a measured lift: its curves, and its law for a case file."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from valvetrain.lift.figures import LobeResult
from valvetrain.parameters.case import Case
from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.schema_case import lend
from valvetrain.parameters.toml_text import resolved, toml_text
from valvetrain.solution.atomic import write_text
from valvetrain.views.files import csv_of

#: Cam degrees between the rows of the curves.
STEP = 0.25
#: First line of the law for a case file.
AS_MEASURED = "# Stations as measured; a noise or band of 0 is found from them in each run.\n"


def lift_parameters(
    lobe: LobeResult, noise: float | None = None, band: float | None = None
) -> LiftLawParameters:
    """The measured law of a lobe as a case says it."""
    values = {
        "cam_angles": tuple(map(float, lobe.measured.cam_angles)), "lifts": tuple(map(float, lobe.measured.lifts)), "noise": noise or 0.0,
        "band": band or 0.0, "draw": 0
    }  # fmt: skip
    return LiftLawParameters("measured", values, lobe.measured.lift_of, lobe.measured.zero)  # type: ignore[arg-type]


def lift_case(
    name: str, lobe: LobeResult | None, noise: float | None = None, band: float | None = None
) -> Case:
    """A case that holds nothing but the lift of ``lobe``, if there is one; its text can be put into any case file."""
    law = LiftLawParameters("zero") if lobe is None else lift_parameters(lobe, noise, band)
    return parse_case(toml_text({"name": name, **resolved({"lift_law": {}}, law)}), name)


def case_with(case: Case, law: LiftLawParameters) -> Case:
    """The case with that lift law, in its text too; its train keeps the lash and the rocker ratio of the cam card."""
    tree = tomllib.loads(case.text)
    lend(tree, tree.get("lift_law", {}))
    tree |= resolved({"lift_law": {}}, law)
    return parse_case(toml_text(tree), case.name)


def write_lift(
    lobes: Sequence[LobeResult], folder: Path, noise: float | None = None, band: float | None = None
) -> list[Path]:
    """``lift.csv`` (or ``intake.csv``, ``exhaust.csv``): lift to jerk and standard deviations; and
    the lift as part of a case file, with the stated ``noise`` and ``band`` (m).
    """
    files = []
    for lobe in lobes:
        name = lobe.measured.name
        first, last = np.degrees(lobe.smoothed.event)
        degrees = np.arange(np.ceil(first / STEP), np.floor(last / STEP) + 1) * STEP
        angles = np.radians(degrees)
        columns, heads = [degrees], ["cam angle [deg]"]
        for order, what in enumerate(
            ("lift [mm]", "velocity [mm/rad]", "acceleration [mm/rad2]", "jerk [mm/rad3]")
        ):
            heads += [what, f"standard deviation of {what}"]
            law = lobe.smoothed
            columns += [1e3 * law.lift(angles, order), 1e3 * law.spread(angles, order)]
        table = csv_of(heads, np.column_stack(columns).tolist(), 9)
        files.append(write_text(folder / f"{name}.csv", table))
        files.append(
            write_text(
                folder / f"{name}.toml",
                AS_MEASURED
                + toml_text(resolved({"lift_law": {}}, lift_parameters(lobe, noise, band))),
            )
        )
    return files
