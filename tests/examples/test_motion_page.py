"""Examples: the code of docs/motion.md prints what it says, its commands know every option, its
numbers are those of the package.
"""

from __future__ import annotations

import re
import shlex
from pathlib import Path

from unit.cli_parts import call
from valvetrain.report.motion import film, scene
from valvetrain.report.motion import parts as outlines

PAGE = (Path(__file__).parents[2] / "docs" / "motion.md").read_text(encoding="utf-8")


def test_the_code_of_the_page_prints_what_it_says(capsys):
    code, printed = re.search(r"```python\n(.*?)```\n\n```text\n(.*?)```", PAGE, re.DOTALL).groups()
    exec(compile(code, "docs/motion.md", "exec"), {})
    assert capsys.readouterr().out == printed


def test_the_commands_of_the_page_know_their_options():
    commands = [
        shlex.split(line) for line in PAGE.splitlines() if line.startswith("    valvetrain ")
    ]
    assert len(commands) == 3 and all(words[1] == "animate" for words in commands)
    known = call("animate", "--help").stdout
    named = {word for words in commands for word in words if word.startswith("--")}
    assert {"--output", "--spring", "--colour"} <= named and not {
        word for word in named if word not in known
    }


def test_the_bounds_of_the_page_are_those_of_the_code():
    assert (
        f"1 to {film.MAX_LENGTH:g} s, {film.NARROWEST} to {film.WIDEST} px wide, {film.RATE} pictures a second"
        in PAGE
    )
    assert (
        f"at most {film.MAX_BYTES / 1e6:g} MB" in PAGE
        and f"all where {scene.MAX_RUN_BYTES / 1e3:g} kB allow it" in PAGE
    )
    assert f"{outlines.LOBE_POINTS} points of the contour" in PAGE
