"""The Python of the README runs as printed, and prints what the README says."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest

import valvetrain

README = Path(__file__).resolve().parents[2] / "README.md"
#: A block of Python, and the block of plain text that may follow it at once: what it prints.
BLOCK = re.compile(r"^```python\n(?P<code>.*?)^```\n(?:\n```text\n(?P<printed>.*?)^```)?", re.MULTILINE | re.DOTALL)
EXAMPLES = [(match["code"], match["printed"]) for match in BLOCK.finditer(README.read_text(encoding="utf-8"))]


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
    names = set(re.findall(r"`(\w+)`", README.read_text(encoding="utf-8")))
    assert not set(valvetrain.__all__) - {"__version__"} - names
