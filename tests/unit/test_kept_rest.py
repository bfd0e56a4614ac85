"""``static`` and ``modes`` in their folders, and the progress that a command tells to a file
descriptor.

Evidence: the folder on disk read by the run store, and lines that came over a pipe of the system.
"""

from __future__ import annotations

import json
import os

import pytest

from unit.cli_parts import SMALL, call
from valvetrain.cli.progress import PROGRESS_VARIABLE, progress_bar, tell_progress
from valvetrain.runs.saved_runs import find_run
from valvetrain.views.page import data_of


@pytest.fixture
def small(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(SMALL)
    return tmp_path


@pytest.mark.parametrize(
    ("command", "more"),
    [("static", ("--steps", "4")), pytest.param("modes", ("--count", "3"), marks=pytest.mark.long)],
)
def test_springs_at_rest_are_kept_as_a_run_is(small, command, more):
    plain = json.loads(call(command, "small.toml", *more, "--output", "own", "--json").stdout)
    assert (small / "own" / "report.html").is_file() and not (small / "runs").exists()
    result = call(command, "small.toml", *more, "--json")
    assert result.exit_code == 0, result.stderr
    told = json.loads(result.stdout)
    run = find_run("small")
    assert (
        run.answer["command"] == command
        and run.answer["completed"] is True
        and (small / told["folder"]).samefile(run.folder)
    )
    assert told["springs_at_rest"] == plain["springs_at_rest"]
    assert told["findings"][0]["level"] == "decides"
    assert all((small / name).is_file() for name in told["files"])
    page = data_of((small / told["page"]).read_text(encoding="utf-8"))
    assert page and {"static": "data-rest", "modes": "data-surge-orders"}[command] in page
    again = json.loads(call(command, str(run.folder), *more, "--json").stdout)
    assert again["springs_at_rest"] == plain["springs_at_rest"], "it is repeated from its folder"


def test_progress_is_told_to_whoever_asked_for_it(monkeypatch):
    reading, writing = os.pipe()
    try:
        monkeypatch.setenv(PROGRESS_VARIABLE, str(writing))
        with progress_bar("small") as report:
            report(0.5, "massless at 4000 rpm")
        tell_progress(None, "writing files")
        monkeypatch.setenv(PROGRESS_VARIABLE, "no number")
        tell_progress(1.0, "nobody hears it")
        monkeypatch.setenv(PROGRESS_VARIABLE, "999999")
        tell_progress(1.0, "nor this")
        lines = os.read(reading, 10_000).decode().splitlines()
    finally:
        os.close(reading)
        os.close(writing)
    assert [json.loads(line) for line in lines] == [
        {"share": 0.0, "text": "small"},
        {"share": 0.5, "text": "massless at 4000 rpm"},
        {"share": None, "text": "writing files"},
    ]
