"""Writes the pages and pictures of the documentation that hold what the program computes or prints.

python scripts/write_pages.py readme                   public-names.md: table of spring models; README: its
picture
python scripts/write_pages.py models                   docs/models.md: which model runs which case,
by running all of them
python scripts/write_pages.py tutorial                 docs/tutorial.md: runs its commands and
inserts what they print
python scripts/write_pages.py model-against-test       two pictures from the sample tests
python scripts/write_pages.py how-to-03 how-to-10      pictures of docs/how-to; how-to: all of them,
a minute or two
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import math
import os
import re
import shlex
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import how_to_pictures
import numpy as np
import plotly.graph_objects as go
import sample_test_cycles
from numpy.typing import NDArray
from plotly_pictures import Panel, curve, dots, drawn, save

import valvetrain as vt
from valvetrain import registry
from valvetrain.compare_test.compare import compare_with_test
from valvetrain.errors import InputError
from valvetrain.measured.sensor import Sensor
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.runs.api import compare, simulate, sweep
from valvetrain.solution.atomic import write_text
from valvetrain.solution.study import Study
from valvetrain.springs.spec import spring_model
from valvetrain.system.build import build
from valvetrain.views.results import figure_for_user
from valvetrain.views.style import BAD

ROOT = Path(__file__).resolve().parents[1]
DOCS, PUBLIC_NAMES = ROOT / "docs", ROOT / "docs" / "public-names.md"
PICTURES = DOCS / "pictures"
Array = NDArray[np.float64]


# README


README = ROOT / "README.md"
#: The sweep of the README: what it prints stands between these lines, from its verdict to its first rows.
SPEEDS = "1000:8000:500"
SWEEP, SWEEP_END = f"mine.toml --rpm {SPEEDS}\n```\n\n```text\n", "```\n"
MODELS_HEAD = "| word | model | what it knows | what it leaves out |\n|---|---|---|---|\n"


def models_table() -> str:
    """The spring models that ship, in the order of the registry, as a table of docs/public-names.md."""
    specs = [spring_model(word) for word in registry.names("springs")]
    return MODELS_HEAD + "".join(
        f"| `{one.word}` | {one.label} | {one.knows} | {one.leaves_out} |\n" for one in specs
    )


def write_readme() -> None:
    """The table of spring models; the pictures of the beehive at three speeds and of a sweep, and what the sweep prints."""
    text = PUBLIC_NAMES.read_text(encoding="utf-8")
    write_text(
        PUBLIC_NAMES,
        re.sub(re.escape(MODELS_HEAD) + r"(?:\|.*\n)*", lambda _: models_table(), text),
    )
    vt.simulate("gu2021-beehive").figure("force").write_image(
        str(PICTURES / "beehive-force.svg"), width=900
    )
    with tempfile.TemporaryDirectory() as name, contextlib.chdir(name):
        printed_by("valvetrain new mine --kind pushrod")
        printed = printed_by(f"valvetrain sweep mine.toml --rpm {SPEEDS} --output sweep")
        study = vt.sweep("mine.toml", f"{SPEEDS} rpm")
        study.figure("speeds").write_image(str(PICTURES / "sweep.svg"), width=900)
    head, _, rest = README.read_text(encoding="utf-8").partition(SWEEP)
    answer = printed[printed.index("My pushrod") : printed.index("  page:")]
    write_text(README, f"{head}{SWEEP}{answer}{rest[rest.index(SWEEP_END) :]}")


# docs/models.md


#: The one speed of all runs (rad/s of the crank), low enough that every train settles soon.
ENGINE_SPEED = 2000 * math.pi / 30
COMMANDS = ("run", "compare", "sweep")
NO_LIFT = "the case has no lift law, so nothing moves: `compare` shows statics and modes by every model, `run` by finite elements"
INTRODUCTION = """# Spring models and shipped cases

Which spring model runs which shipped case under `valvetrain run`, `compare` and `sweep`. Written by `scripts/write_pages.py models` from
real runs at one engine speed with coarse meshes; a test runs them again and compares. A letter refers to a reason below the table.
"""
AFTER = """
Every model also runs from a program (`valvetrain.simulate`, `compare`, `sweep`) and in a case of one's own, with the same reasons
where it cannot. Without a named model a spring alone runs by `finite-element` and `modal-varied` where its wire is known, by
`modal-uniform` from a card with a mass and by `massless` from a card without; a train by `reduced-rod` with wires (by
`multi-mass`, with a sentence, where its rod cannot be reduced) and by `modal-uniform` with cards. What each model knows and leaves out:
"""


def coarse(case: Case) -> Case:
    """The case with few elements per coil and one cam turn of prescribed motion, which changes
    numbers and not what can run.
    """

    def few(springs: tuple[InstalledSpring, ...]) -> tuple[InstalledSpring, ...]:
        return tuple(
            spring.with_options("finite-element", elements_per_coil=6) for spring in springs
        )

    train = case.train
    if train is not None:
        train = train.replace(
            springs={name: few(springs) for name, springs in train.springs.items()}, variants=()
        )
    return replace(
        case, springs=few(case.springs), train=train, operation=replace(case.operation, cycles=1)
    )


def outcomes(case: Case) -> dict[tuple[str, str], str]:
    """(model word, command) -> empty where it ran, else the reason in a sentence."""
    words = registry.names("springs")
    found: dict[tuple[str, str], str] = {}
    long = [word for word in words if spring_model(word).alone]
    for command in COMMANDS:
        moving = [word for word in words if word not in long]
        found |= {(word, command): reason for word, reason in _command(case, command, moving)}
        found |= {(word, command): _without_running(case, command, word, moving) for word in long}
    return found


def _without_running(case: Case, command: str, word: str, moving: list[str]) -> str:
    """Reason of a model that takes minutes: it is built and not run; tests of their own run it."""
    try:
        if case.train is not None and command == "compare":
            _study(case, command, [ENGINE_SPEED], [*moving[:1], word])
        else:
            for member in build(case, spring_models=[word]).members:
                member.system()
    except InputError as error:
        return str(error)
    return NO_LIFT if case.lift_law is None and command != "compare" else ""


def _command(case: Case, command: str, words: list[str]) -> Iterator[tuple[str, str]]:
    """Word and reason of each model under one command."""
    speeds = [ENGINE_SPEED] if case.lift_law is not None else []
    try:
        study = _study(case, command, speeds, words)
    except InputError as error:
        yield from ((word, str(error)) for word in words)
        return
    for word in words:
        runs = [run for run in study.solutions if run.model == word]
        if runs:
            run = runs[0]
            yield word, "" if run.status.completed else run.status.message
        else:
            yield word, "" if word in {one.model for one in study.rest} else NO_LIFT


def _study(case: Case, command: str, speeds: list[float], words: list[str]) -> Study:
    if command == "run":
        return simulate(case, engine_speeds=speeds, models=words, workers=1)
    if command == "compare":
        return compare(case, engine_speeds=speeds, models=words, workers=1)
    return sweep(case, speeds or [ENGINE_SPEED], models=words, workers=1, critical_speeds=False)


def models_text(found: dict[str, dict[tuple[str, str], str]]) -> str:
    """The page of what was found per case."""
    words = registry.names("springs")
    notes: dict[str, str] = {}

    def letter(reason: str) -> str:
        return f"({notes.setdefault(reason, chr(ord('a') + len(notes)))})"

    rows = []
    for name, outcome in found.items():
        cells = []
        for word in words:
            said = {command: outcome[word, command] for command in COMMANDS}
            ran = [command for command in COMMANDS if not said[command]]
            reasons = dict.fromkeys(_plain(reason) for reason in said.values() if reason)
            text = "all" if len(ran) == len(COMMANDS) else ", ".join(ran)
            cells.append(
                " ".join(part for part in (text, *(letter(reason) for reason in reasons)) if part)
            )
        rows.append(f"| `{name}` | {' | '.join(cells)} |")
    head = f"| case | {' | '.join(f'`{word}`' for word in words)} |\n|---|{'---|' * len(words)}\n"
    below = "".join(
        f"\n- ({mark}) {reason[0].upper()}{reason[1:]}." for reason, mark in notes.items()
    )
    return (
        f"{INTRODUCTION}\n`all`: all three commands.\n\n{head}"
        + "\n".join(rows)
        + f"\n{below}\n{AFTER}\n{_knowledge()}"
    )


def _plain(reason: str) -> str:
    """A reason without the names of one case."""
    if "holds no lift law" in reason or "does not move" in reason:
        return NO_LIFT
    if "is a train; leave solid out" in reason:
        return "solids follow a train by run and sweep, and are not compared there"
    return reason.split("is known by its card only; ")[-1].removeprefix("--model: ").rstrip(".")


def _knowledge() -> str:
    specs = [spring_model(word) for word in registry.names("springs")]
    rows = "".join(f"| `{spec.word}` | {spec.knows} | {spec.leaves_out} |\n" for spec in specs)
    return f"| model | knows | leaves out |\n|---|---|---|\n{rows}"


def models_page() -> str:
    """docs/models.md from real runs."""
    return models_text(
        {summary.name: outcomes(coarse(vt.load_case(summary.name))) for summary in vt.list_cases()}
    )


# docs/tutorial.md


#: A command with what it prints, or an addition to the case file.
STEP = re.compile(
    r"^```bash\n(?P<command>.*?)^```\n\n```text\n(?P<printed>.*?)^```$|^```toml\n(?P<added>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)


def printed_by(command: str) -> str:
    """What a command prints on a terminal of 88 columns. Raises RuntimeError where it fails."""
    from typer.testing import CliRunner

    from valvetrain.cli.main import app

    done = CliRunner(env={"COLUMNS": "88"}).invoke(
        app, shlex.split(command)[1:], prog_name="valvetrain"
    )
    if done.exit_code:
        raise RuntimeError(f"{command}\n{done.output}")
    return "\n".join(line.rstrip() for line in done.stdout.strip("\n").splitlines()) + "\n"


def run_page(
    text: str, wanted: Callable[[str], bool] = lambda command: True
) -> Iterator[tuple[re.Match[str], str]]:
    """Each command of the page that is ``wanted``, with what it prints, in this folder."""
    for step in STEP.finditer(text):
        if step["added"]:
            file = Path("my-train.toml")
            file.write_text(
                f"{file.read_text(encoding='utf-8')}\n{step['added']}", encoding="utf-8"
            )
        elif wanted(step["command"]):
            yield step, printed_by(step["command"])


def tutorial_pictures(folder: Path) -> dict[str, go.Figure]:
    """Name -> the three pictures, from what the commands wrote."""
    # the rod to which the spring is fitted: the chain is 3 % stiffer over closing coils
    spring = vt.load_case(folder / "spring" / "spring.toml").springs[0]
    rest = vt.static_curve(spring, "25 mm", models="finite-element")
    assert spring.wire is not None
    height = 1e3 * (spring.wire.free_length - rest.compression)
    loads = dots(np.array([1.8, 1.2]) * 25.4, np.array([140.0, 375.0]) * 4.4482216, "card", BAD)
    force = Panel("height, mm", "force, N", [curve(height, rest.force, "spring"), loads])

    run = vt.solution.load_netcdf(next((folder / "run").glob("*.nc")))
    angle = np.degrees(run.cam_angle - run.cam_angle[0])
    turn = [
        Panel("cam angle, deg", label, [curve(angle, scale * run.channel(name))], x_range=(0, 360))
        for label, name, scale in (
            ("valve lift, mm", "valve_lift", 1e3),
            ("force on the cam, N", "cam_contact_force", 1.0),
        )
    ]
    speeds, least, above_rigid = swept(folder / "sweep" / "sweep-mine.csv")
    over = [
        Panel("engine speed, rpm", label, [curve(speeds, values)])
        for label, values in (
            ("least force on the cam, valve open, N", least),
            ("lift above the rigid lift, mm", above_rigid),
        )
    ]
    return {
        "tutorial-spring": drawn("The spring of the card", [force]),
        "tutorial-run": drawn("The train at 6000 rpm", turn),
        "tutorial-sweep": drawn("The train over engine speed", over),
    }


def swept(file: Path) -> tuple[Array, Array, Array]:
    """Engine speeds (rpm), least force on the cam with the valve open (N) and lift above the rigid
    one (mm) from the table of a sweep.
    """
    with file.open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    names = (
        "engine speed [rpm]",
        "minimum cam contact force while open [N]",
        "lift above the rigid lift [mm]",
    )
    first, second, third = (np.array([float(row[name]) for row in rows]) for name in names)
    return first, second, third


def write_tutorial() -> None:
    """Run the page, then write it and its pictures."""
    page = DOCS / "tutorial.md"
    text = page.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as name, contextlib.chdir(name):
        os.environ["COLUMNS"] = "88"
        new, end = "", 0
        for step, printed in run_page(text):
            start, stop = step.span("printed")
            new, end = f"{new}{text[end:start]}{printed}", stop
        pictures = tutorial_pictures(Path(name))
    write_text(page, new + text[end:])
    for file, picture in pictures.items():
        save(picture, PICTURES / f"{file}.svg")


# Pictures of docs/model-against-test.md


def write_model_against_test() -> None:
    """Both pictures, from the sample tests."""
    with tempfile.TemporaryDirectory() as folder:
        samples = Path(folder)
        sample_test_cycles.main(samples)
        models = ["finite-element", "multi-mass"]
        force = compare_with_test(
            "job-t",
            samples / "spring-force.csv",
            models=models,
            sensor=Sensor(bandwidth=8e3),
        )
        head = compare_with_test("gu2021-beehive-blind", samples / "engine-head.csv")
    for name, found in (("model-less-test", force), ("engine-head", head)):
        figure_for_user(found).write_image(PICTURES / f"{name}.svg", width=900)


#: Name on the command line -> what writes it.
PAGES: dict[str, Callable[[], object]] = {
    "readme": write_readme,
    "models": lambda: write_text(DOCS / "models.md", models_page()),
    "tutorial": write_tutorial,
    "model-against-test": write_model_against_test,
    "how-to": how_to_pictures.write_all,
    **{
        f"how-to-{number}": partial(how_to_pictures.write, number)
        for number in how_to_pictures.PICTURES
    },
}


def main() -> None:
    """Writes the pages named on the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("pages", nargs="+", choices=PAGES, metavar="PAGE", help=", ".join(PAGES))
    for name in parser.parse_args().pages:
        PAGES[name]()
        print(f"wrote {name}")


if __name__ == "__main__":
    main()
