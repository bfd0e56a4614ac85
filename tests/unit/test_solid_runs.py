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
from validation.calculix.jobs import SolidSpring, axial_modes
from validation.calculix.results import last_field, read_fields, read_printed
from validation.calculix.solver import run_deck
from validation.calculix.transient import TransientJob

from valvetrain.continuum.mesh import MeshOptions
from valvetrain.continuum.mesh_file import write_mesh
from valvetrain.errors import InputError, MissingExtraError
from valvetrain.parameters.constructors import cylindrical

PRINTED = """
     E I G E N V A L U E   O U T P U T

 MODE NO    EIGENVALUE                       FREQUENCY
                                     REAL PART            IMAGINARY PART
                           (RAD/TIME)      (CYCLES/TIME     (RAD/TIME)

      1   0.1188937E+08   0.3448096E+04   0.5487816E+03   0.0000000E+00
      2   0.1506657E+08   0.3881569E+04   0.6177708E+03   0.0000000E+00

     P A R T I C I P A T I O N   F A C T O R S

MODE NO.   X-COMPONENT     Y-COMPONENT     Z-COMPONENT     X-ROTATION      Y-ROTATION      Z-ROTATION

      1   0.4013146E-12   0.9732983E-03   0.4786473E-02  -0.1703272E-01  -0.1698305E-02   0.7047506E-02
      2  -0.1586592E-11  -0.1323719E-03  -0.6875028E-03   0.2316508E-02  -0.8026360E-02   0.5388074E-01

     E F F E C T I V E   M O D A L   M A S S

                    E I G E N V A L U E    N U M B E R     1


 total force (fx,fy,fz) for set RETAINER and time  0.1000000E+01

        8.342939E+02 -5.785951E+03 -2.845407E+04

                    E I G E N V A L U E    N U M B E R     2


 total force (fx,fy,fz) for set RETAINER and time  0.1000000E+01

        2.034118E+03  9.971953E+02  5.179156E+03

 total force (fx,fy,fz) for set RETAINER and time  0.1000000E+01

        5.357870E-11  2.422305E-01 -2.741949E+00

 displacements (vx,vy,vz) for set AXIS and time  0.1000000E+01

         7  1.000000E+00  2.000000E+00 -3.000000E+00
         9  0.000000E+00  0.000000E+00 -4.000000E+00

 statistics for slave set ABOVE1, master set BELOW1 and time  0.1000000E+01

   total surface force (fx,fy,fz) and moment about the origin (mx,my,mz)

    1.000000E+00  0.000000E+00  5.000000E+00  0.000000E+00  0.000000E+00  0.000000E+00

   center of gravity and mean normal

             NaN           NaN           NaN           NaN           NaN           NaN

   moment about the center of gravity(mx,my,mz)

             NaN           NaN           NaN

   area,  normal force (+ = tension) and shear force (size)

    2.000000E-01 -5.000000E+00  1.000000E-01
"""

FIELDS = """\
    1C
    2C                             2                                     1
 -1         1 1.01670E+01 8.39409E-02-8.28797E-01
 -3
  100CL  101 1.000000000           2                     0    1           1
 -4  DISP        4    1
 -5  D1          1    2    1    0
 -5  D2          1    2    2    0
 -5  D3          1    2    3    0
 -5  ALL         1    2    0    0    1ALL
 -1         1 1.00000E+00-2.00000E+00 3.00000E+00
 -1         3 4.00000E+00 5.00000E+00-6.00000E-01
 -3
  100CL  102 2.000000000           2                     0    1           1
 -4  DISP        4    1
 -5  D1          1    2    1    0
 -1         1 1.00000E+00
"""


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


def test_printed_results_are_sorted_into_modes_and_steps():
    printed = read_printed(PRINTED)
    assert printed.natural_frequencies[0] == pytest.approx([548.7816, 617.7708])
    assert [row[0, 2] for row in printed.modal("total force", "RETAINER")] == pytest.approx(
        [-28454.07, 5179.156]
    )
    # Both clamps together accelerate the mass of the mode: here each takes half.
    assert printed.participation[0].shape == (2, 6)
    assert -0.1188937e8 * printed.participation[0][0, 2] == pytest.approx(2 * -28454.07, rel=1e-4)
    # The static step ends at the time at which the modes were printed, and is still told apart.
    time, rows = printed.history("total force", "RETAINER")
    assert time.tolist() == [1.0] and rows[0][0, 2] == pytest.approx(-2.741949)
    assert printed.history("displacements", "AXIS")[1][0].tolist() == [[7, 1, 2, -3], [9, 0, 0, -4]]
    assert printed.history("contact", "ABOVE1")[1][0][-1, 1] == -5


def test_a_cut_off_field_is_dropped():
    fields = read_fields(FIELDS)
    assert [field.time for field in fields] == [1.0]
    displacement = last_field(fields, "DISP")
    assert displacement.values.tolist() == [[1, -2, 3], [4, 5, -0.6]]
    assert np.isnan(displacement.dense(3)[1]).all() and displacement.dense(3)[2, 2] == -0.6


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


def test_a_motion_that_fails_is_a_solution_with_a_status(stand_in):
    from validation.calculix.transient import run_transient

    from valvetrain.cam.build import build_lift_law
    from valvetrain.parameters.loading import load_case

    work = stand_in("printf ' *ERROR in arpack: no room\n'\nexit 201\n")
    case = load_case("gu2021-beehive-blind")
    job = TransientJob(build_lift_law(case.lift_law), 800.0, 7e-3, 1.5, 2.0)
    solution = run_transient(SolidSpring(case.springs[0].wire), job, case.name)
    assert solution.status.code == "not-converged" and "no room" in solution.status.message
    assert solution.model == "solid" and solution.engine_speed == 800.0 and len(solution.time) == 0
    assert solution.statistics["elements"] > 0 and list(work.iterdir()) == []


def test_signs_divide_clusters_of_axial_modes():
    assert axial_modes(np.array([0.87, 0.02, 0.05, -0.3, -0.73, -0.07, 0.2, 0.44, 0.1])) == (
        0,
        4,
        7,
    )
    assert axial_modes(np.zeros(0)) == ()


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
