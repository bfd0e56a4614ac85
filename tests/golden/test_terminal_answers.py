"""Golden: every line, space and empty line that the commands print about made-up studies, as
written in ``answers/``.

``python tests/golden/test_terminal_answers.py`` writes the files anew; read the difference before
it is kept. What the lines have to
say is held to the made-up numbers by ``tests/unit/test_every_terminal_line.py``; here nothing may
be lost, broken or moved.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))

import typer
from rich.console import Console

from known_figures import STUDIES
from synthetic_study import own_study, published_study, record, rod_run, sweep_study, train_run
from unit.cli_parts import call
from unit.test_every_table import COMPARED
from valvetrain.cli import modes, refine, runs, static
from valvetrain.cli import runs as compare_runs
from valvetrain.cli.answers import show_study
from valvetrain.cli.main import app
from valvetrain.runs.differences import ResultDifference
from valvetrain.runs.error_bars import Uncertainty, UncertaintyStudy
from valvetrain.runs.saved_runs import SavedRun
from valvetrain.solution.modes import TrainModes
from valvetrain.solution.static import RestPoint

ANSWERS = Path(__file__).parent / "answers"
RPM = np.pi / 30
LONG = (
    Path("a folder with a rather long name")
    / "that goes on for more than a hundred characters"
    / "before it ends"
)


def printed(show: Callable[[Console], Any], width: int = 100) -> str:
    console = Console(
        file=StringIO(), width=width, highlight=False, markup=False, emoji=False, no_color=True
    )
    show(console)
    return console.file.getvalue()


def studies() -> str:
    """Runs side by side, below each other, over speeds, of a train, and beside published values in
    brief and in full.
    """
    many = [
        replace(
            rod_run(), provenance=replace(rod_run().provenance, engine_speed=(1000 + 10 * n) * RPM)
        )
        for n in range(27)
    ]
    trains = [
        train_run(
            (1000 + 10 * n) * RPM,
            label="stock with a name that leaves so little room for numbers that most have to go below",
        )
        for n in range(13)
    ]
    told = replace(published_study(), comparisons=COMPARED)
    shown = [
        (STUDIES["own"](), {}), (STUDIES["train"](), {}), (STUDIES["sweep"](), {}), (sweep_study(), {}), (told, {}),
        (told, {"published": True}), (replace(own_study(()), notes=("Mind the gap.", "And the step.")), {}),
        *((replace(own_study(tuple(many[:count])), rest=()), {}) for count in (4, 5, 27)),
        *((replace(STUDIES["train"](), solutions=tuple(trains[:count])), {}) for count in (12, 13)),
    ]  # fmt: skip
    return "\n====\n".join(
        printed(
            lambda console, one=one, more=more: show_study(
                console, one, LONG, LONG / "report.html", **more
            )
        )
        for one, more in shown
    )


def shapes() -> str:
    study, mass = own_study(()), own_study(()).rest[0].modes
    heavier = tuple(
        replace(study.rest[0], modes=replace(mass, attached_mass=kilograms))
        for kilograms in (0.05, 0.0)
    )
    silent = replace(study.rest[1], modes=None)
    train = TrainModes(
        "stock, multi-mass",
        "open",
        1.7,
        9e-3,
        np.array([0.0, 431.25, 1200.0]),
        ("valve", "lever"),
        ("valve", "lever", "spring"),
        np.array([[1, 0.2], [0.3, 1], [0, 0]]),
        np.array([[0.6, 0.3, 0.1], [0.2, 0.8, 0.0], [0.1, 0.1, 0.8]]),
        ("cam",),
        ("seat", "rocker"),
    )
    closed = replace(train, state="at rest", open=())
    text = printed(
        lambda console: modes._show(console, replace(study, rest=(*study.rest, *heavier, silent)))
    )
    text += printed(
        lambda console: (
            modes._show_train(console, train, 2),
            modes._show_train(console, closed, 24),
        ),
        60,
    )
    return text + printed(lambda console: modes._show(console, study), 40)


def curves() -> str:
    rod, chain = own_study(()).rest
    points = (
        RestPoint(7e-3, 287.0, 41e3, 35e-3, 301e6, 311e6, 401e6, 0.12, 0.34, 5.6, 0.01), RestPoint(9e-3, 369.0, 41e3),
    )  # fmt: skip
    told = replace(
        rod.curve,
        status=replace(
            rod.curve.status,
            message="solid from 17 mm on, as the sentence goes that must not be broken",
        ),
    )
    rest = (
        replace(rod, points=points),
        replace(chain, points=points[1:]),
        replace(chain, curve=told),
    )
    study = replace(
        own_study(()),
        rest=rest,
        still={"a": {"preload": 287.0, "coil_bind_lift": 10.25e-3}, "b": {}, "c": {}},
    )
    return printed(
        lambda console: static._show(console, study, LONG / "curve.csv")
    ) + static.curve_text(study)


def kept() -> str:
    def run(place: int, value: float | None, **more: Any) -> SavedRun:
        quantities = {} if value is None else {"peak_spring_force": {"value": value, "unit": "N"}}
        choices = {
            "spring_models": ["finite-element", "modal-varied", "massless"][: place % 4],
            "engine_speeds": [[], [4200.0], [1000.0, 1100.0, 9000.0]][place % 3],
        }
        answer = {
            "created_at": f"2026-03-{place + 1:02d}T10:{place:02d}:00",
            "case": "own",
            "digest": f"{place:08x}",
            "command": "run",
            "choices": choices,
            "completed": place != 4,
            "quantities": quantities,
        }
        return SavedRun(LONG / str(place), answer | more)

    one = tuple(run(place, 800.0 + place) for place in range(18))
    mixed = (
        run(0, None, quantities={"preload": {"value": 287.0, "unit": "N"}}),
        run(1, 801.0),
        run(2, None),
    )
    texts = [
        printed(lambda console, found=found: runs._show(console, found, LONG))
        for found in (one, mixed, ())
    ]
    inputs = tuple((f"spring.key_{n}", n, ["a", n] if n % 2 else None) for n in range(32))
    inputs = (("spring.long", "x" * 61, "y" * 60), *inputs)
    results = (
        ResultDifference("clash_energy", "own at 4200 rpm", "J", 0.01, 0.02),
        ResultDifference("peak_spring_force", "own", "N", 800.0, 820.0),
        ResultDifference("seating_velocity", "own", "m/s", None, 0.4), ResultDifference("preload", "", "N", 0.0, 1.0),
        *(ResultDifference(f"mode_{n}_frequency", "", "Hz", 600.0, 601.0) for n in range(1, 35)),
    )  # fmt: skip
    pair = one[:2]
    for changed in ((inputs, results), (inputs[:1], ()), ((), results[2:3]), ((), results[:1])):
        texts.append(
            printed(
                lambda console, changed=changed: compare_runs._show_compare_runs(
                    console, pair, *changed
                )
            )
        )
    return "\n====\n".join(texts)


def error_bars() -> str:
    rows = (
        Uncertainty("preload", None, 287.0, 1.5, 2.1, 286.0, 0.0, (287.0, 287.0), (280.0, 290.0)),
        Uncertainty(
            "peak_spring_force",
            5600 * RPM,
            811.0,
            12.0,
            None,
            805.0,
            3.0,
            (801.0, 822.0),
            (790.0, 834.0),
        ),
        Uncertainty(
            "main_clash_cam_angle", 5600 * RPM, 4.3, 0.01, 0.4, 4.4, 0.005, (4.2, 4.4), (4.1, 4.5)
        ),
        Uncertainty(
            "peak_spring_force",
            4200 * RPM,
            711.0,
            11.0,
            0.5,
            705.0,
            2.0,
            (701.0, 722.0),
            (690.0, 734.0),
            "stock",
        ),
    )
    study = UncertaintyStudy(record(), (12, 24, 48), rows, {})
    page = str(LONG / "report.html")
    return printed(
        lambda console: (
            refine._show(console, study, page),
            refine._show(console, replace(study, elements_per_coil=()), page),
        )
    )


def understood() -> str:
    """What ``check`` and ``cases`` say of what ships with the package."""
    return "\n====\n".join(
        call(*words).stdout
        for words in (
            ("cases",),
            ("check", "uniform-spring"),
            ("check", "vaz-ohc"),
            ("check", "job-t"),
        )
    )


def options() -> str:
    """Every option of every command: its names, what it is where it is left out, how often it may
    be given.
    """
    lines = []
    for name, command in sorted(typer.main.get_command(app).commands.items()):
        for option in command.params:
            default = option.default() if callable(option.default) else option.default
            many = " several" if getattr(option, "multiple", False) else ""
            lines.append(
                f"{name} {' '.join(option.opts)}: {default!r}{' needed' if option.required else ''}{many}"
            )
    return "\n".join(lines) + "\n"


TOLD = {
    one.__name__: one for one in (studies, shapes, curves, kept, error_bars, understood, options)
}


@pytest.mark.parametrize("name", TOLD)
def test_the_terminal_says_what_it_said(name):
    assert TOLD[name]() == (ANSWERS / f"{name}.txt").read_text(encoding="utf-8")


if __name__ == "__main__":
    for name, made in TOLD.items():
        (ANSWERS / f"{name}.txt").write_text(made(), encoding="utf-8")
