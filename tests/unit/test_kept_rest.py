"""``static`` and ``modes`` with ``--keep``, and the progress that a command tells to a file
descriptor.

Evidence: the folder on disk read by the run store, and lines that came over a pipe of the system.
"""

from __future__ import annotations

import json
import os
from types import SimpleNamespace

import pytest

from unit.cli_parts import SMALL, call
from valvetrain.cli import static as keep_rest
from valvetrain.cli.outcome import Outcome
from valvetrain.cli.progress import PROGRESS_VARIABLE, progress_bar, tell_progress
from valvetrain.runs.saved_runs import find_run


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
    plain = json.loads(call(command, "small.toml", *more, "--json").stdout)
    assert not (small / "runs").exists()
    result = call(command, "small.toml", *more, "--keep", "--json")
    assert result.exit_code == 0, result.stderr
    told = json.loads(result.stdout)
    run = find_run("small")
    assert (
        run.answer["command"] == command
        and run.answer["completed"] is True
        and (small / told["folder"]).samefile(run.folder)
    )
    assert told["springs_at_rest"] == plain["springs_at_rest"], "keeping changes no number"
    assert all((small / name).is_file() for name in told["files"])
    assert f'data-chart="{command}-1"' in (small / told["page"]).read_text(encoding="utf-8")
    again = json.loads(call(command, str(run.folder), *more, "--json").stdout)
    assert again["springs_at_rest"] == plain["springs_at_rest"], "it is repeated from its folder"


@pytest.mark.parametrize(
    ("failures", "missing", "told"),
    [
        ((), (), ()),
        (("a",), (), ("a",)),
        ((), ("b",), ("b",)),
        (("a", "b"), ("b", "c"), ("a", "b", "c")),
    ],
)
@pytest.mark.parametrize("page", [True, False])
def test_what_is_kept_is_said_with_the_answer_and_all_that_failed(
    tmp_path, monkeypatch, failures, missing, told, page
):
    parts = SimpleNamespace(
        page=tmp_path / "page.html" if page else None,
        data=(tmp_path / "a.csv",),
        figures=(),
        gaps=missing,
    )
    written, said = [], []

    def keep_run(request, text, choices, data, write, made_by, begun, gaps):
        written.extend(write(tmp_path))
        assert data["completed"] is (not told) and data["failures"] == list(told), (
            "run.json says so too"
        )
        assert choices == {"steps": 4, "spring_models": ["rod", "chain"]} and (
            request.command,
            text,
            made_by,
        ) == ("static", "text", "me")
        return tmp_path, ["files"]

    monkeypatch.setattr("valvetrain.cli.run_answer.keep_run", keep_run)
    monkeypatch.setattr("valvetrain.report.study.write_parts", lambda study, target, *_: parts)
    rest = tuple(SimpleNamespace(model=word) for word in ("rod", "chain", "rod"))
    study = SimpleNamespace(
        command="static", rest=rest, record=SimpleNamespace(text="text"), provenance="me"
    )
    outcome = Outcome({"answer": 1}, lambda console: console.print("the answer"), failures)
    found = keep_rest.saved_outcome(outcome, study, None, tmp_path, {"steps": 4})
    found.show(SimpleNamespace(print=lambda words, **more: said.append(words)))
    assert said == ["the answer", f"\nsaved in {tmp_path}"] and found.failures == told
    assert written == [*parts.data, *([parts.page] if page else [])]
    assert found.data == {
        "answer": 1,
        "folder": str(tmp_path),
        "files": ["files"],
        "page": str(parts.page) if page else None,
        "completed": not told,
        "failures": list(told),
    }


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
