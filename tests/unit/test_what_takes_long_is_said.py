"""A search, a study and an identification say before they begin how much they will do where it
takes long, nothing where it does not.
"""

from __future__ import annotations

import re
from types import SimpleNamespace

import pytest

from unit.cli_parts import call
from unit.test_identification_answer import CARD, FILE
from unit.test_optimise_command import LIGHT
from valvetrain.cli import outcome as limits
from valvetrain.cli.run_answer import say_sweep_time
from valvetrain.explore import identify_command as identify
from valvetrain.runs import measured_cost

STUDY = """
case = "card.toml"
spring_models = ["massless"]
outputs = ["preload"]
points = { sampler = "grid", levels = 3 }
[[vary]]
key = "spring.rate"
low = "30 N/mm"
high = "34 N/mm"
"""
SAID = {
    "optimise": r"\d+ trials, .*about .* at most; finished points are stored in '.*out/points.*'",
    "study": r"3 points, about .*; finished ones are stored in '.*out/points.*'",
    "identify": r"this will take about .* \(\d+ points of .* ms\)",
}


@pytest.mark.parametrize("command", SAID)
@pytest.mark.parametrize("worth", [0.0, 1e9])
def test_what_takes_long_is_said_first(command, worth, tmp_path, monkeypatch):
    monkeypatch.setattr(limits, "WORTH_SAYING", worth)
    monkeypatch.setattr(identify, "WORTH_SAYING", worth)
    (tmp_path / "card.toml").write_text(CARD)
    (tmp_path / "asked.toml").write_text(
        {"optimise": LIGHT, "study": STUDY, "identify": FILE}[command]
    )
    answer = call(
        command, str(tmp_path / "asked.toml"), "--workers", "1", "--output", str(tmp_path / "out")
    )
    lines = [
        line for line in answer.stderr.splitlines() if not line.startswith("compiling kernels")
    ]
    assert answer.exit_code == 0
    if worth:
        assert not lines
    else:
        assert len(lines) == 1 and re.fullmatch(SAID[command], lines[0]), lines


def test_the_time_of_a_sweep_is_called_processor_time(monkeypatch, capsys):
    """Contract: 71 s stood before a sweep that took 6 minutes on a busy machine."""
    monkeypatch.setattr(measured_cost, "sweep_seconds", lambda *_, **__: 90.0)
    case = SimpleNamespace(train="any")
    say_sweep_time(SimpleNamespace(case=case, engine_speeds=(300.0,), spring_models=(), spring_sets=(), workers=2))  # fmt: skip
    said = " ".join(capsys.readouterr().err.split())
    assert said.startswith("this will take about 1.5 min of processor time on each of 2 cores, by ")
