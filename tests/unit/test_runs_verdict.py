"""Unit: the last sentence on two saved runs says what the second is better and worse in, error bars counted."""

from __future__ import annotations

import json

import numpy as np
import pytest

from unit.cli_parts import SMALL, call
from valvetrain.report.runs_verdict import runs_verdict
from valvetrain.runs.headline_changes import HeadlineChange, headline_changes
from valvetrain.runs.saved_runs import Inputs, save_run

RPM = np.pi / 30


def answer(bar: float = 0.0, critical: tuple[float | None, ...] = (), **values: float):
    """A ``run.json`` of one label at two engine speeds; ``values`` at the higher, a tenth more at the lower."""
    runs = [
        {
            "label": "massless",
            "engine_speed": {"value": speed},
            "quantities": {name: {"value": factor * value, "unit": "SI"} for name, value in values.items()},
        }
        for speed, factor in ((3000.0, 1.1), (6000.0, 1.0))
    ]  # fmt: skip
    bars = [
        {"quantity": name, "label": "massless", "engine_speed": {"value": speed}, "numerical_uncertainty": {"value": bar}}
        for name in values
        for speed in (3000.0, 6000.0)
    ]  # fmt: skip
    found = {"runs": runs, "uncertainties": bars}
    for speed in critical:
        row = {"label": "massless", "kind": "float", "engine_speed": {"value": speed}}
        found["critical_speeds"] = [row]
        if speed is not None:
            found["quantities_by_label"] = {"massless": {"float_engine_speed": {"value": speed * RPM, "unit": "rad/s"}}}  # fmt: skip
    return found


def test_better_and_worse_go_by_the_sense_of_a_quantity_at_its_worst():
    """Closed form: largest of what should be small, least of what should be large."""
    pair = (
        answer(lift_loss_displacement=1e-4, minimum_cam_contact_force=200.0),
        answer(lift_loss_displacement=9e-5, minimum_cam_contact_force=150.0),
    )
    changes = headline_changes(*pair)
    assert [(one.quantity, one.better) for one in changes] == [("lift_loss_displacement", True), ("minimum_cam_contact_force", False)]  # fmt: skip
    assert changes[1].a == 200.0 and changes[0].a == pytest.approx(1.1e-4)
    said = runs_verdict(changes)
    assert said.startswith("From A to B better: lift lost 0.11 -> 0.099 mm (−10.0 %); worse: minimum cam")  # fmt: skip


def test_lift_and_timing_are_named_before_what_changes_more():
    """Contract: a sentence on flex left out the timing, for power and surge changed more."""
    names = (
        "mean_cam_power",
        "surge_amplitude_force",
        "peak_spring_force",
        "clash_energy",
        "bounce_height",
    )
    first = {
        "lift_loss_displacement": 1e-4,
        "valve_50_thou_lost_crank_angle_range": np.radians(3.2),
    }
    pair = [
        answer(**{name: share * value for name, value in first.items()}, **dict.fromkeys(names, other))
        for share, other in ((1.0, 100.0), (0.9, 50.0))
    ]  # fmt: skip
    said = runs_verdict(headline_changes(*pair))
    assert said.startswith(
        "From A to B better: lift lost 0.11 -> 0.099 mm (−10.0 %), duration lost at 0.050 in 3.52 -> 3.168 crank deg (−10.0 %), "
    )
    assert "and 3 more" in said


def test_a_change_within_the_error_bars_of_both_is_none():
    """Property: widening the bars beyond the change takes it out of the sentence."""
    pair = [{"seating_velocity": 0.5}, {"seating_velocity": 0.54}]
    narrow, wide = (
        runs_verdict(headline_changes(*(answer(bar, **one) for one in pair)))
        for bar in (0.01, 0.03)
    )
    assert "worse: seating velocity 0.55 -> 0.594 m/s (+8.0 %)" in narrow
    assert wide == "No headline quantity changes by more than its error bar or 0.5 %."


def test_a_speed_that_is_never_reached_is_better_than_any():
    """Contract: a searched speed that was not found is told as that."""
    (change,) = headline_changes(answer(critical=(7000.0,)), answer(critical=(None,)))
    assert change.better and change.counts
    assert "7000 rpm -> never reached" in runs_verdict([change])


def test_what_one_run_alone_has_is_not_compared():
    """Contract: a quantity, label or speed without a partner ranks nothing."""
    other = answer(seating_velocity=0.5)
    for run in other["runs"]:
        run["label"] = "multi-mass"
    assert not headline_changes(answer(seating_velocity=0.4), other)
    assert runs_verdict(()).startswith("The two runs have no headline quantity")
    assert runs_verdict((HeadlineChange("seating_velocity", 0.5, 0.4),), ["B"]).startswith("B did not complete; from A to B better")  # fmt: skip


def test_the_command_ends_with_it(tmp_path, monkeypatch):
    """Example: more lift is more force."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(SMALL)
    for name, lift in (("one", "4 mm"), ("two", "3.5 mm")):
        words = ("--set", f"lift_law.maximum_lift={lift}", "--spring", "massless", "--workers", "1")
        assert (
            call("run", "small.toml", *words, "--no-report", "--output", name, "--quiet").exit_code
            == 0
        )
    said = call("compare-runs", "one", "two")
    data = json.loads(call("compare-runs", "one", "two", "--json").stdout)
    assert data["verdict"].startswith("From A to B better: ") and "peak spring force" in data["verdict"]  # fmt: skip
    assert " ".join(said.stdout.split()).endswith(data["verdict"])
    assert "From A" not in call("compare-runs", "one", "one").stdout


def test_a_failed_run_is_named_where_the_numbers_are_the_same(tmp_path, monkeypatch):
    """Contract: a run that lacks files is no equal of a whole one."""
    monkeypatch.chdir(tmp_path)
    for name, failures in (("one", []), ("two", ["file 'curves.csv': No space left on device"])):
        answer = {
            "case": "small",
            "created_at": "2026-01-01",
            "completed": not failures,
            "failures": failures,
        }
        save_run(tmp_path / name, Inputs("small", SMALL, {}, {}), answer)
    said, data = call("compare-runs", "one", "two"), json.loads(call("compare-runs", "one", "two", "--json").stdout)  # fmt: skip
    assert "curves.csv" in said.stdout and "B did not complete" in data["verdict"]
    assert data["failed"] == {"a": [], "b": ["file 'curves.csv': No space left on device"]}
