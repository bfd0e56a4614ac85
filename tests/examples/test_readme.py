"""The Python of the README runs as printed, and prints what the README says; what the program
writes of it is up to date.
"""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest
import write_pages

import valvetrain

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
#: A block of Python, and the block of plain text that may follow it at once: what it prints.
BLOCK = re.compile(
    r"^```python\n(?P<code>.*?)^```\n(?:\n```text\n(?P<printed>.*?)^```)?", re.MULTILINE | re.DOTALL
)
EXAMPLES = [(match["code"], match["printed"]) for match in BLOCK.finditer(README)]


@pytest.mark.parametrize(("code", "printed"), EXAMPLES)
def test_a_block_prints_what_the_readme_says(code, printed, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        exec(compile(code, "README.md", "exec"), {})
    assert printed is None or output.getvalue() == printed


def test_the_readme_has_an_example_with_its_output():
    assert any(printed for _, printed in EXAMPLES)


def test_the_readme_names_every_public_name():
    names = set(re.findall(r"`(\w+)`", README))
    assert not set(valvetrain.__all__) - {"__version__"} - names


def test_the_readme_is_short_and_its_first_ten_lines_say_what_it_is_for_and_show_it():
    lines = README.splitlines()
    assert len(lines) < 170
    top = "\n".join(lines[:10])
    assert "computes" in top and "![" in top and "pip install" in top


def test_the_table_of_spring_models_is_the_one_of_the_registry():
    assert write_pages.models_table() in README


def test_the_picture_stands_in_the_repository():
    (picture,) = re.findall(r"!\[[^]]+\]\(([^)]+)\)", README)
    assert (ROOT / picture) == write_pages.README_PICTURE
    text = (ROOT / picture).read_text(encoding="utf-8")
    assert text.startswith("<svg") and len(text) < 40_000


def test_the_readme_names_every_command():
    named = set(re.findall(r"`valvetrain ([a-z-]+)", README))
    assert set(valvetrain.registry.words("commands")) <= named
