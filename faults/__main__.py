"""Repeats faults with the random numbers of a seed and prints one table of what came.

Use: python -m faults --seed 1 --minutes 10
     python -m faults --only cases-1-4711         one fault again; of a damaged file with its traceback

Two processes share the time: one asks about damaged files, the other one sends requests to a
workbench, then kills commands and fills disks.
"""

from __future__ import annotations

import argparse
import multiprocessing
import sys
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from faults import kills, requests
from faults.apart import FILES, asked, asked_apart, chance_of, compile_kernels, elsewhere, warm
from faults.commands import write_inputs
from server_parts import disk, may_mount

LABELS = {
    "requests": "requests to a workbench, and its disk", "kills": "commands killed, then started again",
    "disks": "commands on a full disk", "cases": "damaged cases, read and built",
    "runs": "damaged cases, checked and run", "measurements": "damaged measurements and plans",
    "results": "damaged result files",
}  # fmt: skip
#: Kinds of damaged files, and of kills, in the order in which they come again and again.
DAMAGE = ("cases",) * 5 + ("results",) * 4 + ("measurements",) * 2 + ("runs",)
KILLS = ("kills", "kills", "disks")
#: Share of the time for requests.
SHARE = 0.35
#: Takes the kind, number and name of a fault, and what it broke.
Report = Callable[[tuple[str, int, str, list[str]]], Any]


def damage(seed: int, numbers: Iterable[int], end: float, report: Report) -> None:
    """Damaged files of all kinds in turn."""
    warm()
    compile_kernels()
    for number in numbers:
        if time.monotonic() > end:
            return
        kind = DAMAGE[number % len(DAMAGE)]
        report((kind, number, *asked_apart(kind, seed, number)))


def processes(
    seed: int, numbers: Iterable[int], end: float, report: Report, kinds: Iterable[str] = LABELS
) -> None:
    """Requests to a workbench, then kills and full disks."""
    last = time.monotonic() + SHARE * (end - time.monotonic())
    with tempfile.TemporaryDirectory(prefix="valvetrain-faults-") as name:
        if "requests" in kinds and may_mount():
            with disk(Path(name, "disk"), "64m") as made, requests.bench_on(made) as bench:
                for number in numbers:
                    if time.monotonic() > last:
                        break
                    chance = chance_of("requests", seed, number)
                    report(("requests", number, *bench.trial(chance)))
        some = [one for one in KILLS if one in kinds and (one != "disks" or kills.may_unshare())]
        folder = write_inputs(Path(name, "commands")) if some else Path()
        for number in numbers if some else ():
            if time.monotonic() > end:
                return
            kind = some[number % len(some)]
            report((kind, number, *kills.trial(kind, folder, chance_of(kind, seed, number))))


def once(kind: str, seed: int, number: int) -> None:
    """Repeat one fault and print what came."""
    if kind in FILES:
        with elsewhere():
            print(asked(kind, seed, number))
    else:
        processes(seed, [number], time.monotonic() + 600, lambda row: print(*row), [kind])


def _reported(part: Callable[..., None], told: Any, *given: Any) -> None:
    try:
        part(*given, told.put)
    finally:
        told.put(None)


def main() -> int:
    """The faults of a seed; 1 where a promise was broken."""
    parser = argparse.ArgumentParser(prog="python -m faults", description=(__doc__ or "")[:83])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--most", type=int, default=10**9, help="faults of each process")
    parser.add_argument("--only", default="", metavar="KIND-SEED-NUMBER")
    given = parser.parse_args()
    if given.only:
        kind, seed, number = given.only.split("-")
        once(kind, int(seed), int(number))
        return 0
    context = multiprocessing.get_context("fork")
    told, end = context.SimpleQueue(), time.monotonic() + 60 * given.minutes
    parts = [
        context.Process(target=_reported, args=(part, told, given.seed, range(given.most), end))
        for part in (damage, processes)
    ]
    for part in parts:
        part.start()
    counts, broken, left = defaultdict[str, Counter[str]](Counter), Counter[str](), len(parts)
    while left:
        if (row := told.get()) is None:
            left -= 1
            continue
        kind, number, what, sentences = row
        counts[kind][what] += 1
        broken[kind] += bool(sentences)
        for sentence in sentences:
            print(f"{kind}-{given.seed}-{number} {what}: {sentence}", flush=True)
    for part in parts:
        part.join()
    print("| what is done | times | what came | promises broken |\n|---|---|---|---|")
    for kind, label in LABELS.items():
        words = counts[kind].most_common() if kind in FILES else ()
        came = ", ".join(f"{count} {word}" for word, count in words)
        print(f"| {label} | {counts[kind].total()} | {came} | {broken[kind]} |")
    return int(bool(broken.total() or any(part.exitcode for part in parts)))


if __name__ == "__main__":
    sys.exit(main())
