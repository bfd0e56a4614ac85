"""Stress of the wire: its extremes over the wire, and at the worst point over the cam angle, dynamic beside quasi-static."""

from __future__ import annotations

import numpy as np

from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.stress import EQUIVALENT, SHEAR, wire_stress_of
from valvetrain.quantities.study import SpringStudy
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Panel, thin
from valvetrain.report.figures.force import ANGLE_LABEL, stage_bands
from valvetrain.report.table import Table, table
from valvetrain.report.words import rpm, speed_words
from valvetrain.solution.result import Solution
from valvetrain.springs.stress import LOADS, with_stress

_MPA = 1e-6


def stressed(study: SpringStudy, run: Solution) -> Solution | None:
    """The run with its stress channels; None for a model without section loads."""
    spring = study.case.spring
    return with_stress(run, spring) if spring is not None and run.has(*LOADS) and len(run.time) > 2 else None


def wire_table(study: SpringStudy, run: Solution) -> Table | None:
    """Over the free wire: ``coil number``; ``largest``, ``least``, ``mean`` shear, ``amplitude``, ``equivalent``, ``quasi-static``: MPa."""
    full = stressed(study, run)
    found = None if full is None else wire_stress_of(full)
    if full is None or found is None:
        return None
    free = found.largest_equivalent > 0
    columns = [
        ("largest", found.largest_shear), ("least", found.least_shear), ("mean", found.mean), ("amplitude", found.amplitude),
        ("equivalent", found.largest_equivalent),
    ]  # fmt: skip
    if study.static_stress is not None:
        slow = study.static_stress.shear_at(_compression(study, full))
        columns.append(("quasi-static", np.max(slow, axis=0)))
    return table(("coil number", "", found.coil_number[free]), *((name, "MPa", values[free] * _MPA) for name, values in columns))


def worst_table(study: SpringStudy, run: Solution) -> tuple[Table, float] | None:
    """``shear``, ``equivalent``, ``quasi-static`` (MPa) over the cam angle (deg) where the shear is largest, and its coil number."""
    full = stressed(study, run)
    found = None if full is None else wire_stress_of(full)
    if full is None or found is None:
        return None
    cycle, worst = reported_cycle(full), found.worst
    columns = [("shear", cycle.channel(SHEAR)[:, worst]), ("equivalent", cycle.channel(EQUIVALENT)[:, worst])]
    if study.static_stress is not None:
        columns.append(("quasi-static", study.static_stress.shear_at(_compression(study, full))[:, worst]))
    data = table(("cam angle", "deg", np.degrees(cycle.cam_angle)), *((name, "MPa", values * _MPA) for name, values in columns))
    return data, float(found.coil_number[worst])


def _compression(study: SpringStudy, run: Solution) -> np.ndarray:
    return study.case.installation.precompression + reported_cycle(run).channel("valve_lift")


def stress_chart(along: Table, over: Table, coil: float, engine_speed: float) -> Chart:
    """Left the extremes over the wire, right the worst point over one cam cycle."""
    dynamic, slow = theme.model_colour("finite-element"), theme.model_colour("massless")
    first: list[Layer] = []
    if "quasi-static" in along:
        first.append(Line(along["coil number"], along["quasi-static"], "quasi-static", slow, dash="dash"))
    first.append(Line(along["coil number"], along["largest"], "shear, largest", dynamic))
    first.append(Line(along["coil number"], along["least"], "shear, least", theme.mix(dynamic, "#ffffff", 0.5)))
    second: list[Layer] = []
    if "quasi-static" in over:
        second.append(Line(*thin(over["cam angle"], over["quasi-static"]), "quasi-static", slow, dash="dash", in_legend=False))
    second.append(Line(*thin(over["cam angle"], over["shear"]), "shear", dynamic, in_legend=False))
    panels = (
        Panel("coil number from the seat", "shear stress at the inner fibre (MPa)", tuple(first), title="Over the wire"),
        Panel(ANGLE_LABEL, "shear stress at the inner fibre (MPa)", tuple(second), title=f"At coil number {coil:g}",
              bands=stage_bands(), x_range=(0, 360), x_step=60),
    )  # fmt: skip
    speed = speed_words(engine_speed)
    caption = (
        f"Shear stress at the inner fibre of the wire at {speed}: torsion and direct shear with the curvature of the bar (Bergsträsser, "
        "EN 13906-1). "
        "Quasi-static is the stress of the static curve at the same lift. No stress concentration under coil contacts, no residual stress."
    )
    return Chart(f"stress-{rpm(engine_speed):g}", f"Wire stress at {speed}", caption, panels, columns=2, height=380)
