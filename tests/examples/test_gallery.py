"""The small programs of the gallery run, print what is kept beside this file, and end in a figure
whose axes carry units.

The quick half runs with all tests, 6 s together; the others with ``make test-long``, and in every
build of the documentation.
Answers that changed for a reason are written anew by ``python tests/examples/test_gallery.py``.
"""

from __future__ import annotations

import ast
import contextlib
import io
import json
import runpy
import sys
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
    assert isinstance(figure, go.Figure) and figure.layout.title.text
    titles = axis_titles(figure)
    assert len(titles) >= 2
    assert all(
        title.endswith(")")
        or title in ("coil number", "tolerance of", "state", "train", "axial displacement")
        for title in titles
    ), titles
    sys.path.insert(0, str(ROOT / "docs" / "_site"))
    try:
        from figure_svg import svg_of
    finally:
        sys.path.pop(0)
    assert svg_of(figure).startswith("<svg")


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_a_program_asks_a_question_and_uses_one_process(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    title, line = (ast.get_docstring(tree) or "").splitlines()[:2]
    assert title.endswith("?") and line == "=" * len(title)
    long_ones = {"simulate", "sweep", "study", "optimise", "critical_speeds", "compare_with_test"}
    calls = [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
    ]
    assert all(
        "workers" in {word.arg for word in call.keywords}
        for call in calls
        if call.func.attr in long_ones
    )


def test_a_figure_is_drawn_once_it_has_its_labels(tmp_path):
    """Contract: five of the gallery's figures, drawn in one block and labelled in the next, stood
    without title and axes.
    """
    sys.path.insert(0, str(ROOT / "docs" / "_site"))
    try:
        from gallery_figures import scrape
    finally:
        sys.path.pop(0)
    go = pytest.importorskip("plotly.graph_objects")
    figure, path = go.Figure(go.Scatter(x=[0, 1], y=[0, 1])), tmp_path / "one.svg"
    block = {"example_globals": {"figure": figure}, "image_path_iterator": iter([str(path)])}
    assert scrape((), block, {}) == "" and not path.exists()
    figure.update_layout(title="A title").update_xaxes(title="engine speed (rpm)")
    assert "one.svg" in scrape((), block, {})
    assert "A title" in path.read_text() and "engine speed (rpm)" in path.read_text()
    assert scrape((), block, {}) == "", "drawn once"


def test_there_are_twenty_and_half_of_them_run_always():
    assert len(PROGRAMS) >= 20
    assert {path.stem[:3] for path in PROGRAMS} >= QUICK and 2 * len(QUICK) >= len(PROGRAMS)
    assert set(json.loads(ANSWERS.read_text(encoding="utf-8"))) == {path.stem for path in PROGRAMS}


if __name__ == "__main__":
    found = {path.stem: answer(path)[0] for path in PROGRAMS}
    ANSWERS.write_text(json.dumps(found, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
