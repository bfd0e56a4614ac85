"""A run computes all before it is returned, and with ``outputs=`` these alone: properties, and limits
between both ways.
"""

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.errors import InputError

#: A spring of textbook size in no library case, and its lift.
SPRING = vt.Spring(
    wire_diameter="3.6 mm",
    mean_diameter="27 mm",
    total_coils=5,
    pitch="8.5 mm",
    material="EN 10270-2 VDSiCr",
    installed_height="25 mm",
    damping={"ratio": 0.02, "ratio_frequency": "400 Hz"},
)
CASE = vt.Case(
    spring=SPRING,
    lift_law=lambda cam_angle: 5e-3 * max(0.0, 1 - ((cam_angle - np.pi) / 1.2) ** 2) ** 4,
    engine_speeds="5500 rpm",
    name="textbook",
)


def test_outputs_are_computed_alone():
    whole = CASE.run("5500 rpm", "multi-mass", workers=1)
    expected = whole.quantities["peak_spring_force"]
    run = CASE.run("5500 rpm", "multi-mass", workers=1, outputs=["peak_spring_force", "seat_force"])
    assert dict(run.quantities) == {"peak_spring_force": expected}
    assert list(run.channels) == ["seat_force"] and run["seat_force"].equals(whole["seat_force"])
    assert run.status.completed
    table = CASE.study(
        {"spring.wire_diameter": ["3.6 mm"]}, ["peak_spring_force"], sampling="list",
        engine_speeds="5500 rpm", models="multi-mass", workers=1,
    )  # fmt: skip
    assert table.values.item() == expected


def test_outputs_at_rest_and_inside_the_spring():
    run = CASE.run("5500 rpm", "multi-mass", workers=1, outputs=["preload", "coil_gap"])
    whole = vt.simulate(CASE.parameters, "5500 rpm", models="multi-mass", workers=1)
    assert dict(run.quantities) == {"preload": whole.quantities["preload"]}
    assert run["coil_gap"].equals(whole.solutions[0]["coil_gap"])


def test_a_sweep_of_outputs_is_that_of_all():
    speeds = "4000:6000:1000 rpm"
    few = CASE.sweep(speeds, "multi-mass", workers=1, outputs="peak_spring_force")
    every = CASE.sweep(speeds, "multi-mass", workers=1)
    one, other = (study.series("multi-mass", "peak_spring_force") for study in (few, every))
    assert one.identical(other)
    assert {name for run in few.solutions for name in run.quantities} == {"peak_spring_force"}


def test_a_train_searches_critical_speeds_where_one_is_requested():
    case, options = vt.Case("tdi-pushrod"), {"spring_sets": "stock", "workers": 1}
    few = case.sweep("6000:6400:400 rpm", "massless", outputs="peak_valve_lift", **options)
    assert not len(few.critical_speeds) and set(few.solutions[0].quantities) == {"peak_valve_lift"}
    speeds = "7000:7400:200 rpm"
    found = case.sweep(speeds, "massless", outputs="contact_loss_engine_speed", **options)
    assert len(found.critical_speeds) and found.quantities["contact_loss_engine_speed"] > 0


@pytest.mark.parametrize(
    ("name", "near"),
    [("seat_forse", "seat_force"), ("prelaod", "preload"), ("peak_spring_forze", "peak_spring_force")],
)  # fmt: skip
def test_a_wrong_output_is_answered_with_the_nearest(name, near):
    with pytest.raises(InputError, match=f"'{name}' is no quantity and no channel.*{near}"):
        CASE.run("3000 rpm", "multi-mass", outputs=name)
    with pytest.raises(InputError, match=f"did you mean .*{near}"):
        CASE.sweep("3000 rpm", "multi-mass", outputs=[name])


def test_a_channel_that_a_run_lacks_is_said():
    with pytest.raises(InputError, match="this massless run has no channel 'torsional_moment'"):
        CASE.run("3000 rpm", "massless", outputs="torsional_moment")
