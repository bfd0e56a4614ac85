"""``valvetrain optimise``: its answer and files, and that a search that is killed or stopped goes on where it was, with the same bits."""

from __future__ import annotations

import csv
import json
import signal
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import valvetrain as vt
from unit.cli_parts import MODULE, call, hear_interrupts, process_environment, sentence, wait_until

#: Short runs of the chain: a limit speed, a bound at rest that is a share of the case, one trial in a few that cannot be built.
SEARCH = """
title = "Higher limit"
case = "gu2021-beehive"
changes = {{ "operation.cycles" = 1 }}
engine_speeds = "8000 rpm"
spring_models = ["multi-mass"]
[[objective]]
limit_speed = {{ quantity = "peak_spring_force", at_most = "860 N", engine_speeds = "6000:9000:1500 rpm", resolution = "400 rpm" }}
direction = "maximise"
label = "limit speed"
[[constraint]]
quantity = "largest_outer_diameter"
at_most = "1.0 x case"
[[constraint]]
quantity = "coil_bind_clearance"
at_least = "1 mm"
[[vary]]
key = "spring.wire_diameter"
low = "3.4 mm"
high = "4.0 mm"
[[vary]]
key = "spring.precompression"
low = "6 mm"
high = "24 mm"
[search]
trials = {trials}
per_round = 4
local = 0.25
"""
#: Sizes alone: a search in a second.
LIGHT = """
title = "Lightest"
case = "job-c"
objective = [{ quantity = "wire_mass", direction = "minimise" }]
constraint = [{ quantity = "estimated_rate", at_least = "1.1 x case" }, { quantity = "smallest_index_ratio", at_least = 5.0, at_most = 9.0 }]
vary = [
  { key = "spring.wire_diameter", low = "3 mm", high = "4.6 mm", label = "wire" },
  { key = "spring.mean_diameter", values = "20, 18, 24, 22 mm", label = "coil" },
]
search = { trials = 20, per_round = 5, seeds = 2 }
"""


@cache
def light() -> vt.Optimum:
    return vt.optimise(LIGHT, workers=1)


def same(one: vt.Optimum, rows: list[dict]) -> None:
    """The trials of an optimum and of the JSON of another, to the last bit."""
    assert len(one.trials) == len(rows)
    for trial, row in zip(one.trials, rows, strict=True):
        for name in ("values", "objectives", "constraints"):
            told = np.array([np.nan if value is None else value for value in row[name]])
            assert np.array_equal(getattr(trial, name), told, equal_nan=True), (trial.number, name)
        assert row["state"] == trial.state and row["failure"] == trial.failure


@pytest.fixture
def file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "light.toml"
    path.write_text(LIGHT)
    return path


def test_the_answer_is_one_json_object_and_the_files_hold_the_same(file):
    answer = call("optimise", str(file), "--workers", "1", "--json")
    assert answer.exit_code == 0, answer.stderr
    data = json.loads(answer.stdout)
    found = light()
    same(found, data["rows"])
    assert data["trials"] == 41 and data["of_case"]["number"] == 0 and data["feasible_trials"] == found.feasible
    best = data["designs"][0]
    assert best["number"] == found.best.trial.number and len(best["steps"]) >= 2 and set(data["best_by_seed"]) == {"1", "2"}
    folder = file.parent / "runs" / "optimise" / "light"
    rows = list(csv.reader((folder / "trials.csv").open()))
    assert len(rows) == 42 and rows[0][2:5] == ["spring.wire_diameter [m]", "spring.mean_diameter [m]", "objective 1: wire mass [kg]"]
    assert float(rows[1 + best["number"]][4]) == best["objectives"][0]
    page = (folder / "report.html").read_text()
    assert all(sentence_ in page for sentence_ in data["sentences"][:2]) and "What small steps do" in page
    assert json.loads((folder / "optimum.json").read_text())["designs"] == data["designs"]


def test_the_answer_for_people_says_the_same(file):
    text = call("optimise", str(file), "--workers", "1").stdout
    assert "The least that keeps every bound: wire mass" in text and "The case itself misses: estimated rate at least" in text
    assert f"{light().feasible} of 41 trials keep every bound" in text and "2 searches from different seeds end at" in text
    again = call("optimise", str(file), "--workers", "1").stdout
    assert "41 trials, 0 points computed" in again


def test_the_case_file_of_the_best_is_the_best(file):
    """Read again, it has the numbers of the trial to the last bit, and nothing that was published of another spring."""
    call("optimise", str(file), "--workers", "1")
    best = light().best.trial
    case = vt.load_case(file.parent / "runs" / "optimise" / "light" / "best.toml")
    assert not case.published and not case.study
    outputs = vt.study(f"""
case = "{(file.parent / "runs" / "optimise" / "light" / "best.toml").as_posix()}"
outputs = ["wire_mass", "estimated_rate", "smallest_index_ratio"]
points = {{ sampler = "list" }}
vary = [{{ key = "spring.precompression", values = "7 mm" }}]
""", workers=1)  # fmt: skip
    assert outputs.values[0].tolist() == [best.objectives[0], best.constraints[0], best.constraints[1]]


def test_optunas_own_reader_opens_the_study(file):
    optuna = pytest.importorskip("optuna")
    call("optimise", str(file), "--workers", "1")
    path = file.parent / "runs" / "optimise" / "light" / "optuna.db"
    (summary,) = optuna.get_all_study_summaries(f"sqlite:///{path}")
    study = optuna.load_study(study_name=summary.study_name, storage=f"sqlite:///{path}")
    found = light()
    inside = [one for one in found.trials if one.number or one.values[1] == 24e-3]
    assert len(study.trials) == len(inside) == 41
    assert study.best_trial.user_attrs["number"] == found.best.trial.number
    assert study.best_trial.params["wire [mm]"] == pytest.approx(1e3 * found.best.trial.values[0])
    assert {one.state.name for one in study.trials} >= {"COMPLETE"}


def test_a_search_without_a_design_names_the_bound_that_is_missed_by_least(file):
    file.write_text(LIGHT.replace("1.1 x case", "80 N/mm"))
    answer = call("optimise", str(file), "--workers", "1")
    assert answer.exit_code == 1 and "No trial keeps every bound" in answer.stderr and "estimated rate at least 80 N/mm" in answer.stderr
    assert (file.parent / "runs" / "optimise" / "light" / "report.html").exists()


def test_a_search_beyond_the_bound_is_refused_before_it_begins(file):
    file.write_text(SEARCH.format(trials=15000))
    answer = call("optimise", str(file))
    assert answer.exit_code == 2 and "--limit" in sentence(answer)
    assert not (file.parent / "runs").exists()


def points_kept(folder: Path) -> int:
    """Whole lines of the journals, read from outside."""
    return sum(path.read_bytes().count(b"\n") for path in folder.glob("*/journal.jsonl"))


def test_a_search_that_is_ended_goes_on_with_the_same_bits_and_computes_nothing_twice(tmp_path):
    """Ended twice, in a way that it hears and in one that it does not; by one and by two workers."""
    text = SEARCH.format(trials=16)
    file, folder = tmp_path / "search.toml", tmp_path / "out"
    file.write_text(text)
    command = [sys.executable, *MODULE, "optimise", str(file), "--output", str(folder), "--json", "--workers"]
    for stop, code, kept, workers in ((signal.SIGTERM, 143, 10, "2"), (signal.SIGKILL, -9, 6, "1")):
        began = subprocess.Popen(
            [*command, workers], cwd=tmp_path, env=process_environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            preexec_fn=hear_interrupts,
        )  # fmt: skip
        wait_until(lambda kept=kept, began=began: points_kept(folder / "points") >= kept or began.poll() is not None, f"{kept} points")
        began.send_signal(stop)
        _, said = began.communicate(timeout=60)
        assert began.returncode == code, said
        if stop == signal.SIGTERM:  # it wrote what it had
            assert b"start the command again to go on" in said and (folder / "trials.csv").exists() and (folder / "optuna.db").exists()
    ended = subprocess.run([*command, "2"], cwd=tmp_path, env=process_environment(), capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    data = json.loads(ended.stdout)
    whole = vt.optimise(text, workers=1)
    same(whole, data["rows"])
    assert 0 < data["computed_now"] <= whole.computed - 16
    states = {one.state for one in whole.trials}
    assert {"refused", "feasible", "infeasible"} <= states
    for one in whole.trials:  # what cannot be built has no number
        assert bool(one.failure) == (one.state == "refused") and (not one.failure or not np.any(np.isfinite(one.objectives)))
    best = whole.best.trial
    (bracket,) = best.measured.limits[whole.plan.objectives[0].measure]
    assert best.objectives[0] == bracket.value and best.objectives[0] >= whole.case.objectives[0]


def test_seeds_and_rounds_alone_decide_which_designs_are_looked_at():
    first, again, other = light(), vt.optimise(LIGHT, workers=2), vt.optimise(LIGHT.replace("seeds = 2", "seed = 7"), workers=1)
    assert all(np.array_equal(one.values, two.values) for one, two in zip(first.trials, again.trials, strict=True))
    assert not all(np.array_equal(one.values, two.values) for one, two in zip(first.trials[1:], other.trials[1:], strict=False))
    designs = [one.values.tobytes() for one in first.trials]
    assert first.computed <= len(set(designs)) + 1 + len(first.best.steps)  # a design that comes twice is computed once


def test_a_library_that_is_not_installed_is_said_in_one_sentence(monkeypatch):
    monkeypatch.setitem(sys.modules, "optuna", None)
    with pytest.raises(vt.ValvetrainError, match=r"pip install 'valvetrain\[studies\]'"):
        vt.optimise(LIGHT, workers=1)


def test_another_model_says_what_it_makes_of_the_best():
    text = SEARCH.format(trials=8).replace("[search]", '[[confirm]]\nspring_model = "massless"\nlabel = "no surge"\n[search]')
    found = vt.optimise(text.replace("6000:9000:1500", "6000:9000:3000"), workers=1)
    (one,) = found.best.confirmed
    told = [sentence_ for sentence_ in repr(found).splitlines() if sentence_.startswith("By no surge: limit speed")]
    assert one.label == "no surge" and len(told) == 1 and one.case.number == 0
    assert one.design.objectives[0] != found.best.trial.objectives[0]
    static = vt.simulate(found.case_of(found.best), "6000 rpm", spring_models=["massless"]).solutions[0].quantities["peak_spring_force"]
    assert bool(static <= 860.0) == bool(one.design.feasible)
