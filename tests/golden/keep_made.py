"""Writes ``made/``: runs tests several times with ``made_watch.py`` listening, and keeps what they
made every time alike.

``python tests/golden/keep_made.py`` for all tests, or with files of tests for these alone. The runs
lie in folders of different names, the
last of them with arrays and linear algebra for another processor, since numbers that depend on the
processor are of no use to others.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))

from made_watch import FOLDER, KEPT, MOST, alike, versions

ROOT = Path(__file__).parents[2]
#: How each run differs from the others: the length of the names of its folders, and the processor
#: that is worked for.
RUNS: tuple[dict[str, str], ...] = (
    {}, {"TMPDIR": "a-longer-name"},
    {"OPENBLAS_CORETYPE": "Haswell", "NPY_DISABLE_CPU_FEATURES": "AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL AVX512_SPR"},
)  # fmt: skip

Sums = list[list[float]]


def one_run(files: list[str], changes: dict[str, str], home: Path) -> dict[str, dict[str, Sums]]:
    """``file|name`` -> digest -> sums of all that one run makes."""
    home.mkdir()
    folder = home / changes.get("TMPDIR", "t")
    folder.mkdir()
    threads = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "NUMBA")}
    environment = {**os.environ, **threads, **changes, "TMPDIR": str(folder), FOLDER: str(home)}
    words = [
        sys.executable,
        "-m",
        "pytest",
        "-n",
        "auto",
        "--dist",
        "loadfile",
        "--no-loadscope-reorder",
        "-q",
        *files,
    ]
    code = subprocess.run(words, cwd=ROOT, env=environment).returncode
    if code not in (0, 5):
        raise SystemExit("tests failed: mend them first, nothing was written")
    found: dict[str, dict[str, Sums]] = defaultdict(dict)
    for path in home.glob("*.json"):
        for key, things in json.loads(path.read_text()).items():
            for digest, sums in things.items():
                found[key].setdefault(digest, []).extend(sums)
    return found


def joined(runs: list[dict[str, dict[str, Sums]]]) -> dict[str, dict[str, Any]]:
    """File of tests -> what is kept of it: ``made``, names that are ``unsure``, and things of which
    the ``words_alone`` are sure.
    """
    kept: dict[str, dict[str, Any]] = defaultdict(
        lambda: {"unsure": [], "words_alone": [], "made": {}}
    )
    for key in sorted({key for run in runs for key in run}):
        file, _, name = key.partition("|")
        each = [run.get(key, {}) for run in runs]
        if any(one.keys() != each[0].keys() for one in each):
            kept[file]["unsure"].append(name)
            continue
        things = kept[file]["made"].setdefault(name, {})
        for digest in sorted(each[0]):
            firm = len(each[0][digest]) < MOST and all(
                any(alike(sums, other) for other in run[digest])
                for run in each
                for one in each
                for sums in one[digest]
            )
            if not firm:
                kept[file]["words_alone"].append(f"{name}|{digest}")
            things[digest] = each[0][digest] if firm else []
    return kept


def write(file: str, one: dict[str, Any]) -> None:
    """One file of tests, a line per name, so that a difference can be read."""
    folder, _, stem = file.removeprefix("tests/").removesuffix(".py").rpartition("/")
    path = KEPT / folder / f"{stem}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [
        f"  {json.dumps(name)}: {json.dumps(things, separators=(',', ':'))}"
        for name, things in one["made"].items()
    ]
    head = f' "unsure": {json.dumps(one["unsure"])},\n "words_alone": {json.dumps(one["words_alone"])},\n'
    path.write_text(
        "{\n" + head + ' "made": {\n' + ",\n".join(lines) + "\n }\n}\n", encoding="utf-8"
    )


def main() -> None:
    files = sys.argv[1:]
    with tempfile.TemporaryDirectory() as home:
        found = joined(
            [
                one_run(files, changes, Path(home) / str(number))
                for number, changes in enumerate(RUNS)
            ]
        )
    if not files:
        for path in KEPT.glob("*/*.json"):
            path.unlink()
    for file, one in found.items():
        write(file, one)
    (KEPT / "versions.json").write_text(json.dumps(versions()) + "\n")


if __name__ == "__main__":
    main()
