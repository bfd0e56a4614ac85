"""Examples: the commands of docs/rig-data.md run as they stand, on sample recordings of the script."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

import valvetrain as vt
from unit.cli_parts import call

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "rig-data.md").read_text(encoding="utf-8")
sys.path.insert(0, str(ROOT / "scripts"))
import sample_rig  # noqa: E402


def test_every_command_of_the_page_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    records = sample_rig.record(
        sample_rig.Rig(slipped=7, sampling_rate=20e3), *sample_rig.simulated()
    )
    for name in ("rig.csv", "rig.tdms"):
        sample_rig.WRITERS[name](tmp_path / name, records)
    commands = [line.strip() for line in PAGE.splitlines() if line.startswith("    valvetrain ")]
    assert len(commands) == 2
    for command in commands:
        shown = call(*shlex.split(command)[1:])
        assert shown.exit_code == 0, shown.output
    (tmp_path / "own.csv").write_text(
        "\n".join(
            line.strip()
            for line in PAGE.splitlines()
            if line.startswith(("    #", "    angle,", "    0,"))
        )
        + "".join(f"\n{angle},1,2" for angle in range(30, 360, 30)),
        encoding="utf-8",
    )
    assert vt.measured.read_cycles(tmp_path / "own.csv").values.shape == (2, 12)
