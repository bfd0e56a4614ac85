"""A workspace with a small case, and a stand-in for the command line whose jobs sleep, eat memory
or refuse as they are told.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Mapping
from datetime import datetime
from pathlib import Path
from random import Random
from typing import Any

from valvetrain.runs.run_folders import link_latest, new_folder
from valvetrain.runs.saved_runs import Inputs, save_run
from valvetrain.views.page import packed
from valvetrain.workbench.workspace import Workspace

#: Names that nothing of a workspace may bear.
BAD_NAMES = (
    "../x",
    "..",
    "a/b",
    "a\\b",
    "/etc/passwd",
    "",
    ".hidden",
    "a\0b",
    "CON",
    "x" * 300,
    "a..b",
    "-x",
    "a:b",
    "a\nb",
)

#: A spring known by its card under a short lift: reads and runs at once.
SMALL = """
[spring]
preload = "250 N"
rate = "32 N/mm"
mass = "42 g" # weighed
installed_height = { value = "36 mm", status = "measured", source = "drawing 17" }
[lift_law]
kind = "polynomial"
maximum_lift = "9 mm"
opening_start = "115 deg"
opening_end = "180 deg"
closing_start = "180 deg"
closing_end = "245 deg"
[operation]
engine_speeds = "4000 rpm"
"""

#: The stand-in: what it does is told by FAKE, where it leaves the numbers of its processes by PIDS.
PROGRAM = """
import json, os, signal, subprocess, sys, time
mode, folder = os.environ["FAKE"], "runs/small/20260101-000000-00000000"
def tell(share, text):
    os.write(int(os.environ["VALVETRAIN_PROGRESS"]), (json.dumps({"share": share, "text": text}) + "\\n").encode())
def keep(code, **more):
    os.makedirs(folder, exist_ok=True)
    print(json.dumps({"folder": folder, **more}), flush=True)
    os._exit(code)
def asked(*_):
    keep(143, failures=["interrupted"]) if mode != "deaf" else None
signal.signal(signal.SIGTERM, asked)
if mode == "refused":
    print(json.dumps({"error": {"message": "a wire of 4 m is no wire", "where": "spring.wire_diameter", "code": 2}}))
    sys.exit(2)
tell(0.25, "first half")
if mode == "quick":
    tell(1.0, "done")
    keep(0, command=sys.argv[1])
worker = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(120)"])
with open(os.environ["PIDS"], "w") as file:
    file.write(f"{os.getpid()} {worker.pid}")
if mode == "hungry":
    held = bytearray(os.urandom(1 << 20)) * 300
while True:
    time.sleep(0.05)
"""


def stand_in(folder: Path, grace: float = 1.0) -> list[str]:
    """Words that start the supervisor with the stand-in in place of the command line, and a short
    grace.
    """
    path = folder / "stand_in.py"
    path.write_text(PROGRAM)
    code = (
        "import sys; from valvetrain.workbench import supervisor as one; "
        f"one.PROGRAM = [sys.executable, {str(path)!r}]; one.GRACE = {grace}; one.WEIGH = 0.1; sys.exit(one.main(sys.argv[1:]))"
    )
    return [sys.executable, "-c", code]


def wait_for(what: Callable[[], object], longest: float = 60.0) -> object:
    """What ``what`` gives once it is true; a failure after ``longest`` seconds."""
    last = time.monotonic() + longest
    while not (found := what()):
        assert time.monotonic() < last, "waited too long"
        time.sleep(0.02)
    return found


def lives(number: int) -> bool:
    """Whether a process runs; one that ended and was not fetched does not."""
    try:
        os.kill(number, 0)
        state = Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0]
    except (OSError, IndexError):
        return False
    return state != "Z"


def kept(
    workspace: Workspace,
    case: str = "small",
    created: str = "2026-01-01T00:00:00+00:00",
    **files: str,
) -> str:
    """A run as the run store keeps it, with text files (an underscore stands for the dot); its id."""
    inputs, at = (
        Inputs(case, SMALL, {}, {"models": ["massless"], "engine_speeds": [4000.0]}),
        datetime.fromisoformat(created),
    )
    folder = new_folder(inputs.case, inputs.digest, at, workspace.runs_folder)
    for name, text in files.items():
        (folder / name.replace("_", ".")).write_text(text)
    answer = {
        "case": case,
        "command": "run",
        "created_at": created,
        "completed": True,
        "files": [*(n.replace("_", ".") for n in files)],
    }
    link_latest(save_run(folder, inputs, answer).folder)
    return folder.relative_to(workspace.runs_folder).as_posix()


#: The spring of the small case, a lift law for it that reads a file, and such a file of 36 lifts.
SPRING = SMALL.split("[lift_law]")[0]
TABLE = "[lift_law]\nkind = 'table'\nfile = 'lift.txt'\nangle_of = 'cam'\nangle_unit = 'deg'\nlift_unit = 'mm'\n"


def lifts(peak: float = 9.0) -> bytes:
    """A table of 36 lifts."""
    return "\n".join(
        f"{place * 10} {max(0.0, peak - abs(place - 18)) ** 2 / peak:.4f}" for place in range(36)
    ).encode()


#: Texts of an answer that says nothing.
NOTHING = {
    "title": "", "fact": "", "next_step": "", "headings": [""], "verdict": None, "lines": [], "bullets": [], "models": None, "paper": None,
    "rests_on": [], "figures": {}, "moving": "", "tables": {}, "computed": [], "text": "", "gaps": [],
}  # fmt: skip


def page_with(texts: Mapping[str, Any], data: Mapping[str, Any]) -> str:
    """A page of a run with these texts, among others, and data."""
    both = {"answer": NOTHING | texts, "data": data}
    return "".join(
        f'<script type="application/gzip" id="{name}">{packed(one)}</script>\n'
        for name, one in both.items()
    )


def damaged_page(seed: int) -> bytes:
    """A page whose texts are of other kinds, missing, or no packed data."""
    dice = Random(seed)
    name = dice.choice([*NOTHING])
    wrong = page_with({name: dice.choice((7, "x", None, [7], {"a": 1}, [{}], {"a": {}}))}, {})
    missing = page_with({}, {}).replace(packed(NOTHING), packed({}))
    torn = wrong.replace("H4sI", "H4sJ", dice.randrange(2)) + wrong[: dice.randrange(len(wrong))]
    return dice.choice((wrong, missing, torn)).encode()
