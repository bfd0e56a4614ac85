"""Runs CalculiX on a deck in a temporary folder, within a time limit, and hands back what it wrote."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from valvetrain.errors import InputError, MissingExtraError
from valvetrain.solution.status import COMPLETED, Status

#: Names under which distributions install the solver.
SOLVER_NAMES = ("ccx", "ccx_2.20", "ccx_2.21", "ccx_2.22")
INSTALL_HINT = (
    "the comparison with CalculiX needs its solver 'ccx', which is not on the PATH: install it with 'sudo apt install calculix-ccx' "
    "(Debian, Ubuntu) or 'conda install -c conda-forge calculix', or name its file in the environment variable CCX"
)
REMEDY = "take smaller increments or softer contact"


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
    deck: str, *, time_limit: float = 300.0, threads: int = 1, read_fields: bool = False
) -> SolverOutput:
    """Run ``deck`` and return what was written; a failed run is a status, with the solver's own
    reason.

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
    with tempfile.TemporaryDirectory(prefix="valvetrain-solid-") as folder:
        Path(folder, "job.inp").write_text(deck, encoding="ascii")
        started = time.perf_counter()
        status = _execute(solver, folder, environment, time_limit)
        elapsed = time.perf_counter() - started
        fields = _text(folder, "job.frd") if read_fields else ""
        return SolverOutput(_text(folder, "job.dat"), fields, status, elapsed)


def _execute(solver: str, folder: str, environment: dict[str, str], time_limit: float) -> Status:
    """Run to the end or the limit."""
    with Path(folder, "job.log").open("wb") as log:
        try:
            code = subprocess.run(
                [solver, "job"], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                stdout=log, stderr=subprocess.STDOUT, timeout=time_limit, check=False,
            ).returncode  # fmt: skip
        except subprocess.TimeoutExpired:
            why = f"CalculiX was stopped after {time_limit:g} s"
            return Status("interrupted", why, remedy="raise the time limit or coarsen the mesh")
    output = _text(folder, "job.log")
    if code == 0 and "Job finished" in output:
        return COMPLETED
    reason = _reason(output) or f"it gave no reason and ended with code {code}"
    return Status("not-converged", f"CalculiX gave up: {reason}", remedy=REMEDY)


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
