"""Runs the measurements: ``python -m benchmarks [part of a name ...]``.

Each ``bench_*.py`` has a function ``measure() -> Mapping[str, float]``: what was measured -> seconds.
"""

from __future__ import annotations

import importlib
import os
import platform
import sys
from pathlib import Path


def main(wanted: list[str]) -> int:
    """Print one line per measurement; the exit code is 1 when nothing bears a wanted name."""
    names = sorted(path.stem for path in Path(__file__).parent.glob("bench_*.py"))
    chosen = [name for name in names if not wanted or any(part in name for part in wanted)]
    if not chosen:
        print(f"no measurement is named like {' or '.join(wanted)}; there are {', '.join(names)}", file=sys.stderr)
        return 1
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}")
    for name in chosen:
        for what, seconds in importlib.import_module(f"benchmarks.{name}").measure().items():
            print(f"{what:<60} {seconds:10.4f} s", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
