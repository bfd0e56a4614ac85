"""One process of the fuzzer: makes and asks a range of inputs, each under a limit of time and of
memory.

Use: python -m fuzz.worker KIND SEED FIRST LAST PLACE
Before each input its number is written to PLACE/KIND.at, so that a process that dies or hangs names
the input; findings go to PLACE.
"""

from __future__ import annotations

import gc
import json
import os
import random
import resource
import signal
import sys
import time
import traceback
from collections import Counter
from pathlib import Path
from types import FrameType

SECONDS, BYTES = 20.0, 2_000_000_000


class TooLongError(BaseException):
    """The input took longer than :data:`SECONDS`."""


def _alarm(number: int, frame: FrameType | None) -> None:
    raise TooLongError(f"longer than {SECONDS:g} s of processor time")


def generator(kind: str, seed: int, number: int) -> random.Random:
    """The random numbers of one input, the same on every machine."""
    return random.Random(f"{kind} {seed} {number}")


def size_of_process() -> int:
    """Address space of this process in bytes."""
    return int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()


def ask(kind: str, seed: int, number: int, place: Path) -> tuple[str, float]:
    """Make and ask one input; its answer (``finding: ...`` for what is none) and the seconds it
    took.
    """
    from fuzz.questions import KINDS

    make, question = KINDS[kind]
    content = make(generator(kind, seed, number))
    begun = time.perf_counter()
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        answer = question(content)
    except (Exception, TooLongError) as error:
        signal.setitimer(signal.ITIMER_PROF, 0)
        told = "".join(traceback.format_exception(error))
        frames = [
            frame
            for frame in traceback.extract_tb(error.__traceback__)
            if "valvetrain" in frame.filename
        ]
        where = f"{Path(frames[-1].filename).name}:{frames[-1].lineno}" if frames else ""
        answer = f"finding: {type(error).__name__} {where} {str(error)[:100]!r}"
        write(place, kind, seed, number, content, told)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    return answer, time.perf_counter() - begun


def write(place: Path, kind: str, seed: int, number: int, content: bytes, told: str) -> None:
    """Keep an input that reproduces a finding, and what was said of it."""
    name = f"{kind}-{seed}-{number}"
    place.mkdir(parents=True, exist_ok=True)
    (place / f"{name}.input").write_bytes(content)
    (place / f"{name}.txt").write_text(told[-20_000:], encoding="utf-8", errors="backslashreplace")


def main() -> None:
    """A range of inputs; one line of JSON at the end, one for each finding before."""
    kind, seed, first, last, place = (
        sys.argv[1],
        int(sys.argv[2]),
        int(sys.argv[3]),
        int(sys.argv[4]),
        Path(sys.argv[5]),
    )
    out = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # nothing that is asked may speak between
    if not os.environ.get("FUZZ_LOUD"):
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    signal.signal(signal.SIGPROF, _alarm)
    at = os.open(sys.argv[6], os.O_WRONLY | os.O_CREAT)
    for number in range(10_000_000, 10_000_003):  # loads what is loaded once
        ask(kind, seed, number, place / "warm")
    resource.setrlimit(resource.RLIMIT_AS, (size_of_process() + BYTES, resource.RLIM_INFINITY))
    answers, slowest = Counter[str](), (0.0, first)
    for number in range(first, last):
        os.pwrite(at, f"{number:012d}".encode(), 0)
        answer, seconds = ask(kind, seed, number, place)
        slowest = max(slowest, (seconds, number))
        answers[answer.split(":")[0]] += 1
        if answer.startswith("finding"):
            out.write(json.dumps({"number": number, "answer": answer}) + "\n")
        if number % 500 == 0:
            gc.collect()
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    out.write(json.dumps({"answers": answers, "slowest": slowest, "memory": memory * 1024}) + "\n")


if __name__ == "__main__":
    main()
