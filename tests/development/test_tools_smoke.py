"""Every tool of the repository runs with its smallest input: benchmarks, scripts, faults and seeded
faults (``make bench`` and so on).
"""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from architecture.layout import ROOT

TOOLS = [
    *(path.stem for path in sorted((ROOT / "scripts").glob("*.py"))),
    *(
        f"{folder}.{path.stem}"
        for folder in ("benchmarks", "faults", "mutants")
        for path in sorted((ROOT / folder).glob("[!_]*.py"))
    ),
]


def run(*arguments: str, folder: Path = ROOT) -> str:
    """What a tool prints, started as make starts it."""
    places = os.pathsep.join(map(str, (ROOT / "src", ROOT)))
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": places},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout


@pytest.mark.parametrize("name", TOOLS)
def test_every_tool_is_imported(name):
    assert importlib.import_module(name).__doc__


def test_a_whole_train_is_measured_against_general_integrators():
    from benchmarks import train_jobs

    rows = train_jobs.one_run(cycles=1, repeats=1)
    assert len(rows) == 6 and all(row.wall > 0 for row in rows)
    errors = {row.program: row.error for row in rows if row.error == row.error}
    assert errors["valvetrain"] < 1e-3
    assert errors["solve_ivp DOP853"] < 1e-2, "the general integrator solves another train"


def test_a_sweep_of_two_speeds_is_measured():
    from benchmarks import train_jobs

    assert "2 settled" in train_jobs.sweep(speeds=2, workers=1).note


@pytest.mark.parametrize(
    ("job", "given"),
    [
        ("transient", ("T", 6, "stiffness", 1)),
        ("transient", ("C", 6, "mass", 1)),
        ("static", (6, 1)),
        ("modes", (6, 1)),
        ("batch", (6, 2, 1)),
        ("chain", (1,)),
    ],
)
def test_a_job_on_a_single_spring_is_measured(job, given):
    from benchmarks import own

    found = getattr(own, f"job_{job}")(*given)
    assert found["cpu"] > 0 and np.all(np.isfinite(found["trace"]))


def test_what_is_compiled_first_is_measured():
    from benchmarks import main_job, start_up

    compile(main_job.CODE.format(folder="here"), "main job", "exec")
    wall, cpu, memory = start_up.run(
        "\n".join((start_up.FIRST_STEP, start_up.TRAIN, start_up.BATCH)),
        {"PYTHONPATH": f"{ROOT / 'src'}:{ROOT}"},
    )
    assert wall > 0 and cpu > 0 and memory > 10


def test_points_of_a_study_are_measured():
    from benchmarks import study_points

    assert study_points.wall_time("multi-mass", 2, 1) > 0


@pytest.mark.slow
def test_faults_break_no_promise():
    assert "| commands killed, then started again | 1 |" in run("-m", "faults", "--most", "1")


def test_faults_are_listed():
    assert "2 faults" in run("-m", "mutants", "--list", "--sample", "2", "--folders", "cam")


def test_the_tests_of_a_room_are_chosen():
    listed = run("scripts/test_fast.py", "springs", "--list").splitlines()
    chosen = [line for line in listed if line.startswith("run: distance 0")]
    assert any("test_spring_models" in line for line in chosen) and listed[-1].endswith("left out")


def test_the_package_is_counted():
    folders = {line.split()[0] for line in run("scripts/count_source.py").splitlines()}
    assert {"springs", "sum"} <= folders


def test_the_accuracy_of_scans_and_films_is_measured(tmp_path, capsys):
    import film_accuracy
    import measure_scans

    measure_scans.large(tmp_path, 4000)
    film_accuracy.damping(films=1)
    printed = capsys.readouterr().out
    assert "4000 points" in printed and "damping: rms" in printed
