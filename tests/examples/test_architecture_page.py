"""The architecture page's table of channels names every channel that a run has, and no channel
twice.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import valvetrain as vt

PAGE = (Path(__file__).parents[2] / "docs" / "architecture.md").read_text(encoding="utf-8")
TABLE = PAGE[PAGE.index("## Channels") :]
NAMES = re.findall(r"`([a-z_<>]+)`", TABLE[TABLE.index("|") :])
PLACES = {
    "place": "(cam|tappet|rocker|valve_tip|seat)", "link": "(stem|support|pushrod_bar)", "joint": "lever_bending",
    "body": "(tappet|pushrod|pushrod_top|lever|lever_tip|support|valve_tip)",
}  # fmt: skip
KNOWN = [re.compile(re.sub(r"<(\w+)>", lambda match: PLACES[match[1]], name)) for name in NAMES]


@pytest.mark.parametrize(
    ("case", "engine_speed", "models"),
    [
        ("job-c", "3000 rpm", ("finite-element", "modal-varied")),
        ("job-t", "3000 rpm", ("multi-mass",)),
        ("vaz-ohc", None, ("multi-mass",)),
        ("tdi-pushrod", None, ("wave-rod",)),
    ],
)
def test_every_channel_stands_in_the_table(case, engine_speed, models):
    for run in vt.simulate(case, engine_speed, models=models, workers=1).solutions:
        plain = {re.sub(r"^(outer|inner)_(?!fibre)", "", str(name)) for name in run.channels}
        assert not {name for name in plain if not any(known.fullmatch(name) for known in KNOWN)}


def test_no_channel_stands_twice():
    assert len(set(NAMES)) == len(NAMES)
