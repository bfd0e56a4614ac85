"""Golden: commands with options that no other test of theirs gives, on parts of our own; their
answers and files are what they were.

Asked here is how a command ends. That nothing it says, draws or writes moves unsaid is held by
``tests/made_watch.py``, as of every test.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from unit.cli_parts import PUBLISHED, SMALL, call
from unit.test_identification_answer import CARD, FILE
from workbench_parts import SMALL as LIFTED

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))
from sample_rig import WRITERS, Rig, record

#: A card of a spring with a nested one, both known by their numbers alone.
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
#: One unknown of two loads, followed, with a second solution and a prediction at a speed.
TWO = FILE.replace("draws = 6", "draws = 4\nmethod = 'ensemble'\nwalkers = 6\nsteps = 8").replace(
    'profile = ["rate"]', ""
)
SAMPLER = """
case = "card.toml"
spring_models = ["massless"]
outputs = ["preload"]
points = { sampler = "%s", count = 8, seed = 3 }
[[vary]]
key = "spring.rate"
%s
[[vary]]
key = "spring.preload"
low = "200 N"
high = "300 N"
"""
SAMPLERS = ("monte-carlo", "latin-hypercube", "sobol", "saltelli")
#: Ways in which a quantity varies.
VARIED = {
    "normal": 'mean = "32 N/mm"\nstandard_deviation = "1 N/mm"',
    "cut": 'mean = "32 N/mm"\nstandard_deviation = "1 N/mm"\nhigh = "32.5 N/mm"',
    "lognormal": 'median = "32 N/mm"\nfactor = 1.1',
    "tolerance": 'tolerance = "5 %"',
    "uniform tolerance": 'tolerance = "2 N/mm"\nshape = "uniform"',
}  # fmt: skip


def lift(angle: np.ndarray) -> np.ndarray:
    return 10e-3 * np.clip(1 - ((np.asarray(angle) % (2 * np.pi) - np.pi) / 1.0) ** 2, 0, None) ** 3


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Cases, tables and a recording that all commands find beside them."""
    place = tmp_path_factory.mktemp("scenarios")
    heights = np.linspace(50.0, 33.5, 31)
    forces = (
        40.0 * (55.0 - heights)
        + np.where(heights < 34.0, 400.0 * (34.0 - heights), 0.0)
        + 0.8 * np.sin(7 * heights)
    )
    few = np.column_stack([heights[::5], forces[::5]])
    for name, rows in (("tester.csv", np.column_stack([heights, forces])), ("few.csv", few)):
        (place / name).write_text(
            "height [mm]; force [N]\n" + "\n".join(f"{a:.4f};{b:.3f}" for a, b in rows) + "\n"
        )
    lead = LIFTED + CARD.partition("[spring]")[0]
    texts = {
        "small.toml": SMALL, "told.toml": SMALL + PUBLISHED, "card.toml": CARD, "lifted.toml": lead.replace('title = "card"\n', ""),
        "pair.toml": PAIR, "rate.toml": FILE, "two.toml": TWO,
    }  # fmt: skip
    texts |= {
        f"{sampler}.toml": SAMPLER % (sampler, VARIED["normal"])
        for sampler in ("monte-carlo", "latin-hypercube", "sobol", "saltelli")
    }
    texts |= {f"{kind}.toml": SAMPLER % ("sobol", words) for kind, words in VARIED.items()}
    for name, text in texts.items():
        (place / name).write_text(text)
    records = record(
        Rig(cycles=8, sampling_rate=20e3, missing=2), lift, lambda angle: 215 + 26e3 * lift(angle)
    )
    WRITERS["rig.csv"](place / "rig.csv", records)
    table = np.column_stack(
        [np.arange(0.0, 360.0, 3.0), 1e3 * lift(np.radians(np.arange(0.0, 360.0, 3.0)))]
    )
    (place / "lobe.csv").write_text(
        "cam angle [deg];valve lift [mm]\n" + "\n".join(f"{a:g};{b:.4f}" for a, b in table) + "\n"
    )
    return place


WIRE = ("--wire-diameter", "4.2 mm", "--outer-diameter", "30.2 mm")
COMMANDS: dict[str, tuple[int, tuple[str, ...]]] = {
    "tester with bound coils": (0, ("spring-card", "tester.csv", *WIRE, "--installed-height", "48 mm")),
    "tester of seven stations": (0, ("spring-card", "few.csv", *WIRE, "--installed-height", "48 mm", "--material", "OTEVA 90 SC")),
    "identified": (0, ("identify", "rate.toml", "--workers", "1", "--seed", "5")),
    "rig, wheel with a gap": (0, ("rig", "rig.csv", "--angle-of", "crank", "--pulses", "Crank wheel", "--teeth", "60", "--missing", "2")),
    "rig, once a turn": (0, ("rig", "rig.csv", "--angle-of", "cam", "--once", "Cam pulse", "--dwell", "-60, 60 deg", "--band", "2 kHz")),
    "rig, span": (0, ("rig", "rig.csv", "--angle-of", "crank", "--encoder", "Crank angle", "--span", "0.05, 0.28 s",
                     "--angle-count", "720")),
    "rig, case": (0, ("rig", "rig.csv", "--angle-of", "crank", "--encoder", "Crank angle", "--case", "lifted.toml", "--keep-outliers")),
    "rig, offset": (0, ("rig", "rig.csv", "--angle-of", "crank", "--encoder", "Crank angle", "--offset", "12.5 deg", "--json")),
    "gauge of all kinds": (0, ("rig", "--case", "lifted.toml", "--engine-speed", "3000 rpm", "--spring", "massless", "--sensor",
                               "natural_frequency=6 kHz, damping_ratio=0.02, order=2, sampling_rate=9 kHz, bandwidth=3 kHz")),
    "gauge of a train": (0, ("rig", "--case", "vaz-ohc", "--engine-speed", "3000 rpm", "--spring", "massless", "--bandwidth", "2 kHz")),
    "gauge, own speeds": (0, ("rig", "--case", "pair.toml", "--spring", "massless,multi-mass", "--bandwidth", "1 kHz")),
    "gauge, two speeds": (0, ("rig", "--case", "lifted.toml", "--engine-speed", "2000, 3000 rpm", "--bandwidth", "1 kHz", "--json")),
    "solid at rest": (0, ("compare", "small.toml", "--spring", "finite-element,solid", "--solid-elements-per-coil", "4")),
    "solid in motion": (0, ("compare", "small.toml", "--spring", "solid", "--solid-elements-per-coil", "4", "--solid-motion",
                            "100:110 deg")),
    "two springs": (0, ("run", "pair.toml", "--spring", "massless,multi-mass", "--no-report")),
    "two springs in JSON": (0, ("run", "pair.toml", "--spring", "massless", "--json", "--no-report")),
    "two springs at rest": (0, ("static", "pair.toml")),
    "two springs' modes": (0, ("modes", "pair.toml", "--spring", "multi-mass")),
    "sweep of a card": (0, ("sweep", "lifted.toml", "--engine-speed", "2000:8000:1000 rpm", "--spring", "multi-mass,modal-varied")),
    "published beside": (0, ("run", "told.toml", "--spring", "massless,finite-element", "--published")),
    "published, at rest": (0, ("static", "told.toml", "--spring", "finite-element")),
    "fidelity of a card": (0, ("fidelity", "lifted.toml", "--engine-speed", "2000:6000:2000 rpm", "--reference", "multi-mass")),
    "fidelity, tight": (0, ("fidelity", "lifted.toml", "--engine-speed", "2000:6000:2000 rpm", "--tolerance", "0.1 %", "--json")),
    "train, sweep": (0, ("sweep", "vaz-ohc", "--engine-speed", "2000:4000:2000 rpm", "--spring", "massless", "--resolution", "500 rpm")),
    "train, two sets": (0, ("compare", "tdi-pushrod", "--engine-speed", "2000 rpm", "--spring", "massless", "--spring-set",
                            "stock,performance")),
    "train, run-up": (0, ("run-up", "vaz-ohc", "--spring", "massless", "--from", "2000 rpm", "--to", "2600 rpm", "--duration", "0.3 s")),
    "train, modes": (0, ("modes", "vaz-ohc", "--spring", "multi-mass")),
    "train, at rest": (0, ("static", "tdi-pushrod")),
    "check of a pair": (0, ("check", "pair.toml")),
    "check in JSON": (0, ("check", "told.toml", "--json", "--spring", "finite-element")),
    "check of a train": (0, ("check", "tdi-pushrod", "--set", "train.lash=0.2 mm")),
    "lift of a lobe": (0, ("lift", "lobe.csv", "--at", "1, 5 mm")),
    "lift in a case": (0, ("lift", "lobe.csv", "--case", "lifted.toml", "--spring", "massless", "--engine-speed", "3000 rpm",
                          "--draws", "5")),
    **{f"study, {kind}": (0, ("study", f"{kind}.toml", "--workers", "1")) for kind in SAMPLERS},
    **{f"study, {kind}": (0, ("study", f"{kind}.toml", "--workers", "1", "--json")) for kind in VARIED},
}  # fmt: skip


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_ends_as_it_should(folder, tmp_path, monkeypatch, name):
    code, words = COMMANDS[name]
    monkeypatch.chdir(folder)
    found = call(
        *words,
        *(() if words[0] in ("check", "static", "modes") else ("--output", str(tmp_path / "out"))),
    )
    assert found.exit_code == code, found.output
