"""``run``, ``compare`` and ``sweep`` of trains: JSON with units, files, pages, sentences for wrong
input.
"""

from __future__ import annotations

import json
import math
import re

import pytest
from typer.testing import CliRunner

from unit.cli_parts import typed
from valvetrain.cli.main import app

QUICK = ["--workers", "1", "--json"]


def call(*words: str, code: int = 0):
    result = CliRunner().invoke(app, list(words))
    assert result.exit_code == code, result.output
    return result


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("trains")


@pytest.fixture(scope="module")
def compared(folder):
    target = folder / "compare"
    words = (
        *typed("compare tdi-pushrod --model massless,multi-mass,modal-uniform,wave-rod --output"),
        str(target),
        *QUICK,
    )
    return json.loads(call(*words).stdout), target


def test_compare_gives_every_model_its_numbers_with_units(compared):
    data, _ = compared
    assert data["command"] == "compare" and data["completed"]
    assert [run["model"] for run in data["runs"]] == [
        "massless",
        "multi-mass",
        "modal-uniform",
        "wave-rod",
    ]
    for run in data["runs"]:
        force = run["quantities"]["nose_cam_contact_force"]
        assert force["unit"] == "N" and force["value"] == pytest.approx(580, rel=0.03)
        assert run["status"]["code"] == "completed"
        assert run["engine_speed"] == {"value": pytest.approx(4000), "unit": "rpm"}
        assert any(event["kind"] == "seating" for event in run["events"])


def test_sweep_tells_where_contact_is_lost(folder):
    target = folder / "sweep"
    words = typed("sweep tdi-pushrod --rpm 6500:7500:500 --model massless --spring-set stock")
    printed = call(*words, "--output", str(target), "--workers", "1").stdout
    data = json.loads((target / "run.json").read_text())
    assert [run["engine_speed"]["value"] for run in data["runs"]] == pytest.approx(
        [6500, 7000, 7500]
    )
    found = {
        name: item
        for values in (data["quantities"], *data["quantities_by_label"].values())
        for name, item in values.items()
    }
    (row,) = [one for one in data["critical_speeds"] if one["kind"] == "contact-loss"]
    speed = row["engine_speed"]["value"]
    assert row["places"] == ["cam"] and row["ranges"][0]["lower"]["value"] == speed
    assert speed == pytest.approx(7148, rel=0.01)  # rigid theory; the contacts give way a little
    assert found["contact_loss_engine_speed"]["value"] * 30 / math.pi == pytest.approx(speed)
    assert found["rigid_contact_loss_engine_speed"]["value"] == pytest.approx(
        7148 * math.pi / 30, abs=0.3
    )
    assert all(run["quantities"]["seating_velocity"]["unit"] == "m/s" for run in data["runs"])
    assert (target / "report.html").is_file()
    assert {"step", "damping", "model"} <= {one["cause"] for one in row["members"]}
    lower = row["range"]["lower"]
    assert lower is None or lower["value"] <= speed * 1.0000001
    assert re.search(r"\b7[01]\d\d rpm", printed, re.IGNORECASE)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("compare", "tdi-pushrod", "--model", "masles"), "massless"),
        (("compare", "tdi-pushrod", "--model", "wave-rod-clash"), "coil gaps of its wire"),
        (
            ("sweep", "tdi-pushrod", "--rpm", "0:100:10"),
            "first speed and step must be above zero",
        ),
        (
            ("sweep", "tdi-pushrod", "--spring-set", "racing", "--rpm", "1000, 2000 rpm"),
            "stock, performance",
        ),
        (("run", "tdi-pushrod", "--set", "train.valve.mass=0 g"), "train.valve.mass"),
        (("run", "tdi-pushrod", "--set", "train.lash=9 mm"), "not smaller than the valve lift"),
    ],
)
def test_wrong_input_is_one_sentence_and_exit_code_two(words, sentence, tmp_path):
    result = call(*words, "--output", str(tmp_path / "out"), code=2)
    assert sentence in result.stderr
    told = [one for one in result.stderr.splitlines() if not one.startswith("compiling kernels")]
    assert len(told) == 1 and told[0].startswith("error: ")
    assert not list(tmp_path.rglob("*.html"))


def test_what_does_not_settle_exits_with_one_and_names_a_key_that_helps(folder):
    words = (
        *typed("compare tdi-pushrod --model massless --output"),
        str(folder / "short"),
        "--no-report",
        *QUICK,
    )
    elastic = [
        word
        for place in ("cam", "rocker", "valve_tip", "seat")
        for word in ("--set", f'train.contacts.{place}.law="hertz-point"')
    ]
    result = call(*words, *elastic, "--set", "train.cycles=100", code=1)  # nothing damps this train
    data = json.loads(result.stdout)
    (run,) = data["runs"]
    assert not data["completed"] and run["status"]["code"] == "not-converged"
    assert (
        "the motion does not repeat" in result.stderr
        and "set cycles in [train] above 100 (" in result.stderr
    )
    assert (
        run["quantities"]["steady_tolerance_ratio"]["value"]
        == 1e-5
        < run["quantities"]["steady_residual_ratio"]["value"]
    )
