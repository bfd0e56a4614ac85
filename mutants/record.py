"""The trail of every test file, made anew where the file is new or changed: which test enters which function."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from mutants.copies import PLACE, ROOT
from mutants.stamp import STAMP

#: Tests of the code's form, not of what it does, do not count as noticing a fault.
NOT_COUNTED = ("tests/architecture/",)
THREADS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")


def environment(copy: Path) -> dict[str, str]:
    """Environment in which a copy's own package is imported, in the processes that its tests start too."""
    places = (copy / "src", copy / "mutants" / "child", copy)
    return os.environ | THREADS | {"PYTHONPATH": os.pathsep.join(map(str, places)), STAMP: "source without a fault"}


def test_files(copy: Path) -> list[str]:
    """Test files that count, those of single parts first."""
    order = ("unit", "contracts", "property", "limits", "published", "golden", "examples", "order")
    found = [str(path.relative_to(copy)) for path in (copy / "tests").rglob("test_*.py")]
    counted = [name for name in found if not name.startswith(NOT_COUNTED) and "example_package" not in name]
    return sorted(counted, key=lambda name: (order.index(name.split("/")[1]) if name.split("/")[1] in order else 9, name))


def trails(copy: Path, anew: bool = True, workers: int = 1) -> dict[str, dict[str, Any]]:
    """Test file -> its trail, from the copy; a file is run again only after a change of its text, and only ``anew``."""
    (PLACE / "trails").mkdir(parents=True, exist_ok=True)
    wanted = {name: _place(name) for name in test_files(copy)}
    if anew:
        with ThreadPoolExecutor(workers) as pool:
            list(pool.map(lambda name: _record(copy, name, wanted[name]), [name for name, kept in wanted.items() if not kept.exists()]))
    return {name: json.loads(kept.read_text()) for name, kept in wanted.items() if kept.exists()}


def _place(name: str) -> Path:
    """Where the trail of a test file is kept, by the digest of its text."""
    text = hashlib.sha256((ROOT / name).read_bytes()).hexdigest()[:12]
    return PLACE / "trails" / f"{Path(name).parent.name}-{Path(name).stem}-{text}.json"


def _record(copy: Path, name: str, kept: Path, limit: float = 1200.0) -> None:
    """Runs one test file for its trail, and says how it went."""
    begun = time.time()
    more = {"VALVETRAIN_TRAIL": str(kept), "VALVETRAIN_TRAIL_SOURCE": str(copy / "src" / "valvetrain")}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "mutants.trail", name]
    try:
        ran = subprocess.run(command, cwd=copy, env=environment(copy) | more, capture_output=True, text=True, timeout=limit)
    except subprocess.TimeoutExpired:
        print(f"{name}: no trail after {limit:.0f} s", flush=True)
        return
    print(f"{name}: {time.time() - begun:.0f} s, {ran.stdout.strip().splitlines()[-1:]}", flush=True)
    if ran.returncode not in (0, 5):
        print(ran.stdout[-2000:], flush=True)
