"""Half-written files of killed processes go; those of living ones, and files of others, stay."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from datetime import UTC, datetime

import pytest

from unit.cli_parts import process_environment
from valvetrain.runs.run_folders import LIST, unfinished_folder
from valvetrain.solution import atomic

pytestmark = pytest.mark.skipif(
    atomic.fcntl is None, reason="needs locks that end with their process"
)
WRITES = (
    "import sys, time; from valvetrain.solution.atomic import atomic_path\n"
    "with atomic_path(sys.argv[1]): print('begun', flush=True); time.sleep(60)"
)


@pytest.fixture
def half_written(tmp_path):
    """A process in the middle of writing ``a.csv``, and its temporary file."""
    command = [sys.executable, "-c", WRITES, str(tmp_path / "a.csv")]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True, env=process_environment()
    ) as running:
        assert running.stdout is not None and running.stdout.readline() == "begun\n"
        (part,) = tmp_path.iterdir()
        yield running, part
        running.kill()


def test_what_a_living_process_writes_stays_and_what_a_killed_one_left_goes(half_written, tmp_path):
    running, part = half_written
    mine = [
        tmp_path / name
        for name in (".a.csv.abcdefgh.part", "a.part", ".valvetrain.part", "a.csv.valvetrain.part")
    ]
    for path in mine:
        path.touch()
    assert atomic.remove_abandoned(tmp_path) == () and part.exists()
    running.kill()
    running.wait()
    assert atomic.remove_abandoned(tmp_path) == (part,) and sorted(tmp_path.iterdir()) == sorted(
        mine
    )


def test_the_first_file_written_to_a_folder_sweeps_it(half_written, tmp_path):
    running, part = half_written
    running.send_signal(signal.SIGKILL)
    running.wait()
    assert part.exists()
    atomic.write_text(tmp_path / "b.csv", "b")
    assert [path.name for path in tmp_path.iterdir()] == ["b.csv"]


def test_a_new_run_of_a_case_removes_what_killed_runs_left_empty_and_nothing_else(tmp_path):
    home = tmp_path / "case"
    for name, files in {
        "1-unfinished": [LIST],
        "2-unfinished": [LIST, "run-0001.nc"],
        "3-unfinished": ["mine.txt"],
        "20260101-x": [LIST],
    }.items():
        (home / name).mkdir(parents=True)
        for file in files:
            (home / name / file).touch()
    living = unfinished_folder("case", datetime(2026, 1, 2, tzinfo=UTC), tmp_path)
    left = {path.name for path in home.iterdir()}
    assert left == {"2-unfinished", "3-unfinished", "20260101-x", living.name}


def test_names_as_long_as_a_file_system_takes_are_written(tmp_path):
    for name in ("a" * 255, "\u6c34" * 85):
        assert atomic.write_text(tmp_path / name, "x").read_text() == "x"
    assert len(os.listdir(tmp_path)) == 2
