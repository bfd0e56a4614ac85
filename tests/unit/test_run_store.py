"""Runs on disk: never overwritten, with their inputs whole, found again and compared; and what a
request costs.
"""

from __future__ import annotations

import json
import os
import tomllib
from datetime import UTC, datetime, timedelta

import pytest

from unit.cli_parts import SMALL, call
from valvetrain.errors import InputError
from valvetrain.runs.differences import input_differences, result_differences
from valvetrain.runs.run_folders import ANSWER, check_folder, link_latest, new_folder
from valvetrain.runs.saved_runs import (
    Inputs,
    SavedRun,
    collect_inputs,
    find_run,
    list_saved_runs,
    run_of_path,
    save_run,
)

TEXT = '# a remark\n[spring]\nwire_diameter = { value = "4 mm", status = "measured" }\n[lift_law]\nkind = "table"\nfile = "lifts/a.csv"\n'
NOON = datetime(2026, 5, 1, 12, 0, 0, tzinfo=UTC)


def answer(peak: float = 900.0, **more):
    runs = [{
        "label": "massless", "engine_speed": {"value": 4000.0, "unit": "rpm"},
        "quantities": {"peak_spring_force": {"value": peak, "unit": "N"}, "bounce_count": {"value": None, "unit": "1"}},
    }]  # fmt: skip
    still = {"preload": {"value": 250.0, "unit": "N"}}
    return {
        "command": "run",
        "case": "mine",
        "created_at": NOON.isoformat(),
        "completed": True,
        "runs": runs,
        "quantities": still,
    } | more


@pytest.fixture
def source(tmp_path):
    (tmp_path / "lifts").mkdir()
    (tmp_path / "lifts" / "a.csv").write_text("0,0\n1,1\n")
    return tmp_path


def made(root, inputs, found, moment=NOON):
    folder = new_folder(inputs.case, inputs.digest, moment, root)
    run = save_run(folder, inputs, found | {"created_at": moment.isoformat()})
    link_latest(folder)
    return run


def test_inputs_are_whole_and_read_again_from_their_folder(source):
    inputs = collect_inputs("mine", TEXT, source, {"command": "run"})
    run = made(source / "runs", inputs, answer(files=["table.csv"]))
    assert (
        run.folder.parent.name == "mine"
        and run.folder.name == f"20260501-120000-{inputs.digest}"
        and len(inputs.digest) == 8
    )
    tree = tomllib.loads(run.case_file.read_text())
    assert (
        tree["name"] == "mine"
        and tree["lift_law"]["file"] == "a.csv"
        and "# a remark" in run.case_file.read_text()
    )
    assert (run.case_file.parent / "a.csv").read_text() == "0,0\n1,1\n"
    kept = json.loads((run.folder / ANSWER).read_text())
    assert (
        kept["files"] == ["table.csv", "inputs/case.toml", "inputs/a.csv"]
        and kept["digest"] == inputs.digest
    )
    again = collect_inputs(
        "mine", run.case_file.read_text(), run.case_file.parent, {"command": "run"}
    )
    assert again.digest == inputs.digest  # the repeated run is the same run


def test_the_digest_tells_inputs_apart(source):
    one = collect_inputs("mine", TEXT, source, {"command": "run"})
    (source / "lifts" / "a.csv").write_text("0,0\n1,2\n")
    others = (
        collect_inputs("mine", TEXT, source, {"command": "run"}),
        collect_inputs("mine", TEXT + "# b", source, {"command": "sweep"}),
    )
    assert len({one.digest, *(other.digest for other in others)}) == 3


def test_a_file_that_is_gone_is_a_sentence(source):
    with pytest.raises(
        InputError, match=r"the file 'lifts/a\.csv' that case 'mine' names cannot be read"
    ):
        collect_inputs("mine", TEXT, source / "lifts", {})


def test_nothing_is_overwritten_and_the_newest_is_linked(tmp_path):
    inputs = Inputs("a b/c", "x = 1")
    runs = [made(tmp_path, inputs, answer(), NOON) for _ in range(3)]
    assert [run.folder.name[24:] for run in runs] == ["", "-2", "-3"] and runs[
        0
    ].folder.parent.name == "a-b-c"
    later = made(tmp_path, inputs, answer(), NOON + timedelta(days=1))
    link = tmp_path / "a-b-c" / "latest"
    assert link.is_symlink() and os.readlink(link) == later.folder.name
    assert [run.folder.name for run in list_saved_runs(root=tmp_path)] == [
        run.folder.name for run in (later, *reversed(runs))
    ]
    assert run_of_path(link).answer == later.answer


def test_runs_are_found_by_folder_digest_case_and_latest(tmp_path):
    one = made(tmp_path, Inputs("mine", "x = 1"), answer())
    two = made(tmp_path, Inputs("other", "x = 2"), answer(case="other"), NOON + timedelta(hours=1))
    names = (
        str(one.folder),
        str(one.case_file),
        str(one.folder / ANSWER),
        one.digest,
        one.digest[:5],
        one.folder.name,
        "mine",
        "mine/latest",
    )
    assert {find_run(name, tmp_path).folder for name in names} == {one.folder}
    assert find_run("latest", tmp_path).folder == two.folder
    assert [run.case for run in list_saved_runs("other", tmp_path)] == ["other"]
    for name in ("zzzz", "", "a\0b", "nowhere/latest"):
        with pytest.raises(InputError):
            find_run(name, tmp_path)


def test_a_folder_of_something_else_is_refused_and_one_of_a_run_is_renewed(tmp_path):
    folder = tmp_path / "out"
    check_folder(folder)
    folder.mkdir()
    check_folder(folder)
    (folder / "old.csv").write_text("1")
    (folder / "mine.csv").write_text("1")
    with pytest.raises(InputError, match="holds files that no run wrote"):
        check_folder(folder)
    save_run(folder, Inputs("mine", "x = 1"), answer(files=["old.csv"]))
    check_folder(folder)
    (folder / "new.csv").write_text("2")
    save_run(folder, Inputs("mine", "x = 2"), answer(files=["new.csv", "../outside"]))
    assert {path.name for path in folder.iterdir()} == {"new.csv", "mine.csv", "inputs", ANSWER}


def test_a_list_of_files_never_reaches_outside_its_folder(tmp_path):
    (tmp_path / "precious.txt").write_text("kept")
    save_run(tmp_path / "out", Inputs("mine", "x = 1"), answer(files=["../precious.txt"]))
    save_run(tmp_path / "out", Inputs("mine", "x = 1"), answer())
    assert (tmp_path / "precious.txt").read_text() == "kept"


def test_differences_of_inputs_and_results(tmp_path):
    one = made(
        tmp_path,
        Inputs(
            "mine",
            '[spring]\nd = "4 mm"\nk = [{ a = 1 }, { a = 2 }]\n',
            choices={"models": ["a"]},
        ),
        answer(),
    )
    changed = (
        '[spring]\nd = { value = "5 mm", source = "x" }\nk = [{ a = 1 }, { a = 3 }]\nnew = 1\n'
    )
    two = made(
        tmp_path,
        Inputs("mine", changed, choices={"models": ["a"]}),
        answer(990.0, quantities={}),
    )
    assert input_differences(one, two) == (
        ("spring.d", "4 mm", "5 mm"),
        ("spring.k.1.a", 2, 3),
        ("spring.new", None, 1),
    )
    rows = result_differences(one, two)
    assert [(row.quantity, row.run, row.unit, row.a, row.b) for row in rows] == [
        ("peak_spring_force", "massless at 4000 rpm", "N", 900.0, 990.0),
        ("preload", "", "N", 250.0, None),
    ]
    assert (
        rows[0].difference == 90.0
        and rows[0].relative == pytest.approx(0.1)
        and rows[1].difference is None
    )
    assert not input_differences(one, one) and not result_differences(one, one)


def test_numbers_of_the_computation_are_no_difference_and_other_speeds_are_refused(tmp_path):
    """Steps per cycle, time step and cycles until settled stood among the results; 4000 was compared with 8000 rpm."""

    def run(force: float, steps: float, speed: float = 4000.0) -> SavedRun:
        quantities = {
            "peak_spring_force": {"value": force, "unit": "N"},
            "steps_per_cycle_count": {"value": steps, "unit": "1"},
            "time_step_duration": {"value": steps, "unit": "s"},
            "steady_cycles_count": {"value": steps, "unit": "1"},
        }
        row = {"label": "own", "engine_speed": {"value": speed}, "quantities": quantities}
        row["statistics"] = {"steps": {"value": steps, "unit": "1"}}
        search = {"label": "own", "kind": "float", "runs_count": {"value": steps, "unit": "1"}}
        found = {"choices": {"engine_speeds": [speed]}, "runs": [row], "critical_speeds": [search]}
        return SavedRun(tmp_path, found)

    rows = result_differences(run(900.0, 1000.0), run(990.0, 3000.0))
    assert [row.quantity for row in rows] == ["peak_spring_force"]
    assert not result_differences(run(900.0, 1000.0), run(900.0, 3000.0))
    with pytest.raises(InputError) as refused:
        result_differences(run(900.0, 1000.0), run(990.0, 1000.0, 8000.0))
    assert "4000" in str(refused.value) and "8000" in str(refused.value)


def test_a_failed_run_is_named_where_the_numbers_are_the_same(tmp_path, monkeypatch):
    """Contract: a run that lacks files is no equal of a whole one."""
    monkeypatch.chdir(tmp_path)
    lost = "file 'curves.csv': No space left on device"
    for name, failures in (("one", []), ("two", [lost])):
        answer = {"case": "small", "created_at": "2026-01-01", "completed": not failures, "failures": failures}  # fmt: skip
        save_run(tmp_path / name, Inputs("small", SMALL, {}, {}), answer)
    data = json.loads(call("compare-runs", "one", "two", "--json").stdout)
    assert data["failed"] == {"a": [], "b": [lost]}
    assert [one["code"] for one in data["findings"]] == ["J223", "J230"]
