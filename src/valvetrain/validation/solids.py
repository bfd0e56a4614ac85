"""The solid in motion: its statics and modes against CalculiX, its clash spikes beside the rod's."""

from __future__ import annotations

import numpy as np

from valvetrain.continuum.statics import SolidStatics
from valvetrain.continuum.wire import SolidContactLaw, SolidWire
from valvetrain.parameters.curves import Constant
from valvetrain.parameters.loading import load_case
from valvetrain.parameters.spring import OPEN_END, SpringDefinition
from valvetrain.runs.run import run_study
from valvetrain.validation.models import SOLID, SOLID_BEEHIVE, solid_beehive
from valvetrain.validation.row import Kind, Row, book_case
from valvetrain.validation.springs import STEEL

KIND: Kind = "independent computation"


@book_case()
def bricks_against_calculix() -> list[Row]:
    """Clamped helices without contact: force at 7 mm and axial frequencies of the free spring."""
    what, rows = "wire 3.8, pitch 7 mm, 5 turns clamped, 24 slices per coil", []
    for name, (diameter, force, frequencies) in SOLID.items():
        spring = SpringDefinition(
            Constant(3.8e-3), Constant(diameter), Constant(7e-3), 5.0, STEEL, OPEN_END, OPEN_END
        )
        statics = SolidStatics(SolidWire(spring, contact=SolidContactLaw(0.0)))
        found = statics.compress([7e-3])[0].retainer_force
        why = "straight slices: 0.1 % at 24 per coil"
        rows.append(
            Row("solids", f"bricks, force at 7 mm, {name}", "", what, force, found, "N", 1e-3 * force, why, KIND)
        )  # fmt: skip
        modes = statics.modes(statics.start(), 10).natural_frequency
        for n, value in zip((1, 5, 9), frequencies, strict=True):
            why = "eight-node bricks: 0.2 % at 24 per coil"
            rows.append(
                Row("solids", f"bricks, free frequency {n} (axial), {name}", "", what, value, float(modes[n - 1]), "Hz", 2e-3 * value, why, KIND)
            )  # fmt: skip
    return rows


@book_case()
def bricks_in_contact_against_calculix() -> list[Row]:
    """The beehive whose coil 2 comes to rest on coil 1: contact on section centres against contact
    of faces.
    """
    statics = SolidStatics(SolidWire(solid_beehive()))
    found = statics.compress(list(SOLID_BEEHIVE))
    what, why = "wire 3.867, D 22.47 to 17.31 mm, 7 coils", "the wire flattens where coils meet"
    return [
        Row("solids", f"bricks in contact, force at {1e3 * at:.1f} mm", "", what, due, one.retainer_force, "N", 0.003 * due, why, KIND)
        for (at, due), one in zip(SOLID_BEEHIVE.items(), found, strict=True)
    ]  # fmt: skip


@book_case(slow=True)
def spikes_of_rod_and_solid() -> list[Row]:
    """The beehive of gu2021 at 8000 rpm by both: peak of the event and spike of the clash by band.

    Expected is the solid. Above 20 kHz neither is right: heights rest on mesh and contact constants.
    """
    study = run_study(
        load_case("gu2021-beehive"),
        engine_speeds=[8000 * np.pi / 30],
        spring_models=["finite-element", "solid"],
    )
    rod, solid = (run.quantities for run in study.solutions)
    what = "gu2021-beehive, 8000 rpm, 24 slices and elements per coil"
    rows = []
    for name, label, within, why in (
        ("stage_2_peak_force", "peak of the event", 0.01, "rod and body move alike below clash"),
        ("main_clash_below_10_khz_peak_force", "spike below 10 kHz", 0.05, "instants of clashes"),
        (
            "main_clash_below_20_khz_peak_force",
            "spike below 20 kHz",
            0.12,
            "contact, mesh, section",
        ),
    ):
        rows.append(
            Row("solids", f"rod beside solid, {label}", "", what, solid[name], rod[name], "N", within * solid[name], why, KIND)
        )  # fmt: skip
    return rows
