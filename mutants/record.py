"""The trail of every test file, made anew where the file is new or changed: which test enters which
function.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from mutants.copies import PLACE, tree_digest

#: Tests of the code's form, not of what it does, do not count as noticing a fault.
NOT_COUNTED = ("tests/architecture/",)
THREADS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")


def environment(copy: Path) -> dict[str, str]:
    """Environment in which a copy's own package is imported, in the processes that its tests start
    too.
    """
    return os.environ | THREADS | {"PYTHONPATH": f"{copy / 'src'}{os.pathsep}{copy}"}


def test_files(copy: Path) -> list[str]:
    """Test files that count, those of single parts first."""
    order = ("unit", "contracts", "property", "limits", "published", "net", "examples", "order")
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
    """Test file -> its trail, from the copy; stored ones serve while no source and no test has
    changed.

    Only with ``anew`` is one run again; without, what is stored serves as it is, which can leave
    tests out but shows nothing false.
    Tests that fail without a fault are named and not run.
    """
    (PLACE / "trails").mkdir(parents=True, exist_ok=True)
    stored = {
        name: PLACE / "trails" / f"{name.replace('/', '-').removesuffix('.py')}.json"
        for name in test_files(copy)
    }
    found = {name: json.loads(path.read_text()) for name, path in stored.items() if path.exists()}
    if anew:
        old = [name for name in stored if name not in found or found[name]["tree"] != tree_digest()]
        with ThreadPoolExecutor(workers) as pool:
            fresh = dict(
                zip(old, pool.map(lambda name: _record(copy, name, stored[name]), old), strict=True)
            )
        found = {name: trail for name, trail in (found | fresh).items() if trail}
    for trail in found.values():
        for node in trail["failed"]:
            print(f"{node} fails without a fault, and is not run", flush=True)
            trail["tests"].pop(node, None)
    return found


def baseline(copy: Path, files: list[str], options: list[str]) -> dict[str, float]:
    """Test -> seconds of some test files on the source without a fault, its kernels compiled; tests
    that fail are named and left out.
    """
    record = copy / "build" / "baseline.xml"
    command = [
        sys.executable,
        "-m",
        "pytest",
        *options,
        "-o",
        "junit_family=xunit1",
        f"--junitxml={record}",
    ]
    subprocess.run(command, cwd=copy, env=environment(copy), capture_output=True)
    found: dict[str, float] = {}
    for case in ElementTree.parse(record).iter("testcase"):
        node = f"{case.get('file')}::{case.get('name')}"
        if case.findall("failure") or case.findall("error"):
            print(f"{node} fails without a fault, and is not run", flush=True)
        elif not case.findall("skipped"):
            found[node] = float(case.get("time", 0.0))
    return {
        node: seconds
        for file in files
        for node, seconds in sorted(found.items(), key=lambda item: item[1])
        if node.startswith(file)
    }


def _record(copy: Path, name: str, kept: Path, limit: float = 1200.0) -> dict[str, Any]:
    """Runs one test file for its trail, says how it went and keeps it; nothing where it came to no
    end.
    """
    begun = time.time()
    kept.unlink(missing_ok=True)
    raw = kept.with_suffix(".raw")
    more = {"VALVETRAIN_TRAIL": str(raw)}
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
    whole(kept, json.dumps(trail | {"tree": tree_digest()}))
    return trail


def whole(place: Path, content: str) -> None:
    """Writes a file whole or not at all."""
    fresh = place.with_suffix(".new")
    fresh.write_text(content, encoding="utf-8")
    fresh.replace(place)
