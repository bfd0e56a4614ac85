"""Unit: the small table of every kind of result, cell by cell under its heads, as notebooks show
it.
"""

from __future__ import annotations

import re
from html import unescape
from types import SimpleNamespace

import numpy as np
import pytest

from unit.test_result_display import RPM, curve, modes, quantities, solution, study
from valvetrain.compare_test.compare import ModelAgainstTest
from valvetrain.explore.identified import Branch, Identified, Interval
from valvetrain.solution.modes import TrainModes

SHARE = np.array([[0.62, 0.2, 0.18], [0.1, 0.7, 0.2]])
STEPS = ["0", "1", "2", "3", "4", "5", "6", "7", "8"]


def train() -> TrainModes:
    return TrainModes(
        "own",
        "open",
        1.5,
        9e-3,
        np.array([500.0, 912.34]),
        ("valve",),
        ("valve", "spring", "rod"),
        np.ones((2, 1)),
        SHARE,
    )


def identified() -> Identified:
    found = [{"rate": Interval(32e3 + at, 0.0, 0.0, 31e3 + at, 33e3 + at)} for at in (0.0, 5e3)]
    branches = tuple(
        Branch(share, 1.0, one, np.eye(1), SimpleNamespace(warnings=()))
        for share, one in zip((0.75, 0.25), found, strict=True)
    )
    none = np.zeros((0, 1))
    return Identified("nested", (), branches, none, none[:, 0], none[:, 0].astype(int), (), (), {})


def against() -> SimpleNamespace:
    """A model with Fisher's test and one without."""
    runs = (
        SimpleNamespace(label="rod", adequacy=SimpleNamespace(ratio=12.345, p_value=0.00123)),
        SimpleNamespace(label="chain", adequacy=None),
    )
    return SimpleNamespace(
        runs=runs, _repr_html_=lambda: ModelAgainstTest._repr_html_(SimpleNamespace(runs=runs))
    )


NUMBERS = ["800 N", "1 mm", "1", "2"]
TABLES = {
    "modes of a train": (train, [["mode", "natural frequency", "moving"], ["1", "500 Hz", "valve 62 %, spring 20 %, rod 18 %"],
                                 ["2", "912.34 Hz", "spring 70 %, rod 20 %"]]),
    "quantities": (quantities, [["quantity", "run", "value"], ["preload", "", "301.5 N"],
                                *(["peak_seat_force", f"rod, {n * 100 / RPM:.5g} rpm", f"{800 + n} N"] for n in range(1, 6))]),
    "curve": (curve, [["compression", "force", "stiffness"], *([f"{n} mm", f"{40 * n} N", "40 N/mm"] for n in range(9))]),
    "solution": (solution, [["quantity", "value"], ["peak_seat_force", "800 N"], ["clearance", "1 mm"], ["a", "1"], ["b", "2"]]),
    "modes": (modes, [["mode", "natural frequency", "axial transmission", ""], ["1", "400 Hz", "1", ""], ["2", "630 Hz", "1", "axial"],
                      ["3", "1120 Hz", "1", "axial"], ["4", "1300 Hz", "1", ""], ["5", "1639 Hz", "1", "axial"]]),
    "study": (study, [["run", "engine speed", "status", "peak seat force", "clearance", "a", "b"],
                      *([label, f"{speed} rpm", "completed", *NUMBERS] for label in ("rod", "chain") for speed in (4200, 5600))]),
    "identification": (identified, [["branch", "probability", "quantity", "best", "2.5 %", "97.5 %"],
                                    ["1", "0.750", "rate", "32000", "31000", "33000"], ["2", "0.250", "rate", "37000", "36000", "38000"]]),
    "models beside a test": (against, [["model", "F", "p"], ["rod", "12.3", "0.0012"], ["chain", "", ""]]),
}  # fmt: skip


@pytest.mark.parametrize("name", TABLES)
def test_a_table_holds_each_number_under_its_head(name, monkeypatch):
    make, expected = TABLES[name]
    page = make()._repr_html_()
    rows = [re.findall(r"<t[hd]>(.*?)</t[hd]>", row) for row in re.findall(r"<tr>(.*?)</tr>", page)]
    assert [[unescape(cell) for cell in row] for row in rows] == expected
