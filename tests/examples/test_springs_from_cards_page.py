"""Examples: the commands of docs/springs-from-cards.md run as they stand, on the sample tables that the script writes."""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

from unit.cli_parts import call

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "springs-from-cards.md").read_text(encoding="utf-8")


def test_every_command_of_the_page_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    subprocess.run([sys.executable, str(ROOT / "scripts" / "sample_measurements.py"), "."], check=True, cwd=tmp_path)
    commands = [line.strip() for line in PAGE.splitlines() if line.startswith("    valvetrain ")]
    assert len(commands) == 3
    answers = [call(*shlex.split(command)[1:]) for command in commands]
    assert [shown.exit_code for shown in answers] == [0, 0, 0], [shown.output for shown in answers]
    assert "force at the installed height" in answers[1].output
