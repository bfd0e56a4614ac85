"""Runs CalculiX on a deck in a temporary folder, within a time limit, and hands back what it wrote."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import IO

from valvetrain.errors import InputError, MissingExtraError
from valvetrain.solution.atomic import is_abandoned, lock
from valvetrain.solution.status import COMPLETED, Status

#: Begin of the names of work folders, and the file in each that its maker keeps locked.
PREFIX, LOCK = "valvetrain-solid-", ".in-use"
GUARDIAN = Path(__file__).with_name("guardian.py")


def start(
    program: Sequence[str], folder: str, environment: dict[str, str], log: IO[bytes]
) -> subprocess.Popen[bytes]:
    """Start ``program`` in ``folder``, its words in ``log``. Where there are forks, a guardian
    is between: it ends with this
    process, and the program with it. Out of the terminal's group, Ctrl-C reaches neither;
    :func:`end` ends both."""
    guard = [sys.executable, "-I", "-S", str(GUARDIAN), folder] if hasattr(os, "fork") else []
    return subprocess.Popen(
        [*guard, *program],
        cwd=folder,
        env=environment,
        stdin=subprocess.PIPE,
        stdout=log,
        stderr=subprocess.STDOUT,
        start_new_session=bool(guard),
    )


def end(process: subprocess.Popen[bytes], patience: float = 10.0) -> None:
    """End what :func:`start` began, if it still runs."""
    assert process.stdin is not None
    with suppress(OSError):
        process.stdin.close()  # signals the guardian
    if hasattr(os, "fork"):
        with suppress(subprocess.TimeoutExpired):
            process.wait(patience)
    if process.poll() is None:
        process.kill()
        process.wait()


@contextmanager
def work_folder() -> Iterator[str]:
    """A temporary folder, removed at the end; those that killed processes left are removed first."""
    _sweep()
    with tempfile.TemporaryDirectory(prefix=PREFIX, ignore_cleanup_errors=True) as folder:
        handle = os.open(Path(folder, LOCK), os.O_WRONLY | os.O_CREAT, 0o600)
        try:
            lock(handle)
            yield folder
        finally:
            os.close(handle)


@cache
def _sweep() -> None:
    """Once per process: remove this user's work folders whose makers are gone."""
    with suppress(OSError):
        for folder in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
            if (
                not folder.is_symlink()
                and (not hasattr(os, "getuid") or folder.lstat().st_uid == os.getuid())
                and is_abandoned(folder / LOCK)
            ):
                shutil.rmtree(folder, ignore_errors=True)


#: Names under which distributions install the solver.
SOLVER_NAMES = ("ccx", "ccx_2.20", "ccx_2.21", "ccx_2.22")
#: What a missing solver means for the user.
INSTALL_HINT = (
    "the solid model needs the CalculiX solver 'ccx', which is not on the PATH: install it with 'sudo apt install calculix-ccx' "
    "(Debian, Ubuntu) or 'conda install -c conda-forge calculix', or name its file in the environment variable CCX"
)
REMEDY = "take smaller increments or softer contact"
#: Called with the solver time that a run has reached.
Watch = Callable[[float], None]
#: Time (s) between two looks at a running solver.
POLL_INTERVAL = 0.2


@dataclass(frozen=True)
class SolverOutput:
    """Texts of the result files (``fields`` only when requested), the end of the run and its wall
    time (s).
    """

    printed: str
    fields: str
    status: Status
    wall_time: float


def find_solver() -> str:
    """Path of ``ccx`` (environment variable CCX, else the PATH); :class:`MissingExtraError` with
    the install command.
    """
    names = [given] if (given := os.environ.get("CCX")) else SOLVER_NAMES
    found = next((path for name in names if (path := shutil.which(name))), None)
    if found is None:
        raise MissingExtraError(INSTALL_HINT)
    return found


def run_deck(
    deck: str,
    *,
    time_limit: float = 300.0,
    threads: int = 1,
    read_fields: bool = False,
    watch: Watch | None = None,
) -> SolverOutput:
    """Run ``deck`` and return what was written; a failed run is a status, with the solver's own
    reason.

    ``watch`` is called with the solver time reached, repeatedly; what it raises stops the solver and
    is raised here.
    Raises :class:`MissingExtraError` without ``ccx`` and :class:`InputError` for a time limit or
    threads below zero.
    """
    if not time_limit > 0 or threads < 1:
        raise InputError(
            f"a time limit of {time_limit:g} s on {threads} threads runs nothing; give a positive limit and at least 1 thread"
        )
    solver = find_solver()
    environment = {
        **os.environ,
        "OMP_NUM_THREADS": str(threads),
        "CCX_NPROC_STIFFNESS": str(threads),
        "CCX_NPROC_RESULTS": str(threads),
    }
    with work_folder() as folder:
        Path(folder, "job.inp").write_text(deck, encoding="ascii")
        started = time.perf_counter()
        status, log = _execute(solver, folder, environment, time_limit, watch)
        elapsed = time.perf_counter() - started
        if status is None:
            status = _judge(log)
        printed = _text(folder, "job.dat")
        return SolverOutput(
            printed, _text(folder, "job.frd") if read_fields else "", status, elapsed
        )


def _execute(
    solver: str, folder: str, environment: dict[str, str], time_limit: float, watch: Watch | None
) -> tuple[Status | None, str]:
    """Run to the end or the limit; a status already known (time ran out, signal) or None, and the
    log.
    """
    with Path(folder, "job.log").open("wb") as log:
        process = start([solver, "job"], folder, environment, log)
        try:
            code = _wait(process, folder, time_limit, watch)
        finally:
            end(process)
    output = _text(folder, "job.log")
    if code is None:
        why = f"CalculiX was stopped after {time_limit:g} s"
        return Status("interrupted", why, remedy="raise the time limit or coarsen the mesh"), output
    if code == 0:
        return None, output
    reason = _reason(output) or f"it gave no reason and ended with code {code}"
    return Status("not-converged", f"CalculiX gave up: {reason}", remedy=REMEDY), output


def _wait(
    process: subprocess.Popen[bytes], folder: str, time_limit: float, watch: Watch | None
) -> int | None:
    """The exit code, or None where the limit (s) is over first."""
    end = time.perf_counter() + time_limit
    while (left := end - time.perf_counter()) > 0:
        try:
            return process.wait(min(left, POLL_INTERVAL))
        except subprocess.TimeoutExpired:
            if watch is not None:
                watch(_time_reached(folder))
    return None


def _time_reached(folder: str) -> float:
    """Total solver time of the last increment that the run has noted as done, 0 before the first."""
    columns = (_text(folder, "job.sta").splitlines() or [""])[-1].split()
    try:
        return float(columns[4])
    except (IndexError, ValueError):
        return 0.0


def _judge(log: str) -> Status:
    if "Job finished" in log:
        return COMPLETED
    return Status(
        "not-converged",
        f"CalculiX ended early: {_reason(log) or 'it gave no reason'}",
        remedy=REMEDY,
    )


def _reason(log: str) -> str:
    """The solver's own words: its first error line with the line that continues it, or the last
    warning of divergence.
    """
    lines = [line.strip() for line in log.splitlines()]
    for number, line in enumerate(lines):
        if line.startswith("*ERROR"):
            follow = lines[number + 1] if number + 1 < len(lines) else ""
            return " ".join(f"{line.removeprefix('*ERROR').lstrip(': ')} {follow}".split())
    errors = [
        line
        for line in lines
        if "divergence" in line or "too many" in line.lower() or "smaller than minimum" in line
    ]
    return errors[-1] if errors else ""


def _text(folder: str, name: str) -> str:
    path = Path(folder, name)
    return path.read_text(encoding="ascii", errors="replace") if path.exists() else ""
