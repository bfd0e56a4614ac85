"""Seeds faults into copies of ``src/``, runs the tests about each and prints the share that is
noticed.

Use: python -m mutants --sample 150 --seed 1 --workers 2
     python -m mutants --changed                                   one fault a line changed since
     main, tests as make test-fast chooses
     python -m mutants --changed HEAD~3                            since another commit
     python -m mutants --folders report,quantities --sample 40     faults of these folders only
     python -m mutants --folders algorithms                        physics, and what tools compute
     python -m mutants --without-net                               tests/net are not run
     python -m mutants --list --sample 20                          the faults alone, nothing is run
     python -m mutants --sample 150 --minutes 60                   as many of the sample as are
     judged in an hour
     python -m mutants --sample 150 --seed 1 --resume              continues a sample that was
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

from mutants.choose import SOURCE, changed, sample, tests_for
from mutants.copies import PLACE, ROOT, renew, tree_digest, twin_of
from mutants.faults import Fault, seeded
from mutants.record import baseline, environment, trails, whole

sys.path.insert(0, str(ROOT / "scripts"))
import test_fast

#: Seconds that a fault may take beyond four times what its tests take.
LIMIT = 90.0
#: Estimated seconds of the tests that are run about a changed line.
FAST = 10.0


def difference(fault: Fault) -> str:
    """The changed lines of a fault."""
    text = (SOURCE / fault.file).read_text(encoding="utf-8")
    lines = difflib.unified_diff(
        text.splitlines(), seeded(text, fault).splitlines(), n=0, lineterm=""
    )
    return "\n".join(line for line in list(lines)[2:] if line[:2] != "@@")


class Answers(dict[int, dict[str, Any]]):
    """Number of a fault -> its answer; every new one is written to disk at once, with the digest of
    the tree that it belongs to.
    """

    def __init__(self, path: Path, chosen: dict[int, Fault]) -> None:
        super().__init__()
        self.path, self.chosen, self.lock = path, chosen, threading.Lock()

    def read(self) -> None:
        """Reads what an earlier call of the same sample found. What came to no end is run again."""
        if not self.path.exists():
            raise SystemExit(
                f"nothing to resume: no sample of this name was begun ({self.path.name}); leave --resume out"
            )
        saved = json.loads(self.path.read_text())
        if saved["tree"] != tree_digest():
            raise SystemExit(
                "the sample was begun on another source or with other tests; leave --resume out to begin it again"
            )
        self.update(
            {one.pop("number"): one for one in saved["answers"] if one["verdict"] != "endless"}
        )

    def add(self, number: int, answer: dict[str, Any]) -> None:
        """Adds an answer and writes all."""
        with self.lock:
            self[number] = answer
            rows = [
                {"number": number, **self.chosen[number].__dict__, **one}
                for number, one in sorted(self.items())
            ]
            whole(self.path, json.dumps({"tree": tree_digest(), "answers": rows}, indent=1))


#: A number, its fault, the tests to run about it and the seconds that they take without it.
Task = tuple[int, Fault, list[str], float]


def work(base: Path, name: str, tasks: Queue[Task], answers: Answers, end: float) -> None:
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
    while time.monotonic() < end:
        try:
            number, fault, nodes, seconds = tasks.get_nowait()
        except Empty:
            break
        if nodes:
            process.stdin.write(
                json.dumps({"fault": fault.__dict__, "tests": nodes, "limit": LIMIT + 4 * seconds})
                + "\n"
            )
            process.stdin.flush()
            answer = json.loads(process.stdout.readline())
        else:
            answer = {"verdict": "unseen", "by": "no test enters it", "seconds": 0.0}
        answers.add(number, answer | {"tests": len(nodes)})
        lines = "" if answer["verdict"] == "noticed" else "\n" + difference(fault)
        where = f"{fault.file}:{fault.line} [{fault.kind}]"
        print(
            f"{number:4d} {answer['verdict']:8s} {answer['seconds']:6.1f} s  {where} {answer['by'][:110]}{lines}",
            flush=True,
        )
    process.stdin.close()
    process.wait()


def default_base() -> str:
    """The commit that a change is measured from: where the branch left main, the one before the
    last on main itself.
    """

    def git(*words: str) -> str:
        return subprocess.run(
            ["git", *words], cwd=ROOT, capture_output=True, text=True
        ).stdout.strip()

    left, head = git("merge-base", "HEAD", "main"), git("rev-parse", "HEAD")
    if left and left != head:
        return left
    return "HEAD" if git("status", "--porcelain", "--", "src") else "HEAD~1"


def arguments() -> argparse.Namespace:
    """What the command line gives."""
    parser = argparse.ArgumentParser(
        prog="python -m mutants",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--sample", type=int, default=150, help="number of faults")
    parser.add_argument("--seed", type=int, default=1, help="seed of the sample")
    parser.add_argument(
        "--changed",
        metavar="COMMIT",
        nargs="?",
        const="",
        help="lines changed since a commit (main, or HEAD~1) alone",
    )
    parser.add_argument(
        "--folders",
        default="",
        help="folders of the package, by commas; all of them where left out",
    )
    parser.add_argument("--without-net", action="store_true", help="leave tests/net out")
    parser.add_argument(
        "--workers",
        type=int,
        default=0,
        help="faults judged at one time, each in a copy of its own (1; --changed: 2)",
    )
    parser.add_argument(
        "--minutes",
        type=float,
        default=0.0,
        help="begin no fault after this time; those judged are the first (--changed: 1)",
    )
    parser.add_argument(
        "--only", default="", help="numbers of the sample, by commas; their answers are not stored"
    )
    parser.add_argument(
        "--resume",
        action="store_true",
        help="judge only what an earlier call of the same sample left",
    )
    parser.add_argument(
        "--recorded",
        action="store_true",
        help="take the stored trails as they are, old ones too, and make none",
    )
    parser.add_argument("--list", action="store_true", help="print the faults and run nothing")
    return parser.parse_args()


def tests_of(
    given: argparse.Namespace, base: Path, chosen: dict[int, Fault]
) -> dict[int, tuple[list[str], float]]:
    """Number of a fault -> the tests to run about it, and their seconds without a fault."""
    without = ("tests/net/",) if given.without_net else ()
    if given.changed is not None:
        files = {SOURCE / fault.file for fault in chosen.values()}
        modules = {name for name, path in test_fast.package_modules().items() if path in files}
        taken, _ = test_fast.select(modules, FAST, without)
        seconds = baseline(base, [one.file for one in taken], test_fast.pytest_options(taken))
        return dict.fromkeys(chosen, (list(seconds), sum(seconds.values())))
    known = trails(base, anew=not given.recorded, workers=given.workers)
    known = {file: trail for file, trail in known.items() if not file.startswith(without or ("-",))}
    times = {
        node: one["seconds"] for trail in known.values() for node, one in trail["tests"].items()
    }
    found = {number: tests_for(fault, known) for number, fault in chosen.items()}
    return {number: (nodes, sum(times[node] for node in nodes)) for number, nodes in found.items()}


def main() -> None:
    """The run as the command line gives it."""
    given, begun = arguments(), time.monotonic()
    given.workers = given.workers or (1 if given.changed is None else 2)
    folders = list(filter(None, given.folders.split(",")))
    if given.changed is not None:
        chosen = dict(
            enumerate(changed(given.changed or default_base(), given.sample, given.seed, folders))
        )
    else:
        chosen = dict(enumerate(sample(given.sample, given.seed, folders)))
    if given.only:
        chosen = {int(number): chosen[int(number)] for number in given.only.split(",")}
    if given.list or not chosen:
        for number, fault in chosen.items():
            print(f"{number:4d} {fault.file}:{fault.line} [{fault.kind}]\n{difference(fault)}")
        print(f"{len(chosen)} faults")
        return
    kind = (
        "changed"
        if given.changed is not None
        else f"faults-{given.seed}-{given.sample}-{given.folders or 'all'}"
    )
    answers = Answers(
        PLACE
        / f"{kind}{'-without-net' if given.without_net else ''}{'-only' if given.only else ''}.json",
        chosen,
    )
    if given.resume:
        answers.read()
    base, tasks = renew("base"), Queue[Task]()
    for number, (nodes, seconds) in tests_of(given, base, chosen).items():
        if number not in answers:
            tasks.put((number, chosen[number], nodes, seconds))
    end = (begun if given.changed is None else time.monotonic()) + 60 * (
        given.minutes or (1e6 if given.changed is None else 1.0)
    )
    threads = [
        threading.Thread(target=work, args=(base, f"copy-{n}", tasks, answers, end))
        for n in range(given.workers)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    summary(chosen, answers)
    print(f"stored in {answers.path}; {time.monotonic() - begun:.0f} s")


def summary(chosen: dict[int, Fault], answers: dict[int, dict[str, Any]]) -> None:
    """The share by folder and in all."""
    seen, every, late, endless = Counter[str](), Counter[str](), 0, 0
    for number, answer in answers.items():
        if (
            answer["verdict"] == "endless"
        ):  # a loop without end, or a machine too busy: nobody knows which
            endless += 1
            continue
        folder = chosen[number].file.split("/")[0]
        every[folder] += 1
        seen[folder] += answer["verdict"] == "noticed"
        late += answer["by"].startswith(("tests/net", "tests/examples"))
    for folder in sorted(every):
        print(f"{folder:12s} {seen[folder]:4d} of {every[folder]:4d}")
    total = max(every.total(), 1)
    share = 100 * seen.total() / total
    print(
        f"noticed {seen.total()} of {every.total()} ({share:.1f} %), {late} of them by the stored numbers of tests/net or a printed page alone"
    )
    print(
        f"of {len(chosen)} faults: {endless} came to no end, {len(chosen) - len(answers)} not run"
    )


if __name__ == "__main__":
    main()
