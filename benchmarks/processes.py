"""Runs a job in a process of its own, of this package or of a peer, and reads the RESULT line."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

PEERS = Path(__file__).parent / "peers"
#: Module that a peer's interpreter must be able to import.
MODULES = {"exudyn": "exudyn", "pyelastica": "elastica", "mujoco": "mujoco"}
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}


def own(options: dict[str, Any]) -> dict[str, Any]:
    """Result of one job of this package."""
    return _result([sys.executable, "-m", "benchmarks.own", json.dumps(options)])


def peer(
    name: str, interpreter: str, options: dict[str, Any], limit: float = 300.0
) -> dict[str, Any] | str:
    """Result of a peer's job, or the reason why there is none."""
    try:
        return _result(
            [interpreter, "-W", "ignore", str(PEERS / f"{name}_peer.py"), json.dumps(options)],
            limit,
        )
    except subprocess.TimeoutExpired:
        return f"not done within {limit:.0f} s"
    except RuntimeError as error:
        return str(error)


def present(name: str, interpreter: str) -> bool:
    """Whether a peer can be imported by ``interpreter``."""
    if not interpreter:
        return False
    try:
        return (
            subprocess.run(
                [interpreter, "-c", f"import {MODULES[name]}"], capture_output=True, check=False
            ).returncode
            == 0
        )
    except OSError:
        return False


def _result(command: list[str], limit: float | None = None) -> dict[str, Any]:
    run = subprocess.run(
        command,
        env={**os.environ, **ONE_THREAD},
        capture_output=True,
        text=True,
        check=False,
        timeout=limit,
    )
    lines = [line for line in run.stdout.splitlines() if line.startswith("RESULT ")]
    if not lines:
        raise RuntimeError((run.stderr.strip().splitlines() or ["no result"])[-1][:160])
    return json.loads(lines[-1][7:])
