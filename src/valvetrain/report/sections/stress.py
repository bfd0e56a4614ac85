"""Stress of the wire: named numbers by run, extremes along the wire, and over the cam angle where it is largest."""

from __future__ import annotations

import numpy as np

from valvetrain.quantities.cycle import reported_cycle
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Panel, thin
from valvetrain.report.figures.common import ANGLE_LABEL, by_speed, event_bands, looks
from valvetrain.report.page import Block, Cell, Grid, SectionSpec, figure_or_gap, text
from valvetrain.report.sections.coils import along
from valvetrain.report.words import number, speed_words
from valvetrain.solution.definition import label_of, shown
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

SHEAR = "inner_fibre_shear_stress"
NAMES = (
    "peak_shear_stress", "minimum_shear_stress", "peak_shear_stress_coil_number", "peak_equivalent_stress",
    "largest_amplitude_shear_stress",
    "largest_amplitude_mean_shear_stress", "quasi_static_peak_shear_stress", "quasi_static_amplitude_shear_stress",
    "dynamic_to_static_stress_ratio", "nominal_peak_shear_stress", "nominal_minimum_shear_stress",
)  # fmt: skip
_LEAD = "Shear at the inner fibre: torsion and direct shear with the curvature of the wire. No stress concentration under coil contacts."


def blocks(study: Study) -> tuple[Block, ...]:
    """Figures by engine speed, then the named numbers, one column per run."""
    known = looks(study)

    def at(engine_speed: float, runs: list[Solution], key: str) -> tuple[Block, ...]:
        found: tuple[Block, ...] = ()
        for place, run in enumerate(runs, start=1):
            for spring in run.springs:
                whose = f"{known[run.label].words}, {spring} spring" if len(run.springs) > 1 else known[run.label].words
                title = f"Wire stress: {whose}, {speed_words(engine_speed)}"
                found += figure_or_gap(title, stress_chart, study, run, spring, f"{key}-{place}-{spring}", title)
        return found

    figures = by_speed(study, "stress", at)
    runs = [run for run in study.solutions if any(name in run.quantities for name in NAMES)]
    if study.over_speed or not runs:
        return figures
    rows = []
    for name in (name for name in NAMES if any(name in run.quantities for run in runs)):
        words, unit = label_of(name), shown(name, 1.0)[1]
        values = [shown(name, run.quantities[name])[0] if name in run.quantities else None for run in runs]
        cells = (
            Cell(f"{words[:1].upper()}{words[1:]}", "", name),
            Cell(unit, "quiet"),
            *(Cell(number(value), "number") for value in values),
        )
        rows.append((cells, ()))
    headers = ("", "unit", *(f"{known[run.label].words}, {speed_words(run.engine_speed)}" for run in runs))
    return (text(_LEAD, "quiet"), *figures, Grid(headers, tuple(rows)))


def stress_chart(study: Study, run: Solution, spring: str, key: str, title: str) -> Chart | None:
    """Largest and least shear along the wire, and the worst point over one cam cycle (MPa), beside those of the static curve."""
    found = along(run, run.channel_of(spring, SHEAR))
    if found is None:
        return None
    (coil, shear), cycle = found, reported_cycle(run)
    angle, worst = np.degrees(cycle.cam_angle), int(np.argmax(shear.max(axis=0)))
    dynamic, slow, words = theme.model_colour(run.model), theme.model_colour("massless"), "static curve at the same lift"
    first: list[Layer] = [
        Line(coil, shear.max(axis=0) * 1e-6, "largest", dynamic),
        Line(coil, shear.min(axis=0) * 1e-6, "least", theme.mix(dynamic, "#ffffff", 0.5)),
    ]
    second: list[Layer] = [Line(*thin(angle, shear[:, worst] * 1e-6), "largest", dynamic, in_legend=False)]
    rest = next((one for one in study.rest if one.spring == spring and one.stress is not None), None)
    if rest is not None and rest.stress is not None and run.has("valve_lift"):
        still = rest.stress.shear_at(rest.precompression + cycle.channel("valve_lift")) * 1e-6
        near = int(np.argmin(np.abs(rest.stress.coil_number - coil[worst])))
        first.insert(0, Line(rest.stress.coil_number, still.max(axis=0), words, slow, 1.4, "dash"))
        second.insert(0, Line(*thin(angle, still[:, near]), words, slow, 1.4, "dash"))
    place = f"At coil number {coil[worst]:.3g}"
    panels = (
        Panel("coil number from the seat", "shear stress (MPa)", tuple(first), "Along the wire"),
        Panel(ANGLE_LABEL, "shear stress (MPa)", tuple(second), place, event_bands(study), x_range=(0, 360), x_step=60),
    )
    return Chart(key, title, "Shear stress at the inner fibre of the wire over the reported cycle.", panels, 2, 330)


SPEC = SectionSpec("stress", "Wire stress", blocks)
