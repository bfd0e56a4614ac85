"""Each command with a folder of results is killed by SIGKILL behind its first file, and takes that
folder back.

Evidence: processes that end at that moment. ``python -m faults`` repeats it at any moment.
"""

from __future__ import annotations

import os
import sys
import tempfile

import pytest
from faults.commands import COMMANDS, OBSERVED, answer_in, words, write_inputs

from unit.cli_parts import call
from valvetrain.registry import places

pytestmark = pytest.mark.skipif(
    os.name != "posix", reason="kills by signals, which Windows does not have"
)
#: Commands without a folder of results.
WITHOUT = {"cases", "check", "compare-runs", "findings", "new", "quantities", "runs", "serve"}


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    return write_inputs(tmp_path_factory.mktemp("killed"))


def killed(command, folder, behind):
    """What the command left that ended behind that file."""
    (folder / "temporary").mkdir(exist_ok=True)
    child = os.fork()  # a process of its own without the start of an interpreter
    if child == 0:
        try:
            with open(folder / "told.log", "w") as told:
                for stream in (1, 2):
                    os.dup2(told.fileno(), stream)
            os.chdir(folder)
            tempfile.tempdir = os.environ["TMPDIR"] = str(folder / "temporary")
            sys.stdout, sys.stderr = sys.__stdout__, sys.__stderr__
            sys.argv = ["valvetrain", str(behind), *words(command)]
            exec(OBSERVED, {"__name__": "observed"})
        finally:
            os._exit(1)
    _, status = os.waitpid(child, 0)
    assert os.waitstatus_to_exitcode(status) == -9, (folder / "told.log").read_text()
    return {path.name for path in (folder / "out").iterdir()}


def test_no_command_is_left_out():
    assert {*COMMANDS} | WITHOUT == {*places("commands")}


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_a_killed_command_takes_its_folder_back(command, inputs, tmp_path, monkeypatch):
    """Seven of them refused it for ever."""
    for path in inputs.iterdir():
        (tmp_path / path.name).symlink_to(path)
    left = killed(command, tmp_path, 1)
    assert left and "run.json" not in left and not list((tmp_path / "temporary").iterdir())
    monkeypatch.chdir(tmp_path)
    again = call(*words(command))
    assert again.exit_code == 0, again.output
    assert answer_in(tmp_path / "out")
    names = [path.name for path in (tmp_path / "out").rglob("*")]
    assert not [name for name in names if name.endswith((".part", "runs.jsonl"))], names


@pytest.mark.slow
def test_a_search_leaves_nothing_in_the_temporary_directory(inputs, tmp_path):
    """The file of Optuna stayed there."""
    for path in inputs.iterdir():
        (tmp_path / path.name).symlink_to(path)
    for behind in (2, 3, 4):
        killed("optimise", tmp_path, behind)
        assert not list((tmp_path / "temporary").iterdir())
