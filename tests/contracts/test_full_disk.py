"""A disk that takes no more: one sentence, an exit code, no crash of a library, and what was
written stays.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys

import pytest

from unit.cli_parts import MODULE, process_environment, typed
from valvetrain.solution.netcdf import load_result

JOB = typed("run job-t --rpm '2000, 2500 rpm' --model massless,multi-mass --no-report --output out")
#: Bytes that the disk takes: the first files, not all of them.
ROOM = 300_000


def shell(script: str, folder, *arguments: str) -> subprocess.CompletedProcess[str]:
    """The command below a line of shell that makes the disk small."""
    command = ["sh", "-c", script, "sh", sys.executable, *MODULE, *arguments]
    return subprocess.run(
        command, capture_output=True, text=True, cwd=folder, timeout=120, env=process_environment()
    )


def checked(result: subprocess.CompletedProcess[str], told: str) -> list[str]:
    """The sentences of a command that met the end of a disk."""
    assert result.returncode == 1, (result.returncode, result.stderr)
    for word in ("HDF5", "H5", "Traceback", "Segmentation", "errno", "Errno"):
        assert word not in result.stderr
    failed = [line for line in result.stderr.splitlines() if line.startswith("failed: ")]
    assert (
        failed
        and all(told in line or "NetCDF" not in line for line in failed)
        and any(told in line for line in failed)
    )
    return failed


@pytest.mark.skipif(shutil.which("sh") is None, reason="limits the size of files by a shell")
def test_a_file_that_does_not_fit_costs_itself_alone(tmp_path):
    result = shell(
        'ulimit -f 100; exec "$@"', tmp_path, *JOB
    )  # of 512 or 1024 bytes, as the shell has it
    failed = checked(result, "File too large")
    assert sum(".nc" in line for line in failed) >= 1
    answer = json.loads((tmp_path / "out" / "run.json").read_text())
    assert (
        not answer["completed"]
        and len(answer["runs"]) == 4
        and all(run["quantities"] for run in answer["runs"])
    )
    assert (tmp_path / "out" / "quantities.csv").stat().st_size > 1000 and not list(
        (tmp_path / "out").glob(".*.part")
    )
    assert " 541 N" in result.stdout


def small_disk(folder) -> str:
    """A line of shell that begins the command in a file system of :data:`ROOM` bytes, kept by its
    last process.
    """
    made = f"mount -t tmpfs -o size={ROOM} none '{folder}' && cd '{folder}'"
    return f"{made} && \"$@\"; code=$?; cp -r '{folder}/out' '{folder}.left'; exit $code"


def may_mount() -> bool:
    """Whether this user may have a small file system of its own."""
    tool = shutil.which("unshare")
    return (
        tool is not None
        and not subprocess.run(
            [tool, "-rm", "sh", "-c", "mount -t tmpfs -o size=4096 none /mnt"], capture_output=True
        ).returncode
    )


@pytest.mark.skipif(not may_mount(), reason="needs a file system of its own")
def test_a_disk_that_runs_full_keeps_the_files_that_fit(tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    command = ["unshare", "-rm", "sh", "-c", small_disk(disk), "sh", sys.executable, *MODULE, *JOB]
    result = subprocess.run(
        command,
        capture_output=True,
        text=True,
        cwd=tmp_path,
        timeout=120,
        env=process_environment(),
    )
    checked(result, "No space left on device")
    left = tmp_path / "disk.left"
    kept = sorted(left.glob("*.nc"))
    assert kept and all(load_result(path).status.completed for path in kept)  # whole, each of them
    assert not list(left.rglob("*.part")) and " 541 N" in result.stdout
