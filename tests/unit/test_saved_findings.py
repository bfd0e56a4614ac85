"""Every rule on saved runs: one folder, or pair of runs, in which it holds and one in which it does not."""

from __future__ import annotations

import json
import os
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from valvetrain.findings.rules_saved import SavedFacts
from valvetrain.findings.words import Words
from valvetrain.runs.differences import differences
from valvetrain.runs.run_folders import (
    finish_folder,
    mark_unfinished,
    unfinished_folder,
    unfinished_runs,
)
from valvetrain.runs.saved_runs import Inputs, SavedRun, list_saved_runs, save_run
from valvetrain.views.saved import DifferenceAnswer, SavedAnswer

NOON = datetime(2026, 5, 1, 12, 0, 0, tzinfo=UTC)


def saved(root: Path, peak: float = 900.0, minutes: int = 0, rate: int = 30, **more: object) -> SavedRun:  # fmt: skip
    """A run with a spring force (N), saved ``minutes`` after noon, of a spring of a ``rate`` (N/mm)."""
    made = NOON + timedelta(minutes=minutes)
    inputs = Inputs("mine", f'[spring]\nrate = "{rate} N/mm"\n', {}, {"engine_speeds": [4000.0]})
    folder = finish_folder(unfinished_folder("mine", made, root), "mine", inputs.digest, made, root)
    run = {"label": "own", "engine_speed": {"value": 4000.0}, "quantities": {"peak_spring_force": {"value": peak, "unit": "N"}}}  # fmt: skip
    answer = {"command": "run", "case": "mine", "created_at": made.isoformat(), "completed": True, "runs": [run]}  # fmt: skip
    return save_run(folder, inputs, answer | more)


def listed(root: Path) -> SavedAnswer:
    return SavedAnswer(SavedFacts(list_saved_runs(root=root), unfinished_runs(root=root), root), words=Words())  # fmt: skip


def killed(root: Path) -> None:
    folder = unfinished_folder("mine", NOON, root)
    handle = mark_unfinished(folder)
    os.write(handle, json.dumps({"command_line": ["valvetrain", "run", "mine.toml"]}).encode() + b"\n")  # fmt: skip
    os.close(handle)


def test_a_folder_without_runs(tmp_path):
    assert listed(tmp_path).findings.codes == ("J201",)
    saved(tmp_path)
    assert "J201" not in listed(tmp_path).findings.codes


def test_a_killed_run_decides_and_can_be_begun_again(tmp_path):
    saved(tmp_path)
    assert listed(tmp_path).verdict.code == "J204"
    killed(tmp_path)
    answer = listed(tmp_path)
    assert answer.findings.codes == ("J202",) and answer.next_step == "valvetrain run mine.toml"
    assert [line.mark for line in answer.lines] == ["warn", ""] or len(answer.lines) == 2


def test_the_newest_run_that_did_not_complete_decides(tmp_path):
    saved(tmp_path, completed=False, failures=["own: diverged"])
    assert listed(tmp_path).findings.codes == ("J203",)
    saved(tmp_path, minutes=1)
    assert listed(tmp_path).findings.codes == ("J204",)


def test_rows_carry_the_stored_verdict_and_the_next_step_compares_two_inputs(tmp_path):
    told = [{"code": "C101", "level": "decides", "mark": "bad", "text": "loses the cam"}]
    first = saved(tmp_path, findings=told)
    answer = listed(tmp_path)
    assert [(line.mark, line.remark) for line in answer.lines] == [("bad", "loses the cam")]
    assert "compare-runs" not in answer.next_step
    second = saved(tmp_path, minutes=1, rate=40)
    for minutes in range(2, 20):
        saved(tmp_path, minutes=minutes, rate=40)
    answer = listed(tmp_path)
    assert len(answer.lines) == 12 and f"{first.digest} {second.digest}" in answer.next_step


def compared(one: SavedRun, other: SavedRun) -> DifferenceAnswer:
    return DifferenceAnswer(differences(one, other), words=Words())


def bar(force: float) -> dict[str, object]:
    row = {"quantity": "peak_spring_force", "engine_speed": {"value": 4000.0, "unit": "rpm"}}
    return {"uncertainties": [row | {"numerical_uncertainty": {"value": force, "unit": "N"}}]}


@pytest.mark.parametrize(
    ("first", "second", "code"),
    [
        ({}, {"peak": 990.0, "rate": 40}, "J221"), ({}, {"peak": 900.5, "rate": 40}, "J222"),
        (bar(20.0), {"peak": 950.0, "rate": 40, **bar(40.0)}, "J222"), (bar(20.0), {"peak": 950.0, "rate": 40, **bar(20.0)}, "J221"),
        ({}, {"rate": 40}, "J223"), ({}, {}, "J223"),
    ],
)  # fmt: skip
def test_the_largest_change_beyond_its_error_bars_decides(tmp_path, first, second, code):
    answer = compared(saved(tmp_path, **first), saved(tmp_path, minutes=1, **second))
    assert answer.findings.codes == (code,)
    assert ("spring.rate" in answer.verdict.fields["input"]) == ("rate" in second)
    assert len(answer.tables()["inputs"].rows) == ("rate" in second)


def test_two_runs_of_one_variant_each_are_compared_whatever_it_is_called(tmp_path):
    """Two spring sets of a train: their runs have other labels, and their numbers are the same ones."""
    run = {"label": "other", "engine_speed": {"value": 4000.0}, "quantities": {"peak_spring_force": {"value": 950.0, "unit": "N"}}}  # fmt: skip
    error = bar(40.0)["uncertainties"][0] | {"label": "other"}
    one, other = saved(tmp_path), saved(tmp_path, minutes=1, runs=[run])
    assert compared(one, other).findings.codes == ("J221",)
    within = saved(tmp_path, minutes=2, runs=[run], uncertainties=[error | {"numerical_uncertainty": {"value": 60.0, "unit": "N"}}])  # fmt: skip
    assert compared(one, within).findings.codes == ("J222",)


def test_fields_of_a_change(tmp_path):
    one = saved(tmp_path)
    other = saved(tmp_path, 990.0, 1, 40)
    verdict = compared(one, other).verdict
    assert (verdict.quantity, verdict.value, verdict.fields["a"].value) == ("peak_spring_force", 990.0, 900.0)  # fmt: skip
    assert verdict.fields["way"] == "rises" and "more" not in verdict.to_dict()["fields"]


def test_what_failed_or_is_in_one_run_only_is_said(tmp_path):
    more = {"quantities": {"preload": {"value": 250.0, "unit": "N"}}}
    whole, part = saved(tmp_path, **more), saved(tmp_path, minutes=1, failures=["file 'a.csv': no space"])  # fmt: skip
    answer = compared(whole, part)
    assert answer.findings.codes == ("J223", "J230")
    assert {one.code for one in answer.bullets} == {"J230"}
    assert compared(whole, whole).findings.codes == ("J223",)


def test_lists_of_files_load_no_kernels(tmp_path):
    """``runs`` starts at once: what draws or computes is not loaded."""
    import subprocess
    import sys

    code = (
        "import sys; from valvetrain.cli.main import main\nsys.argv = ['valvetrain', 'runs']\n"
        "try: main()\nexcept SystemExit: print(' '.join(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)  # fmt: skip
    assert not {"numba", "scipy", "plotly", "jinja2", "xarray"} & set(done.stdout.split())
