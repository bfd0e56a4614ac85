"""Runs that were begun and not finished are listed as such: what they hold, whether they go on, and
the command that began them.
"""

from __future__ import annotations

import json
import os
import signal
import sys

import pytest

from fault_parts import gone, started
from unit.cli_parts import SMALL, call, sentence, typed, wait_until
from valvetrain.errors import InputError
from valvetrain.runs.run_folders import (
    LIST,
    lock_folder,
    mark_unfinished,
    unfinished_runs,
)
from valvetrain.runs.saved_runs import SavedRun, list_saved_runs

pytestmark = pytest.mark.skipif(
    os.name != "posix", reason="living runs are known by the lock of a POSIX system"
)
ROW = {"label": "massless", "command_line": ["valvetrain", "sweep", "my case.toml"]}


def begun(root, name: str, rows: list[object], files: tuple[str, ...] = ()):
    """A folder as a killed run leaves it."""
    folder = root / "job" / name
    folder.mkdir(parents=True)
    (folder / LIST).write_text("".join(json.dumps(row) + "\n" for row in rows))
    for file in files:
        (folder / file).write_text("x")
    return folder


def test_folders_of_killed_and_of_living_runs_are_told_apart(tmp_path):
    killed = begun(
        tmp_path,
        "20260102-030405-unfinished",
        [ROW, {"label": "b"}],
        ("run-0001.nc", "run-0002.nc"),
    )
    final = begun(tmp_path, "20260102-030407-0123abcd", [{}], ("report.html",))
    living = tmp_path / "job" / "20260102-030406-unfinished"
    handle = mark_unfinished(living)
    none = begun(tmp_path, "20260101-000000-unfinished-2", [])
    odd = begun(tmp_path, "20260102-030408-unfinished", [])
    (odd / LIST).write_bytes(b"\xff\xfe{[\n" + b"[" * 100_000)
    (tmp_path / "job" / "20269999-999999-unfinished").mkdir()
    (tmp_path / "job" / "mine").mkdir()
    (tmp_path / "job" / "link-unfinished").symlink_to(killed)
    whole = begun(tmp_path, "20260103-000000-89abcdef", [ROW])
    (whole / "run.json").write_text(
        json.dumps({"created_at": "2026-01-03T00:00:00+00:00", "case": "job"})
    )
    found = unfinished_runs(root=tmp_path)
    os.close(handle)
    assert [(one.folder, one.finished, one.files, one.living) for one in found] == [
        (odd, 1, 0, False),
        (final, 1, 1, False),
        (living, 0, 0, True),
        (killed, 2, 2, False),
        (none, 0, 0, False),
    ]
    assert (
        found[3].command == "valvetrain sweep 'my case.toml'"
        and found[3].created_at == "2026-01-02T03:04:05+00:00"
    )
    assert found[0].command_line == found[4].command_line == () and {one.case for one in found} == {
        "job"
    }
    assert (
        unfinished_runs("job", tmp_path)[0].folder == odd
        and unfinished_runs("other", tmp_path) == ()
    )
    assert [run.folder for run in list_saved_runs(root=tmp_path)] == [whole]


@pytest.mark.parametrize("command", ["run", "refine"])
def test_a_folder_that_another_run_writes_into_is_refused_and_loses_nothing(command, tmp_path):
    """The second of two runs in one folder emptied the list of the first and took away what it had
    kept.
    """
    (tmp_path / "small.toml").write_text(SMALL)
    handle = mark_unfinished(tmp_path / "out")
    os.write(handle, json.dumps({"file": "run-0001.nc"}).encode() + b"\n")
    (tmp_path / "out" / "run-0001.nc").write_text("kept")
    said = sentence(call(command, str(tmp_path / "small.toml"), "--output", str(tmp_path / "out")))
    assert "another run writes into folder" in said and "choose another" in said
    with pytest.raises(InputError, match="another run writes"):
        mark_unfinished(tmp_path / "out")
    assert (tmp_path / "out" / "run-0001.nc").read_text() == "kept" and (
        tmp_path / "out" / LIST
    ).stat().st_size > 0
    os.close(handle)
    os.close(mark_unfinished(tmp_path / "out"))  # the first is gone now
    assert (
        not (tmp_path / "out" / "run-0001.nc").exists()
        and (tmp_path / "out" / LIST).read_text() == ""
    )


@pytest.mark.parametrize("command", ["run", "refine", "spring-card"])
def test_of_two_begun_at_the_same_moment_the_second_is_refused(command, tmp_path):
    """Before either has a finished run to list: each wrote its files between those of the other."""
    (tmp_path / "small.toml").write_text(SMALL)
    card = typed(
        "--wire-diameter '4.4 mm' --outer-diameter '32 mm' --installed '46 mm, 350 N' --open-load '34 mm, 830 N'"
    )
    asked = card if command == "spring-card" else (str(tmp_path / "small.toml"),)
    release = lock_folder(tmp_path / "deep" / "out")
    said = sentence(call(command, *asked, "--output", str(tmp_path / "deep" / "out")))
    assert (
        "another run writes into folder" in said
        and list((tmp_path / "deep" / "out").iterdir()) == []
    )
    release()
    assert not (tmp_path / "deep").exists()
    if command == "spring-card":
        for _ in range(2):  # given back when the command has ended
            assert (
                call(
                    command, *asked, "--output", str(tmp_path / "deep" / "out"), "--quiet"
                ).exit_code
                == 0
            )


@pytest.mark.parametrize(
    "cut",
    [
        '{"file": "run-0002.nc", "quantities": {"peak_for',
        '{"file": "run-0002.nc"}',
        "{",
        "[1]\n",
        "\n",
    ],
)
def test_a_line_that_a_kill_cut_costs_no_other(cut, tmp_path):
    """It counted as a finished run, and what the others listed was left in the folder for good."""
    folder = begun(
        tmp_path,
        "20260102-030405-unfinished",
        [{**ROW, "file": "run-0001.nc"}, {"file": "run-0003.nc"}],
        ("run-0001.nc", "run-0003.nc"),
    )
    with (folder / LIST).open("a") as stream:
        stream.write(cut)
    (one,) = unfinished_runs(root=tmp_path)
    assert one.finished == 2 + cut.endswith("\n") and one.command_line == tuple(ROW["command_line"])
    os.close(mark_unfinished(folder))
    assert [path.name for path in folder.iterdir()] == [LIST]


def test_a_refinement_clears_what_a_killed_run_left_in_its_folder(tmp_path):
    (tmp_path / "small.toml").write_text(
        SMALL.replace("elements_per_coil = 6", "elements_per_coil = 8")
    )
    folder = begun(tmp_path, "out", [{"file": "run-0001.nc"}], ("run-0001.nc",))
    result = call(
        "refine", str(tmp_path / "small.toml"), "--output", str(folder), "--workers", "1", "--quiet"
    )
    assert result.exit_code == 0, result.stderr
    assert sorted(path.name for path in folder.iterdir()) == [
        "inputs",
        "levels.csv",
        "report.html",
        "run.json",
        "uncertainty.csv",
    ]


@pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="finds processes by their environment in /proc"
)
def test_a_run_that_is_killed_is_listed_with_what_it_holds_and_how_to_go_on(tmp_path):
    words = typed(
        "sweep tdi-pushrod --rpm '1000:5000:25 rpm' --model massless --spring-set stock "
        "--no-critical-speeds --workers 1 --set 'title=two words'"
    )
    with started(*words, folder=tmp_path) as (run, mark):
        wait_until(
            lambda: (
                [path.read_bytes().count(b"\n") > 1 for path in tmp_path.glob(f"runs/*/*/{LIST}")]
                == [True]
            ),
            "some runs are finished",
        )
        living = json.loads(call("runs", "--folder", str(tmp_path / "runs"), "--json").stdout)[
            "unfinished"
        ]
        assert [one["state"] for one in living] == ["going on"]
        run.send_signal(signal.SIGKILL)
        run.wait()
        gone(mark)
    (one,) = json.loads(
        call("runs", "tdi-pushrod", "--folder", str(tmp_path / "runs"), "--json").stdout
    )["unfinished"]
    assert (
        one["state"] == "killed"
        and one["finished_runs"] > 1
        and one["command_line"] == ["valvetrain", *words]
    )
    shown = call("runs", "--folder", str(tmp_path / "runs"))
    assert "next: valvetrain sweep tdi-pushrod --rpm '1000:5000:25 rpm'" in shown.stdout


@pytest.mark.parametrize(
    ("answer", "expected"),
    [
        ({"completed": True}, "completed"),
        ({"completed": False, "failures": ["a: diverged"]}, "failed"),
        ({}, "failed"),
        (
            {"runs": [{"status": {"code": "completed"}}, {"status": {"code": "interrupted"}}]},
            "interrupted",
        ),
        ({"failures": ["interrupted: 3 of 8 runs were finished"]}, "interrupted"),
    ],
)
def test_runs_that_were_interrupted_are_told_from_those_that_failed(answer, expected, tmp_path):
    assert SavedRun(tmp_path, answer).state == expected
