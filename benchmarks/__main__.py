"""``python -m benchmarks``: this package and the peers that are installed, side by side, as one
table, printed and saved.

Peers are no dependency: name an interpreter that holds them with ``--peers PYTHON`` or the variable
VALVETRAIN_PEERS.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from pathlib import Path

from benchmarks import main_job, spring_jobs, start_up, train_jobs
from benchmarks.rows import HEAD, Row, cells, machine, save


def main() -> None:
    """Measure the wanted parts."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks", description=__doc__.splitlines()[0]
    )
    parser.add_argument(
        "parts", nargs="*", help="start, main, springs, trains; all of them by default"
    )
    parser.add_argument(
        "--peers",
        default=os.environ.get("VALVETRAIN_PEERS", ""),
        help="Python interpreter that holds the peers",
    )
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("build/benchmarks"),
        help="folder for speed.json and speed.md",
    )
    wanted = parser.parse_args()
    parts: dict[str, Callable[[], list[Row]]] = {
        "start": start_up.measure, "main": main_job.measure, "springs": lambda: spring_jobs.measure(wanted.peers),
        "trains": train_jobs.measure,
    }  # fmt: skip
    unknown = [name for name in wanted.parts if name not in parts]
    if unknown:
        parser.error(f"no part is named {unknown[0]}; there are {', '.join(parts)}")
    rows: list[Row] = []
    print(machine(), flush=True)
    print("  ".join(HEAD), flush=True)
    for name in wanted.parts or parts:
        for row in parts[name]():
            rows.append(row)
            print("  ".join(cell or "-" for cell in cells(row)), flush=True)
    save(rows, wanted.output)
    print(f"saved in {wanted.output}")


if __name__ == "__main__":
    main()
