"""Commands with options that no other test of theirs gives, on parts of our own whose answers have
a closed form.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from sample_rig import WRITERS, Rig, record

from unit.cli_parts import SMALL, call
from unit.test_identification_answer import CARD
from workbench_parts import SMALL as LIFTED

#: A card of a spring with a nested one, both given by preload, rate and mass alone.
PAIR = """
[[spring]]
name = "outer"
preload = "250 N"
rate = "32 N/mm"
mass = "42 g"
[[spring]]
name = "inner"
preload = "90 N"
rate = "14 N/mm"
mass = "15 g"
[lift_law]
kind = "polynomial"
maximum_lift = "9 mm"
opening_start = "115 deg"
opening_end = "180 deg"
closing_start = "180 deg"
closing_end = "245 deg"
[operation]
engine_speeds = "4000, 5000 rpm"
"""
PEAK_LIFT = 10e-3


def lift(angle: np.ndarray) -> np.ndarray:
    """``(1 - x^2)^3`` of a lift of 10 mm, x in radians from its peak."""
    x = np.asarray(angle) % (2 * np.pi) - np.pi
    return PEAK_LIFT * np.clip(1 - x**2, 0, None) ** 3


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Cases, tables and a recording that all commands read."""
    folder = tmp_path_factory.mktemp("options")
    heights = np.linspace(50.0, 33.5, 31)
    forces = 40.0 * (55.0 - heights) + np.where(heights < 34.0, 400.0 * (34.0 - heights), 0.0)
    rows = zip(heights, forces + 0.8 * np.sin(7 * heights), strict=True)
    angles = np.arange(0.0, 360.0, 3.0)
    lobe = zip(angles, 1e3 * lift(np.radians(angles)), strict=True)
    lead = LIFTED + CARD.partition("[spring]")[0]
    texts = {
        "small.toml": SMALL, "pair.toml": PAIR,
        "lifted.toml": lead.replace('title = "card"\n', ""),
        "tester.csv": "height [mm]; force [N]\n" + "".join(f"{a:.4f};{b:.3f}\n" for a, b in rows),
        "lobe.csv": "cam angle [deg];valve lift [mm]\n" + "".join(f"{a:g};{b:.4f}\n" for a, b in lobe),
    }  # fmt: skip
    for name, text in texts.items():
        (folder / name).write_text(text)
    rig = Rig(cycles=8, sampling_rate=20e3, missing=2)
    WRITERS["rig.csv"](folder / "rig.csv", record(rig, lift, lambda at: 215 + 26e3 * lift(at)))
    return folder


@pytest.fixture
def answer(folder, tmp_path, monkeypatch):
    """Runs a command that has to end well; its standard output."""
    monkeypatch.chdir(folder)

    def run(*words: str) -> str:
        output = () if words[0] in ("check",) else ("--output", str(tmp_path / "out"))
        done = call(*words, *output)
        assert done.exit_code == 0, done.output
        return done.stdout

    return run


def value(text: str, name: str) -> float:
    """The first number of the line that begins with ``name``."""
    (line,) = re.findall(rf"^ *{re.escape(name)} +(.*)$", text, re.MULTILINE)
    return float(re.findall(r"[\d.]+", line)[0])


ENCODER = ("--angle-of", "crank", "--encoder", "Crank angle")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--angle-of", "crank", "--pulses", "Crank wheel", "--teeth", "60", "--missing", "2"), {"cycles": 8}),
        (("--angle-of", "cam", "--once", "Cam pulse", "--dwell", "-60, 60 deg", "--band", "2 kHz"), {"cycles": 8, "angles": 360}),
        ((*ENCODER, "--span", "0.05, 0.28 s", "--angle-count", "720"), {"cycles": 4, "angles": 720}),
        ((*ENCODER, "--case", "lifted.toml", "--keep-outliers"), {"cycles": 8, "outliers": []}),
        ((*ENCODER, "--offset", "12.5 deg"), {"cycles": 8}),
    ],
)  # fmt: skip
def test_a_recording_gives_the_lift_that_was_recorded(answer, words, expected):
    found = json.loads(answer("rig", "rig.csv", *words, "--json"))
    assert expected.items() <= found.items()
    assert found["quantities"]["largest_valve_lift"]["value"] == pytest.approx(PEAK_LIFT, rel=2e-3)


def test_nested_springs_of_a_card_add_up(answer):
    words = ("--model", "massless", "--json", "--no-report")
    found = json.loads(answer("run", "pair.toml", *words))
    for run in found["runs"]:
        quantities = run["quantities"]
        assert quantities["peak_spring_force"]["value"] == pytest.approx(340 + 46 * 9, rel=1e-6)
        assert quantities["minimum_spring_force"]["value"] == pytest.approx(340, rel=1e-6)
    rest = json.loads(answer("static", "pair.toml", "--json", "--no-report"))["quantities_by_label"]
    assert [one["preload"]["value"] for one in rest.values()] == pytest.approx([250, 90])


def test_the_resolution_of_critical_speeds_is_that_of_their_scan(answer):
    def runs(resolution: str) -> float:
        words = ("--model", "massless", "--spring-set", "nested", "--resolution", resolution)
        found = answer("sweep", "vaz-ohc", "--rpm", "4000:4400:400 rpm", *words, "--json")
        return sum(row["runs_count"]["value"] for row in json.loads(found)["critical_speeds"])

    assert runs("400 rpm") < runs("50 rpm")


def test_a_measured_lift_moves_the_spring_of_a_case(answer):
    words = ("--model", "massless", "--rpm", "3000 rpm", "--draws", "5")
    text = answer("lift", "lobe.csv", "--case", "lifted.toml", *words)
    assert value(text, "peak spring force below 10 kHz") == pytest.approx(250 + 32 * 10, rel=1e-3)


def test_a_table_of_forces_beyond_coil_bind_gives_rate_and_bind(answer):
    """40 N/mm from a free length of 55 mm, and ten times as stiff below 34 mm."""
    wire = ("--wire-diameter", "4.2 mm", "--outer-diameter", "30.2 mm")
    text = answer("spring-card", "tester.csv", *wire, "--installed-height", "48 mm")
    assert value(text, "rate at the installed height") == pytest.approx(40, rel=0.02)
    assert value(text, "force at the installed height") == pytest.approx(280, rel=0.01)
    assert value(text, "solid height") == pytest.approx(34, abs=0.2)
