"""Asks the package about mutants of case files, runs of mutants and damaged result files; prints
what ends in anything but an answer.

Use: python -m fuzz 1000                       1000 mutants of cases, 20 that run, 100 damaged
result files
     python -m fuzz --cases 100000 --runs 2000 --files 10000 --workers 2
     python -m fuzz --only cases-1-4711        one input again, with its traceback
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from queue import Empty, Queue
from typing import Any

from fuzz.questions import KINDS
from fuzz.worker import SECONDS, ask, generator, write

PLACE = Path(__file__).resolve().parents[1] / "build" / "fuzz"
#: Inputs that one process is asked in a row.
CHUNK = {"cases": 500, "runs": 10, "files": 250}
#: A process that used this much processor time (s), or waited this long (s), at one input, its
#: start included, is stopped from outside.
STUCK, ASLEEP = SECONDS + 40, 900.0


def processor_time(number: int) -> float:
    """Processor time (s) that the process of that number has used; 0 where it is gone."""
    try:
        fields = Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Told:
    """What the workers say, gathered."""

    def __init__(self) -> None:
        self.answers: Counter[str] = Counter()
        self.findings: list[tuple[str, str]] = []
        self.slowest, self.memory = (0.0, ""), 0
        self.lock = threading.Lock()

    def read(self, kind: str, seed: int, lines: Iterable[str]) -> None:
        """Takes the lines of a worker until it ends."""
        for said in map(json.loads, lines):
            self._take(kind, seed, said)

    def _take(self, kind: str, seed: int, said: dict[str, Any]) -> None:
        with self.lock:
            if "answer" in said:
                self.finding(f"{kind}-{seed}-{said['number']}", said["answer"])
            else:
                self.answers.update(
                    {f"{kind} {word}": count for word, count in said["answers"].items()}
                )
                seconds, number = said["slowest"]
                self.slowest = max(self.slowest, (seconds, f"{kind}-{seed}-{number}"))
                self.memory = max(self.memory, said["memory"])

    def finding(self, name: str, words: str) -> None:
        """One finding, printed as it comes."""
        self.findings.append((name, words))
        print(f"{name} {words}", flush=True)


def ask_range(kind: str, seed: int, first: int, last: int, told: Told) -> None:
    """Ask a range of inputs in processes of their own; one that dies or is stuck is a finding, and
    the rest of the range goes on.
    """
    while first < last:
        with tempfile.NamedTemporaryFile() as mark:
            command = [
                sys.executable,
                "-m",
                "fuzz.worker",
                kind,
                str(seed),
                str(first),
                str(last),
                str(PLACE),
                mark.name,
            ]
            process = subprocess.Popen(
                command, stdout=subprocess.PIPE, text=True, cwd=PLACE.parents[1], env=os.environ
            )
            assert process.stdout
            reader = threading.Thread(target=told.read, args=(kind, seed, process.stdout))
            reader.start()
            seen, since, used = b"", time.monotonic(), 0.0
            while process.poll() is None:
                time.sleep(0.2)
                now = Path(mark.name).read_bytes()
                if now != seen:
                    seen, since, used = now, time.monotonic(), processor_time(process.pid)
                elif (
                    processor_time(process.pid) - used > STUCK or time.monotonic() - since > ASLEEP
                ):
                    process.kill()
            reader.join()
            if process.returncode == 0:
                return
            if not seen:
                told.finding(
                    f"{kind}-{seed}-{first}",
                    "finding: no process could be started for it; see python -m fuzz --only",
                )
                return
            at = int(seen)
            told.finding(
                f"{kind}-{seed}-{at}", f"finding: the process ended with {process.returncode}"
            )
            write(
                PLACE,
                kind,
                seed,
                at,
                KINDS[kind][0](generator(kind, seed, at)),
                f"the process ended with {process.returncode}",
            )
            told.answers.update({f"{kind} asked before a process ended": at - first + 1})
            first = at + 1


def main() -> int:
    """The run as the command line asks for it; 1 where something was found."""
    parser = argparse.ArgumentParser(
        prog="python -m fuzz",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "amount",
        type=int,
        nargs="?",
        default=1000,
        help="mutants of cases; a 50th of them run, a tenth damaged files",
    )
    for kind, words in (
        ("cases", "mutants of cases"),
        ("runs", "mutants that run"),
        ("files", "damaged result files"),
    ):
        parser.add_argument(f"--{kind}", type=int, default=None, help=f"number of {words}")
    parser.add_argument("--seed", type=int, default=1, help="seed of all inputs")
    parser.add_argument("--first", type=int, default=0, help="number of the first input")
    parser.add_argument("--workers", type=int, default=1, help="processes at one time")
    parser.add_argument("--minutes", type=float, default=1e6, help="begin nothing after this time")
    parser.add_argument("--only", default="", help="name of one input, KIND-SEED-NUMBER")
    given = parser.parse_args()
    if given.only:
        kind, seed, number = given.only.split("-")
        written = PLACE / f"{given.only}.txt"
        written.unlink(missing_ok=True)  # of an earlier time
        print(ask(kind, int(seed), int(number), PLACE))
        print(written.read_text("utf-8") if written.exists() else "nothing was found")
        return 0
    named = (given.cases, given.runs, given.files)
    usual = (
        (given.amount, given.amount // 50, given.amount // 10)
        if named == (None, None, None)
        else (0, 0, 0)
    )
    amounts = {
        kind: one if one is not None else own
        for kind, one, own in zip(CHUNK, named, usual, strict=True)
    }
    tasks, told, begun = Queue[tuple[str, int, int]](), Told(), time.monotonic()
    for kind, amount in amounts.items():
        for first in range(given.first, given.first + amount, CHUNK[kind]):
            tasks.put((kind, first, min(first + CHUNK[kind], given.first + amount)))

    def work() -> None:
        while time.monotonic() - begun < 60 * given.minutes:
            try:
                kind, first, last = tasks.get_nowait()
            except Empty:
                return
            ask_range(kind, given.seed, first, last, told)

    threads = [threading.Thread(target=work) for _ in range(given.workers)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    seconds = time.monotonic() - begun
    for word, count in sorted(told.answers.items()):
        print(f"{count:8d}  {word}")
    for words, count in Counter(
        words.split("'")[0][9:].strip() for _, words in told.findings
    ).most_common():
        print(f"{count:8d}  found: {words}")
    total = sum(told.answers.values())
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(
        f"{total} inputs in {seconds:.0f} s, {used.ru_utime + used.ru_stime:.0f} s of processor time; slowest {told.slowest[0]:.1f} s "
        f"({told.slowest[1]}), largest process {told.memory / 1e6:.0f} MB; reproducing files in {PLACE}"
    )
    return 1 if told.findings else 0


if __name__ == "__main__":
    sys.exit(main())
