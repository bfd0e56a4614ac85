"""The section on wire stress of a spring page: a table of named stresses and a figure per engine speed."""

from __future__ import annotations

from valvetrain.quantities.study import SpringStudy
from valvetrain.report.figures import stress
from valvetrain.report.page import Block, Cell, Figure, Grid, text
from valvetrain.report.words import number, speed_words
from valvetrain.solution.quantity import Quantity

#: Column -> (quantity, factor to the unit shown).
_COLUMNS = {
    "peak shear (MPa)": ("peak_shear_stress", 1e-6), "quasi-static (MPa)": ("quasi_static_peak_shear_stress", 1e-6),
    "dynamic / static": ("dynamic_to_static_stress_ratio", 1.0), "at coil number": ("peak_shear_stress_coil_number", 1.0),
    "largest amplitude (MPa)": ("largest_amplitude_shear_stress", 1e-6), "its mean (MPa)": ("largest_amplitude_mean_shear_stress", 1e-6),
    "quasi-static amplitude (MPa)": ("quasi_static_amplitude_shear_stress", 1e-6), "peak von Mises (MPa)": ("peak_equivalent_stress", 1e-6),
}  # fmt: skip


def stress_blocks(study: SpringStudy) -> tuple[Block, ...]:
    """Lead, table and figures; nothing where no run holds section loads of the wire."""
    rows, figures = [], []
    for run in study.solutions:
        along, over = stress.wire_table(study, run), stress.worst_table(study, run)
        if along is None or over is None:
            continue
        values = [study.quantities.get(Quantity(name, run.engine_speed, run.model)) for name, _ in _COLUMNS.values()]
        shown = [None if value is None else value * factor for value, (_, factor) in zip(values, _COLUMNS.values(), strict=True)]
        rows.append(((Cell(speed_words(run.engine_speed), "number"), *(Cell(number(value), "number") for value in shown)), ""))
        figures.append(Figure(stress.stress_chart(along, *over, run.engine_speed)))
    if not rows:
        return ()
    lead = (
        "Stress at the inner fibre from the section loads of the rod: torsion and direct shear with the curvature of the bar. "
        "Amplitude and mean are half the difference and half the sum of largest and least shear at one point of the wire over the cycle."
    )
    return (text(lead, "quiet"), Grid(("engine speed", *_COLUMNS), tuple(rows)), *figures)
