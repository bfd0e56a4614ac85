"""Unit: columns of a measured curve are what their headings, or the file of the
identification, say; never what stands first.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import valvetrain as vt
from study_parts import identification_plan

HEAD = """
case = "job-t"
[quantities.wire]
key = "spring.wire_diameter"
prior = "normal"
mean = "4 mm"
standard_deviation = "0.1 mm"
[measurements.tester]
file = "tester.csv"
scatter = "1 N"
"""


def read(folder: Path, table: str, more: str = ""):
    (folder / "tester.csv").write_text(table)
    return identification_plan(HEAD + more, "test", folder)


CURVES = [
    ("compression [mm], load [N]\n3, 90\n5, 150\n", "", "force"),
    ("load [N]; deflection [mm]\n90; 3\n150; 5\n", "", "force"),
    ("Federweg [mm]; Kraft [kN]\n3; 0.09\n5; 0.15\n", "", "force"),
    ("height [mm], force [N]\n3, 90\n5, 150\n", "", "load"),
    (
        "force [N], length [cm], time [s]\n90, 0.3, 1\n150, 0.5, 2\n",
        'columns = ["force", "height", "ignore"]\n',
        "load",
    ),
    ("3 90\n5 150\n", 'columns = ["height", "force"]\nunits = ["mm", "N"]\n', "load"),
    ("3 90\n5 150\n", 'columns = ["compression", "force"]\nunits = ["mm", "N"]\n', "force"),
    ("90 3\n150 5\n", 'columns = ["force", "compression"]\nunits = ["N", "mm"]\n', "force"),
    ("force [lb], height [in]\n20.23281, 0.1181102\n33.72135, 0.1968504\n", "", "load"),
]


@pytest.mark.parametrize(("table", "more", "kind"), CURVES)
def test_a_curve_is_over_height_or_compression_as_its_headings_say(tmp_path, table, more, kind):
    """3 and 5 mm with 90 and 150 N in every form, other columns left out."""
    request = read(tmp_path, table, more)
    assert {one.kind for one in request.fitted.targets} == {kind}
    np.testing.assert_allclose([one.at for one in request.fitted.targets], [3e-3, 5e-3], rtol=1e-6)
    np.testing.assert_allclose([datum.value for datum in request.data], [90.0, 150.0], rtol=1e-6)


@pytest.mark.parametrize(
    ("table", "more", "words"),
    [
        ("s [mm], force [N]\n3, 90\n5, 150\n", "", "gives a travel from anywhere"),
        ("3 90\n5 150\n", 'units = ["mm", "N"]\n', "tester.csv does not say which of its 2 columns is what"),
        ("height [mm], compression [mm], force [N]\n3, 1, 90\n5, 2, 150\n", "", "does not say which of its 3 columns"),
        ("height [mm], force [N]\n3, 90\n", 'columns = ["height", "load"]\n', "a column is one of .*, not 'load'"),
        ("height [mm], force [N]\n3, 90\n", 'columns = ["height"]\n', "has 2 columns and 1 are given; say what each is"),
        ("height, force\n3, 90\n", "", "does not say the unit of its length"),
        ("height [N], force [mm]\n3, 90\n", "", "'N' is no unit of length"),
        ("height [mm], force [mm]\n3, 90\n", "", "'mm' is no unit of force"),
        ("height [mm]\n3\n", "", "does not say which of its 1 columns"),
    ],
)  # fmt: skip
def test_a_curve_whose_columns_are_not_told_is_refused_at_its_file(tmp_path, table, more, words):
    with pytest.raises(vt.InputError, match=words) as refusal:
        read(tmp_path, table, more)
    assert "measurements.tester.file" in str(refusal.value)
