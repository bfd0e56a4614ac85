"""The pushrod template, a small-block V8 in card values, with the values of another card, from the
file to its answers.
"""

from __future__ import annotations

import math

import pytest

import valvetrain as vt
from fact_parts import with_code
from valvetrain.explore.new_command import write_template

INCH, POUND = 25.4e-3, 4.4482216152605
RATE, PRELOAD = 220 * POUND / (0.55 * INCH), 130 * POUND
CARD = {
    "lift_law.lobe_lift": "0.353 in", "lift_law.rocker_ratio": 1.6, "lift_law.duration": "242 deg",
    "lift_law.advertised_duration": "294 deg", "lift_law.lobe_centre": "108 deg", "train.follower.mass": "118 g",
    "train.valve.mass": "138 g",
}  # fmt: skip


@pytest.fixture
def engine(tmp_path, monkeypatch) -> vt.Case:
    monkeypatch.chdir(tmp_path)
    return vt.load_case(write_template("my-v8", "pushrod"), CARD)


def test_a_card_gives_surge_seating_bind_and_valve_events(engine):
    """Every value that the cards themselves decide is checked against them; the valve ends near its
    lobe lift times the ratio.
    """
    study = vt.simulate(engine, "4000 rpm", models=["massless"])
    (run,) = study.solutions
    assert run.status.completed and not study.failures
    found, still = run.quantities, next(iter(study.still.values()))
    lift = 1.6 * 0.353 * INCH
    assert still["rigid_maximum_valve_lift"] == pytest.approx(lift, rel=3e-3)
    assert found["peak_valve_lift"] == pytest.approx(lift, rel=0.02)
    assert found["coil_bind_clearance"] == pytest.approx(
        (1.80 - 1.15) * INCH - found["peak_valve_lift"], abs=0.05e-3
    )
    assert found["surge_frequency"] == pytest.approx(0.5 * math.sqrt(RATE / 0.096), rel=1e-6)
    assert found["peak_spring_force"] == pytest.approx(
        PRELOAD + RATE * found["peak_valve_lift"], rel=5e-3
    )
    assert math.degrees(still["lobe_50_thou_open_crank_angle_range"]) == pytest.approx(
        242, abs=1e-6
    )
    opens, closes = (
        2 * (math.degrees(still[f"lobe_50_thou_{end}_cam_angle"]) - 180)
        for end in ("opening", "closing")
    )
    assert (opens, closes) == pytest.approx((108 - 121, 108 + 121), abs=1e-6)
    assert 0.05 < found["seating_velocity"] < 0.6 and found["bounce_height"] < 0.1e-3
    assert with_code(study.facts, "default-contacts")


def test_it_holds_the_cam_below_the_speed_of_rigid_theory_and_floats_above(engine):
    """Contact-loss speed, rigid parts against the mass of this train at the nose by hand; the runs
    on both sides of it.
    """
    law = vt.cam.build_lift_law(engine.lift_law)
    nose = float(law.lift(math.pi + math.radians(54), 2))
    # At the nose, reduced to the tappet: tappet, pushrod and rocker, and valve with a third of the
    # spring times the ratio squared.
    mass = 0.118 + 0.05735 + 30e-6 / (0.9 * INCH) ** 2 + 1.6**2 * (0.138 + 0.096 / 3)
    force = 1.6 * (PRELOAD + RATE * 1.6 * 0.353 * INCH) + 0.3 / (0.9 * INCH)
    by_hand = 2 * math.sqrt(force / (mass * -nose))
    study = vt.simulate(engine, [0.6 * by_hand, 1.1 * by_hand], models=["massless"])
    rigid = next(values["rigid_contact_loss_engine_speed"] for values in study.still.values())
    assert rigid == pytest.approx(by_hand, rel=0.05)
    below, above = (run.quantities for run in study.runs("massless"))
    assert below["float_excess_lift"] == 0.0 and below["minimum_cam_contact_force"] > 0
    assert below["minimum_spring_margin_ratio"] > 1 > above["minimum_spring_margin_ratio"]
    assert above["float_excess_lift"] > 0.1e-3 and above["minimum_cam_contact_force"] == 0.0
