"""What tests of faults share: processes found by a mark in their environment, functions that kill
their worker, a stand-in solver.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from unit.cli_parts import MODULE, hear_interrupts, process_environment, wait_until

MARK = "VALVETRAIN_FAULT_TEST"
#: A sweep of trains over two workers, many speeds of some 50 ms each.
SWEEP = (
    "sweep",
    "tdi-pushrod",
    "--rpm",
    "1000:5000:25 rpm",
    "--model",
    "massless",
    "--spring-set",
    "stock",
    "--no-critical-speeds",
    "--no-report",
    "--quiet",
    "--workers",
    "2",
    "--output",
    "out",
)


def marked(mark: str) -> list[int]:
    """Ids of the living processes that were started with this mark, their children included."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if (
                f"{MARK}={mark}".encode() in (folder / "environ").read_bytes()
                and (folder / "stat").read_text().rpartition(")")[2].split()[0] != "Z"
            ):
                found.append(int(folder.name))
        except OSError:
            continue
    return found


@contextmanager
def started(
    *arguments: str, folder: Path, code: str = "", **environment: str
) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """The command (or ``code``) as a process of its own group, and the mark of all that it starts;
    nothing of it is left afterwards.
    """
    mark = uuid.uuid4().hex
    command = [sys.executable, *(["-c", code] if code else MODULE), *arguments]
    pipes: dict[str, Any] = {
        "stdout": subprocess.PIPE,
        "stderr": subprocess.PIPE,
        "text": True,
        "preexec_fn": hear_interrupts,
    }
    with subprocess.Popen(
        command,
        cwd=folder,
        env=process_environment(**{MARK: mark, **environment}),
        start_new_session=True,
        **pipes,
    ) as run:
        try:
            yield run, mark
        finally:
            for process_id in marked(mark):
                os.kill(process_id, signal.SIGKILL)


def gone(mark: str, limit: float = 30.0) -> None:
    """Wait until no process with this mark is left; fails after ``limit`` seconds."""
    wait_until(lambda: not marked(mark), f"processes {marked(mark)} end", limit)


def lives(process_id: int) -> bool:
    """Whether a process is there."""
    try:
        os.kill(process_id, 0)
    except ProcessLookupError:
        return False
    return True


def square(shared: Path, point: int) -> int:
    """The square of a point."""
    return point * point


def killed_once(shared: Path, point: int) -> int:
    """The square; the worker that comes to 3 first is killed, as by a machine out of memory."""
    if point == 3:
        try:
            (shared / "killed").touch(exist_ok=False)
        except FileExistsError:
            return 9
        os.kill(os.getpid(), signal.SIGKILL)
    return point * point


def killed_always(shared: Path, point: int) -> int:
    """The square; whatever worker comes to 3 is killed."""
    if point == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return point * point


def slow(shared: Path, point: int) -> int:
    """Leaves a note and takes a minute."""
    (shared / f"begun-{point}").touch()
    time.sleep(60)
    return point
