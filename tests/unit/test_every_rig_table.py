"""Unit: rows, JSON and curves of the answer on a recording, beside made-up cycles."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from valvetrain.findings.words import Amount, Words
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.rig.alignment import LiftAlignment
from valvetrain.rig.answer import RigAnswer
from valvetrain.rig.channels import RigQuantity
from valvetrain.rig.files import COLUMNS, data_of, rows_of
from valvetrain.rig.result import RigChannelCycles
from valvetrain.views.columns import table_of
from valvetrain.views.results import figures_of

DEGREES = np.arange(360.0)
ANGLE, RPM, TURN = np.radians(DEGREES), np.pi / 30, 2 * np.pi
#: Three cycles of lift, top at 199, 200 and 201 degrees with 8.9, 9.0 and 9.1 mm; of strain, tops
#: of 150, 160 and 170 anywhere.
LIFT = 1e-3 * np.array(
    [5 + 4 * np.cos(np.radians(DEGREES - 200 - k)) + 0.1 * k for k in (-1, 0, 1)]
)
STRAIN = 1e-6 * np.array(
    [100 + (60 + 10 * k) * np.cos(np.radians(DEGREES - 20 - 120 * k)) for k in (-1, 0, 1)]
)
#: Half width of the 95 % interval of the mean of three values with a standard deviation of one.
OF_THREE = 4.302653 / np.sqrt(3)


def channel(quantity: str, unit: str, values, spread, band: float) -> RigChannelCycles:
    cycles = MeasuredCycles(quantity, unit, ANGLE, values, 100.0, notes=(f"note on {quantity}",))
    samples = np.arange(1000)
    raw = RigQuantity(
        quantity, unit, 2e-3 * np.sin(TURN * samples * 0.05), 0.5, 1e-4, f"{quantity} of the file"
    )
    return RigChannelCycles(cycles, raw, band, spread, np.zeros(0))


def result(**changes) -> SimpleNamespace:
    told = {
        "name": "own.csv", "form": "CSV", "synthetic": False, "notes": ("first note", "second note"), "alignment": None,
        "channels": (channel("valve_lift", "m", LIFT, 1e-6 * DEGREES, 2e3), channel("strain", "1", STRAIN, np.full(360, np.inf), 5e3)),
        "grid": SimpleNamespace(
            cycles=4, cam_angle=ANGLE, cam_speeds=np.array([1000, 1010, 9999, 1020]) * RPM, cut_times=np.array([0.0, 1.0, 2.0, 4.0, 5.0])
        ),
        "retained": (0, 1, 3), "outliers": ((2, "is far off"),), "offset": 0.0, "offset_uncertainty": 0.0, "placed": True,
        "shaft": SimpleNamespace(scatter=0.0, readings=360.0, cam_speed=lambda times: 100.0 * RPM * np.asarray(times)),
    }  # fmt: skip
    return SimpleNamespace(**told | changes)


MEASURED, MODEL = 1e-3 * np.array([1.0, 3.0, 6.0, 2.0]), 1e-3 * np.array([0.0, 2.0, 4.0, 1.0])
LAID = LiftAlignment(
    0.5,
    0.01,
    np.radians(28.0),
    np.radians(29.0),
    1.25,
    1e-4,
    np.radians(np.arange(0.0, 360.0, 90.0)),
    MEASURED,
    MODEL,
)


def test_a_strain_is_said_in_millionths():
    assert Words().amount(Amount("strain", 160e-6)) == "160 µm/m"


def rows(**changes) -> list[tuple[str, ...]]:
    return list(table_of("", COLUMNS, rows_of(result(**changes)), Words()).rows)


def test_rows_tell_the_mean_and_the_extremes_of_the_cycles():
    """Largest of the mean: 5 + 4 (1 + 2 cos 1 deg) / 3 mm; the extremes of the strain are anywhere."""
    lift, strain = rows()[:3], rows()[3:]
    assert lift == [
        ("valve lift", "mean", "9.000 mm", "0.2 mm", "", "200 cam deg"),
        ("valve lift", "largest", "9 mm", "0.2484 mm", "0.1 mm", "200 cam deg"),
        ("valve lift", "smallest", "1 mm", "0.2484 mm", "0.1 mm", "20 cam deg"),
    ]
    assert [row[1:] for row in strain[1:]] == [
        ("largest", "160 µm/m", "24.84 µm/m", "10 µm/m", ""),
        ("smallest", "40 µm/m", "24.84 µm/m", "10 µm/m", ""),
    ]
    one = channel("valve_lift", "m", LIFT[1:2], np.full(360, np.inf), 2e3)
    assert [row[2:4] for row in rows(channels=(one,))] == [
        ("9 mm", ""),
        ("9 mm", "0 µm"),
        ("1 mm", "0 µm"),
    ]


def test_the_answer_in_json_is_in_si():
    found = data_of(result(offset=0.3, offset_uncertainty=0.02, alignment=LAID))
    assert {name: (one["value"], one["unit"]) for name, one in found["quantities"].items()} == {
        "largest_valve_lift": (pytest.approx(9e-3), "m"),
        "smallest_valve_lift": (pytest.approx(1e-3), "m"),
        "largest_strain": (pytest.approx(160e-6), "1"),
        "smallest_strain": (pytest.approx(40e-6), "1"),
    }
    plain = {
        name: found[name]
        for name in (
            "command",
            "case",
            "completed",
            "file",
            "form",
            "synthetic",
            "cycles",
            "kept",
            "angles",
        )
    }
    assert plain == {
        "command": "rig",
        "case": "",
        "completed": True,
        "file": "own.csv",
        "form": "CSV",
        "synthetic": False,
        "cycles": 4,
        "kept": [1, 2, 4],
        "angles": 360,
    }
    assert (
        found["outliers"] == [{"cycle": 3, "why": "is far off"}] and found["angle_scatter"] == 0.0
    )
    assert found["cam_speed"] == {"value": pytest.approx(1010 * RPM), "unit": "rad/s"}
    assert found["offset"] == {"value": 0.3, "standard_uncertainty": 0.02, "unit": "rad"}
    left = 1e-3 * np.array(
        [0.9, 0.4, 0.9, 0.65]
    )  # measured less 0.1 mm less 1.25 times the lift of the case
    assert found["alignment"] == pytest.approx(
        {
            "opening": np.radians(28),
            "closing": np.radians(29),
            "gain": 1.25,
            "residual": np.sqrt(np.mean(left**2)),
        }
    )
    assert data_of(result())["alignment"] is None
    lift, strain = found["channels"]
    assert (lift["quantity"], lift["unit"], lift["channel"], lift["band"]) == (
        "valve_lift",
        "m",
        "valve_lift of the file",
        2e3,
    )
    assert lift["notes"] == ["note on valve_lift"] and lift["spread_of_mean"] == pytest.approx(
        179.5e-6
    )
    assert strain["spread_of_mean"] is None
    top, low = lift["figures"]
    assert top == {
        "figure": "largest",
        "mean": pytest.approx(9e-3),
        "interval": pytest.approx(OF_THREE * 1e-4),
        "scatter": pytest.approx(1e-4),
        "cam_angle": pytest.approx(np.radians(200)),
        "scatter_of_angle": pytest.approx(np.radians(np.sqrt(2 / 3))),
    }
    assert (low["figure"], low["mean"], low["cam_angle"]) == (
        "smallest",
        pytest.approx(1e-3),
        pytest.approx(np.radians(20)),
    )


def traces(name: str) -> dict:
    return {one.name: one for one in figures_of(RigAnswer(result()))[name].data}


def test_speeds_stand_at_the_middle_of_their_cycles():
    drawn = traces("speed")
    assert drawn["mean of each cycle"].x == pytest.approx([0.5, 1.5, 3.0, 4.5])
    assert drawn["mean of each cycle"].y == pytest.approx([1000, 1010, 9999, 1020])
    assert drawn["cam speed"].y == pytest.approx(100.0 * drawn["cam speed"].x, rel=1e-5)
