"""Deck, solver calls and readers of the solid model, without the solver: stand-in programs and
short result texts.
"""

from __future__ import annotations

import stat
import tempfile

import numpy as np
import pytest
from validation.calculix.deck import (
    SolidContact,
)
from validation.calculix.jobs import SolidSpring
from validation.calculix.solver import run_deck

from spring_shapes import cylindrical
from valvetrain.continuum.mesh import MeshOptions
from valvetrain.continuum.mesh_file import write_mesh
from valvetrain.errors import InputError, MissingExtraError


@pytest.fixture
def model() -> SolidSpring:
    return SolidSpring(
        cylindrical(3.8e-3, 22e-3, 7e-3, 6.0), MeshOptions(8, 1, 1, ends="bonded"), SolidContact()
    )


@pytest.fixture
def stand_in(tmp_path, monkeypatch):
    """Installs a shell script in place of the solver; its working folders come under tmp_path/work."""
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(work))

    def install(script: str):
        program = tmp_path / "fake-ccx"
        program.write_text("#!/bin/sh\n" + script)
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setenv("CCX", str(program))
        return work

    return install


def test_time_limit_becomes_a_status_and_leaves_nothing(stand_in):
    work = stand_in("echo started\nexec sleep 20\n")
    output = run_deck("*HEADING\n", time_limit=0.3)
    assert output.status.code == "interrupted" and "0.3 s" in output.status.message
    assert output.wall_time < 5 and list(work.iterdir()) == []


def test_error_exit_becomes_a_status_with_the_solvers_reason(stand_in, model):
    work = stand_in(
        "printf ' *ERROR: too many cutbacks\\n        best solution in the frd file\\n'\nexit 201\n"
    )
    curve = model.static_curve(5e-3)
    assert curve.status.code == "not-converged" and "too many cutbacks" in curve.status.message
    assert curve.compression.tolist() == [0.0] and list(work.iterdir()) == []
    assert model.modes(0.0).status.code == "not-converged"


@pytest.mark.parametrize("ending", ["vtu", "vtk", "msh"])
def test_mesh_files_hold_the_mesh(model, tmp_path, ending):
    meshio = pytest.importorskip("meshio")
    path = write_mesh(model.mesh, tmp_path / f"spring.{ending}")
    again = meshio.read(path)
    assert again.cells[0].type == "hexahedron20"
    assert np.allclose(
        again.points[again.cells[0].data], model.mesh.coordinates[model.mesh.elements], atol=1e-9
    )
    assert [item.name for item in tmp_path.iterdir()] == [path.name]


def test_mesh_export_without_meshio_names_the_command(model, tmp_path, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "meshio", None)
    with pytest.raises(MissingExtraError, match="pip install"):
        write_mesh(model.mesh, tmp_path / "spring.vtu")
    assert list(tmp_path.iterdir()) == []


def test_unknown_mesh_ending_is_refused(model, tmp_path):
    pytest.importorskip("meshio")
    with pytest.raises(InputError, match="names no format"):
        write_mesh(model.mesh, tmp_path / "spring.stl")
