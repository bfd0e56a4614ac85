"""Views that users of the field know, on a motorcycle engine from card values: pressure of the cam
against Hertz's line contact and clearance of the piston against a hand calculation (closed form).
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.errors import UnusualValueWarning
from valvetrain.findings.facts import Facts
from valvetrain.parameters.loading import parse_case
from valvetrain.system.build import build, lift_law_of
from valvetrain.views.figures import contacts, force, worst_run

#: Four valves of 250 cm3: bucket tappets on a cam of 14 mm, cards of cam and springs in crank degrees.
BIKE = """
title = "Motorcycle, intake"
[lift_law]
kind = "cam-card"
angle_of = "crank"
valve_lift = "8.3 mm"
duration = "244 deg"
duration_lift = "1 mm"
lobe_centre = "105 deg"
lash = "0.15 mm"
[operation]
engine_speeds = "6000, 11000 rpm"
[train]
kind = "direct"
spring_set = "dual"
spring_model = "massless"
contacts = "steel"
cam = { base_radius = "14 mm", width = "9 mm" }
follower = { shape = "flat", mass = "16 g" }
valve = { mass = "32 g" }
crank = { radius = "24 mm", rod_length = "95 mm", clearance = "7 mm", valve_inclination = "12 deg" }
[[train.springs.dual]]
wire_diameter = "3.0 mm"
outer_diameter = "24 mm"
preload = "150 N"
installed_height = "32 mm"
open_load = "345 N"
open_height = "23.7 mm"
[[train.springs.dual]]
wire_diameter = "2.2 mm"
outer_diameter = "16.6 mm"
preload = "80 N"
installed_height = "30 mm"
open_load = "190 N"
open_height = "21.7 mm"
"""


def around_top(run):
    """Crank degrees from top dead centre, rising, and clearance (m) to the piston."""
    crank = run.cycle["crank_angle"].values
    order = np.argsort(crank)
    return np.degrees(crank[order]), run.cycle["piston_clearance"].values[order]


@pytest.fixture(scope="module")
def study():
    return vt.Case(BIKE, name="bike").compare(["6000 rpm", "11000 rpm"], "massless")


def test_pressure_is_that_of_hertz_under_the_force_of_the_run(study):
    """A flat face on a cam of radius r = base circle + lift + second derivative of the lift (geometry
    of the flat follower); p0 = sqrt(F E* / (pi b r)), E* = E / (2 (1 - nu^2)).
    """
    run = study.solutions[0]
    law = lift_law_of(parse_case(BIKE))
    angle = run.cam_angle
    radius = 14e-3 + law.lift(angle) + law.lift(angle, 2)
    reduced = 206e9 / (2 * (1 - 0.3**2))
    force = run.channel("cam_contact_force")
    due = np.sqrt(force * reduced / (math.pi * 9e-3 * radius))
    loaded = run.channel("rigid_valve_lift") > 0.2e-3
    assert run.channel("cam_contact_pressure")[loaded] == pytest.approx(due[loaded], rel=5e-3)
    assert np.all(run.channel("cam_contact_pressure")[force == 0] == 0)
    top = float(np.max(run.channel("cam_contact_pressure")))
    assert run.quantities["peak_cam_contact_pressure"] == top
    assert 0.4e9 < top < 1.5e9  # steel on steel: some 1 GPa


@pytest.mark.parametrize("crank_degrees", [-20.0, 0.0, 10.0, 25.0])
def test_clearance_of_the_piston_by_hand_in_crank_degrees(study, crank_degrees):
    """s = r + l - r cos a - sqrt(l^2 - r^2 sin^2 a); the valve, opened by the lobe whose nose is 105
    crank degrees after top dead centre, takes its lift times cos 12 degrees.
    """
    run = study.solutions[0]
    turned, clearance = around_top(run)
    a = math.radians(crank_degrees)
    travel = 24e-3 + 95e-3 - 24e-3 * math.cos(a) - math.sqrt(95e-3**2 - (24e-3 * math.sin(a)) ** 2)
    law = lift_law_of(parse_case(BIKE))
    nose = math.pi + math.radians(
        105 / 2
    )  # the card's own zero: top dead centre at 180 cam degrees
    lobe = float(law.lift(nose - math.radians(105 - crank_degrees) / 2))
    due = 7e-3 + travel - max(lobe - 0.15e-3, 0.0) * math.cos(math.radians(12))
    assert np.interp(crank_degrees, turned, clearance) == pytest.approx(due, abs=2e-5)


def test_no_set_up_in_cam_degrees_is_needed():
    """The same clearance wherever the zero of the cam angle is, by the cam card or by ``lobe_centre``
    of the crank.
    """
    base = vt.Case(BIKE, name="bike")
    moved = base.set({"lift_law.top_dead_centre": "100 deg"})
    by_nose = base.set(
        {"train.crank.lobe_centre": "105 deg", "lift_law.top_dead_centre": "140 deg"}
    )
    found = [around_top(one.run("6000 rpm", models="massless")) for one in (base, moved, by_nose)]
    at = np.linspace(-60, 60, 25)
    first, *others = (np.interp(at, *pair) for pair in found)
    for other in others:
        assert other == pytest.approx(first, abs=2e-5)


def test_margin_is_the_spring_less_the_inertia_over_the_nose(study):
    """At the nose: preloads and rates at 8.15 mm less moving mass times acceleration; a bucket has
    the motion of its valve.
    """
    run = study.solutions[1]
    law = lift_law_of(parse_case(BIKE))
    nose = math.pi + math.radians(105 / 2)
    spring = 230 + (195 / 8.3e-3 + 110 / 8.3e-3) * 8.15e-3
    moving = 48e-3 + (13.54e-3 + 7.94e-3) / 3
    inertia = moving * float(law.lift(nose, 2)) * (run.engine_speed / 2) ** 2
    weight = -48e-3 * 9.80665  # opens downwards
    found = np.interp(nose, run.cam_angle, run.channel("rigid_spring_margin"))
    assert found == pytest.approx(spring + inertia + weight, rel=0.05)
    at_rest = np.interp(nose, run.cam_angle, run.channel("rigid_spring_force"))
    assert at_rest == pytest.approx(spring, rel=0.01)


def test_both_springs_share_the_force_that_is_drawn(study):
    """Closed form: the forces of two nested springs add up to that on the retainer."""
    drawn = {one.name: one.y for one in force(Facts(study)).data}
    both = drawn["outer, 11000 rpm"] + drawn["inner, 11000 rpm"]
    assert both == pytest.approx(drawn["11000 rpm"], rel=1e-3)


def test_the_torque_that_is_drawn_does_the_work_of_the_cam(study):
    """Its integral over a turn is what contacts, parts and springs lose of energy in it."""
    facts = Facts(study)
    torque = next(one for one in contacts(facts).data if one.name == "cam torque")
    lost = sum(
        worst_run(facts).quantities[f"{where}_dissipated_energy"] for where in ("cycle", "spring")
    )
    turn = np.trapezoid(torque.y, np.radians(torque.x))
    assert turn == pytest.approx(lost, rel=0.1)


def test_a_bucket_asks_for_no_rocker_ratio_and_refuses_another_one():
    case = vt.Case(BIKE, name="bike")
    assert parse_case(BIKE).lift_law.values["maximum_lift"] == pytest.approx(8.3e-3)
    with pytest.raises(vt.InputError, match="bucket tappet has no rocker"):
        case.set({"lift_law.rocker_ratio": 1.5})


def test_a_valve_of_kilograms_is_warned_of():
    with pytest.warns(UnusualValueWarning, match=r"14\.5 kg is heavy for a lift of 8\.15 mm"):
        build(vt.Case(BIKE, name="bike").set({"train.valve.mass": "14.5 kg"}))


def test_stress_beside_the_strength_of_the_wire():
    """The point of a run is its least and largest shear; at the line, too, the uncorrected stress is
    what the wire is permitted.
    """
    wire = {
        "wire_diameter": "3 mm", "outer_diameter": "24 mm", "total_coils": 6.5, "installed_height": "32 mm",
        "pitch": {"formula": "closed-ends", "pitch": "7.3 mm", "ramp": 0.2}, "material": "EN 10270-2 VDSiCr",
        "ends": {"kind": "closed-ground", "inactive_coils": 0.9, "ground_coils": 0.9},
    }  # fmt: skip
    done = (
        vt.Case(BIKE, name="bike")
        .set({"train.springs.dual": [wire]})
        .compare("6000 rpm", "massless")
    )
    found = done.solutions[0].quantities
    figure = done.figure("strength")
    point = figure.data[1]
    assert point.x[0] == pytest.approx(found["closed_nominal_shear_stress"] * 1e-6)
    assert point.y[0] == pytest.approx(found["open_nominal_shear_stress"] * 1e-6)
    share = found["open_uncorrected_shear_stress"] / found["permitted_shear_stress"]
    assert point.y[0] == pytest.approx(share * figure.layout.shapes[0].y0)
