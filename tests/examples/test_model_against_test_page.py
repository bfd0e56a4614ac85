"""Examples: the commands of docs/model-against-test.md run as they stand on the sample tests, and
say what the page says.
"""

from __future__ import annotations

import json
import re
import runpy
import shlex
from functools import cache
from pathlib import Path

import pytest
from api_pages import PUBLIC

from unit.cli_parts import call
from valvetrain.measured.cycles import write_cycles

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "model-against-test.md").read_text(encoding="utf-8")
COMMANDS = [line.strip() for line in PAGE.splitlines() if line.startswith("    valvetrain ")]


@cache
def samples(folder: Path) -> Path:
    """What the script writes, but for the second table of coils, whose commands differ from those
    of the first in a number.
    """
    script = runpy.run_path(str(ROOT / "scripts" / "sample_test_cycles.py"))
    folder.mkdir()
    write_cycles(folder / "spring-force.csv", script["force_cycles"]())
    (folder / "coils-lash-0.csv").write_text(script["coil_table"]("0 mm", 11), encoding="utf-8")
    (folder / "engine-head.csv").write_text(script["engine_head_table"](), encoding="utf-8")
    return folder


@pytest.mark.parametrize(
    ("number", "numbers"),
    [
        (0, {"finite-element": "1.21", "multi-mass": "11.8"}),
        (1, {"finite-element": "534", "modal-varied": "681"}),
        (2, {"wave-rod": "33.2", "multi-mass": "35.1"}),
    ],
)
def test_the_commands_of_the_page_say_what_it_says(tmp_path_factory, monkeypatch, number, numbers):
    monkeypatch.chdir(samples(tmp_path_factory.getbasetemp() / "tests-of-the-page"))
    assert len(COMMANDS) == 4
    shown = call(*shlex.split(COMMANDS[number])[1:], "--json")
    assert shown.exit_code == 0, shown.output
    ratios = {
        run["label"]: f"{run['f_test']['ratio']:.3g}" for run in json.loads(shown.stdout)["runs"]
    }
    for model, ratio in numbers.items():
        assert any(label.startswith(model) and one == ratio for label, one in ratios.items()), (
            ratios
        )
        assert ratio in PAGE


def test_every_name_of_the_page_exists():
    names = re.search(r"From Python: (.*?)\.\n", PAGE, re.DOTALL)
    assert names and set(re.findall(r"`(\w+)`", names[1])) <= set(PUBLIC)
