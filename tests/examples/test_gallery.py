"""The small programs of the gallery run, print what is kept beside this file, and end in a figure
whose axes carry units.

The quick half runs with all tests, 6 s together; the others with ``make test-long``, and in every
build of the documentation.
Answers that changed for a reason are written anew by ``python tests/examples/test_gallery.py``.
"""

from __future__ import annotations

import contextlib
import io
import json
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "examples" / "gallery"
ANSWERS = Path(__file__).with_name("gallery_answers.json")
PROGRAMS = sorted(FOLDER.glob("*.py"))
QUICK = {"g01", "g02", "g04", "g08", "g09", "g10", "g12", "g16", "g18", "g19", "g22", "g23", "g25"}


def answer(path: Path) -> tuple[list[str], object]:
    """What a program prints, line by line, and its figure."""
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        scope = runpy.run_path(str(path))
    return output.getvalue().splitlines(), scope["figure"]


def axis_titles(figure) -> list[str]:
    """Titles of the axes, of panels over one x axis the one of the lowest."""
    layout = figure.layout
    return [
        layout[name].title.text
        for name in layout
        if name[1:5] == "axis" and layout[name].title.text
    ]


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, marks=[] if path.stem[:3] in QUICK else [pytest.mark.long], id=path.stem)
        for path in PROGRAMS
    ],
)
def test_a_program_answers_and_draws(path):
    import plotly.graph_objects as go

    printed, figure = answer(path)
    assert printed == json.loads(ANSWERS.read_text(encoding="utf-8"))[path.stem]
    assert isinstance(figure, go.Figure) and len(axis_titles(figure)) >= 2


if __name__ == "__main__":
    found = {path.stem: answer(path)[0] for path in PROGRAMS}
    ANSWERS.write_text(json.dumps(found, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
