"""``python -m benchmarks.against CHECKOUT``: this checkout and another one of the package, turn by
turn in one call, as one table.

Both run under this interpreter with their own sources; kernels of single jobs are warm, commands
are whole processes after a first one
that may compile. The ratio is that of the least CPU times, which other work on the machine disturbs
least.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parents[1]
#: Name -> job of ``benchmarks.own``.
JOBS: dict[str, dict[str, object]] = {
    "T, 12 elements per coil": {"job": "T", "per_coil": 12, "damping": "stiffness", "repeats": 9},
    "T, 26 elements per coil": {"job": "T", "per_coil": 26, "damping": "stiffness", "repeats": 7},
    "C, 24 elements per coil": {"job": "C", "per_coil": 24, "damping": "stiffness", "repeats": 7},
    "S, static curve": {"job": "S", "per_coil": 24, "repeats": 11},
    "M, six frequencies": {"job": "M", "per_coil": 24, "repeats": 15},
    "C by the chain": {"job": "chain", "repeats": 15},
    "B, 16 variants": {"job": "B", "per_coil": 12, "variants": 16, "workers": 1},
}
#: Above 8000 rpm it floats into coil bind by its card, and the sweep ends with an error.
PUSHROD = str(HERE / "benchmarks" / "pushrod.toml")
#: Name -> arguments of the command line.
COMMANDS: dict[str, tuple[str, ...]] = {
    "run gu2021-beehive (main job), page included": ("run", "gu2021-beehive", "--workers", "1"),
    "run vaz-ohc, page included": ("run", "vaz-ohc", "--workers", "1"),
    "W, sweep of tdi-pushrod at 200 speeds, no critical speeds": (
        "sweep", "tdi-pushrod", "--rpm", "1000:4980:20 rpm", "--spring-set", "stock", "--workers", "1", "--no-report",
        "--no-critical-speeds",
    ),
    "sweep of pushrod by card, with critical speeds": (
        "sweep", PUSHROD, "--rpm", "3000:8000:500 rpm", "--workers", "1", "--no-report",
    ),
    "sweep of pushrod by wire, with critical speeds": (
        "sweep", PUSHROD, "--rpm", "3000:8000:500 rpm", "--spring-set", "wire", "--workers", "1", "--no-report",
    ),
    "check tdi-pushrod": ("check", "tdi-pushrod"),
    "cold compilation, tdi-pushrod": ("run", "tdi-pushrod", "--rpm", "1000 rpm", "--workers", "1", "--no-report"),
}  # fmt: skip
#: Options that older versions do not know -> their word for it; an empty one leaves the option out.
OLDER = {"--rpm": "--engine-speed", "--no-critical-speeds": ""}


def cpu_of(checkout: Path, arguments: list[str], cache: str = "") -> tuple[float, str]:
    """CPU time (s) of one process with that checkout's sources, and what it printed; ``cache``: a folder for its
    compiled kernels.
    """
    inherited = {
        name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"
    }  # users' installations keep it
    environment = {
        **inherited,
        "PYTHONPATH": str(checkout / "src"),
        **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"),
        **({"NUMBA_CACHE_DIR": cache} if cache else {}),
    }
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [sys.executable, *arguments], cwd=checkout, env=environment, capture_output=True, text=True
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise SystemExit(f"{checkout}: {' '.join(arguments)} failed: {done.stderr.strip()[-400:]}")
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done.stdout


def once(checkout: Path, name: str) -> float:
    """CPU time (s) of one measurement of one row."""
    if name in JOBS:
        _, printed = cpu_of(checkout, ["-m", "benchmarks.own", json.dumps(JOBS[name])])
        line = next(line for line in printed.splitlines() if line.startswith("RESULT"))
        return float(json.loads(line.removeprefix("RESULT"))["cpu"])
    words = known_words(checkout, COMMANDS[name])
    with tempfile.TemporaryDirectory() as folder:
        if words[0] != "check":
            words += ["--output", str(Path(folder) / "result")]
        cache = str(Path(folder) / "kernels") if name.startswith("cold") else ""
        return cpu_of(checkout, ["-m", "valvetrain", *words], cache)[0]


def known_words(checkout: Path, words: tuple[str, ...]) -> list[str]:
    """The words of a command as a checkout knows them."""
    answer = subprocess.run(
        [sys.executable, "-m", "valvetrain", words[0], "--help"],
        env={**os.environ, "PYTHONPATH": str(checkout / "src"), "COLUMNS": "200"},
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    chosen = (OLDER.get(word, word) if word not in answer else word for word in words)
    return [word for word in chosen if word]


def main() -> None:
    """Print the table as Markdown, row by row."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.against", description=__doc__.splitlines()[0]
    )
    parser.add_argument(
        "checkout", type=Path, help="folder of the other version, with src and benchmarks"
    )
    parser.add_argument("--rounds", type=int, default=3, help="measurements of each side")
    parser.add_argument("--only", default="", help="rows whose name holds this")
    wanted = parser.parse_args()
    other = wanted.checkout.resolve()
    print("| job | before, CPU s | after, CPU s | ratio |\n| --- | --- | --- | --- |", flush=True)
    for name in filter(lambda name: wanted.only in name, (*JOBS, *COMMANDS)):
        sides: dict[Path, list[float]] = {other: [], HERE: []}
        for turn in range(wanted.rounds + 1):
            for side in (other, HERE) if turn % 2 else (HERE, other):
                sides[side].append(once(side, name))
        before, after = (
            min(times[1:]) for times in (sides[other], sides[HERE])
        )  # the first may compile
        print(f"| {name} | {before:.4g} | {after:.4g} | {after / before:.2f} |", flush=True)


if __name__ == "__main__":
    main()
