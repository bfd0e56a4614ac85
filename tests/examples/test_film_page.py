"""Examples: the commands and the code of docs/film.md run as they stand, the commands on short
films of the same scenes.
"""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

import film_parts as made
from unit.cli_parts import call

pytest.importorskip("cv2")
PAGE = (Path(__file__).parents[2] / "docs" / "film.md").read_text(encoding="utf-8")


def test_every_command_of_the_page_runs(tmp_path, monkeypatch):
    """On short films of other scenes; the case of the first is run and laid beside."""
    monkeypatch.chdir(tmp_path)
    scene, share = made.drawn.Scene(), np.linspace(0.0, 0.9, 7)
    decay, _ = made.drawn.draw(
        scene, made.drawn.decaying(2.0 + 34.0 * share, share, (1.2,), 420.0, 0.012), 70
    )
    train, _ = made.drawn.draw(scene, made.turning, 170, made.cam_marks(170))
    made.drawn.write_frames(tmp_path / "decay", decay)
    made.drawn.write_frames(tmp_path / "train", train)
    commands = [line.strip() for line in PAGE.splitlines() if line.startswith("    valvetrain ")]
    assert len(commands) == 3
    for command, words in zip(
        commands, ("vaz-ohc by multi-mass", "by the marker", "damping ratio"), strict=True
    ):
        shown = call(*shlex.split(command)[1:])
        assert shown.exit_code == 0, shown.output
        assert words in shown.output


def test_the_code_of_the_page_prints_what_it_says(capsys):
    code, printed = re.search(r"```python\n(.*?)```\n\n```text\n(.*?)```", PAGE, re.DOTALL).groups()
    exec(compile(code, "docs/film.md", "exec"), {})
    assert capsys.readouterr().out == printed
