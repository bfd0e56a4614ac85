"""Results show themselves: escaped tables, frames in SI, and figures bound on first use."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from synthetic_spring import bump
from valvetrain.errors import InputError, MissingExtraError
from valvetrain.solution.channels import spring_channels
from valvetrain.solution.modes import ModalResult
from valvetrain.solution.provenance import CaseRecord, Provenance
from valvetrain.solution.quantity import Quantities, Quantity
from valvetrain.solution.result import Solution
from valvetrain.solution.static import StaticCurve
from valvetrain.solution.status import Event
from valvetrain.solution.study import Study

RPM = np.pi / 30


def solution(engine_speed: float = 5600 * RPM, label: str = "rod & <b>", **changes) -> Solution:
    """One turn of the cam with a channel of every shape."""
    angle = np.linspace(0, 2 * np.pi, 361)
    force = 300 + 500 * bump(np.degrees(angle), 180, 106)
    values = {
        "valve_lift": 9e-3 * bump(np.degrees(angle), 180, 106),
        "seat_force": force,
        "coil_gap": np.outer(force, [1e-6, 2e-6]),
    }
    channels = spring_channels(angle / (engine_speed / 2), angle, values, upper_coil=[1.5, 2.5])
    made = Solution(
        channels,
        (Event("clash", 1.0, 0.1, 1e-4, 5.0, "N"),),
        provenance=Provenance("own", "m", engine_speed, label=label),
    )
    return replace(
        made,
        quantities={"peak_seat_force": float(force.max()), "clearance": 1e-3, "a": 1.0, "b": 2.0},
        statistics={},
        **changes,
    )


def curve() -> StaticCurve:
    """A straight spring of 40 N/mm with two coil pairs."""
    steps = np.linspace(0, 8e-3, 9)
    pairs, points = np.ones((9, 2)) * 1e-3, np.zeros((9, 0))
    return StaticCurve(
        steps,
        40e3 * steps,
        np.full(9, 40e3),
        pairs,
        0 * pairs,
        np.array([1.5, 2.5]),
        points,
        np.zeros(0),
    )


def modes() -> ModalResult:
    """Five modes, three of them axial."""
    return ModalResult(
        7e-3,
        np.array([400, 630, 1120, 1300, 1639.0]),
        np.ones((5, 4, 3)),
        np.arange(4.0),
        np.ones(5),
        (1, 2, 4),
    )


def study() -> Study:
    """Two models at two speeds."""
    runs = tuple(
        solution(speed * RPM, label) for label in ("rod", "chain") for speed in (4200, 5600)
    )
    return Study(CaseRecord("own <i>"), "sweep", runs, still={"": {"preload": 301.5}})


def quantities() -> Quantities:
    """Six values of two names."""
    return Quantities(
        {Quantity("preload"): 301.5}
        | {Quantity("peak_seat_force", n * 100.0, "rod"): 800.0 + n for n in range(1, 6)}
    )


def test_results_are_asked_in_the_units_of_the_field():
    assert curve().force_at("7.5 mm") == curve().force_at(7.5e-3) == pytest.approx(300.0)
    assert curve().stiffness_at("0.2 inch") == pytest.approx(40e3)
    assert study().solution("rod", "5600 rpm").label == "rod"
    assert study().quantities.of_run("rod", "5600 rpm")["clearance"] == 1e-3
    with pytest.raises(InputError, match="7 m of compression can only be meant as 7 mm"):
        curve().force_at(7)
    with pytest.raises(InputError, match="can only be meant as 5600 rpm"):
        study().solution("rod", 5600)


def test_frames_hold_every_value_in_si():
    table = solution().to_pandas()
    assert list(table.columns) == [
        "cam_angle",
        "valve_lift",
        "seat_force",
        "coil_gap[1.5]",
        "coil_gap[2.5]",
    ]
    assert table.index.name == "time" and len(table) == 361
    assert np.array_equal(table["coil_gap[2.5]"], solution().channel("coil_gap")[:, 1])
    assert table.attrs["units"]["coil_gap[1.5]"] == "m"
    assert len(solution().reduced().to_pandas()) == 0
    assert np.array_equal(curve().to_pandas()["force"], curve().force)
    assert "coil_contact_force[1.5]" in curve().to_pandas()
    assert list(modes().to_pandas()["axial"]) == [False, True, True, False, True]
    rows = study().to_pandas()
    assert list(rows.columns) == ["quantity", "label", "engine_speed", "value", "unit"]
    assert len(rows) == 17 and rows["engine_speed"].isna().sum() == 1
    assert rows.set_index("quantity").loc["preload", "value"] == 301.5


def test_without_pandas_one_sentence_says_what_to_do(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingExtraError, match="needs pandas, which is not installed; install it"):
        solution().to_pandas()


def test_results_load_no_plotting_until_asked():
    code = "import sys, valvetrain.solution.study; print([m for m in ('plotly', 'pandas', 'valvetrain.views') if m in sys.modules])"
    assert (
        subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        ).stdout.strip()
        == "[]"
    )
