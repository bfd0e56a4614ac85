"""Stress of the wire beside its strength: largest over least shear of every run, as the charts of
spring makers have it.
"""

from __future__ import annotations

import numpy as np

from valvetrain.quantities.limits import LIMITS
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Marks, Panel, Rule
from valvetrain.report.page import Block, SectionSpec, figure_or_gap
from valvetrain.report.run_charts import line_styles
from valvetrain.report.text import number, speed_text
from valvetrain.solution.definition import NESTED
from valvetrain.solution.study import Study

PEAK, LEAST = "nominal_peak_shear_stress", "nominal_minimum_shear_stress"
#: The limit of the nominal stress; an unlimited one has no figure.
PERMITTED = next(one.against for one in LIMITS if one.quantity == PEAK)
SYMBOLS = ("circle", "diamond", "triangle", "square")


def blocks(study: Study) -> tuple[Block, ...]:
    """One figure; nothing where the strength of no wire is known."""
    return figure_or_gap("Stress beside the strength of the wire", strength_chart, study)


def strength_chart(study: Study) -> Chart | None:
    """A point per run and spring, its permitted shear as a line across; None without a strength."""
    known, layers, bounds = line_styles(study), list[Layer](), dict[str, float]()
    worst: list[tuple[float, str]] = []
    for label in study.labels:
        for place, spring in enumerate(("", *(f"{name}_" for name in NESTED))):
            if not spring and any(f"outer_{PEAK}" in run.quantities for run in study.runs(label)):
                continue  # that of the pair is the larger one of its springs
            names = [f"{spring}{name}" for name in (PEAK, LEAST, PERMITTED)]
            runs = [run for run in study.runs(label) if all(one in run.quantities for one in names)]
            if not runs:
                continue
            peak, least, limit = (
                np.array([run.quantities[name] for run in runs]) * 1e-6 for name in names
            )
            whose = known[label].label + (f", {spring[:-1]} spring" if spring else "")
            speeds = tuple(speed_text(run.engine_speed) for run in runs)
            layers.append(
                Marks(
                    least, peak, whose, known[label].colour, SYMBOLS[place], filled=True, size=7,
                    hints=tuple(f"{one}: {number(high, 4)} MPa" for one, high in zip(speeds, peak, strict=True)),
                )
            )  # fmt: skip
            bounds.setdefault(
                f"{spring[:-1]} permitted {number(float(limit[0]), 4)} MPa".strip(), float(limit[0])
            )
            top = int(np.argmax(peak / limit))
            worst.append(
                (float(peak[top] / limit[top]), f"{whose} at {speeds[top]}, {number(float(peak[top]), 4)} of {number(float(limit[top]), 4)} MPa")
            )  # fmt: skip
    if not worst:
        return None
    high = 1.08 * max([*bounds.values(), *(float(np.max(one.y)) for one in layers)])
    low = min(0.0, *(float(np.min(one.x)) for one in layers))
    layers.insert(
        0, Line(np.array([low, high]), np.array([low, high]), "no change of stress", theme.MUTED, 1.0, "dot")
    )  # fmt: skip
    rules = tuple(Rule("y", value, label) for label, value in bounds.items())
    share, label = max(worst)
    panel = Panel(
        "least shear stress of the cycle (MPa)",
        "largest shear stress (MPa)",
        tuple(layers),
        rules=rules,
        x_range=(low, high),
        y_range=(low, high),
    )
    caption = (
        "Shear by EN 13906-1 of every run; the higher above the dotted line, the larger the swing. Line across: 0.56 of the "
        f"least tensile strength (EN 13906-1). Nearest to it: {label}, {number(100 * share, 3)} %."
    )
    return Chart(
        "strength", "Stress beside the strength of the wire", caption, (panel,), height=380
    )


SPEC = SectionSpec("strength", "Stress and strength", blocks)
