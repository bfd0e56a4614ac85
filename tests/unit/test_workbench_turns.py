"""Two visitors at once, a full disk, names of any kind: one change at a time, one sentence, nothing
half made.

Evidence: threads that meet at the worst moment, errors of the system put where it may give them,
what stands on disk afterwards.
"""

from __future__ import annotations

import errno
import shutil
import threading
import time

import pytest

from valvetrain.errors import InputError
from valvetrain.workbench import saved_runs as saved_tests
from valvetrain.workbench import side_files as passing
from valvetrain.workbench.edits import read_change
from valvetrain.workbench.saved_runs import MAX_TESTS, keep_test
from valvetrain.workbench.workspace import Workspace
from workbench_parts import SMALL, SPRING, TABLE, kept, lifts


def at_once(*calls):
    """What each call raised, None where it did not; all begin together."""
    found, start = [None] * len(calls), threading.Barrier(len(calls))

    def one(place):
        start.wait(10)
        try:
            calls[place]()
        except Exception as error:
            found[place] = error

    threads = [threading.Thread(target=one, args=(place,)) for place in range(len(calls))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(30)
    return found


@pytest.fixture
def workspace(tmp_path):
    return Workspace(tmp_path / "bench")


@pytest.fixture
def table(workspace):
    """A case that names its table of lifts."""
    return workspace.upload("small.toml", (SPRING + TABLE).encode(), {"lift.txt": lifts()})


def test_a_file_goes_or_is_named_never_both(workspace, table, monkeypatch):
    """A value that names a file is read while another tab removes that file: one of the two is
    refused, and the case reads.
    """
    workspace.attach(table, "other.txt", lifts(8.0))
    reading = threading.Event()

    def slow(*given):
        found = read_change(*given)
        reading.set()
        time.sleep(0.1)
        return found

    def gone():
        reading.wait(10)
        workspace.detach(table, "other.txt")

    monkeypatch.setattr("valvetrain.workbench.workspace.read_change", slow)
    named, removed = at_once(lambda: workspace.set_value(table, "lift_law.file", "other.txt"), gone)
    monkeypatch.undo()
    assert named is None and isinstance(removed, InputError) and "so it stays" in str(removed)
    assert workspace.read(table).lift_law is not None


def test_no_more_tests_are_kept_than_may_be(workspace, monkeypatch):
    run = workspace.run(kept(workspace))
    for place in range(MAX_TESTS - 1):
        keep_test(run, f"t{place}.csv", b"1")
    monkeypatch.setattr(
        saved_tests, "refuse_living", lambda folder: time.sleep(0.05)
    )  # between the check and the writing
    refused = at_once(
        *(lambda place=place: keep_test(run, f"n{place}.csv", b"1") for place in range(3))
    )
    assert (
        len([one for one in refused if isinstance(one, InputError)]) == 2
        and refused.count(None) == 1
    )
    assert len(saved_tests.saved_tests(run)) == MAX_TESTS


def full(*_, **__):
    raise OSError(errno.ENOSPC, "No space left on device")


@pytest.mark.parametrize("where", ["write_text", "write_bytes"])
def test_a_full_disk_leaves_no_case(workspace, monkeypatch, where):
    monkeypatch.setattr(passing, where, full)
    for make in (
        lambda: workspace.new_case("a", "spring"),
        lambda: workspace.upload("a.toml", (SPRING + TABLE).encode(), {"lift.txt": lifts()}),
    ):
        refused = None
        try:
            make()
        except InputError as error:
            refused = str(error)
            assert "cannot be written (no space left on device); free space" in refused
        assert refused is not None or where == "write_bytes", "a template has no file"
        monkeypatch.undo()
        assert list(workspace.cases_folder.iterdir()) == [
            workspace.case_folder(one.name) for one in workspace.cases()
        ]
        assert not list(workspace.jobs_folder.iterdir())
        for one in workspace.cases():
            shutil.rmtree(workspace.case_folder(one.name))
        assert workspace.new_case("a", "spring") == "a"
        shutil.rmtree(workspace.case_folder("a"))
        monkeypatch.setattr(passing, where, full)


def test_what_a_killed_server_was_making_is_no_case(workspace):
    left = workspace.cases_folder / ".new-abc" / "mine"
    left.mkdir(parents=True)
    (left / "case.toml").write_text(SMALL)
    (workspace.cases_folder / ".new-abc" / "case.toml").write_text(SMALL)
    mine = workspace.upload("upload-abc.toml", SMALL.encode())
    assert [card.name for card in workspace.cases()] == [mine] == ["upload-abc"]
    workspace.hold()()
    assert [path.name for path in workspace.cases_folder.iterdir()] == [mine]
