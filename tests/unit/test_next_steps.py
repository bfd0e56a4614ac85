"""Unit: what a command says to run next can be pasted: it stands on one line, and the command line takes it."""

from __future__ import annotations

import io
import shlex

import pytest
from rich.console import Console
from typer.main import get_command

import valvetrain as vt
from valvetrain.cli.main import app
from valvetrain.findings.table import every_rule
from valvetrain.findings.words import Words, fields_of
from valvetrain.views.answer import Answer
from valvetrain.views.terminal import screen

#: Fields of steps -> what a result puts there.
FIELDS = {
    "case": "engine.toml", "stem": "engine", "round": "6730", "better": "finite-element", "next": "sweep", "model": "wave-rod", "file": "test.csv",
    "test": "test.csv", "shared": "spring.damping", "ratio": "0.02", "value": "400 Hz", "speed": "6600 rpm", "command": "run",
    "remedy": "", "message": "", "pair": "runs/a runs/b", "step": "", "again": "lobe.dat --draws 8", "template": "pushrod",
    "speeds": " --rpm 6600rpm", "beyond": "7000:8000:250", "first": "6500", "red": "6800", "reach": "3000-6800 rpm", "set": "stock",
    "march": "7000:7500:10 rpm",
}  # fmt: skip
STEPS = sorted(
    {rule.step for rule in every_rule() if rule.step.strip("[").startswith("valvetrain ")}
)


@pytest.mark.parametrize("step", STEPS)
def test_the_command_line_takes_every_next_step(step):
    assert set(fields_of(step)) <= set(FIELDS)
    for line in Words().fill(step, FIELDS).split("&&"):
        name, *options = shlex.split(line)[1:]
        command = get_command(app).get_command(None, name)  # type: ignore[union-attr]
        command.make_context(name, options).close()


def test_a_next_step_stands_on_one_line_of_any_terminal():
    study = vt.simulate("job-t", "2000 rpm", models=["massless"], workers=1)
    answer = Answer(study, Words(case="a/folder/in/a/folder/with/a/long/name/engine.toml"))
    printed = io.StringIO()
    Console(width=40, file=printed).print(screen(answer, "page.html"), crop=False)
    lines = printed.getvalue().splitlines()
    assert len(answer.next_step) > 40 and any(
        line.rstrip().endswith(answer.next_step) for line in lines
    )
