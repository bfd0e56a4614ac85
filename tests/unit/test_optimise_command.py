"""``valvetrain optimise``: its answer and files, and that a search that is killed or stopped goes
on where it was, with the same bits.
"""

from __future__ import annotations

import csv
import json
import signal
import subprocess
import sys
from functools import cache

import numpy as np
import pytest

import valvetrain as vt
from unit.cli_parts import MODULE, call, process_environment, sentence, wait_until
from unit.test_study_command import points_kept
from valvetrain.explore.engine import Interrupted
from valvetrain.explore.optimise import STEPS
from valvetrain.explore.optimum import case_text
from valvetrain.views.page import data_of
from valvetrain.views.results import answer_of

#: Short runs of the chain: a limit speed, a bound at rest that is a share of the case, one trial in
#: a few that cannot be built.
SEARCH = """
title = "Higher limit"
case = "gu2021-beehive-blind"
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
constraint = [{ quantity = "estimated_rate", at_least = "1.1 x case" }, { quantity = "smallest_index_ratio", at_least = 5, at_most = 9 }]
vary = [
  { key = "spring.wire_diameter", low = "3 mm", high = "4.6 mm", label = "wire" },
  { key = "spring.mean_diameter", values = "20, 18, 24, 22 mm", label = "coil" },
]
search = { trials = 40, per_round = 5 }
"""


@cache
def light() -> vt.explore.Optimum:
    return vt.optimise(LIGHT, workers=1)


def same(one: vt.explore.Optimum, rows: list[dict]) -> None:
    """The trials of an optimum and of the JSON of another, to the last bit."""
    assert len(one.trials) == len(rows)
    for trial, row in zip(one.trials, rows, strict=True):
        heads = {
            "values": one.plan.varied.names,
            "objectives": [f"objective_{k + 1}" for k in range(len(trial.objectives))],
            "constraints": [f"constraint_{k + 1}" for k in range(len(trial.constraints))],
        }
        for name, keys in heads.items():
            told = np.array([row[key] for key in keys], dtype=float)
            assert np.array_equal(getattr(trial, name), told, equal_nan=True), (trial.number, name)
        assert row["state"] == trial.state and row["failure"] == trial.failure


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """The light search by the command, once: its folder and its JSON."""
    folder = tmp_path_factory.mktemp("light")
    (folder / "light.toml").write_text(LIGHT)
    answer = call(
        *f"optimise {folder / 'light.toml'} --workers 1 --json --output {folder / 'out'}".split()
    )
    assert answer.exit_code == 0, answer.stderr
    return folder / "out", json.loads(answer.stdout)


def test_the_answer_is_one_json_object_and_the_files_hold_the_same(kept):
    (folder, data), found = kept, light()
    same(found, data["rows"])
    assert (
        data["trials"] == len(found.trials) > 20
        and data["of_case"]["number"] == 0
        and data["feasible_trials"] == found.feasible
    )
    assert data["findings"][0]["code"] == answer_of(found).verdict.code == "O108"
    best = data["designs"][0]
    assert best["trial"]["number"] == found.best.trial.number
    rows = list(csv.DictReader((folder / "trials.csv").open()))
    assert len(rows) == len(found.trials) and "spring.wire_diameter [m]" in rows[0]
    row = rows[best["trial"]["number"]]
    assert float(row["objective_1 [kg]"]) == best["trial"]["objectives"][0]
    page = (folder / "report.html").read_text()
    assert data_of(page) and answer_of(found).verdict.text in page
    assert json.loads((folder / "optimise.json").read_text())["designs"] == data["designs"]


def test_the_case_file_of_the_best_has_its_numbers_to_the_last_bit(kept):
    folder, _ = kept
    best, case = light().best.trial, vt.load_case(folder / "best.toml")
    assert not case.published and not case.study
    outputs = vt.study(
        f"""
case = "{(folder / "best.toml").as_posix()}"
outputs = ["wire_mass", "estimated_rate", "smallest_index_ratio"]
points = {{ sampler = "list" }}
vary = [{{ key = "spring.precompression", values = "7 mm" }}]
""",
        workers=1,
    )
    assert outputs.values[0].tolist() == [best.objectives[0], *best.constraints[:2]]


def test_the_case_file_runs_what_was_searched(tmp_path):
    """It kept the set of the case, so that its run was that of an untouched spring."""
    found = vt.optimise(
        """
case = "tdi-pushrod"
engine_speeds = "2500, 3000 rpm"
spring_sets = ["performance"]
spring_models = ["massless"]
vary = [{ key = "train.valve.mass", as = "factor", low = 0.9, high = 1.1 }]
objective = [{ quantity = "minimum_spring_force", direction = "maximise" }]
search = { trials = 2, per_round = 2 }
""",
        workers=1,
    )
    file = tmp_path / "best.toml"
    file.write_text(case_text(found, found.best))
    case = vt.load_case(file)
    assert (case.train.spring_set, case.train.spring_model) == ("performance", "massless")
    rpm = [speed * 30 / np.pi for speed in case.operation.engine_speeds]
    assert rpm == pytest.approx([2500, 3000], rel=1e-9)


@pytest.fixture
def file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "search.toml"
    path.write_text(LIGHT)
    return path


def test_a_search_without_a_design_names_the_bound_that_is_missed_by_least(file):
    text = LIGHT.replace(
        ', { quantity = "smallest_index_ratio", at_least = 5, at_most = 9 }', ""
    ).replace("per_round = 5", "per_round = 5, local = 0.0")
    file.write_text(text.replace("1.1 x case", "400 N/mm"))
    answer = call("optimise", str(file), "--workers", "1")
    assert answer.exit_code == 1 and "estimated rate at least 400 N/mm" in answer.stderr
    assert (file.parent / "runs" / "optimise" / "search" / "report.html").exists()


def test_a_search_beyond_the_bound_is_refused_before_it_begins(file):
    file.write_text(SEARCH.format(trials=15000))
    answer = call("optimise", str(file))
    assert answer.exit_code == 2 and "--limit" in sentence(answer)
    assert not (file.parent / "runs").exists()


@pytest.mark.long
def test_a_search_that_is_killed_goes_on_with_the_same_bits_and_computes_nothing_twice(tmp_path):
    """Killed with one worker, ended with two, beside one that nobody disturbed."""
    text = SEARCH.format(trials=12)
    file, folder = tmp_path / "search.toml", tmp_path / "out"
    file.write_text(text)
    command = [
        sys.executable,
        *MODULE,
        *f"optimise {file} --output {folder} --json --workers".split(),
    ]
    with subprocess.Popen(
        [*command, "1"], cwd=tmp_path, env=process_environment(), stdout=subprocess.DEVNULL
    ) as began:
        wait_until(
            lambda: points_kept(folder / "points") >= 12 or began.poll() is not None, "12 points"
        )
        began.kill()
    assert began.returncode == -signal.SIGKILL
    ended = subprocess.run(
        [*command, "2"], cwd=tmp_path, env=process_environment(), capture_output=True, text=True
    )
    assert ended.returncode == 0, ended.stderr
    data = json.loads(ended.stdout)
    whole = vt.optimise(text, workers=1)
    same(whole, data["rows"])
    assert 0 < data["computed"] <= whole.computed - 12
    states = {one.state for one in whole.trials}
    assert {"refused", "feasible", "infeasible"} <= states
    for one in whole.trials:  # what cannot be built has no number
        assert bool(one.failure) == (one.state == "refused") and (
            not one.failure or not np.any(np.isfinite(one.objectives))
        )
    best = whole.best.trial
    (bracket,) = best.measured.limits[whole.plan.objectives[0].measure]
    assert best.objectives[0] == bracket.value and best.objectives[0] >= whole.case.objectives[0]


def test_a_search_that_is_stopped_keeps_what_it_has_and_goes_on(tmp_path, monkeypatch):
    """By a signal after a few rounds: trials in the exception; by the command, all files of them
    and the exit code of Ctrl-C.
    """

    def stop(share: float, words: str) -> None:
        if "of 40 trials" in words and int(words.split()[0]) >= 25:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as cut:
        vt.optimise(LIGHT, workers=1, output=tmp_path / "out" / "points", progress=stop)
    held = cut.value.result
    assert (
        not held.finished
        and 25 <= len(held.trials) < len(light().trials)
        and "stopped before its end" in repr(held)
    )
    assert all(
        np.array_equal(one.values, two.values)
        for one, two in zip(held.trials, light().trials, strict=False)
    )
    again = vt.optimise(LIGHT, workers=1, output=tmp_path / "out" / "points")
    assert again.computed <= light().computed - 20
    same(again, light().to_pandas().to_dict("records"))

    def interrupted(*_: object, **__: object) -> None:
        raise Interrupted(held)

    monkeypatch.setattr("valvetrain.explore.optimise.STEPS", (*STEPS[:2], interrupted))
    (tmp_path / "light.toml").write_text(LIGHT)
    answer = call("optimise", str(tmp_path / "light.toml"), "--output", str(tmp_path / "out"))
    assert answer.exit_code == 130 and "start the command again to continue" in answer.stderr
    assert {"trials.csv", "report.html", "optimise.json"} <= {
        path.name for path in (tmp_path / "out").iterdir()
    }


def test_seed_and_rounds_alone_decide_which_designs_are_looked_at():
    first, again, other = (
        light(),
        vt.optimise(LIGHT, workers=2),
        vt.optimise(LIGHT.replace("per_round = 5", "per_round = 5, seed = 7"), workers=1),
    )
    assert all(
        np.array_equal(one.values, two.values)
        for one, two in zip(first.trials, again.trials, strict=True)
    )
    assert not all(
        np.array_equal(one.values, two.values)
        for one, two in zip(first.trials[1:], other.trials[1:], strict=False)
    )
    designs = [one.values.tobytes() for one in first.trials]
    assert first.computed <= len(set(designs)) + 1  # a design that comes twice is computed once


def test_a_library_that_is_not_installed_is_said_in_one_sentence(monkeypatch):
    monkeypatch.setitem(sys.modules, "optuna", None)
    with pytest.raises(vt.ValvetrainError, match=r"pip install 'valvetrain\[studies\]'"):
        vt.optimise(LIGHT, workers=1)
