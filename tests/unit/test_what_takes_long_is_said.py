"""A search, a study and an identification say before they begin how much they will do where it
takes long, nothing where it does not.
"""

from __future__ import annotations

import re

import pytest

from unit.cli_parts import call
from unit.test_identification_answer import CARD, FILE
from unit.test_optimise_command import LIGHT
from valvetrain.cli import outcome as limits
from valvetrain.explore import identify_command as identify

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
