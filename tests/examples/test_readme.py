"""The Python of the README runs as printed, and prints what the README says; what the program
writes of it is up to date.
"""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import numpy as np
import pytest
import write_pages
from api_pages import PUBLIC

import valvetrain

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
#: A block of Python, and the block of plain text that may follow it at once: what it prints.
BLOCK = re.compile(
    r"^```python\n(?P<code>.*?)^```\n(?:\n```text\n(?P<printed>.*?)^```)?", re.MULTILINE | re.DOTALL
)
PAGES = [
    (ROOT / "docs" / page).read_text(encoding="utf-8")
    for page in ("public-names.md", "python.md", "extend/own-parts-in-a-script.md")
]
EXAMPLES = [
    (match["code"], match["printed"]) for text in (README, *PAGES) for match in BLOCK.finditer(text)
]


@pytest.mark.parametrize(("code", "printed"), EXAMPLES)
def test_a_block_prints_what_the_readme_says(code, printed, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        exec(compile(code, "README.md", "exec"), {})
    assert printed is None or output.getvalue() == printed


def test_the_readme_has_an_example_with_its_output():
    assert any(printed for _, printed in EXAMPLES)


def test_the_page_of_public_names_lists_every_one():
    names = set(re.findall(r"`(\w+)`", PAGES[0]))
    assert not set(valvetrain.__all__) - names
    assert not set(PUBLIC) - names


def test_the_table_of_spring_models_is_the_one_of_the_registry():
    assert write_pages.models_table() in PAGES[0]


def test_the_readme_names_every_command():
    named = set(re.findall(r"`valvetrain ([a-z-]+)", README))
    assert set(valvetrain.registry.names("commands")) <= named


def test_the_sweep_of_the_readme_loses_the_cam_where_it_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_pages.printed_by("valvetrain new mine --kind pushrod")
    lost = valvetrain.sweep("mine.toml", "5500:7000:500 rpm").critical_speeds.of("contact-loss")
    printed = float(re.search(r"LOSES THE CAM AT ABOUT (\d+) RPM", README)[1])
    assert printed == pytest.approx(lost.engine_speed * 30 / np.pi, abs=60)
