"""Draw docs/pictures/optimise-beehive.svg: clash energy over engine speed of the case and of the
best spring of the worked example.

valvetrain optimise examples/optimise-beehive.toml
python scripts/draw_optimisation.py runs/optimise/optimise-beehive/best.toml
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import valvetrain as vt
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Panel
from valvetrain.report.svg_chart import svg

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "pictures" / "optimise-beehive.svg"
MODELS = ("multi-mass", "finite-element")


def clash_energy(case: str, model: str) -> tuple[np.ndarray, np.ndarray]:
    """Engine speeds (rpm) and clash energy of a cycle (mJ)."""
    table = vt.study(
        f"""
case = "{case}"
spring_models = "{model}"
outputs = "clash_energy"
points = {{ sampler = "grid", levels = 15 }}
vary = [{{ key = "engine_speed", low = "5500 rpm", high = "9000 rpm" }}]
""",
        limit="1 h",
    )
    return table.column("engine_speed") * 30 / np.pi, 1e3 * table.column("clash_energy")


def main(best: str) -> None:
    """Draw the picture."""
    panels = []
    for model in MODELS:
        layers: list[Layer] = []
        for case, words, colour in (
            ("gu2021-beehive", "the case", theme.SERIES[1]),
            (best, "the best of the search", theme.SERIES[2]),
        ):
            layers.append(
                Line(*clash_energy(case, model), words, colour, 2.0, in_legend=model == MODELS[0])
            )
        panels.append(
            Panel(
                "engine speed (rpm)", "clash energy (mJ)", tuple(layers), theme.model_words(model)
            )
        )
    chart = Chart("optimise", "Energy of all clashes of a cycle", "", tuple(panels), 2, 330)
    PICTURE.write_text(svg(chart), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1])
