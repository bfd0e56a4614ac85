"""Example: the program of docs/clusters.md runs as printed, on processes that Dask starts."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from unit.cli_parts import process_environment

pytest.importorskip("distributed")


def test_the_program_of_the_page_prints_what_stands_there(tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "clusters.md").read_text()
    program, printed = re.search(
        r"```python\n(.*?)```\n\n```text\n(.*?)```", page, re.DOTALL
    ).groups()
    file = tmp_path / "program.py"
    file.write_text(program)
    done = subprocess.run(
        [sys.executable, str(file)],
        cwd=tmp_path,
        env=process_environment(),
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.stdout == printed, done.stderr[-2000:]
