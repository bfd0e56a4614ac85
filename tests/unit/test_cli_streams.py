"""Streams that are closed, readers that leave, and names that are no text: the work is done, kept,
and told of by the exit code.
"""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from unit.cli_parts import MODULE, call, process_environment, sentence
from valvetrain.cli.outcome import mend_streams
from valvetrain.errors import InputError
from valvetrain.parameters.loading import LIBRARY
from valvetrain.runs.run_folders import check_folder
from valvetrain.solution.atomic import check_target, write_text

pytestmark = pytest.mark.skipif(
    os.name != "posix", reason="streams are closed as a POSIX shell closes them"
)
RUN = "run job-t --model massless --no-report --rpm '3000 rpm' --output out"


def shell(command: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[bytes]:
    """``command`` in a shell, where ``vt`` is the command line of the package."""
    whole = f'vt() {{ "{sys.executable}" {" ".join(MODULE)} "$@"; }}\n{command}'
    return subprocess.run(
        ["bash", "-c", os.fsencode(whole)],
        cwd=folder,
        capture_output=True,
        timeout=120,
        env=process_environment(**environment),
    )


def kept(folder: Path) -> float:
    """The peak force that the kept run in ``folder`` tells."""
    return json.loads((folder / "run.json").read_text())["runs"][0]["quantities"][
        "peak_spring_force"
    ]["value"]


@pytest.mark.parametrize("closed", ["<&- >&- 2>&-", "--json >&-"])
def test_a_run_with_closed_streams_is_kept_and_ends_well(closed, tmp_path):
    """A closed stream frees its number for the next file that is opened, and what prints would
    write into that file.
    """
    result = shell(f"vt {RUN} {closed}", tmp_path)
    assert result.returncode == 0
    assert b"fault" not in result.stderr and b"Traceback" not in result.stderr
    assert kept(tmp_path / "out") == pytest.approx(522, abs=1)
    assert (tmp_path / "out" / "massless-3000rpm.nc").read_bytes().startswith(b"\x89HDF")


@pytest.mark.parametrize("command", ["cases", RUN])
def test_the_exit_code_tells_of_the_work_not_of_a_reader_that_left(command, tmp_path):
    result = shell(f"vt {command} | true; exit ${{PIPESTATUS[0]}}", tmp_path)
    assert result.returncode == 0
    assert not [
        line for line in result.stderr.decode().splitlines() if not line.startswith("compiling")
    ]


@pytest.mark.parametrize("words", ["--help | true", "run --help | head -1", "--version | true"])
def test_a_shell_sees_the_help_end_well(words, tmp_path):
    result = shell(f"vt {words}; exit ${{PIPESTATUS[0]}}", tmp_path)
    assert (result.returncode, result.stderr) == (0, b"")


def test_an_error_that_is_none_of_the_reader_keeps_its_code(tmp_path, monkeypatch):
    """A pipe that broke elsewhere, with standard output read to its end, is a failure."""

    def broken(*_, **__):
        raise BrokenPipeError(32, "Broken pipe")

    monkeypatch.setattr("valvetrain.runs.saved_runs.list_saved_runs", broken)
    assert call("runs", "--folder", str(tmp_path)).exit_code == 1


def test_a_run_that_failed_says_so_to_a_reader_that_left(tmp_path):
    result = shell("vt run missing.toml | true; exit ${PIPESTATUS[0]}", tmp_path)
    assert result.returncode == 2 and b"check the path" in result.stderr


@pytest.mark.skipif(
    not Path("/dev/full").exists(), reason="this system has no device that is always full"
)
def test_an_output_that_takes_nothing_is_named_and_the_run_is_kept(tmp_path):
    result = shell(f"vt {RUN} > /dev/full", tmp_path)
    assert result.returncode == 1 and b"No space left on device (standard output)" in result.stderr
    assert kept(tmp_path / "out") == pytest.approx(522, abs=1)


@pytest.mark.parametrize("locale", ["C"])
def test_names_that_are_no_text_are_read_written_and_shown(locale, tmp_path):
    """Case file, folder of the case and folder of the results in Latin 1, which is not UTF-8."""
    name = b"caf\xe9"
    home = os.fsencode(tmp_path) + b"/" + name
    os.mkdir(home)
    table = "\n".join(
        f"{angle}, {lift}"
        for angle, lift in zip(range(0, 110, 10), [0, 0, 1, 3, 5, 6, 5, 3, 1, 0, 0], strict=True)
    )
    Path(os.fsdecode(home), "lift.csv").write_text(table)
    law = "kind = 'spline'\nfile = 'lift.csv'\nangle_of = 'cam'\nangle_unit = 'deg'\nlift_unit = 'mm'\nlift_of = 'valve'\n"
    spring = (LIBRARY / "job-t.toml").read_text(encoding="utf-8").partition("[lift_law]")[0]
    Path(os.fsdecode(home + b"/f\xe9.toml")).write_text(f"{spring}[lift_law]\n{law}")
    command = (
        "vt run caf\udce9/f\udce9.toml --model massless --rpm '3000 rpm' --output caf\udce9/out"
    )
    result = shell(command, tmp_path, LC_ALL=locale, PYTHONUTF8="0", PYTHONCOERCECLOCALE="0")
    assert result.returncode == 0, result.stderr
    out = Path(os.fsdecode(home), "out")
    assert kept(out) > 0 and "f\ufffd" in (out / "report.html").read_text(encoding="utf-8")
    told = json.loads((out / "run.json").read_bytes())
    assert told["case"] == "f\ufffd" and told["command_line"][2] == "caf\udce9/f\udce9.toml"
    missing = shell("vt run m\udce9.toml --json", tmp_path, LC_ALL=locale)
    assert (
        missing.returncode == 2
        and "there is no file" in json.loads(missing.stdout)["error"]["message"]
    )


def test_a_value_that_is_no_text_is_refused():
    assert "is not UTF-8" in sentence(call("check", "job-t", "--set", "title=\udce9"))


@pytest.mark.parametrize("name", ["", "  "])
def test_an_empty_folder_name_is_refused(name):
    result = call("run", "job-t", "--output", name)
    assert result.exit_code == 2 and "--output: the name of the folder is empty" in sentence(result)


def test_a_folder_that_cannot_be_is_refused_before_the_work(tmp_path):
    """All of these were found out after it."""
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "dangling").symlink_to("nowhere")
    (tmp_path / "file").write_text("1")
    for name, words in {
        "loop": "a link that leads nowhere",
        "loop/under": "a link that leads nowhere",
        "dangling": "a link that leads nowhere",
        "file": "a file, not a folder",
        "file/under": "a file, not a folder",
        "a" * 300: "not a usable folder name",
        "a/" * 3000: "not a usable",
    }.items():
        with pytest.raises(InputError, match=words) as found:
            check_folder(tmp_path / name)
        assert len(str(found.value)) < 300
    assert sorted(path.name for path in tmp_path.iterdir()) == ["dangling", "file", "loop"]


@pytest.mark.skipif(
    not Path("/proc/self").exists(),
    reason="needs a folder that takes no files whatever its permissions say",
)
def test_a_folder_that_takes_no_files_is_refused_before_the_work():
    with pytest.raises(InputError, match="may not be written to"):
        check_folder(Path("/proc/out"))
    with pytest.raises(InputError, match=r"--csv: folder '/proc' may not be written to"):
        check_target("/proc/curve.csv", "--csv")


def test_a_file_never_takes_the_place_of_a_pipe_or_a_folder(tmp_path):
    """Written by a new file that is renamed, a curve for the null device took its place on the
    whole machine.
    """
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    for name, words in {"pipe": "a device or a pipe", "folder": "a folder"}.items():
        with pytest.raises(InputError, match=words):
            write_text(tmp_path / name, "text")
    assert (tmp_path / "pipe").is_fifo() and not list((tmp_path / "folder").iterdir())
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder", "pipe"]


@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "utf-8"])
@pytest.mark.parametrize("name", ["stdout", "stderr"])
def test_what_a_stream_cannot_show_is_written_with_backslashes(name, encoding, monkeypatch):
    """A spring called after the Greek letter and an ohm sign: as it is where the stream knows them,
    else as Python escapes them.
    """
    raw, words = io.BytesIO(), "Feder \u03b1 \u2126 \udcff"
    monkeypatch.setattr(sys, name, io.TextIOWrapper(raw, encoding=encoding))
    mend_streams()
    print(words, file=getattr(sys, name), flush=True)
    greek = "\u03b1 \u2126" if encoding == "utf-8" else "\\u03b1 \\u2126"
    assert raw.getvalue().decode(encoding).strip() == f"Feder {greek} \\udcff"


def test_without_a_terminal_the_time_left_is_told_once_and_without_what_came_before(
    monkeypatch, capsys
):
    """Closed form: a twentieth of the work in 10 s leaves 190 s; what came before the first report does not count."""
    from valvetrain.cli import progress

    clock = iter((100.0, 110.0, 120.0, 130.0))
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(clock))
    with progress.progress_bar("engine") as report:
        for done in (0.0, 0.05, 0.1, 0.15):
            report(done, "")
    assert capsys.readouterr().err.splitlines() == ["engine: about 3 min left"]
