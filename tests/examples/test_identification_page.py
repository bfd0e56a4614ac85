"""docs/identification.md: its command runs, its program prints what it says, its file is the
example's, its options are all there are.
"""

from __future__ import annotations

import contextlib
import io
import re
import tomllib
from typing import get_args

import pytest
from typer.testing import CliRunner

from architecture.layout import ROOT
from valvetrain.cli.main import app
from valvetrain.explore.identification_file import Method, Search
from valvetrain.explore.observe import FORMS

PAGE = (ROOT / "docs" / "identification.md").read_text(encoding="utf-8")


def block(kind: str) -> str:
    found = re.search(rf"^```{kind}\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    assert found
    return found[1]


def test_the_command_runs_and_writes_its_page(tmp_path, monkeypatch) -> None:
    (command,) = block("sh").strip().splitlines()
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    result = CliRunner().invoke(app, [*command.split()[1:], "--workers", "1"])
    assert result.exit_code == 0, result.output
    assert "wire diameter" in result.output and "closed coils" in result.output
    (page,) = tmp_path.glob("runs/identify/*/report.html")
    assert "valvetrain findings I112" in page.read_text(encoding="utf-8")
    (case,) = tmp_path.glob("runs/identify/*/identified.toml")
    assert CliRunner().invoke(app, ["static", str(case), "--json"]).exit_code == 0


def test_the_program_prints_what_the_page_says() -> None:
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        exec(compile(block("python"), "identification.md", "exec"), {})
    assert output.getvalue() == block("text")


def test_the_file_shown_is_that_of_the_example() -> None:
    shown = tomllib.loads(block("toml"))
    example = tomllib.loads(
        (ROOT / "examples" / "identify-spring.toml").read_text(encoding="utf-8")
    )
    for table in ("quantities", "measurements"):
        for name, values in shown[table].items():
            assert values.items() <= example[table][name].items()


@pytest.mark.parametrize(
    "word", [*get_args(Method), *FORMS, *(one for one in Search.model_fields if one != "seed")]
)
def test_the_page_names_every_word_of_a_file(word: str) -> None:
    assert f"`{word}`" in PAGE
