"""Every command that writes a folder, with inputs that it answers in a second or two."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from sample_film import Scene, decaying, draw, write_frames
from sample_measurements import stations_of_lobe
from sample_rig import WRITERS, Rig, record
from sample_scan import Scanner, cloud, ply, springs
from sample_test_cycles import force_cycles

from unit.cli_parts import SMALL

#: A grid of three points.
STUDY = """
case = "small.toml"
engine_speeds = "9000 rpm"
spring_models = ["massless"]
outputs = ["peak_spring_force"]
points = { sampler = "grid", levels = 3 }
vary = [{ key = "spring.precompression", low = "2 mm", high = "3 mm" }]
"""
#: A search by sizes alone.
SEARCH = """
title = "Lightest"
case = "job-c"
objective = [{ quantity = "wire_mass", direction = "minimise" }]
constraint = [{ quantity = "estimated_rate", at_least = "1.1 x case" }]
vary = [{ key = "spring.wire_diameter", low = "3 mm", high = "4.6 mm", label = "wire" }]
search = { trials = 6, per_round = 3 }
"""
#: The wire of a spring from its load.
IDENTIFICATION = """
title = "Wire of a small spring"
case = "small.toml"
search = { draws = 20 }
[quantities.wire_diameter]
key = "spring.wire_diameter"
prior = "uniform"
low = "3.6 mm"
high = "4.0 mm"
[measurements.loads]
heights = "18, 16 mm"
forces = "170, 400 N"
scatter = "3 %"
spring_model = "massless"
"""
CARD = (
    "--outer-diameter",
    "29 mm",
    "--wire-diameter",
    "3.8 mm",
    "--installed",
    "36 mm, 250 N",
    "--open-load",
    "27 mm, 538 N",
)
FILM = ("--frame-rate", "2000 1/s", "--line", "6, 10, 6, 239", "--scale", "4, 0, 4, 120, 20 mm")
MODELS = ("--model", "massless,multi-mass", "--workers", "1")
PLAIN = ("--no-report", "--workers", "1", "--model")
TRAIN = ("tdi-pushrod", "--spring-set", "stock", "--no-report", "--model", "massless")
#: Words of each command; the folder of its results is "out".
COMMANDS: dict[str, tuple[str, ...]] = {
    "run": ("run", "small.toml", *MODELS),
    "compare": ("compare", "small.toml", "--rpm", "6000, 9000 rpm", "--no-report", *MODELS),
    "sweep": ("sweep", *TRAIN, "--rpm", "1000:4000:500 rpm", "--no-critical-speeds", "--workers", "2"),
    "compare-springs": ("compare-springs", "job-c", "job-t", "--train", "tdi-pushrod", "--rpm", "2000 rpm", "--model", "massless"),
    "run-up": ("run-up", *TRAIN, "--from", "1000 rpm", "--to", "1500 rpm", "--duration", "0.2 s"),
    "branches": ("branches", "tdi-pushrod", "--model", "massless", "--rpm", "1000:1500:500 rpm"),
    "static": ("static", "small.toml", "--model", "massless,multi-mass"),
    "modes": ("modes", "small.toml", "--model", "multi-mass"),
    "refine": ("refine", "small.toml", "--set", "spring.options.finite-element.elements_per_coil=8", "--workers", "1"),
    "compare-test": ("compare-test", "job-t", "--test", "cycles.csv", "--model", "massless"),
    "lift": ("lift", "lobe.csv"),
    "spring-card": ("spring-card", *CARD),
    "scan": ("scan", "scan.ply"),
    "film": ("film", "film", "--free-decay", "--synthetic", *FILM),
    "rig": ("rig", "rig.csv", "--angle-of", "crank", "--encoder", "Crank angle", "--zero", "spring_force=215 N"),
    "study": ("study", "study.toml", "--workers", "1"),
    "optimise": ("optimise", "search.toml", "--workers", "1"),
    "identify": ("identify", "identify.toml", "--workers", "1"),
}  # fmt: skip
#: A command that ends by SIGKILL behind its N-th file (the first word; 0: never), and notes each file
#: and each run that it holds for finished.
OBSERVED = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.SIG_DFL)  # as valvetrain/__main__.py, while the package loads
last, usual, folder = int(sys.argv.pop(1)), os.replace, os.path.abspath("out")
written = []
def note(text):
    with open("noted.log", "a") as log:
        log.write(text + "\\n")
def replace(source, target, **more):
    usual(source, target, **more)
    if os.path.abspath(target).startswith(folder):
        written.append(target)
        note(f"file|{target}")
        if len(written) == last:
            os.kill(os.getpid(), signal.SIGKILL)
os.replace = replace
from valvetrain.views.files import UnfinishedRun
add = UnfinishedRun.add
def added(self, place, solution):
    add(self, place, solution)
    note(f"run|{solution.label}|{solution.engine_speed * 30 / 3.141592653589793:.6f}")
UnfinishedRun.add = added
from valvetrain.cli.main import main
main()
"""


def words(command: str) -> tuple[str, ...]:
    """The words of a command with the folder of its results."""
    return (*COMMANDS[command], "--output", "out", "--quiet")


def write_inputs(folder: Path) -> Path:
    """Write the files that the commands read; the folder."""
    from valvetrain.measured.cycles import write_cycles

    folder.mkdir(parents=True, exist_ok=True)
    texts = {"small.toml": SMALL, "study.toml": STUDY, "search.toml": SEARCH, "identify.toml": IDENTIFICATION}  # fmt: skip
    for name, text in texts.items():
        (folder / name).write_text(text)
    write_cycles(folder / "cycles.csv", force_cycles(6, 180))
    rows = "\n".join(f"{angle},{lift}" for angle, lift in stations_of_lobe())
    (folder / "lobe.csv").write_text(f"cam angle [deg],valve lift [in]\n{rows}\n")
    points, _ = cloud(springs()["conical"], 3000, Scanner(noise=0.03e-3, seed=4))
    (folder / "scan.ply").write_bytes(ply(points))
    share = np.linspace(0, 1, 6)
    film, _ = draw(Scene(columns=10), decaying(2.0 + 32.0 * share, share, (1.2, 0.4), 412.0, 0.015), 120)  # fmt: skip
    write_frames(folder / "film", film)

    def lift(angle: Any) -> Any:
        return 10e-3 * np.maximum(1 - (np.asarray(angle) % (2 * np.pi) - np.pi) ** 2, 0) ** 3

    rig = record(Rig(cycles=4, slipped=3, sampling_rate=20e3), lift, lambda at: 215 + 26e3 * lift(at))  # fmt: skip
    for name in ("rig.csv", "rig.tdms", "rig.mat"):
        WRITERS[name](folder / name, rig)
    return folder


def noted(folder: Path) -> tuple[list[str], list[tuple[str, str]]]:
    """Files that a command wrote, and label and speed of the runs that it held for finished."""
    try:
        rows = [line.split("|") for line in (folder / "noted.log").read_text("utf-8").splitlines()]
    except OSError:
        return [], []
    runs = [(label, speed) for kind, label, *rest in rows if kind == "run" for speed in rest]
    return [row[1] for row in rows if row[0] == "file"], runs


def answer_in(folder: Path) -> dict[str, Any]:
    """The answer in a folder of results; empty where there is none."""
    for name in ("run.json", "study.json", "optimise.json", "identify.json"):
        if (folder / name).is_file():
            answer: dict[str, Any] = json.loads((folder / name).read_text("utf-8"))
            return answer
    return {}
