"""The trail of every test file, made anew where the file is new or changed: which test enters which
function.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from mutants.copies import PLACE
from mutants.digests import of_trail, of_tree
from mutants.stamp import STAMP

#: Tests of the code's form, not of what it does, do not count as noticing a fault.
NOT_COUNTED = ("tests/architecture/",)
THREADS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")


def environment(copy: Path) -> dict[str, str]:
    """Environment in which a copy's own package is imported, in the processes that its tests start
    too.
    """
    places = (copy / "src", copy / "mutants" / "child", copy)
    return (
        os.environ
        | THREADS
        | {"PYTHONPATH": os.pathsep.join(map(str, places)), STAMP: "source without a fault"}
    )


def test_files(copy: Path) -> list[str]:
    """Test files that count, those of single parts first."""
    order = ("unit", "contracts", "property", "limits", "published", "golden", "examples", "order")
    found = [str(path.relative_to(copy)) for path in (copy / "tests").rglob("test_*.py")]
    counted = [
        name for name in found if not name.startswith(NOT_COUNTED) and "example_package" not in name
    ]
    return sorted(
        counted,
        key=lambda name: (
            order.index(name.split("/")[1]) if name.split("/")[1] in order else 9,
            name,
        ),
    )


def trails(copy: Path, anew: bool = True, workers: int = 1) -> dict[str, dict[str, Any]]:
    """Test file -> its trail, from the copy; kept ones serve until the test, its helpers or a
    function that it entered has changed.

    Only with ``anew`` is one run again; without, what is kept serves as it is, which can leave
    tests unasked but shows nothing false.
    Tests that fail without a fault are named and not asked.
    """
    (PLACE / "trails").mkdir(parents=True, exist_ok=True)
    wanted = {
        name: PLACE / "trails" / f"{name.replace('/', '-').removesuffix('.py')}.json"
        for name in test_files(copy)
    }
    found = {name: json.loads(kept.read_text()) for name, kept in wanted.items() if kept.exists()}
    if anew:
        serves = {
            name
            for name, trail in found.items()
            if not trail["failed"] and trail["of"] == of_trail(name, trail)
        }
        old = [name for name in wanted if name not in serves]
        with ThreadPoolExecutor(workers) as pool:
            fresh = dict(
                zip(old, pool.map(lambda name: _record(copy, name, wanted[name]), old), strict=True)
            )
        found = {name: trail for name, trail in (found | fresh).items() if trail}
    for trail in found.values():
        for node in trail["failed"]:
            print(f"{node} fails without a fault, and is not asked", flush=True)
            trail["tests"].pop(node, None)
    return found


def _record(copy: Path, name: str, kept: Path, limit: float = 1200.0) -> dict[str, Any]:
    """Runs one test file for its trail, says how it went and keeps it; nothing where it came to no
    end.
    """
    begun = time.time()
    kept.unlink(missing_ok=True)
    raw = kept.with_suffix(".raw")
    more = {
        "VALVETRAIN_TRAIL": str(raw),
        "VALVETRAIN_TRAIL_SOURCE": str(copy / "src" / "valvetrain"),
    }
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:cacheprovider",
        "-p",
        "mutants.trail",
        name,
    ]
    try:
        ran = subprocess.run(
            command,
            cwd=copy,
            env=environment(copy) | more,
            capture_output=True,
            text=True,
            timeout=limit,
        )
    except subprocess.TimeoutExpired:
        print(f"{name}: no trail after {limit:.0f} s", flush=True)
        return {}
    print(
        f"{name}: {time.time() - begun:.0f} s, {ran.stdout.strip().splitlines()[-1:]}", flush=True
    )
    if ran.returncode not in (0, 5):
        print(ran.stdout[-2000:], flush=True)
    if not raw.exists():
        return {}
    trail: dict[str, Any] = json.loads(raw.read_text())
    raw.unlink()
    whole(kept, json.dumps(trail | {"of": of_trail(name, trail)}))
    return trail


def whole(place: Path, content: str) -> None:
    """Writes a file whole or not at all."""
    fresh = place.with_suffix(".new")
    fresh.write_text(content, encoding="utf-8")
    fresh.replace(place)


def golden_tests_pass(copy: Path) -> bool:
    """Whether all golden tests pass on the copy without a fault; asked once for a tree.

    A golden file that is out of date fails with every fault as without, and each would stand as
    noticed.
    """
    passed = PLACE / "golden-passed"
    if passed.exists() and passed.read_text() == of_tree():
        return True
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-x",
        "--tb=short",
        "-p",
        "no:cacheprovider",
        "tests/golden",
    ]
    ran = subprocess.run(command, cwd=copy, env=environment(copy), capture_output=True, text=True)
    if ran.returncode:
        print(ran.stdout[-3000:], flush=True)
        return False
    passed.write_text(of_tree())
    return True
