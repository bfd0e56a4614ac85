"""Run-ups: the turns of constant acceleration in closed form, and a slow one between the steady
states of a sweep.
"""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import valvetrain as vt
from train_parts import direct, system
from unit.cli_parts import call, sentence
from valvetrain.errors import InputError
from valvetrain.integrate.run_up import turns_of_run_up
from valvetrain.integrate.train_record import TrainOptions
from valvetrain.integrate.train_run import runner
from valvetrain.parameters.templates import TEMPLATES
from valvetrain.views.page import data_of

ENGINE = str(TEMPLATES / "pushrod.toml")
#: Quantity -> largest difference of a slow run-up from the steady state at the same speed, as a
#: share.
BANDS = {
    "peak_cam_contact_force": 0.01, "peak_spring_force": 2e-3, "minimum_spring_force": 5e-3, "peak_retainer_force": 2e-3,
    "minimum_cam_contact_force": 0.02, "peak_valve_tip_contact_force": 0.01, "peak_valve_lift": 1e-3, "coil_bind_clearance": 5e-3,
    "seating_velocity": 0.03,
}  # fmt: skip


def test_turns_follow_the_law_of_constant_acceleration():
    """Turn n is done at (sqrt(w^2 + 4 pi n a) - w) / a; a record ends at the sample nearest to it,
    and the next goes on from there.
    """
    first, last, acceleration = 100.0, 160.0, 900.0
    ready = runner(
        system(direct()), first, TrainOptions(samples=360), cam_acceleration=acceleration
    )
    records = list(turns_of_run_up(ready, last))
    interval = ready.time_step * ready.steps / 360
    done = np.cumsum([len(record.q) for record in records]) * interval
    expected = (
        np.sqrt(first**2 + 4 * math.pi * acceleration * np.arange(1, len(records) + 1)) - first
    ) / acceleration
    assert np.max(np.abs(done - expected)) < 0.51 * interval
    angle = np.concatenate([record.cam_angle for record in records])
    time = np.arange(len(angle)) * interval
    assert angle == pytest.approx(first * time + acceleration * time**2 / 2, rel=1e-9, abs=1e-9)
    assert (
        records[-1].cam_speed
        < last
        <= records[-1].cam_speed + acceleration * len(records[-1].q) * interval
    )


def test_a_slow_run_up_passes_through_the_steady_states():
    """A rise by 8 % in 22 turns of the template. The bands tell the two speeds apart: values of one
    are outside at the other.
    """
    still = vt.sweep(ENGINE, "5100, 5300 rpm", models=["massless"], spring_sets=["card"])
    study = vt.run_up(ENGINE, "5000 rpm", "5400 rpm", "0.5 s", models=["massless"])
    outside, crossed = {}, []
    for name, band in BANDS.items():
        curve, steady = study.series("massless", name), still.series("massless", name)
        found = np.interp(steady.engine_speed, curve.engine_speed, curve)
        steady = steady.values
        if np.max(np.abs(found / steady - 1)) > band:
            outside[name] = found / steady - 1
        crossed += [name] if np.max(np.abs(found[::-1] / steady - 1)) > band else []
    assert not outside
    assert {"peak_cam_contact_force", "minimum_cam_contact_force", "seating_velocity"} <= set(
        crossed
    )


def test_the_command_keeps_a_page_and_its_turns(tmp_path):
    asked = (
        "run-up",
        ENGINE,
        "--from",
        "3000 rpm",
        "--to",
        "3400 rpm",
        "--duration",
        "0.15 s",
        "--model",
        "massless",
        "--json",
    )
    answer = json.loads(call(*asked, "--output", str(tmp_path / "up")).stdout)
    assert answer["command"] == "run-up" and answer["completed"] and len(answer["runs"]) >= 3
    speeds = [run["engine_speed"]["value"] for run in answer["runs"]]
    assert speeds == sorted(speeds) and 3000 < speeds[0] < 3400 <= speeds[-1] + 200
    assert {"peak_cam_contact_force", "minimum_cam_contact_force", "float_excess_lift"} <= set(
        answer["runs"][0]["quantities"]
    )
    page = (tmp_path / "up" / "report.html").read_text(encoding="utf-8")
    assert answer["findings"][0]["code"] in ("U101", "U102", "U103") and set(data_of(page)) == {
        "data-run-up"
    }


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("job-t",), "holds no train"),
        ((ENGINE, "--rpm", "3000 rpm"), "no such option: --rpm"),
        ((ENGINE, "--from", "3000, 4000 rpm"), "one speed is needed"),
        (
            (ENGINE, "--from", "3000 rpm", "--to", "3000 rpm"),
            "from one engine speed to another",
        ),
        ((ENGINE, "--duration", "0 s"), "not positive"),
        ((ENGINE, "--duration", "9 mm"), "time"),
    ],
)
def test_what_leads_nowhere_is_refused_in_one_sentence(words, said, tmp_path):
    result = call("run-up", *words, "--output", str(tmp_path / "out"))
    assert result.exit_code == 2 and said in sentence(result)


def test_workers_and_python_refusals():
    with pytest.raises(InputError, match="not positive"):
        vt.run_up(ENGINE, "3000 rpm", "4000 rpm", 0.0)
    sets = ["card", "wire"]
    one, two = (
        vt.run_up(
            ENGINE,
            "3000 rpm",
            "3200 rpm",
            "0.05 s",
            models=["massless"],
            spring_sets=sets,
            workers=count,
        )
        for count in (1, 2)
    )
    assert one.labels == two.labels and len(one.labels) == 2
    assert all(a.identical(b) for a, b in zip(one.solutions, two.solutions, strict=True))


def test_a_model_that_cannot_run_floats_at_no_speed():
    models = ["massless", "wave-rod-clash"]
    found = vt.run_up(
        "tdi-pushrod",
        "1000 rpm",
        "1100 rpm",
        "0.4 s",
        models=models,
        spring_sets=["stock"],
        workers=1,
    )
    (refused,) = found.failures
    assert "wave-rod-clash" in refused and found.still.get("wave-rod-clash", {}) == {}


@pytest.mark.parametrize(("first", "last"), [("1000 rpm", "6000 rpm"), ("6000 rpm", "1000 rpm")])
def test_a_run_up_of_less_than_a_few_turns_is_refused(first, last):
    with pytest.raises(InputError, match=r"0\.29 cam revolutions, .*take a longer time"):
        vt.run_up("tdi-pushrod", first, last, "0.01 s", models=["massless"], spring_sets=["stock"])


def test_a_time_beyond_all_bounds_is_refused_before_it_is_counted(tmp_path):
    result = call("run-up", "tdi-pushrod", "--duration", "1e12 s", "--output", str(tmp_path / "up"))
    assert result.exit_code == 2 and "beyond the bound of 10 min" in sentence(result)
