"""Writes what the program makes of its own README: the picture, and the table of spring models from
the registry.

    python scripts/write_readme.py

The picture is the spring force of the published beehive spring over the cam angle, by the rod and
by the modal model.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

import valvetrain as vt
from valvetrain.registry import words
from valvetrain.springs.spec import spring_model

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "pictures" / "beehive-force.svg"
#: Label of a run -> its words and its colour.
SHOWN = {
    "finite-element": ("finite-element rod, coils clash", "#c2410c"),
    "modal-varied": ("modal model, coils pass through", "#2563eb"),
}
HEAD = "| word | model | what it knows | what it leaves out |\n|---|---|---|---|\n"


def models_table() -> str:
    """The spring models that ship, in the order of the registry, as a table of the README."""
    specs = [spring_model(word) for word in words("springs")]
    return HEAD + "".join(
        f"| `{one.word}` | {one.label} | {one.knows} | {one.leaves_out} |\n" for one in specs
    )


def picture() -> str:
    """The picture as SVG: force on the seat (N) over one cam turn at 8000 rpm of the crank."""
    from valvetrain.report.chart import Chart, Line, Panel
    from valvetrain.report.svg_chart import svg

    study = vt.simulate("gu2021-beehive", "8000 rpm")
    lines = []
    for label, (told, colour) in SHOWN.items():
        (run,) = study.runs(label)
        angle = np.degrees(run.cam_angle)
        lines.append(
            Line(
                np.round(angle - 360 * np.floor(angle[0] / 360), 2),
                run.channel("seat_force"),
                told,
                colour,
            )
        )
    panel = Panel(
        "cam angle (deg)", "force on the seat (N)", tuple(lines), x_range=(0.0, 360.0), x_step=45.0
    )
    return svg(Chart("beehive-force", "Beehive valve spring at 8000 rpm", "", (panel,), height=300))


if __name__ == "__main__":
    readme = ROOT / "README.md"
    text = re.sub(
        re.escape(HEAD) + r"(?:\|.*\n)*",
        lambda _: models_table(),
        readme.read_text(encoding="utf-8"),
    )
    readme.write_text(text, encoding="utf-8")
    PICTURE.write_text(picture(), encoding="utf-8")
