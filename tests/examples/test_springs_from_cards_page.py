"""Examples: the commands of docs/springs-from-cards.md run as they stand, on the sample tables that
the script writes.
"""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from unit.cli_parts import call

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "springs-from-cards.md").read_text(encoding="utf-8")


COMMANDS = [line.strip() for line in PAGE.splitlines() if line.startswith("    valvetrain ")]


def test_the_page_has_its_commands():
    assert len(COMMANDS) == 3


@pytest.mark.parametrize(
    "place", [0, pytest.param(1, marks=pytest.mark.long), pytest.param(2, marks=pytest.mark.long)]
)
def test_every_command_of_the_page_runs(place, tmp_path, monkeypatch):
    """Those that read a table of forces search a pitch law, in some ten seconds each."""
    monkeypatch.chdir(tmp_path)
    if place:
        subprocess.run(
            [sys.executable, str(ROOT / "scripts" / "sample_measurements.py"), "."],
            check=True,
            cwd=tmp_path,
        )
    shown = call(*shlex.split(COMMANDS[place])[1:])
    assert shown.exit_code == 0, shown.output
    assert place != 1 or "force at the installed height" in shown.output
