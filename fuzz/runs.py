"""Mutants of case files that are run whole: check, run, files and page."""

from __future__ import annotations

import copy
import json
import os
import random
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

from fuzz import trees
from valvetrain.errors import InputError

#: Estimated time beyond which a mutant is refused (the machine may be several times slower than the
#: estimate's).
MAX_TIME = "4 s"
#: Mutants tried until one can be built.
TRIES = 12


@cache
def short_cases() -> dict[str, dict[str, Any]]:
    """The shipped cases at one speed, with a coarse mesh, few turns and nothing published."""
    found = {}
    for name, whole in trees.trees().items():
        tree = {
            key: value
            for key, value in copy.deepcopy(whole).items()
            if key not in ("published", "study", "sources", "remarks")
        }
        operation = tree.setdefault("operation", {})
        operation.pop("cam_speeds", None)
        operation |= {"output_step": "2 deg"} | (
            {"engine_speeds": "4000 rpm"} if "lift_law" in tree else {}
        )
        if "train" in tree:
            tree["train"].pop("variants", None)
            used = tree["train"].get("spring_set") or next(iter(tree["train"]["springs"]))
            tree["train"]["springs"] = {
                used: tree["train"]["springs"][used]
            }  # check builds every set, run the one in use
            tree["train"] |= {"cycles": 2, "spring_model": "massless"}
        elif "spring" in tree:
            operation["cycles"] = 1
            for spring in tree["spring"] if isinstance(tree["spring"], list) else [tree["spring"]]:
                if "preload" not in spring:
                    spring.setdefault("options", {})["finite-element"] = {"elements_per_coil": 8}
        found[name] = tree
    return found


def make(rng: random.Random) -> bytes:
    """A mutant that can be built, where one of a few can."""
    from valvetrain.parameters.loading import parse_case
    from valvetrain.system.build import build

    text = ""
    for _ in range(TRIES):
        name = rng.choice(sorted(short_cases()))
        text = trees.written(trees.mutated(rng, short_cases()[name], mild=0.85))
        try:
            build(parse_case(text))
            break
        except InputError:
            continue
    return text.encode("utf-8", "surrogatepass")


def ask(content: bytes) -> str:
    """``check`` and ``run``: they refuse alike, and what is not refused is run, kept and shown."""
    from fuzz.questions import Finding, command

    before = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "case.toml").write_bytes(content)
        os.chdir(folder)
        try:
            checked, reason = command("check", "case.toml", "--quiet")
            report = "--report" if len(content) % 2 else "--no-report"
            ran, said = command(
                "run",
                "case.toml",
                "--quiet",
                "--workers",
                "1",
                "--limit",
                MAX_TIME,
                "--output",
                "out",
                report,
            )
            answer = Path("out", "run.json")
            runs = json.loads(answer.read_text("utf-8"))["runs"] if answer.exists() else []
        finally:
            os.chdir(before)
    if "beyond the bound" in said:
        return "too long"
    if checked == 0 and "names no engine speed" in said:
        return "without a speed"  # a case may leave it to the command line
    if checked not in (0, 2) or ran not in (0, 1, 2):
        raise Finding(f"exit codes {checked} {ran}: {reason[-200:]} {said[-200:]}")
    integrated = ran != 2 and not (runs and all(run["status"]["code"] == "refused" for run in runs))
    # a spring that cannot be compressed to its installed height: `run` shows its curve as far as it
    # goes, with its status
    stuck = checked == 2 and ran == 1 and not runs
    if (checked == 0) != integrated and not stuck:
        raise Finding(f"check gives {checked} ({reason[-250:]}), run gives {ran} ({said[-250:]})")
    return ("completed", "failed in time" if integrated else "refused", "refused")[ran]
