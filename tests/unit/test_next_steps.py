"""Unit: what a command says to run next can be pasted: it stands on one line, and the command line takes it."""

from __future__ import annotations

import io
import shlex

import pytest
from rich.console import Console
from typer.main import get_command

import valvetrain as vt
from valvetrain.cli.main import app
from valvetrain.findings.engine import Finding, Findings
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
    "onward": "run engine.toml", "intake": "--duration '217.5 deg' --lobe-centre '103.75 deg'",
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


@pytest.mark.parametrize(("newton", "said"), [(863e3, "863 kN"), (5.2e-3, "5.2 mN")])
def test_a_verdict_in_capitals_keeps_its_units(newton, said):
    """Contract: a meganewton is no millinewton; numbers and units are read as they are written."""
    study = vt.simulate("job-t", "2000 rpm", models=["massless"], workers=1)
    answer = Answer(study)
    verdict = Finding("C101", "decides", "bad", f"force {said}: too much")
    printed = io.StringIO()
    vars(answer)["findings"] = Findings((verdict,))
    Console(width=80, file=printed).print(screen(answer), crop=False)
    assert f"FORCE {said}" in printed.getvalue()
