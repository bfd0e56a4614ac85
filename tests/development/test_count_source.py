"""The size of the source is counted alike by every Python, and `budget.toml` bounds it."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib

import pytest
from count_source import ROOT, complaints, tokens_of

BOUNDS = {"cam": 100, "springs": 200, "page_bytes": 50}


def test_an_f_string_is_one_token_of_this_python(tmp_path):
    path = tmp_path / "example.py"
    path.write_text('x = f"{a:{b}} c" + f"d"  # why\n', encoding="utf-8")
    assert tokens_of(path) == 5


@pytest.mark.parametrize(
    ("total", "change"),
    [(300, {"cam": 101}), (300, {"page_bytes": 51}), (300, {"new": 1}), (299, {})],
)
def test_a_figure_exceeded_is_named(total, change):
    (sentence,) = complaints(BOUNDS, total, BOUNDS | change)
    assert all(name in sentence for name in change)


@pytest.mark.slow
def test_the_main_job_enters_no_more_functions(tmp_path):
    bounds = tomllib.loads((ROOT / "budget.toml").read_text(encoding="utf-8"))["entered"]
    job = ("run", "gu2021-beehive", "--workers", "1")
    command = [sys.executable, str(ROOT / "scripts" / "count_source.py"), "--entered", *job]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    functions, files = map(int, re.findall(r"\d+", done.stdout.splitlines()[-1]))
    assert functions <= bounds["functions"], done.stdout
    assert files <= bounds["files"], done.stdout
    assert functions > 100
