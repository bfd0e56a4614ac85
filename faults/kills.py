"""Commands that are killed, and disks that are full: what was finished is there, nothing else stays,
and the command takes its folder back.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from fault_parts import marked, started
from faults.commands import COMMANDS, OBSERVED, answer_in, noted, words
from unit.cli_parts import process_environment

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
#: What a command never says, whatever is done to it.
NEVER = ("Traceback", "HDF5", "Segmentation", "fault in valvetrain")
#: Numbers of a command that count what it computed this time.
COUNTS = ("seconds", "evaluations", "computed_now")
Numbers = dict[tuple[str, str], tuple[float, str]]


@dataclass(frozen=True)
class Reference:
    """An undisturbed command: its numbers, how many files it writes, how long it takes (s)."""

    numbers: Numbers
    files: int
    seconds: float


def numbers_in(folder: Path) -> Numbers:
    """Every number of the answer in a folder of results, apart from :data:`COUNTS`."""
    from valvetrain.runs.differences import answer_numbers

    found = dict(answer_numbers(answer_in(folder)))
    return {key: value for key, value in found.items() if key[0] not in COUNTS}


def undisturbed(command: str, folder: Path) -> tuple[Reference, list[str]]:
    """Run a command to its end; what it broke."""
    begun, environment = time.monotonic(), process_environment(TMPDIR=str(_temporary(folder)))
    done = subprocess.run(
        [sys.executable, "-c", OBSERVED, "0", *words(command)],
        cwd=folder, env=environment, capture_output=True, text=True,
    )  # fmt: skip
    broken = [f"'{word}' is said" for word in NEVER if word in done.stderr]
    if done.returncode:
        broken.append(f"exit code {done.returncode}: {done.stderr[-300:]}")
    left = [*_left(folder / "out"), *(folder / "temporary").iterdir()]
    broken += [f"'{path.relative_to(folder)}' stays" for path in left]
    files, _ = noted(folder)
    return Reference(numbers_in(folder / "out"), len(files), time.monotonic() - begun), broken


def _temporary(folder: Path) -> Path:
    (folder / "noted.log").unlink(missing_ok=True)
    shutil.rmtree(folder / "temporary", ignore_errors=True)
    (folder / "temporary").mkdir()
    return folder / "temporary"


def _left(folder: Path) -> list[Path]:
    """What only an unfinished command has in its folder."""
    return [
        path
        for path in folder.rglob("*")
        if path.name.endswith(".part") or path.name == "unfinished-runs.jsonl"
    ]


@cache
def reference(command: str, folder: Path) -> Reference:
    """The command in a fresh folder, without a fault."""
    shutil.rmtree(folder / "out", ignore_errors=True)
    found, broken = undisturbed(command, folder)
    assert found.numbers and not broken, (command, broken)
    return found


def killed(command: str, folder: Path, chance: random.Random) -> tuple[str, list[str]]:
    """Kill the command or its worker: behind one of its files, or at any time by any signal. Then
    start it again in the folder that it left.
    """
    whole = reference(command, folder)
    if chance.random() < 0.7:
        shutil.rmtree(folder / "out", ignore_errors=True)
    behind = chance.randint(1, whole.files) if chance.random() < 0.5 else 0
    worker = command == "sweep" and chance.random() < 0.5
    number = signal.SIGKILL if behind or worker else chance.choice(SIGNALS)
    environment = {"TMPDIR": str(_temporary(folder))}
    with started(str(behind), *words(command), folder=folder, code=OBSERVED, **environment) as (
        run,
        mark,
    ):
        end = time.monotonic() + chance.uniform(0.2, 1.1) * whole.seconds
        while not behind and time.monotonic() < end and run.poll() is None:
            time.sleep(0.01)
        others = [one for one in marked(mark) if one != run.pid] if worker else [run.pid]
        hit = not behind and run.poll() is None and bool(others)
        if hit:
            os.kill(chance.choice(others), number)
        try:
            _, errors = run.communicate(timeout=180)
        except subprocess.TimeoutExpired:
            return command, ["it hangs"]
        late = time.monotonic() + 20
        while marked(mark) and time.monotonic() < late:
            time.sleep(0.05)
        broken = [f"process {one} lives on" for one in marked(mark)]
    broken += [f"'{word}' is said" for word in NEVER if word in errors]
    broken += [f"'{path.name}' stays" for path in (folder / "temporary").iterdir()]
    broken += _runs_lost(folder)
    allowed = {-9} if behind else {0, 1} if worker else {0, -number, 128 + number} if hit else {0}
    if run.returncode not in allowed:
        broken.append(f"exit code {run.returncode}: {errors[-300:]}")
    again, more = undisturbed(command, folder)
    broken += [f"started again: {sentence}" for sentence in more]
    if not more and again.numbers != whole.numbers:
        broken.append("started again: other numbers")
    how = f"behind file {behind}" if behind else f"{'worker ' if worker else ''}{number.name}"
    return f"{command}, {how}", broken


def _runs_lost(folder: Path) -> list[str]:
    """Runs that the command held for finished and that are not on disk."""
    from valvetrain.runs.run_folders import LIST, whole_lines
    from valvetrain.solution.netcdf import load_netcdf

    rows = [*map(json.loads, whole_lines(folder / "out" / LIST))]
    rows += answer_in(folder / "out").get("runs", [])
    for path in (folder / "out").glob("run-*.nc"):
        load_netcdf(path)
    moving = [row for row in rows if "label" in row and row.get("engine_speed")]
    saved = {(row["label"], f"{row['engine_speed']['value']:.6f}") for row in moving}
    return [f"run {label} at {speed} rpm is lost" for label, speed in {*noted(folder)[1]} - saved]


def full_disk(command: str, folder: Path, chance: random.Random) -> tuple[str, list[str]]:
    """A file system that has less room than the command takes: it says so and leaves nothing
    half-written.
    """
    disk = folder / "disk"
    disk.mkdir(exist_ok=True)
    size = chance.randrange(8_000, 300_000)
    begin = f"mount -t tmpfs -o size={size} none '{disk}' && mkdir '{disk}/out' && ln -s '{disk}/out' out"
    script = f"{begin} && \"$@\"; code=$?; cp -r '{disk}/.' left; exit $code"
    for name in ("left", "out"):
        shutil.rmtree(folder / name, ignore_errors=True)
    done = subprocess.run(
        ["unshare", "-rm", "sh", "-c", script, "sh", sys.executable, "-m", "valvetrain", *words(command)],
        cwd=folder, env=process_environment(TMPDIR=str(_temporary(folder))), capture_output=True, text=True,
    )  # fmt: skip
    (folder / "out").unlink(missing_ok=True)
    broken = [f"'{word}' is said" for word in NEVER if word in done.stderr]
    broken += [f"exit code {done.returncode}"] if done.returncode not in (0, 1, 2) else []
    broken += ["no sentence"] if done.returncode and not done.stderr.strip() else []
    broken += [f"{path.name} is half-written" for path in (folder / "left").rglob("*.part")]
    return f"{command}, disk of {size} bytes", broken


def trial(kind: str, folder: Path, chance: random.Random) -> tuple[str, list[str]]:
    """One fault of a kind at a random command."""
    command = chance.choice(sorted(COMMANDS))
    return {"kills": killed, "disks": full_disk}[kind](command, folder, chance)


def may_unshare() -> bool:
    """Whether a command can have a file system of its own."""
    return not subprocess.run(["unshare", "-rm", "true"], capture_output=True).returncode
