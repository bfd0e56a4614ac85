"""Example: the ten notebooks of the documentation run, hold at most ten lines of code with public
names alone, and their numbers are those of the command line for the same case.

Those that take seconds run with ``make test-long`` and in every build of the documentation.
"""

from __future__ import annotations

import ast
import contextlib
import io
import json
import runpy
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import valvetrain
from valvetrain.cli.main import app

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = sorted((ROOT / "examples" / "notebooks").glob("*.py"))
named = pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)


def run(number: int) -> tuple[dict, str]:
    """Names of a notebook after it ran, and what it printed."""
    (path,) = (one for one in PROGRAMS if one.stem.startswith(f"n{number:02d}"))
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        return runpy.run_path(str(path)), output.getvalue()


def by_command(folder: Path, *arguments: str) -> dict:
    """What the command line answers, as JSON."""
    found = CliRunner().invoke(app, [*arguments, "--json", "--output", str(folder / "out")])
    assert found.exit_code == 0, found.output[-500:]
    return json.loads(found.stdout)


def same_numbers(solution, answer: dict) -> None:
    """Every number of a run of Python is that of the same run of the command line."""
    (of_command,) = (one for one in answer["runs"] if one["label"] == solution.label)
    values = {name: one["value"] for name, one in of_command["quantities"].items()}
    shared = [name for name in solution.quantities if name in values]
    assert len(shared) > 10 and set(solution.quantities) - set(values) == set()
    for name in shared:
        assert values[name] == pytest.approx(solution.quantities[name], rel=1e-9, nan_ok=True), name


@named
def test_a_notebook_uses_public_names_alone(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    modules = {
        name
        for node in ast.walk(tree)
        if isinstance(node, (ast.Import, ast.ImportFrom))
        for name in ([node.module] if isinstance(node, ast.ImportFrom) else [node.names[0].name])
    }
    assert not [one for one in modules if one.startswith("valvetrain.")]
    used = [node for node in ast.walk(tree) if isinstance(node, ast.Attribute)]
    assert not [one.attr for one in used if one.attr.startswith("_")]
    of_package = {
        one.attr for one in used if isinstance(one.value, ast.Name) and one.value.id == "vt"
    }
    assert of_package and of_package <= set(valvetrain.__all__)


def test_load_change_plot_as_by_the_command_line(tmp_path):
    scope, printed = run(1)
    wire, model = "spring.wire_diameter=3.9 mm", "modal-uniform"
    request = ("--set", wire, "--rpm", "6000 rpm", "--model", model)
    answer = by_command(tmp_path, "run", "job-t", *request)
    same_numbers(scope["run"], answer)
    assert printed == "seat force -104 to 772 N\n"


@pytest.mark.parametrize(("number", "engine_speed"), [(3, "5500 rpm"), (4, "6000 rpm")])
def test_what_is_made_from_parts_has_a_file_that_the_command_line_runs(
    number, engine_speed, tmp_path
):
    scope, _ = run(number)
    file = scope["case"].save(tmp_path / "own.toml")
    solutions = [scope["run"]] if number == 3 else scope["both"].solutions
    models = [part for one in solutions for part in ("--model", one.model)]
    answer = by_command(tmp_path, "run", str(file), "--rpm", engine_speed, *models)
    for one in solutions:
        same_numbers(one, answer)


def test_saved_and_loaded():
    scope, printed = run(9)
    assert printed.splitlines() == ["True True", "{'operation.cycles': (2, 3)}"]
    assert scope["case"] == valvetrain.Case("job-t").set({"operation.cycles": 3})


def test_internals_agree_with_the_events_of_the_run():
    scope, _ = run(10)
    solution, touched = scope["run"], scope["touched"]
    assert solution.quantities["peak_clash_force"] == pytest.approx(float(touched.max()), rel=0.3)
    assert len(scope["modes"].axial_frequencies) == 3
    assert np.all(np.diff(scope["modes"].axial_frequencies) > 0)


@pytest.mark.long
@pytest.mark.parametrize(
    ("number", "printed"),
    [
        (2, "335 N at 10 mm, first mode 422 Hz"),
        (5, "200 designs, 481 to 682 N"),
        (6, "float from 7200 rpm on with a valve of 48 g"),
        (7, "damping 7.93 us, 4.9 N left over"),
        (8, "spring.wire diameter"),
    ],
)
def test_the_longer_notebooks_answer(number, printed):
    assert printed in run(number)[1]
