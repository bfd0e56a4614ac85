"""The command as users start it: a process with an exit code, two output streams and a keyboard."""

from __future__ import annotations

import json
import math
import os
import resource
import signal
import subprocess
import sys

import pytest

from unit.cli_parts import (
    MODULE,
    SMALL,
    hear_interrupts,
    process,
    process_environment,
    processor_time,
    sentence,
    typed,
    wait_until,
)

HEAVY = set("numba scipy xarray pint plotly matplotlib pydantic numpy h5py jinja2".split())


def test_help_starts_quickly_and_loads_nothing_heavy(tmp_path):
    """At most 2.2 times the processor time in which the library of commands loads, the best of up to eight each, in turns."""

    def took(*command: str) -> float:  # os.times counts in hundredths of a second
        start = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(
            command, check=True, cwd=tmp_path, env=process_environment(), capture_output=True
        )
        end = resource.getrusage(resource.RUSAGE_CHILDREN)
        return end.ru_utime + end.ru_stime - start.ru_utime - start.ru_stime

    commands = ("-c", "import typer.main, typer.rich_utils"), (*MODULE, "--help")
    library = told = math.inf
    for _ in range(8):
        library, told = (
            min(best, took(sys.executable, *command))
            for best, command in zip((library, told), commands, strict=True)
        )
        if told < 2.2 * library:
            break
    assert 0 < told < 2.2 * library
    code = "import sys; from valvetrain.cli.main import main\ntry: main()\nexcept SystemExit: print(*sys.modules)"
    result = subprocess.run(
        [sys.executable, "-c", code, "--help"],
        capture_output=True,
        text=True,
        check=True,
        env=process_environment(),
    )
    loaded = {name.split(".")[0] for name in result.stdout.splitlines()[-1].split()}
    assert "typer" in loaded and not HEAVY & loaded


@pytest.mark.parametrize(
    ("command", "files", "heavy"),
    [
        ("sweep tdi-pushrod --spring-set stock --no-report --workers 1", {"run.json"}, "valvetrain.springs.finite_element"),
        ("run job-t", {"massless-3000rpm.nc", "massless-3000rpm.csv", "report.html"}, ""),
    ],
)  # fmt: skip
def test_a_run_or_sweep_loads_no_units_library_no_tables_and_no_rod(
    tmp_path, command, files, heavy
):
    """What it never needs cost it half a second of every start, and its files are written without labelled datasets."""
    words = f"{command} --rpm 3000rpm --model massless --quiet --output out".split()
    code = (
        f"import sys; from valvetrain.cli.main import main\nsys.argv = {['valvetrain', *words]}\n"
        "try: main()\nexcept SystemExit as end: assert not end.code, end.code\nprint(' '.join(sys.modules))"
    )
    result = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=process_environment(),
    )
    assert result.returncode == 0, result.stderr
    loaded = set(result.stdout.splitlines()[-1].split())
    assert "numba" in loaded and files <= {path.name for path in (tmp_path / "out").iterdir()}
    assert not {"pint", "xarray", "pandas", "tomlkit", *heavy.split()} & loaded


def test_json_is_alone_on_standard_output_and_words_go_to_standard_error(tmp_path):
    (tmp_path / "small.toml").write_text(SMALL.replace('engine_speeds = "9000 rpm"\n', ""))
    result = process("run", "small.toml", "--no-report", "--json", folder=tmp_path)
    assert result.returncode == 0, result.stderr
    assert json.loads(result.stdout)["completed"] is True
    assert "names no engine speed" in result.stderr


@pytest.mark.skipif(os.name != "posix", reason="sends a signal as the keyboard does")
def test_ctrl_c_ends_at_once_with_one_sentence_and_130(tmp_path):
    (tmp_path / "small.toml").write_text(SMALL)
    command = [
        sys.executable,
        *MODULE,
        *typed(
            "run small.toml --set operation.cycles=10000 --set spring.options.finite-element.elements_per_coil=24 --limit '1 d, 1 TB'"
        ),
    ]
    before = sum(os.times()[2:4])
    with subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
        env=process_environment(),
        preexec_fn=hear_interrupts,
    ) as running:
        assert running.stderr is not None
        # One model is done in a moment, the other has minutes before it.
        listed = "runs/small/*-unfinished/unfinished-runs.jsonl"
        wait_until(
            lambda: any(path.stat().st_size for path in tmp_path.glob(listed)),
            "the first run is finished and listed",
        )
        asked = processor_time(running.pid)
        running.send_signal(signal.SIGINT)
        output, errors = running.communicate(timeout=120)
    used = sum(os.times()[2:4]) - before - asked
    assert running.returncode == 130 and used < 3, (
        f"{used:.1f} s of processor time after the interrupt"
    )
    assert (
        errors.splitlines()[-1].startswith(
            "interrupted: 1 of 2 runs were finished and are saved in 'runs/small/"
        )
        and "Traceback" not in errors
    )
    (answer,) = (
        json.loads(path.read_text()) for path in (tmp_path / "runs").glob("small/2*/run.json")
    )
    states = {run["label"]: run["status"]["code"] for run in answer["runs"]}
    assert (
        states == {"finite-element": "interrupted", "modal-varied": "completed"}
        and not answer["completed"]
    )
    assert "runs/small/" in output


@pytest.mark.skipif(os.name != "posix", reason="sends a signal as the keyboard does")
def test_ctrl_c_ends_worker_processes_too(tmp_path):
    mark, job = tmp_path / "begun", tmp_path / "job.py"
    job.write_text(
        f"import time\nwith open({str(mark)!r}, 'a') as file:\n    file.write('x')\ntime.sleep(60)\n"
    )
    code = (
        "import runpy; from valvetrain import map; from valvetrain.cli import main\n"
        f"main.app.command('x')(lambda: map(runpy.run_path, [{str(job)!r}] * 4, 2))\n"
        "import sys; sys.argv = ['valvetrain', 'x']; main.main()"
    )
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "preexec_fn": hear_interrupts}
    with subprocess.Popen(
        [sys.executable, "-c", code],
        text=True,
        env=process_environment(),
        start_new_session=True,
        **pipes,
    ) as running:
        wait_until(lambda: mark.exists() and mark.stat().st_size == 2, "both workers begin")
        os.killpg(running.pid, signal.SIGINT)
        _, errors = running.communicate(timeout=60)
    assert (
        running.returncode == 130
        and errors.startswith("interrupted: ")
        and len(errors.splitlines()) == 1
    )
    wait_until(lambda: not group_lives(running.pid), "the worker processes end")


def group_lives(group: int) -> bool:
    """Whether any process of a group is left."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def test_an_unexpected_error_is_a_sentence_unless_its_origin_is_asked_for(tmp_path):
    code = (
        "import valvetrain.parameters.loading as loading\n"
        "def broken(*_): raise ZeroDivisionError('nought')\n"
        "loading.load_case = broken\n"
        "from valvetrain.cli.main import main; main()"
    )
    command = [sys.executable, "-c", code, "check", "job-c"]
    result = subprocess.run(command, capture_output=True, text=True, env=process_environment())
    assert result.returncode == 1 and "fault in valvetrain (ZeroDivisionError: nought)" in sentence(
        result
    )
    shown = subprocess.run(
        command, capture_output=True, text=True, env=process_environment(VALVETRAIN_TRACEBACK="1")
    )
    assert shown.returncode == 1 and "Traceback" in shown.stderr
