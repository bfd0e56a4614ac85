"""Readers tried in a process of their own: how each ends is told, and what is no fault of the file."""

from __future__ import annotations

import itertools
import subprocess
import sys
from contextlib import nullcontext
from importlib import invalidate_caches

import pytest

from valvetrain.errors import InputError
from valvetrain.solution import read_apart

READERS_SO_FAR = itertools.count()


@pytest.fixture
def reader_of_tests(tmp_path, monkeypatch):
    """Tries a file by a reader whose lines are given; what it raises is told as 'cannot be read'."""
    (tmp_path / "it").write_bytes(b"x")
    monkeypatch.syspath_prepend(str(tmp_path))

    def tried(lines):
        module = f"reader_of_tests_{next(READERS_SO_FAR)}"  # each its own: modules are remembered
        (tmp_path / f"{module}.py").write_text(
            f"import os\ndef read(path):\n    assert path.name == 'it'\n    {lines}\n"
        )
        invalidate_caches()
        read_apart.tried_apart(
            f"{module}:read", tmp_path / "it", "it", "cannot be read, so the caller does not"
        )

    return tried


ENDS = {
    "raise MemoryError": "more than 4 GB", "bytes(4_500_000_000)": "more than 4 GB", "os.kill(os.getpid(), 9)": "does not come back",
    "raise OSError('no room')": "cannot be read", "x = {}[0]": "cannot be read", "raise SystemExit(0)": "cannot be read",
    "from valvetrain.errors import InputError; raise InputError('its own words')": "", "os.write(1, b'printed')": "",
}  # fmt: skip


@pytest.mark.parametrize("end", ENDS)
def test_the_end_of_a_trial_is_told(reader_of_tests, end):
    """Only a file at which the reader comes back, or has its own words, is read by the caller."""
    with pytest.raises(InputError, match=ENDS[end]) if ENDS[end] else nullcontext():
        reader_of_tests(end)


@pytest.mark.slow
def test_a_reader_that_waits_for_ever_is_ended_by_the_clock(reader_of_tests, monkeypatch):
    """It takes none of the processor's time, which is bounded otherwise."""
    monkeypatch.setattr(read_apart, "MAX_SECONDS", 1)
    monkeypatch.setattr(read_apart, "_PATIENCE", 8)
    with pytest.raises(InputError, match="does not come back"):
        reader_of_tests("import time; time.sleep(60)")


@pytest.mark.parametrize("interpreter", ["", "/gone/bin/python", "/bin/false", None])
def test_without_an_interpreter_no_damage_is_told(reader_of_tests, monkeypatch, interpreter):
    monkeypatch.setattr(sys, "executable", interpreter)
    told = {"/bin/false": "ended with status 1", "/gone/bin/python": "No such file"}.get(
        interpreter or "", ""
    )
    with pytest.raises(
        InputError,
        match=rf"it: is not read, .* does not start as a Python that finds .*{told}.*; set it",
    ):
        reader_of_tests("return 1")


def test_a_reader_that_is_not_found_is_no_damage_of_the_file(reader_of_tests):
    with pytest.raises(InputError, match=r"is not read.*No module named 'no_module_of_this_name'"):
        reader_of_tests("return 1\nimport no_module_of_this_name")


def test_a_bound_that_stands_already_drops_no_other():
    lines = (
        "import resource; resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))\n"
        "resource.setrlimit(resource.RLIMIT_CPU, (7, 8)); from valvetrain.solution.read_apart import bound_process\n"
        "bound_process(4 << 30, 9); print(*(resource.getrlimit(getattr(resource, 'RLIMIT_' + one)) for one in ('AS', 'CPU', 'CORE')))"
    )
    told = subprocess.run(
        [sys.executable, "-c", lines], capture_output=True, text=True, check=True
    ).stdout.strip()
    assert told == f"{(3 << 30, 3 << 30)} (7, 7) (0, 0)"
