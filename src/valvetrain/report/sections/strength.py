"""Stress of the wire and its strength: largest over least corrected shear of every run, as the
charts of spring makers have it, with published fatigue strengths and the static limit.
"""

from __future__ import annotations

import numpy as np

from valvetrain.parameters.material import FATIGUE_RANGES
from valvetrain.quantities.limits import LIMITS
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Marks, Panel, Rule
from valvetrain.report.page import Block, SectionSpec, figure_or_gap
from valvetrain.report.run_charts import line_styles
from valvetrain.report.text import amount, number, speed_text
from valvetrain.solution.definition import NESTED
from valvetrain.solution.study import Study
from valvetrain.units.reader import reader_factor

PEAK, LEAST = "open_nominal_shear_stress", "closed_nominal_shear_stress"
UNCORRECTED = "open_uncorrected_shear_stress"
#: The limit of the uncorrected stress; a wire without one has no figure.
PERMITTED = next(one.against for one in LIMITS if one.quantity == UNCORRECTED)
SYMBOLS = ("circle", "diamond", "triangle", "square")


def blocks(study: Study) -> tuple[Block, ...]:
    """One figure; nothing where the strength of no wire is known."""
    return figure_or_gap("Stress and strength of the wire", strength_chart, study)


def strength_chart(study: Study) -> Chart | None:
    """A point per run and spring, and as a line across the corrected shear at which the uncorrected
    one is what the wire is permitted; None without a strength.
    """
    known, layers, bounds = line_styles(study), list[Layer](), dict[str, float]()
    worst: list[tuple[float, str]] = []
    for label in study.labels:
        for place, spring in enumerate(("", *(f"{name}_" for name in NESTED))):
            if not spring and any(f"outer_{PEAK}" in run.quantities for run in study.runs(label)):
                continue  # that of the pair is the larger one of its springs
            names = [f"{spring}{name}" for name in (PEAK, LEAST, UNCORRECTED, PERMITTED)]
            runs = [run for run in study.runs(label) if all(one in run.quantities for one in names)]
            if not runs:
                continue
            peak, least, plain, limit = (
                np.array([run.quantities[name] for run in runs]) * 1e-6 for name in names
            )
            whose = known[label].label + (f", {spring[:-1]} spring" if spring else "")
            speeds = tuple(speed_text(run.engine_speed) for run in runs)
            layers.append(
                Marks(
                    least, peak, whose, known[label].colour, SYMBOLS[place], filled=True, size=7,
                    hints=tuple(f"{one}: {amount(high, 'MPa')}" for one, high in zip(speeds, peak, strict=True)),
                )
            )  # fmt: skip
            most = float(limit[0] * peak[0] / plain[0])  # of one wire the factor is the same
            bounds.setdefault(f"{spring[:-1]} static limit {amount(most, 'MPa')}".strip(), most)
            top = int(np.argmax(plain / limit))
            highest = number(float(plain[top]) * reader_factor("MPa"), 4)
            worst.append(
                (float(plain[top] / limit[top]), f"{whose} at {speeds[top]}, {highest} of {amount(float(limit[top]), 'MPa')}")
            )  # fmt: skip
    if not worst:
        return None
    borne = 1e-6 * np.array(list(FATIGUE_RANGES.values()))
    layers.append(
        Marks(
            borne[:, 0], borne[:, 1], "fatigue strength (Zimmerli 1957)", theme.MUTED, "diamond", labels=tuple(FATIGUE_RANGES), size=7,
            hints=tuple(f"{amount(one, 'MPa', 3)} to {amount(other, 'MPa', 3)}" for one, other in borne),
        )
    )  # fmt: skip
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
        "Corrected shear by EN 13906-1 of every run; the higher above the dotted line, the larger the swing, which fatigues the "
        "wire. Open marks: swings that spring steels below 10 mm bore without end (Zimmerli 1957), no verdict on the life of this one. "
        "Line across: where the uncorrected shear is 0.56 of the least tensile strength (EN 13906-1, at rest). Nearest to it: "
        f"{label} uncorrected, {number(100 * share, 3)} %."
    )
    return Chart("strength", "Stress and strength of the wire", caption, (panel,), height=380)


SPEC = SectionSpec("strength", "Stress and strength", blocks)
