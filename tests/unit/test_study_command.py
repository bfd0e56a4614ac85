"""``valvetrain study``: its answer, and that a study that is killed or stopped goes on where it
was, with the same bits.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import valvetrain as vt
from unit.cli_parts import MODULE, call, hear_interrupts, process_environment, wait_until
from valvetrain.explore.files import FileText
from valvetrain.explore.outputs import Run, Task
from valvetrain.explore.store import FILE, Store
from valvetrain.explore.study import StudyModel, read_plan

#: A grid of short runs; one in four has a lift beyond coil bind.
GRID = """
case = "gu2021-beehive-blind"
engine_speeds = "6000 rpm"
spring_models = ["{model}"]
outputs = ["peak_spring_force", "clash_count"]
points = {{ sampler = "grid", levels = {levels} }}
[[vary]]
key = "lift_law.maximum_lift"
low = "9 mm"
high = "20 mm"
[[vary]]
key = "spring.precompression"
low = "6 mm"
high = "8 mm"
"""


def study_text(model="multi-mass", levels=4) -> str:
    return GRID.format(model=model, levels=levels)


@pytest.fixture
def file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "grid.toml"
    path.write_text(study_text())
    return path


def values_in(data: dict, table: vt.explore.StudyTable) -> np.ndarray:
    """The outputs of a JSON answer, row by row."""
    return np.array([[row[name] for name in table.outputs] for row in data["rows"]], dtype=float)


@cache
def table_of(levels: int = 4, workers: int = 1) -> vt.explore.StudyTable:
    return vt.study(study_text(levels=levels), workers=workers)


def test_the_answer_is_one_json_object_with_every_point_and_its_status(file):
    answer = call("study", str(file), "--workers", "1", "--json")
    assert answer.exit_code == 0
    data = json.loads(answer.stdout)
    assert data["points"] == 16 and data["computed"] == 16 and len(data["rows"]) == 16
    codes = [row["status"] for row in data["rows"]]
    assert {"completed", "refused"} == set(codes) and data["completed_points"] == codes.count(
        "completed"
    )
    assert len(data["failures"]) == codes.count("refused") and "coil bind" in data["failures"][0]
    table = table_of()
    assert np.array_equal(values_in(data, table), table.values, equal_nan=True)
    assert "J130" in [one["code"] for one in data["findings"]]
    (file.parent / data["page"]).read_text().index("coil bind")
    kept = json.loads((file.parent / data["folder"] / "study.json").read_text())
    assert kept["findings"] == data["findings"]


def test_a_file_in_which_nothing_comes_out_is_a_failure(file):
    file.write_text(study_text().replace('"9 mm"', '"18 mm"'))
    answer = call("study", str(file), "--workers", "1")
    assert answer.exit_code == 1 and "coil bind" in answer.stderr


def test_a_study_beyond_the_bound_is_refused_before_it_begins(file):
    file.write_text(study_text("finite-element", 250))
    answer = call("study", str(file))
    assert (
        answer.exit_code == 2
        and "--limit" in answer.stderr
        and len(answer.stderr.splitlines()) == 1
    )
    assert not (file.parent / "runs").exists()


def points_kept(folder) -> int:
    """Whole lines of the store, read from outside."""
    file = folder / FILE
    return file.read_bytes().count(b"\n") if file.exists() else 0


@pytest.mark.slow
def test_a_study_that_is_ended_goes_on_with_the_same_bits_and_computes_nothing_twice(tmp_path):
    """Ended twice, first in a way that it hears, then in one that it does not."""
    text = study_text(levels=8)
    file, folder = tmp_path / "grid.toml", tmp_path / "out"
    file.write_text(text)
    command = [*MODULE, "study", str(file), "--output", str(folder), "--workers", "2", "--json"]
    for stop, code, kept in ((signal.SIGTERM, 143, 2), (signal.SIGKILL, -9, 8)):
        began = subprocess.Popen(
            [sys.executable, *command], cwd=tmp_path, env=process_environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            preexec_fn=hear_interrupts,
        )  # fmt: skip
        wait_until(
            lambda kept=kept, began=began: (
                points_kept(folder / "points") >= kept or began.poll() is not None
            ),
            f"{kept} points",
        )
        began.send_signal(stop)
        _, said = began.communicate(timeout=60)
        assert began.returncode == code and (
            stop == signal.SIGKILL or b"points are stored in" in said
        )
    here = {"cwd": tmp_path, "env": process_environment()}
    ended = subprocess.run(
        [sys.executable, *command], capture_output=True, text=True, check=True, **here
    )
    data = json.loads(ended.stdout)
    assert 0 < data["computed"] < 64 - 7  # eight were there and are not computed again
    whole = vt.study(text, workers=1)
    assert [row["status"] for row in data["rows"]] == [one.code for one in whole.statuses]
    assert np.array_equal(values_in(data, whole), whole.values, equal_nan=True)
    with Store(folder / "points") as store:
        assert len(store) == 64


LISTED = """
case = "gu2021-beehive-blind"
outputs = ["preload"]
[[vary]]
key = "spring.precompression"
values = ["6 mm", "7 mm", "7.5 mm"]
"""
SECOND = '[[vary]]\nkey = "spring.wire_diameter"\nvalues = ["3.7 mm", "3.8 mm", "3.9 mm"]\n'


def _plan(text: str):
    return read_plan(FileText(text, "study", Path(), StudyModel))


def test_values_that_are_listed_are_run_as_they_are_listed():
    """Contract: a list without a sampler is no range to draw from; of two lists the file says how
    they meet; draws that are counted are drawn.
    """
    np.testing.assert_allclose(_plan(LISTED).draws()[:, 0], [6e-3, 7e-3, 7.5e-3])
    with pytest.raises(vt.InputError, match=r'sampler = "grid".*"list"'):
        _plan(LISTED + SECOND)
    assert len(_plan(f'points = {{ sampler = "grid" }}{LISTED}{SECOND}').draws()) == 9
    assert len(_plan(f"points = {{ count = 20 }}{LISTED}{SECOND}").draws()) == 20


def test_the_answer_is_in_the_units_of_the_reader_and_its_files_are_not(tmp_path, monkeypatch):
    """Values that were varied are converted as outputs are."""
    monkeypatch.chdir(tmp_path)
    text = 'rest_model = "massless"\n' + LISTED
    Path("rest.toml").write_text(text)
    shown = call("study", "rest.toml", "--workers", "1", "--units", "imperial")
    assert "lbf" in shown.stdout and " in" in shown.stdout and "7 mm" not in shown.stdout
    data = json.loads(Path("runs/study/rest/study.json").read_text())
    assert data["units"]["preload"] == "N"
    assert data["rows"][0]["preload"] == vt.study(text, workers=1).values[0, 0]


def test_the_number_of_workers_moves_no_bit():
    one, two = table_of(3), table_of(3, 2)
    assert np.array_equal(one.values, two.values, equal_nan=True) and one.statuses == two.statuses


def test_the_digest_of_a_point_changes_with_everything_of_it():
    """Whatever can move a number gives another key; words that move none give the same."""
    base = study_text()
    run = (600.0, "multi-mass", "")

    def digest(text, values=(9e-3, 7e-3), run=run):
        experiment = _plan(text).experiment
        return experiment.digest(values, Task(Run(*run), experiment.outputs.request))

    first = digest(base)
    others = [
        digest(base, (np.nextafter(9e-3, 1), 7e-3)), digest(base, (7e-3, 9e-3)), digest(base, run=(np.nextafter(600.0, 1e9), *run[1:])),
        digest(base, run=(600.0, "massless", "")), digest(base, run=(600.0, "multi-mass", "stock")),
        digest(base, run=(None, "multi-mass", "")),
        digest(base.replace('"clash_count"', '"clash_energy"')), digest('rest_model = "massless"\n' + base),
        digest('changes = { "operation.cycles" = 3 }\n' + base), digest(base.replace("gu2021-beehive-blind", "job-c")),
        digest(base.replace('key = "spring.precompression"', 'key = "spring.precompression"\nas = "offset"')),
    ]  # fmt: skip
    assert len({first, *others}) == len(others) + 1
    assert (
        digest('title = "other words"\n' + base)
        == digest(base.replace("levels = 4", "levels = 9"))
        == first
    )


def test_the_digest_changes_with_the_source_text_and_the_libraries(monkeypatch):
    from valvetrain.explore import store as versions

    before = versions.versions_digest.__wrapped__()
    assert before == versions.versions_digest.__wrapped__()
    monkeypatch.setattr(versions.platform, "machine", lambda: "another")
    assert versions.versions_digest.__wrapped__() != before


def test_a_table_knows_its_columns_and_its_frame():
    table = table_of()
    frame = table.to_pandas()
    assert list(frame["lift_law.maximum_lift"]) == table.column("lift_law.maximum_lift").tolist()
    assert (
        frame["status"].tolist() == [one.code for one in table.statuses]
        and frame.attrs["units"]["peak_spring_force"] == "N"
    )
    assert f"{np.count_nonzero(table.completed)} of 16 points completed" in repr(table)
    with pytest.raises(vt.InputError, match="has no 'peak'"):
        table.column("peak")
