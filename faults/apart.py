"""Damaged files, each asked about in a fork within bounds of time and memory."""

from __future__ import annotations

import os
import resource
import select
import shutil
import signal
import tempfile
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from random import Random
from typing import NoReturn

from faults import ROOT, inputs, questions, results

#: Bounds of one damaged file: processor time and time (s), memory beyond that of the start (bytes).
SECONDS, WAIT, BYTES = 20, 300.0, 2_000_000_000
#: Where files that broke a promise are kept.
PLACE = ROOT / "build" / "faults"
#: What is damaged -> what makes it, and what is asked about it.
FILES: dict[str, tuple[Callable[[Random], bytes], Callable[[bytes], str]]] = {
    "cases": (inputs.case_mutant, questions.case), "runs": (questions.run_mutant, questions.run),
    "measurements": (questions.measured_mutant, questions.measured), "results": (results.mutant, results.ask),
}  # fmt: skip


def chance_of(kind: str, seed: int, number: int) -> Random:
    """The random numbers of one fault, the same on every machine."""
    return Random(f"{kind} {seed} {number}")


@contextmanager
def elsewhere() -> Iterator[Path]:
    """A new working directory, which goes afterwards."""
    before = os.getcwd()
    with tempfile.TemporaryDirectory(prefix="valvetrain-faults-") as folder:
        os.chdir(folder)
        try:
            yield Path(folder)
        finally:
            os.chdir(before)


def asked(kind: str, seed: int, number: int) -> str:
    """The answer about one damaged file, which is left as "input" in the working directory."""
    os.environ["VALVETRAIN_TRACEBACK"] = "1"  # a part that fails is told, not a gap of the answer
    make, question = FILES[kind]
    content = make(chance_of(kind, seed, number))
    Path("input").write_bytes(content)
    return question(content)


def warm() -> None:
    """Load once what every fork needs."""
    for kind in FILES:
        with elsewhere(), suppress(Exception):
            asked(kind, 0, 0)


def compile_kernels() -> None:
    """Run the short cases, so that no fork compiles what they need."""
    for tree in inputs.short_cases().values():
        with elsewhere(), suppress(Exception):
            questions.run(inputs.case_text(tree))


def asked_apart(kind: str, seed: int, number: int) -> tuple[str, list[str]]:
    """The same by a fork: the answer, and what was broken."""
    with elsewhere():
        read, write = os.pipe()
        child = os.fork()
        if not child:
            _answer(kind, seed, number, write)
        os.close(write)
        said = b""
        while select.select([read], [], [], WAIT)[0] and (part := os.read(read, 65536)):
            said += part
        os.close(read)
        if not said:
            os.kill(child, signal.SIGKILL)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        word, _, told = said.decode().partition("\n")
        if word and not told:
            return word, []
        PLACE.mkdir(parents=True, exist_ok=True)
        with suppress(FileNotFoundError):
            shutil.copy("input", PLACE / f"{kind}-{seed}-{number}.input")
        return "broken", [told or f"the process ended with {status} (-24: after {SECONDS} s)"]


def _answer(kind: str, seed: int, number: int, write: int) -> NoReturn:
    """The part of the fork."""
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (size + BYTES, resource.RLIM_INFINITY))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 5))
    for stream in (1, 2):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
    try:
        text = asked(kind, seed, number)
    except BaseException as error:
        frames = [one for one in traceback.extract_tb(error.__traceback__) if "/valvetrain/" in one.filename]  # fmt: skip
        where = f" {Path(frames[-1].filename).name}:{frames[-1].lineno}" if frames else ""
        text = f"broken\n{type(error).__name__}{where} {str(error)[:300]!r}"
    os.write(write, text.encode("utf-8", "backslashreplace"))
    os._exit(0)
