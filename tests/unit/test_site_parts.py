"""The own parts of the documentation site: equations, figures, the tree of pages, the pages that a
build writes.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import plotly.graph_objects as go
import pytest
import typer

from valvetrain.cli.main import app

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(autouse=True)
def parts(monkeypatch):
    monkeypatch.setattr(sys, "path", [str(ROOT / "docs" / "_site"), *sys.path])


@pytest.mark.parametrize(
    "latex",
    [
        r"F = k\,\frac{x}{h}",
        r"\tfrac12 k x^2",
        r"^{3/2}",
        r"\frac{a}{b}\Big|_{0}",
        r"x_1 \le \dots \le x_n",
    ],
)
def test_equations_become_mathml(latex, caplog):
    from native_math import mathml

    assert mathml(latex, None, True).startswith("<math") and not caplog.records


def test_an_equation_that_cannot_be_set_is_a_warning_and_stays_readable(monkeypatch):
    import native_math

    told = []
    monkeypatch.setattr(
        native_math.LOG, "warning", lambda *words, **where: told.append(words[0] % words[1:])
    )
    assert (
        native_math.mathml(r"\nosuchcommand{x} < 1", None, False)
        == r"<code>\nosuchcommand{x} &lt; 1</code>"
    )
    assert len(told) == 1 and "nosuchcommand" in told[0]


def test_figures_are_drawn_with_lines_marks_bars_and_maps():
    from figure_svg import svg_of

    lines = go.Figure(
        [
            go.Scatter(x=[0, 1], y=[1, 2], name="force"),
            go.Scatter(x=[0, 1], y=[2, 1], mode="markers", name="test"),
        ]
    )
    bars = go.Figure(go.Bar(x=["installed", "solid"], y=[1.0, 2.0]))
    heat = go.Figure(
        go.Heatmap(x=[0, 1], y=[0, 1], z=[[0, 1], [2, 3]], colorbar={"title": "force (N)"})
    )
    texts = [
        svg_of(one.update_xaxes(title="x (mm)").update_yaxes(title="y (N)"))
        for one in (lines, bars, heat)
    ]
    assert all("x (mm)" in text and "y (N)" in text for text in texts)
    assert (
        "force" in texts[0]
        and "test" in texts[0]
        and "2 solid" in texts[1]
        and "<image" in texts[2]
    )
    with pytest.raises(ValueError, match="pie are not drawn"):
        svg_of(go.Figure(go.Pie(values=[1, 2])))


def test_the_tree_takes_pages_of_its_own_reach_in_order(tmp_path):
    from page_tree import children

    (tmp_path / "part").mkdir()
    for name in ("b.md", "a.md", "tutorial.md", "hub.md", "part/README.md", "part/one.md"):
        (tmp_path / name).write_text("")
    text = "[b](b.md) [b again](b.md#x) [a](a.md) [t](tutorial.md) [none](none.md) [w](https://x.org/y.md)"
    assert children("hub", text, tmp_path) == ["b", "a"]
    assert children("part/README", "[one](one.md) [up](../a.md) [me](README.md)", tmp_path) == [
        "one"
    ]


def test_every_public_name_has_its_place_in_the_api_and_programs_beside_it(tmp_path):
    from api_pages import HOMES, pages

    (tmp_path / "valvetrain.sweep.examples").write_text('<div class="sphx-glr-thumbcontainer">')
    text = "".join(pages(tmp_path).values())
    assert re.findall(r"^\.\. minigallery:: (.*)$", text, re.MULTILINE) == ["valvetrain.sweep"]
    assert sorted(re.findall(r"^\.\. auto\w+:: (\S+)$", text, re.MULTILINE)) == sorted(HOMES)


@pytest.mark.parametrize(
    ("written", "public"),
    [
        ("valvetrain.solution.result.Solution", "valvetrain.Solution"),
        ("vt.sweep", "valvetrain.sweep"),
        ("valvetrain.cam.build", None),
    ],
)
def test_names_lead_to_the_public_one(written, public):
    from api_pages import public_name

    assert public_name(written) == public


def test_a_name_that_does_not_exist_is_not_let_pass():
    from api_pages import exists

    assert (
        exists("valvetrain.runs.api.sweep")
        and exists("Status")
        and not exists("valvetrain.runs.api.swep")
        and not exists("Stattus")
    )


def test_the_page_of_the_command_line_holds_every_option():
    from command_pages import page

    text = page()
    for name, command in typer.main.get_command(app).commands.items():
        assert f"\nvalvetrain {name}\n---" in text
        assert all(
            flag in text
            for one in command.params
            for flag in one.opts
            if flag.startswith("--") and flag != "--help"
        )
