"""``compare`` of a spring by rod, modal model and solid finite elements: pairing of modes, refusals, the run itself."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from unit.cli_parts import MODULE, SMALL, call, process_environment, sentence
from valvetrain.quantities.spring_comparison import differences, match_modes
from valvetrain.solution.modal import ModalResult
from valvetrain.solution.netcdf import load_modal_result, load_netcdf, load_static_curve
from valvetrain.solution.static import SpringAtRest, StaticCurve

ALL = ("--spring", "finite-element,modal-varied,solid")
COARSE = ("--solid-elements-per-coil", "6")


@pytest.fixture
def small(tmp_path):
    path = tmp_path / "small.toml"
    path.write_text(SMALL)
    return str(path)


def modes(frequencies, shapes, points=41):
    """Modes whose wire moves as sines of a number of half waves along one axis: ``shapes`` (half waves, axis)."""
    coil = np.linspace(0.0, 3.0, points)
    shape = np.zeros((len(frequencies), points, 3))
    for place, (waves, axis) in enumerate(shapes):
        shape[place, :, axis] = np.sin(waves * np.pi * coil / 3)
    axial = tuple(place for place, (_, axis) in enumerate(shapes) if axis == 2)
    return ModalResult(1e-3, np.array(frequencies, dtype=float), shape, coil, np.ones(len(frequencies)), axial)


def straight(rate, reach, steps):
    x, none = np.linspace(0.0, reach, steps), np.zeros((steps, 0))
    return StaticCurve(x, rate * x, np.full(steps, rate), none, none, np.zeros(0), none, np.zeros(0))


def test_modes_that_change_places_are_paired_by_shape():
    first = modes([500, 510, 900], [(1, 2), (1, 0), (2, 2)])
    second = modes([504, 507, 905, 906], [(1, 0), (1, 2), (3, 1), (2, 2)], points=17)
    pairs = match_modes(first, second)
    assert {mode: partner for mode, (partner, _) in pairs.items()} == {0: 1, 1: 0, 2: 3}
    assert all(share == pytest.approx(1.0, abs=1e-2) for _, share in pairs.values())


def test_modes_of_unlike_shape_are_no_pair():
    assert match_modes(modes([500], [(1, 2)]), modes([500], [(1, 0)])) == {}
    assert match_modes(modes([], []), modes([500], [(1, 0)])) == {}


def test_differences_are_those_of_the_inputs():
    solid = SpringAtRest("spring", "solid", curve=straight(50e3, 2.2e-3, 12), modes=modes([500.0], [(1, 2)]))
    rod = SpringAtRest("spring", "finite-element", curve=straight(51e3, 2.2e-3, 34), modes=modes([495.0], [(1, 2)]))
    rows = differences((solid, rod), 2e-3)
    assert [row.quantity for row in rows] == ["force"] * 5 + ["mean stiffness", "natural frequency"]
    assert rows[3].place == pytest.approx(2e-3) and rows[3].values["solid"] == pytest.approx(100.0)
    assert [row.relative("finite-element", "solid") for row in rows] == pytest.approx([0.02] * 6 + [-0.01])
    assert rows[-1].axial == 1 and rows[-1].relative("modal-varied", "solid") is None
    # Beyond the end of a curve nothing is compared.
    short = SpringAtRest("spring", "finite-element", curve=straight(51e3, 1e-3, 34), modes=modes([495.0], [(1, 2)]))
    assert "finite-element" not in differences((solid, short), 2e-3)[4].values


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
        ((*ALL, "--solid-time-limit", "0 s"), "above 0"),
        ((*ALL, "--solid-motion", "90"), "85:105 deg"),
        ((*ALL, "--solid-motion", "110:90 deg"), "beyond the first"),
        ((*ALL, "--solid-motion", "150:160 deg"), "starts at rest"),
        ((*ALL, "--solid-motion", "90:95 deg", "--engine-speed", "4000, 5000 rpm"), "one engine speed"),
    ],
)
def test_wrong_options_are_told_in_a_sentence(small, tmp_path, monkeypatch, words, told):
    monkeypatch.setenv("CCX", "/bin/true")  # refusals come before any run
    result = call("compare", small, *words, "--output", str(tmp_path / "out"))
    assert result.exit_code == 2 and told in sentence(result)


def test_a_train_is_told_that_the_solid_is_for_springs(tmp_path):
    result = call("compare", "tdi-pushrod", "--spring", "multi-mass,solid", "--output", str(tmp_path / "out"))
    assert result.exit_code == 2 and "spring alone" in sentence(result)


@pytest.mark.skipif(os.name != "posix", reason="a shell script stands in for the solver")
def test_an_interrupt_stops_the_solver_and_clears_its_files(small, tmp_path):
    work, program, mark = tmp_path / "work", tmp_path / "ccx", tmp_path / "solver.pid"
    work.mkdir()
    program.write_text(f"#!/bin/sh\necho $$ > '{mark}'\nexec sleep 60\n")
    program.chmod(0o755)
    command = [sys.executable, *MODULE, "compare", small, "--spring", "solid", *COARSE, "--output", str(tmp_path / "out")]
    environment = process_environment(CCX=str(program), TMPDIR=str(work))
    run = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment)
    end = time.monotonic() + 60
    while not (mark.exists() and mark.read_text().strip()) and time.monotonic() < end:
        time.sleep(0.05)
    time.sleep(1.0)  # past the rod's part, into the wait for the solver
    run.send_signal(signal.SIGINT)
    _, told = run.communicate(timeout=30)
    assert run.returncode == 130 and told.splitlines()[-1].startswith("interrupted"), told
    assert list(work.iterdir()) == []
    with pytest.raises(ProcessLookupError):
        os.kill(int(mark.read_text()), 0)


@pytest.mark.calculix
def test_a_spring_by_three_models(small, tmp_path):
    target = tmp_path / "out"
    words = ("--solid-elements-per-coil", "8", "--set", "spring.options.finite-element.elements_per_coil=16", "--workers", "2")
    result = call("compare", small, *ALL, *words, "--solid-motion", "98:112 deg", "--output", str(target), "--json")
    assert result.exit_code == 0, result.stderr
    assert "statics and modes take about" in result.stderr and "the motion of" in result.stderr
    data = json.loads(result.stdout)
    assert data["completed"] and [one["model"] for one in data["springs_at_rest"]] == ["solid", "finite-element", "modal-varied"]
    # The two models share nothing but the definition: coarse as both are, they agree to a few per cent.
    rest = [load_static_curve(target / f"static-small-{model}.nc") for model in ("solid", "finite-element")]
    modes_of = [load_modal_result(target / f"modes-small-{model}.nc") for model in ("solid", "finite-element")]
    pair = tuple(SpringAtRest("small", name, 2e-3, *both) for name, *both in zip(("solid", "finite-element"), rest, modes_of, strict=True))
    rows = differences(pair, 2e-3)
    forces = [row for row in rows if row.quantity == "force"]
    assert any(row.place == pytest.approx(2e-3, rel=1e-9) for row in forces)
    assert all(abs(row.relative("finite-element", "solid")) < 0.015 for row in forces)
    axial = next(row for row in rows if row.quantity == "natural frequency" and row.axial)
    assert abs(axial.relative("finite-element", "solid")) < 0.01
    assert data["springs_at_rest"][0]["static_curve"]["force"]["values"][-1] == pytest.approx(rest[0].force[-1])
    stretch = [load_netcdf(target / f"{name}-9000rpm.nc") for name in ("solid", "finite-element-as-the-solid")]
    assert stretch[0].model == "solid" and stretch[0].cam_angle == pytest.approx(stretch[1].cam_angle)
    page = (target / "report.html").read_text()
    for part in ("Spring at rest", "Static curve", "Natural modes", "solid finite elements", "finite-element rod"):
        assert part in page
