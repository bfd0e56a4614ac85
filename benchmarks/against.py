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
#: Name -> arguments of the command line.
COMMANDS: dict[str, tuple[str, ...]] = {
    "run gu2021-beehive-blind, report included": ("run", "gu2021-beehive-blind", "--workers", "1"),
    "run vaz-ohc, report included": ("run", "vaz-ohc", "--workers", "1"),
    "sweep tdi-pushrod, 31 speeds": (
        "sweep", "tdi-pushrod", "--rpm", "1000:4000:100 rpm", "--workers", "1", "--no-report",
    ),
    "the same without the search of critical speeds": (
        "sweep", "tdi-pushrod", "--rpm", "1000:4000:100 rpm", "--workers", "1", "--no-report", "--no-critical-speeds",
    ),
}  # fmt: skip
#: Options that leave out work which older versions never did, and so do not know.
NEWER = ("--no-critical-speeds",)


def cpu_of(checkout: Path, arguments: list[str]) -> tuple[float, str]:
    """CPU time (s) of one process with that checkout's sources, and what it printed."""
    inherited = {
        name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"
    }  # users' installations keep it
    environment = {
        **inherited,
        "PYTHONPATH": str(checkout / "src"),
        **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"),
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
    with tempfile.TemporaryDirectory() as folder:
        start = "from valvetrain.cli.main import main; main()"
        return cpu_of(
            checkout,
            [
                "-c",
                start,
                *known_words(checkout, COMMANDS[name]),
                "--output",
                str(Path(folder) / "result"),
            ],
        )[0]


def known_words(checkout: Path, words: tuple[str, ...]) -> list[str]:
    """The words of a command that a checkout knows."""
    source = "".join(
        path.read_text(encoding="utf-8")
        for path in (checkout / "src" / "valvetrain" / "cli").glob("*.py")
    )
    return [
        word for word in words if word not in NEWER or f"/{word}" in source or f'"{word}"' in source
    ]


def main() -> None:
    """Print the table as Markdown, row by row."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.against", description=__doc__.splitlines()[0]
    )
    parser.add_argument(
        "checkout", type=Path, help="folder of the other version, with src and benchmarks"
    )
    parser.add_argument("--rounds", type=int, default=3, help="measurements of each side")
    wanted = parser.parse_args()
    other = wanted.checkout.resolve()
    print("| job | before, CPU s | after, CPU s | change |\n| --- | --- | --- | --- |", flush=True)
    for name in (*JOBS, *COMMANDS):
        sides: dict[Path, list[float]] = {other: [], HERE: []}
        for turn in range(wanted.rounds + 1):
            for side in (other, HERE) if turn % 2 else (HERE, other):
                sides[side].append(once(side, name))
        before, after = (
            min(times[1:]) for times in (sides[other], sides[HERE])
        )  # the first may compile
        print(f"| {name} | {before:.4g} | {after:.4g} | {after / before - 1:+.1%} |", flush=True)


if __name__ == "__main__":
    main()
