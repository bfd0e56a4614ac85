"""Examples: the code of docs/motion.md prints what it says, and its numbers are those of the package."""

from __future__ import annotations

import re
from pathlib import Path

from valvetrain.views.motion import parts as outlines
from valvetrain.views.motion import scene

PAGE = (Path(__file__).parents[2] / "docs" / "motion.md").read_text(encoding="utf-8")


def test_the_code_of_the_page_prints_what_it_says(capsys):
    code, printed = re.search(r"```python\n(.*?)```\n\n```text\n(.*?)```", PAGE, re.DOTALL).groups()
    exec(compile(code, "docs/motion.md", "exec"), {})
    assert capsys.readouterr().out == printed


def test_the_bounds_of_the_page_are_those_of_the_code():
    assert f"all where {scene.MAX_RUN_BYTES / 1e3:g} kB allow it" in PAGE
    assert f"{outlines.LOBE_POINTS} points of the contour" in PAGE
