"""``compare`` of a spring by rod, modal model and solid finite elements: refusals, the run itself."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from unit.cli_parts import (
    MODULE,
    SMALL,
    call,
    hear_interrupts,
    process_environment,
    processor_time,
    sentence,
    wait_until,
)
from valvetrain.solution.netcdf import load_modal_result, load_static_curve

ALL = ("--spring", "finite-element,modal-varied,solid")
COARSE = ("--solid-elements-per-coil", "6")


@pytest.fixture
def small(tmp_path):
    path = tmp_path / "small.toml"
    path.write_text(SMALL)
    return str(path)


def test_without_the_solver_the_command_to_install_it_is_named(small, tmp_path, monkeypatch):
    monkeypatch.delenv("CCX", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    result = call("compare", small, *ALL, "--output", str(tmp_path / "out"))
    assert result.exit_code == 2 and "apt install calculix-ccx" in sentence(result)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--spring", "finite-element,solidd"), "solid"),
        (("--spring", "finite-element", *COARSE), "add --spring"),
        ((*ALL, "--solid-elements-per-coil", "2"), "greater than or equal to 4"),
        ((*ALL, "--solid-core", "0"), "greater than or equal to 1"),
        ((*ALL, "--solid-time-limit", "0 s"), "above zero"),
    ],
)
def test_wrong_options_are_told_in_a_sentence(small, tmp_path, monkeypatch, words, told):
    monkeypatch.setenv("CCX", "/bin/true")  # refusals come before any run
    result = call("compare", small, *words, "--output", str(tmp_path / "out"))
    assert result.exit_code == 2 and told in sentence(result)


def test_a_train_is_told_that_the_solid_is_for_springs(tmp_path):
    result = call(
        "compare", "tdi-pushrod", "--spring", "multi-mass,solid", "--output", str(tmp_path / "out")
    )
    assert result.exit_code == 2 and "spring alone" in sentence(result)


def stands_still(process_id: int) -> bool:
    """Whether a process uses next to no processor time for a while: it waits, or the machine is so
    busy that it does not come to work.
    """
    before = processor_time(process_id)
    time.sleep(0.5)
    return processor_time(process_id) - before < 0.1


@pytest.mark.skipif(os.name != "posix", reason="a shell script stands in for the solver")
def test_an_interrupt_stops_the_solver_and_clears_its_files(small, tmp_path):
    work, program, mark = tmp_path / "work", tmp_path / "ccx", tmp_path / "solver.pid"
    work.mkdir()
    program.write_text(f"#!/bin/sh\necho $$ > '{mark}'\nexec sleep 60\n")
    program.chmod(0o755)
    command = [
        sys.executable,
        *MODULE,
        "compare",
        small,
        "--spring",
        "solid",
        *COARSE,
        "--output",
        str(tmp_path / "out"),
    ]
    environment = process_environment(CCX=str(program), TMPDIR=str(work))
    pipes = {"stderr": subprocess.PIPE, "stdout": subprocess.PIPE, "preexec_fn": hear_interrupts}
    run = subprocess.Popen(command, text=True, env=environment, **pipes)
    wait_until(lambda: mark.exists() and bool(mark.read_text().strip()), "the solver starts")
    wait_until(lambda: stands_still(run.pid), "the rod's part is done and the solver is waited for")
    run.send_signal(signal.SIGINT)
    _, told = run.communicate(timeout=60)
    assert run.returncode == 130 and told.splitlines()[-1].startswith("interrupted"), told
    assert list(work.iterdir()) == []
    with pytest.raises(ProcessLookupError):
        os.kill(int(mark.read_text()), 0)


@pytest.mark.calculix
@pytest.mark.long
def test_a_spring_by_three_models(small, tmp_path):
    target = tmp_path / "out"
    words = (
        "--solid-elements-per-coil",
        "8",
        "--set",
        "spring.options.finite-element.elements_per_coil=16",
        "--workers",
        "2",
    )
    result = call(
        "compare",
        small,
        *ALL,
        *words,
        "--output",
        str(target),
        "--json",
    )
    assert result.exit_code == 0, result.stderr
    assert "statics and modes take about" in result.stderr
    data = json.loads(result.stdout)
    assert data["completed"] and [one["model"] for one in data["springs_at_rest"]] == [
        "solid",
        "finite-element",
        "modal-varied",
    ]
    # The two models share nothing but the definition: coarse as both are, they agree to a few per
    # cent.
    rest = [
        load_static_curve(target / f"static-small-{model}.nc")
        for model in ("solid", "finite-element")
    ]
    solid, rod = (
        load_modal_result(target / f"modes-small-{model}.nc")
        for model in ("solid", "finite-element")
    )
    places = np.array([0.5e-3, 1e-3, 1.5e-3, 2e-3, rest[0].compression[-1]])
    forces = [np.interp(places, one.compression, one.force) for one in rest]
    assert rest[1].compression[-1] >= places[-1] * (1 - 1e-6)
    assert forces[1] == pytest.approx(forces[0], rel=0.015)
    assert rod.axial_frequencies[0] == pytest.approx(solid.axial_frequencies[0], rel=0.01)
    assert data["springs_at_rest"][0]["static_curve"]["force"]["values"][-1] == pytest.approx(
        rest[0].force[-1]
    )
    page = (target / "report.html").read_text()
    for part in (
        "Spring at rest",
        "Static curve",
        "Natural modes",
        "solid finite elements",
        "finite-element rod",
    ):
        assert part in page
