"""The command rig: tables, pages, files and JSON of a recording; what it asks and refuses."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import valvetrain as vt
from unit.cli_parts import call, typed

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))
from sample_rig import WRITERS, Rig, record


def lift(angle):
    """The lift of job-t would cost a build; this one is like it."""
    return 10e-3 * np.clip(1 - ((np.asarray(angle) % (2 * np.pi) - np.pi) / 1.0) ** 2, 0, None) ** 3


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("rig")
    records = record(
        Rig(cycles=6, slipped=3, sampling_rate=20e3), lift, lambda angle: 215 + 26e3 * lift(angle)
    )
    for name in ("rig.csv", "rig.tdms"):
        WRITERS[name](made / name, records)
    return made


ANSWERS = ("--angle-of", "crank", "--encoder", "Crank angle", "--zero", "spring_force=215 N")


def test_the_command_tells_writes_and_keeps(folder, tmp_path):
    out = call(
        "rig",
        str(folder / "rig.csv"),
        *ANSWERS,
        "--output",
        str(tmp_path / "out"),
        "--json",
    )
    assert out.exit_code == 0, out.output
    data = json.loads(out.stdout)
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names >= {
        "report.html",
        "spring_force.csv",
        "valve_lift.csv",
        "means.csv",
        "run.json",
    }
    assert (
        data["synthetic"] and data["outliers"][0]["cycle"] == 4 and data["kept"] == [1, 2, 3, 5, 6]
    )
    out_folder = tmp_path / "out"
    direct = vt.rig.rig_cycles(
        folder / "rig.csv",
        vt.rig.RigAnswers(angle_of="crank", encoder="Crank angle", zero={"spring_force": "215 N"}),
    )
    for one in direct.cycles:
        read_back = vt.measured.read_cycles(out_folder / f"{one.quantity}.csv")
        np.testing.assert_array_equal(read_back.values, one.values)
    peak = next(one for one in data["channels"] if one["quantity"] == "spring_force")["figures"][0][
        "mean"
    ]
    assert peak == pytest.approx(float(np.mean(direct.channels[0].peaks()[0])), rel=1e-12)
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert data["findings"][0]["code"] == "T105" and "synthetic" in page and "left out" in page
    shown = call("rig", str(folder / "rig.csv"), *ANSWERS, "--output", str(tmp_path / "out2"))
    assert "cycle 4" in shown.output and "synthetic" in shown.output


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("none.csv",), "cannot be read"),
        (("rig.csv", "--unit", "spring_force"), "is no pair"),
        (("rig.csv", "--unit", "a=N", "--unit", "a=N"), "is given twice"),
        (("rig.csv", "--angle-of", "x"), "--angle-of: 'x' is not available"),
        (("rig.csv", "--dwell", "1 deg"), "two ends"),
        (("rig.csv", "--span", "3, 2 s"), "ends before it begins"),
        (("rig.csv", "--span", "0.1, 0.101 s", "--angle-of", "cam"), "in the span"),
        (("rig.csv", "--angle-of", "crank", "--unit", "encoder=mm"), "is no angle"),
        (
            ("rig.csv", "--angle-of", "crank", "--channel", "spring_force=Force 9"),
            "has no channel 'Force 9'",
        ),
        (("rig.csv", "--angle-of", "crank", "--pulses", "Crank wheel", "--teeth", "58"), "teeth"),
        (
            typed("rig.csv --angle-of crank --pulses 'Crank wheel' --teeth 60 --missing 3"),
            "no gap of 3 missing teeth",
        ),
        (("rig.csv", "--angle-of", "crank", "--pulses", "Valve lift", "--teeth", "60"), "pulses"),
        (("rig.csv", "--angle-of", "crank", "--band", "2 Hz"), "shorter than the filter"),
        (("rig.csv", "--set", "a=1"), "--case"),
        (("rig.csv", "--angle-count", "4"), "--angle-count: 4 is outside"),
        (("rig.csv", "--teeth", "0"), "--teeth: 0 is outside"),
        (("rig.csv", "--angle-of", "crank", "--zero", "spring_force=1 mm"), "zero of spring_force"),
    ],
)
def test_what_is_wrong_is_one_sentence(folder, monkeypatch, words, sentence):
    monkeypatch.chdir(folder)
    out = call("rig", *words)
    assert out.exit_code == 2 and sentence in " ".join(out.output.split()), out.output
