"""Seeds a sample of faults into ``src/`` (copies of it), asks the tests about each and prints the
share that is noticed.

Use: python -m mutants --sample 150 --seed 1 --workers 2
     python -m mutants --folders report,quantities --sample 40     faults of these folders only
     python -m mutants --list --sample 20                          the faults alone, nothing is run
     python -m mutants --sample 150 --minutes 60                   as many of the sample as are
     judged in an hour
     python -m mutants --sample 150 --seed 1 --resume              goes on with a sample that was
     stopped, on the same source and tests
     python -m mutants --only 3,17 --sample 150 --seed 1           these numbers of the sample again
"""

from __future__ import annotations

import argparse
import difflib
import json
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path
from queue import Empty, Queue
from typing import Any

from mutants.choose import SOURCE, sample, tests_for
from mutants.copies import PLACE, renew, twin_of
from mutants.digests import of_tree
from mutants.faults import Fault, seeded
from mutants.record import environment, golden_tests_pass, trails, whole

LIMIT = 90.0
JUDGED = Path(__file__).with_name("judged.txt")


def difference(fault: Fault) -> str:
    """The changed lines of a fault."""
    text = (SOURCE / fault.file).read_text(encoding="utf-8")
    lines = difflib.unified_diff(
        text.splitlines(), seeded(text, fault).splitlines(), n=0, lineterm=""
    )
    return "\n".join(line for line in list(lines)[2:] if line[:2] != "@@")


def mark(fault: Fault) -> str:
    """What the list of judged faults knows a fault by: its file and its changed lines, not their
    numbers.
    """
    return f"{fault.file} {' '.join(difference(fault).split())}"


def judged() -> dict[str, str]:
    """Faults that change nothing which anybody can meet -> the reason."""
    lines = JUDGED.read_text(encoding="utf-8").splitlines() if JUDGED.exists() else []
    pairs = [line.split(" || ") for line in lines if " || " in line]
    return {known: reason for known, reason in pairs}


class Answers(dict[int, dict[str, Any]]):
    """Number of a fault -> its answer; every new one is kept on disk at once, beside the digest of
    the tree that it belongs to.
    """

    def __init__(self, place: Path, chosen: dict[int, Fault]) -> None:
        super().__init__()
        self.place, self.chosen, self.lock = place, chosen, threading.Lock()

    def read(self) -> None:
        """Takes what an earlier call of the same sample found. What came to no end is asked again."""
        if not self.place.exists():
            raise SystemExit(
                f"nothing to resume: no sample of this name was begun ({self.place.name}); leave --resume out"
            )
        kept = json.loads(self.place.read_text())
        if kept["tree"] != of_tree():
            raise SystemExit(
                "the sample was begun on another source or with other tests; leave --resume out to begin it anew"
            )
        self.update(
            {one.pop("number"): one for one in kept["answers"] if one["verdict"] != "endless"}
        )

    def keep(self, number: int, answer: dict[str, Any]) -> None:
        """Adds an answer and writes all."""
        with self.lock:
            self[number] = answer
            told = [
                {"number": number, **self.chosen[number].__dict__, **one}
                for number, one in sorted(self.items())
            ]
            whole(self.place, json.dumps({"tree": of_tree(), "answers": told}, indent=1))


def work(
    base: Path,
    name: str,
    tasks: Queue[tuple[int, Fault]],
    known: dict[str, Any],
    answers: Answers,
    end: float,
) -> None:
    """One worker's thread: hands tasks to its process until none is left or the time ``end`` has
    come.
    """
    copy = twin_of(base, name)
    command = [sys.executable, "-m", "mutants.worker", str(base), str(copy)]
    process = subprocess.Popen(
        command,
        cwd=copy,
        env=environment(copy),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdin and process.stdout
    seconds = {
        node: one["seconds"] for trail in known.values() for node, one in trail["tests"].items()
    }
    while time.monotonic() < end:
        try:
            number, fault = tasks.get_nowait()
        except Empty:
            break
        nodes = tests_for(fault, known)
        if nodes:
            limit = LIMIT + 4 * sum(seconds[node] for node in nodes)
            process.stdin.write(
                json.dumps({"fault": fault.__dict__, "tests": nodes, "limit": limit}) + "\n"
            )
            process.stdin.flush()
            answer = json.loads(process.stdout.readline())
        else:
            answer = {"verdict": "unseen", "by": "no test enters it", "seconds": 0.0}
        answers.keep(number, answer | {"tests": len(nodes)})
        told = "" if answer["verdict"] == "noticed" else "\n" + difference(fault)
        place = f"{fault.file}:{fault.line} [{fault.kind}]"
        print(
            f"{number:4d} {answer['verdict']:8s} {answer['seconds']:6.1f} s  {place} {answer['by'][:110]}{told}",
            flush=True,
        )
    process.stdin.close()
    process.wait()


def arguments() -> argparse.Namespace:
    """What the command line asks for."""
    parser = argparse.ArgumentParser(
        prog="python -m mutants",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--sample", type=int, default=150, help="number of faults")
    parser.add_argument("--seed", type=int, default=1, help="seed of the sample")
    parser.add_argument(
        "--folders",
        default="",
        help="folders of the package, by commas; all of them where left out",
    )
    parser.add_argument(
        "--workers",
        type=int,
        default=1,
        help="faults judged at one time, each in a copy of its own",
    )
    parser.add_argument(
        "--minutes",
        type=float,
        default=1e6,
        help="begin no fault after this time; those judged are the first of the sample",
    )
    parser.add_argument(
        "--only", default="", help="numbers of the sample, by commas; their answers are not kept"
    )
    parser.add_argument(
        "--resume",
        action="store_true",
        help="judge only what an earlier call of the same sample left",
    )
    parser.add_argument(
        "--recorded",
        action="store_true",
        help="take the trails that are kept as they are, old ones too, and make none",
    )
    parser.add_argument("--list", action="store_true", help="print the faults and run nothing")
    return parser.parse_args()


def main() -> None:
    """The run as the command line asks for it."""
    given = arguments()
    end = time.monotonic() + 60 * given.minutes
    chosen = dict(
        enumerate(sample(given.sample, given.seed, filter(None, given.folders.split(","))))
    )
    if given.only:
        chosen = {int(number): chosen[int(number)] for number in given.only.split(",")}
    if given.list:
        for number, fault in chosen.items():
            print(f"{number:4d} {fault.file}:{fault.line} [{fault.kind}]\n{difference(fault)}")
        return
    name = f"faults-{given.seed}-{given.sample}-{given.folders or 'all'}{'-only' if given.only else ''}.json"
    answers = Answers(PLACE / name, chosen)
    if given.resume:
        answers.read()
    base, same = renew("base"), judged()
    if not golden_tests_pass(base):
        raise SystemExit(
            "a golden test fails without a fault: write its file anew (CONTRIBUTING.md), or every fault stands as noticed"
        )
    known, tasks = (
        trails(base, anew=not given.recorded, workers=given.workers),
        Queue[tuple[int, Fault]](),
    )
    alike = {number for number, fault in chosen.items() if mark(fault) in same}
    for number, fault in chosen.items():
        if number in alike:
            answers.pop(number, None)
            print(f"{number:4d} the same  {fault.file}:{fault.line} {same[mark(fault)]}")
        elif number not in answers:
            tasks.put((number, fault))
    threads = [
        threading.Thread(target=work, args=(base, f"copy-{n}", tasks, known, answers, end))
        for n in range(given.workers)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    summary(chosen, answers, alike=len(alike))
    print(f"kept in {answers.place}")


def summary(chosen: dict[int, Fault], answers: dict[int, dict[str, Any]], alike: int) -> None:
    """The share by folder and in all; ``alike``: faults of the sample that change nothing, as they
    were judged before.
    """
    seen, every, late, endless = Counter[str](), Counter[str](), 0, 0
    for number, answer in answers.items():
        if (
            answer["verdict"] == "endless"
        ):  # a loop without end, or a machine too busy: told apart, since nobody knows
            endless += 1
            continue
        folder = chosen[number].file.split("/")[0]
        every[folder] += 1
        seen[folder] += answer["verdict"] == "noticed"
        late += answer["by"].startswith(("tests/golden", "tests/examples"))
    for folder in sorted(every):
        print(f"{folder:12s} {seen[folder]:4d} of {every[folder]:4d}")
    total = max(sum(every.values()), 1)
    share = 100 * sum(seen.values()) / total
    print(
        f"noticed {sum(seen.values())} of {total} ({share:.1f} %), {late} of them by golden numbers or a printed page alone"
    )
    print(
        f"of the sample of {len(chosen)}: {alike} change nothing, {endless} came to no end, {len(chosen) - alike - len(answers)} not asked"
    )


if __name__ == "__main__":
    main()
