"""Kill workers, parents and the solid solver at random moments, fill the disk, damage the cache,
take the home away; tell what was lost.

Use: python scripts/faults.py [TRIALS] [--seed SEED]

Every trial starts a command as a process and disturbs it once. An observer inside notes each run
when the command holds it for finished;
afterwards each noted run must be on disk with the numbers of an undisturbed command, no process and
no work folder may be left, the exit
code must be the one that is promised, and the next command in the same folder must leave nothing
half-written there.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from fault_parts import marked, stand_in_solver, started
from unit.cli_parts import SMALL, process_environment

OBSERVED = """
import signal
signal.signal(signal.SIGINT, signal.SIG_DFL)  # as valvetrain/__main__.py, while the package loads
from valvetrain.report.files import UnfinishedRun
usual = UnfinishedRun.add
def add(self, place, solution):
    usual(self, place, solution)
    with open('finished.log', 'a') as log:
        log.write(f'{solution.label}|{solution.engine_speed * 30 / 3.141592653589793:.6f}\\n')
UnfinishedRun.add = add
from valvetrain.cli.main import main
main()
"""
TRAIN = ("--spring-set", "stock", "--no-report", "--quiet", "--workers", "2", "--output", "out")
COMMANDS = {
    "sweep": ("sweep", "tdi-pushrod", "--engine-speed", "1000:5000:50 rpm", "--spring", "massless", "--no-critical-speeds", *TRAIN),
    "run": ("run", "tdi-pushrod", "--engine-speed", "2000:5000:250 rpm", "--spring", "massless,multi-mass", *TRAIN),
    "compare": ("compare", "small.toml", "--engine-speed", "6000, 9000 rpm", "--spring", "massless,multi-mass,modal-varied", "--no-report",
                "--quiet", "--output", "out"),
    "solid": ("compare", "small.toml", "--spring", "solid", "--solid-elements-per-coil", "6", "--no-report", "--quiet", "--output", "out"),
}  # fmt: skip
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)


@dataclass
class Reference:
    """What an undisturbed command gives, by label and engine speed, and how long it takes (s)."""

    numbers: dict[tuple[str, str], dict[str, object]]
    seconds: float


def numbers_in(folder: Path) -> dict[tuple[str, str], dict[str, object]]:
    """Quantities of every finished run in a folder, of a whole or an unfinished one."""
    rows: list[dict[str, Any]] = []
    for name in ("run.json", "unfinished-runs.jsonl"):
        try:
            text = (folder / name).read_text("utf-8")
        except OSError:
            continue
        rows += (
            json.loads(text)["runs"]
            if name == "run.json"
            else [json.loads(line) for line in text.splitlines() if line.endswith("}")]
        )
    return {
        (row["label"], f"{row['engine_speed']['value']:.6f}"): row["quantities"]
        for row in rows
        if row["quantities"]
    }


def noted(folder: Path) -> list[tuple[str, str]]:
    """Runs that the observer saw finished."""
    try:
        lines = (folder / "finished.log").read_text("utf-8").splitlines()
    except OSError:
        return []
    return [(label, speed) for label, _, speed in (line.partition("|") for line in lines)]


def undisturbed(kind: str, folder: Path, **environment: str) -> Reference:
    """Run a command to its end."""
    begun = time.monotonic()
    command = [sys.executable, "-c", OBSERVED, *COMMANDS[kind]]
    done = subprocess.run(
        command, cwd=folder, env=process_environment(**environment), capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return Reference(numbers_in(folder / "out"), time.monotonic() - begun)


def disturbed(
    kind: str, folder: Path, reference: Reference, chance: random.Random
) -> tuple[str, list[str]]:
    """One trial: what was done, and what of the promises was broken."""
    (folder / "finished.log").unlink(missing_ok=True)
    work = folder / "work"
    work.mkdir(exist_ok=True)
    environment = {"TMPDIR": str(work)} | ({"CCX": str(folder / "ccx")} if kind == "solid" else {})
    victim = chance.choice(
        {"solid": ("parent", "solver")}.get(kind, ("parent", "parent", "worker"))
    )
    number = chance.choice(SIGNALS) if victim == "parent" else signal.SIGKILL
    with started(*COMMANDS[kind], folder=folder, code=OBSERVED, **environment) as (run, mark):
        end = time.monotonic() + chance.uniform(0.3, 1.1) * reference.seconds
        while time.monotonic() < end and run.poll() is None:
            time.sleep(0.01)
        target = run.pid if victim == "parent" else _other(victim, run.pid, mark, folder, chance)
        hit = run.poll() is None and target is not None
        if hit and target is not None:
            os.kill(target, number)
        if kind == "solid" and victim == "solver" and not hit:
            run.send_signal(signal.SIGTERM)  # it would wait for the solver for ever
        broken = []
        try:
            _, errors = run.communicate(timeout=120)
        except subprocess.TimeoutExpired:
            return f"{kind}, {victim}", ["it hangs"]
        late = time.monotonic() + 20
        while marked(mark) and time.monotonic() < late:
            time.sleep(0.05)
        if left := marked(mark):
            broken.append(f"processes {left} live on")
    broken += _broken(kind, folder, reference, run.returncode, victim, number if hit else 0, errors)
    return f"{kind}, {victim} {signal.Signals(number).name}{'' if hit else ' (too late)'}", broken


def _other(victim: str, parent: int, mark: str, folder: Path, chance: random.Random) -> int | None:
    if victim == "solver":
        note = folder / "solver.pid"
        text = note.read_text().strip() if note.exists() else ""
        note.unlink(missing_ok=True)
        return int(text) if text and int(text) in marked(mark) else None
    workers = [one for one in marked(mark) if one != parent]
    return chance.choice(workers) if workers else None


def _broken(
    kind: str, folder: Path, reference: Reference, code: int, victim: str, number: int, errors: str
) -> list[str]:
    broken = [
        f"'{word}' is said" for word in ("Traceback", "HDF5", "Segmentation") if word in errors
    ]
    there = numbers_in(folder / "out")
    for key in noted(folder):
        if key not in there:
            broken.append(f"{key} is lost")
        elif there[key] != reference.numbers.get(key):
            broken.append(f"{key} has other numbers than without the fault")
    if list((folder / "work").glob("valvetrain-solid-*")):
        broken.append("a work folder of the solver stays")
    shutil.rmtree(folder / "work", ignore_errors=True)
    early = -number in (code,)  # before the command listened, or SIGKILL
    allowed = (
        {0, 128 + number} if victim == "parent" else {0, 1} if number else {0, 1, 143}
    )  # 143: what waits for ever is ended
    if code not in allowed and not (victim == "parent" and number and early):
        broken.append(f"exit code {code}: {errors[-300:]}")
    if victim == "worker" and code == 0 and there.keys() < reference.numbers.keys():
        broken.append("runs are missing after a worker was killed")
    return broken


def full_disk(folder: Path, chance: random.Random) -> tuple[str, list[str]]:
    """A file system of a random size below what the run takes."""
    disk = folder / "disk"
    disk.mkdir(exist_ok=True)
    size = chance.randrange(40_000, 900_000)
    made = f"mount -t tmpfs -o size={size} none '{disk}' && cd '{disk}'"
    script = f"{made} && \"$@\"; code=$?; cp -r out '{folder}/left'; exit $code"
    shutil.rmtree(folder / "left", ignore_errors=True)
    words = (
        "run",
        "job-t",
        "--engine-speed",
        "2000, 2500 rpm",
        "--spring",
        "massless,multi-mass",
        "--no-report",
        "--output",
        "out",
    )
    command = [
        "unshare",
        "-rm",
        "sh",
        "-c",
        script,
        "sh",
        sys.executable,
        "-m",
        "valvetrain",
        *words,
    ]
    done = subprocess.run(
        command, cwd=folder, env=process_environment(), capture_output=True, text=True
    )
    broken = [
        f"'{word}' is said" for word in ("Traceback", "HDF5", "Segmentation") if word in done.stderr
    ]
    broken += [f"exit code {done.returncode}"] if done.returncode not in (0, 1) else []
    broken += ["no numbers in the terminal"] if "Peak spring force" not in done.stdout else []
    left = folder / "left"
    broken += [f"{path.name} is half-written" for path in left.rglob("*.part")]
    from valvetrain.solution.netcdf import load_netcdf

    for path in (*left.glob("massless*.nc"), *left.glob("multi-mass*.nc")):
        load_netcdf(path)
    return "full disk", broken


def damaged_cache(
    folder: Path, cache: Path, reference: Reference, chance: random.Random
) -> tuple[str, list[str]]:
    """Files of the cache of compiled kernels cut short or emptied, and no home."""
    files = sorted(path for path in cache.rglob("*.nb*") if path.is_file())
    for path in chance.sample(files, min(3, len(files))):
        content = path.read_bytes()
        path.write_bytes(content[: chance.randrange(0, max(len(content) // 2, 1))])
    again = undisturbed(
        "sweep", folder, NUMBA_CACHE_DIR=str(cache), HOME=str(folder / "no-such-home")
    )
    return "damaged cache, no home", [] if again.numbers == reference.numbers else ["other numbers"]


def main() -> int:
    """Run the trials; the exit code is 1 where a promise was broken."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("trials", type=int, nargs="?", default=40)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    chance, counts, failures = random.Random(asked.seed), Counter[str](), 0
    with tempfile.TemporaryDirectory(prefix="valvetrain-faults-") as name:
        folders = {kind: Path(name) / kind for kind in (*COMMANDS, "disk", "cache")}
        for folder in folders.values():
            folder.mkdir()
            (folder / "small.toml").write_text(SMALL)
        stand_in_solver(folders["solid"])
        references = {
            kind: undisturbed(kind, folders[kind]) for kind in COMMANDS if kind != "solid"
        }
        references["solid"] = Reference({}, 6.0)
        cache, mounts = (
            Path(name) / "kernels",
            not subprocess.run(["unshare", "-rm", "true"], capture_output=True).returncode,
        )
        kinds = [*COMMANDS, "sweep", "run", *(["disk"] if mounts else [])]
        try:
            for count in range(1, asked.trials + 1):
                kind = chance.choice(kinds) if count % 20 else "cache"
                if kind == "cache":
                    undisturbed("sweep", folders[kind], NUMBA_CACHE_DIR=str(cache))
                    what, broken = damaged_cache(folders[kind], cache, references["sweep"], chance)
                else:
                    what, broken = (
                        full_disk(folders[kind], chance)
                        if kind == "disk"
                        else disturbed(kind, folders[kind], references[kind], chance)
                    )
                counts[what] += 1
                failures += bool(broken)
                for sentence in broken:
                    print(f"trial {count}: {what}: {sentence}", flush=True)
        except KeyboardInterrupt:
            print(f"stopped after {counts.total()} faults", flush=True)
        for kind in references.keys() - {"solid"}:
            undisturbed(kind, folders[kind])
            left = [
                str(path)
                for path in folders[kind].rglob("*")
                if path.suffix == ".part" or path.name == "unfinished-runs.jsonl"
            ]
            if left:
                failures += 1
                print(f"after the last run of {kind} there is still {left}")
    print("\n".join(f"{number:5d}  {what}" for what, number in sorted(counts.items())))
    print(f"{counts.total()} faults, {failures} of them with a broken promise (seed {asked.seed})")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
