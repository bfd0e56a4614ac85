"""The general numbers of a run, each against a value known from elsewhere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synthetic_spring import ENGINE_SPEED, EVENT, bump, clashing_run, run
from synthetic_train import ANGLE, CAM_SPEED, train
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import CoilContact, InstalledSpring, SpringCard
from valvetrain.parameters.loading import load_case
from valvetrain.quantities.cycle import Frame
from valvetrain.quantities.evaluate import evaluate
from valvetrain.quantities.forces import lift_harmonic
from valvetrain.quantities.statics import design_quantities, estimated_rate
from valvetrain.solution.static import SpringAtRest, StaticCurve, StaticStress
from valvetrain.springs.stress import nominal_stress_per_force

DEG = np.pi / 180
CAM_RATE = ENGINE_SPEED / 2
WIRE = load_case("uniform-spring").spring
SPRING = InstalledSpring(wire=WIRE, precompression=5e-3)


def _curve(rate: float) -> StaticCurve:
    x, none = np.linspace(0, 20e-3, 21), np.zeros((21, 0))
    return StaticCurve(x, rate * x, np.full(21, rate), none, none, np.zeros(0), none, np.zeros(0))


def test_extremes_are_those_of_every_instant():
    made = clashing_run()
    found = evaluate(made).quantities
    fine = made.channel("seat_force_fine")[720:]
    assert found["raw_peak_spring_force"] == np.max(fine) >= np.max(made.channel("seat_force"))
    assert found["peak_spring_force"] == pytest.approx(np.max(fine), rel=1e-3)
    assert found["peak_spring_force_cam_angle"] / DEG == pytest.approx(180, abs=0.3)
    assert found["minimum_spring_force"] == pytest.approx(300.0)
    assert "peak_retainer_force" not in found


def test_filtered_peak_loses_what_the_filter_takes():
    """200 waves of 10 kHz in a closed turn: half of them left at 10 kHz (6 dB down)."""
    made = run(
        {"seat_force": lambda degrees: 300 + 100 * np.cos(200 * degrees * DEG)}, per_turn=4000, turns=1,
        engine_speed=2 * 2 * np.pi * 10e3 / 200, system="train",
    )  # fmt: skip
    found = evaluate(made).quantities
    assert found["raw_peak_spring_force"] == pytest.approx(400.0)
    assert found["peak_spring_force"] == pytest.approx(350.0)


def test_clearance_to_coil_bind_is_the_least_of_the_springs():
    lift = {
        "valve_lift": lambda degrees: 9e-3 * bump(degrees, 180, 106),
        "seat_force": lambda degrees: 300 + 0 * degrees,
    }
    card = InstalledSpring(card=SpringCard(20e3, 100.0, None, 35e-3, solid_height=24e-3))
    unknown = InstalledSpring(card=SpringCard(20e3, 100.0))
    assert evaluate(run(lift), Frame((card, unknown))).quantities[
        "coil_bind_clearance"
    ] == pytest.approx(2e-3)
    tighter = replace(card, card=replace(card.card, solid_height=25e-3))
    assert evaluate(run(lift), Frame((card, tighter))).quantities[
        "coil_bind_clearance"
    ] == pytest.approx(1e-3)
    assert "coil_bind_clearance" not in evaluate(run(lift), Frame((unknown,))).quantities


def test_surge_stands_where_it_was_put():
    """9 N at order 13 and 40 N at order 3 on a static force: surge at 13.2 sees the 9 N only."""

    def lift(angle):
        return 4e-3 * (1 - np.cos(angle)) + 2e-5 * np.cos(13 * angle)

    def force(degrees):
        angle = degrees * DEG
        return 30e3 * (5e-3 + lift(angle)) + 9 * np.cos(13 * angle + 1) + 40 * np.sin(3 * angle)

    frequency = 13.2 * CAM_RATE / (2 * np.pi)
    rest = SpringAtRest(SPRING.name, "multi-mass", 5e-3, _curve(30e3))
    frame = Frame((SPRING,), (rest,), (frequency,), EVENT, lift)
    found = evaluate(
        run({"seat_force": force, "valve_lift": lambda degrees: lift(degrees * DEG)}), frame
    ).quantities
    assert found["surge_cam_order"] == pytest.approx(13.2) and found["surge_frequency"] == frequency
    assert found["surge_amplitude_force"] == pytest.approx(9.0, abs=1e-6)
    assert found["surge_amplitude_cam_order"] == 13.0
    assert (found["surge_order_3_force"], found["surge_order_13_force"]) == pytest.approx(
        (40.0, 9.0), abs=1e-6
    )
    assert (
        found["surge_order_40_force"] == pytest.approx(0.0, abs=1e-6)
        and "surge_order_41_force" not in found
    )
    assert found["nearest_lift_harmonic_order"] == 13.0
    assert found["nearest_lift_harmonic_lift"] == pytest.approx(2e-5) == lift_harmonic(lift, 13)
    bare = evaluate(
        run({"seat_force": force, "valve_lift": lambda degrees: lift(degrees * DEG)}),
        replace(frame, rest=()),
    ).quantities
    assert (
        "surge_amplitude_force" not in bare and bare["surge_cam_order"] == found["surge_cam_order"]
    )


def test_surge_of_a_train_is_taken_from_its_own_static_force():
    run = train(seat_force=520 + 7 * np.cos(11 * ANGLE), static_retainer_force=500 + 0 * ANGLE)
    frame = Frame(surge_frequencies=(11 * CAM_SPEED / (2 * np.pi), 15.0 * CAM_SPEED))
    assert evaluate(run, frame).quantities["surge_amplitude_force"] == pytest.approx(7.0)


def test_nominal_stress_is_that_of_the_standard():
    """EN 13906-1 by hand for the uniform spring: d = 4 mm, D = 24 mm, w = 6."""
    diameter, mean = (float(law.value(3.0)) for law in (WIRE.wire_diameter, WIRE.mean_diameter))
    index = mean / diameter
    per_force = (index + 0.5) / (index - 0.75) * 8 * mean / (np.pi * diameter**3)
    assert nominal_stress_per_force(WIRE) == pytest.approx(per_force)
    found = evaluate(
        run({"valve_lift": lambda degrees: 4e-3 * bump(degrees, 180, 100)}), Frame((SPRING,))
    ).quantities
    rate = estimated_rate(WIRE)[0]  # the load at rest, whatever the seat bears
    assert found["open_nominal_shear_stress"] == pytest.approx(9e-3 * rate * per_force, rel=1e-3)
    assert found["closed_nominal_shear_stress"] == pytest.approx(5e-3 * rate * per_force, rel=1e-3)


def test_nominal_stress_looks_for_the_worst_place_of_the_wire():
    beehive = load_case("gu2021-beehive-blind").spring
    coil = np.linspace(*beehive.free_coils, 50)
    index = beehive.mean_diameter.value(coil) / beehive.wire_diameter.value(coil)
    places = (
        (index + 0.5)
        / (index - 0.75)
        * 8
        * beehive.mean_diameter.value(coil)
        / (np.pi * beehive.wire_diameter.value(coil) ** 3)
    )
    assert nominal_stress_per_force(beehive) >= np.max(places) * (1 - 1e-9)


def test_nested_springs_carry_their_own_stresses():
    soft = replace(SPRING, precompression=2e-3)
    made = train(springs=("outer", "inner"), valve_lift=2e-3 * (1 - np.cos(ANGLE)))
    run = evaluate(made, Frame((SPRING, soft))).quantities
    outer, inner = (run[f"{one}_open_nominal_shear_stress"] for one in ("outer", "inner"))
    assert run["open_nominal_shear_stress"] == outer
    assert inner == pytest.approx(outer * 6 / 9, rel=1e-3)


def test_stress_of_the_wire_over_a_cycle():
    """Two wire points with 200 +- 100 and 350 +- 20 MPa: the peak stands at the first, the largest
    amplitude too.
    """

    def shear(degrees):
        wave = np.cos(degrees * DEG)
        return 1e6 * np.stack([300 + 100 * wave, 350 + 20 * wave], axis=1)

    extra = {
        name: (("wire_point",), "Pa", "made up")
        for name in ("inner_fibre_shear_stress", "inner_fibre_equivalent_stress")
    }
    values = {
        "inner_fibre_shear_stress": shear,
        "inner_fibre_equivalent_stress": lambda degrees: 2 * shear(degrees),
    }
    values |= {"valve_lift": lambda degrees: 9e-3 * bump(degrees, 180, 106)}
    static = StaticStress(
        np.array([0.0, 20e-3]),
        np.array([1.0, 2.0]),
        1e6 * np.array([[0.0, 0], [200, 320]]),
        np.zeros((2, 2)),
    )
    made = run(values, extra=extra, coil_number=[1.0, 2.0])
    found = evaluate(
        made, Frame((SPRING,), (SpringAtRest(SPRING.name, "finite-element", 5e-3, stress=static),))
    ).quantities
    assert found["peak_shear_stress"] == pytest.approx(400e6) and found[
        "minimum_shear_stress"
    ] == pytest.approx(200e6)
    assert found["peak_shear_stress_coil_number"] == 1.0 and found[
        "peak_equivalent_stress"
    ] == pytest.approx(800e6)
    assert found["largest_amplitude_shear_stress"] == pytest.approx(100e6)
    assert found["quasi_static_peak_shear_stress"] == pytest.approx(320e6 * 14 / 20)
    assert found["dynamic_to_static_stress_ratio"] == pytest.approx(400 / 224)
    assert found["largest_amplitude_mean_shear_stress"] == pytest.approx(300e6)


def test_clash_numbers_are_those_of_the_last_turn_and_absent_without_contact():
    found = evaluate(clashing_run(), Frame((SPRING,))).quantities
    assert found["clash_count"] == 1 and found["peak_clash_force"] == pytest.approx(4 * 200.0)
    assert found["clash_energy"] == pytest.approx(4 * 0.5 * 200 * 0.1e-3)
    through = replace(SPRING, contact=CoilContact(0.0))
    passed = evaluate(clashing_run(), Frame((through,)))
    assert passed.events == () and "clash_count" not in passed.quantities


def test_a_diverged_run_gives_nothing_and_a_short_one_no_peak():
    broken = run({"seat_force": lambda degrees: np.where(degrees > 300, np.nan, 300.0)})
    assert evaluate(broken).quantities == {}
    whole = run({"seat_force": lambda degrees: 300 + degrees}, turns=1)
    cut = type(whole)(whole.channels.isel(sample=slice(0, 300)), provenance=whole.provenance)
    assert "peak_spring_force" not in evaluate(cut).quantities


def test_an_unknown_source_is_refused():
    with pytest.raises(InputError, match="source study 'gu2012' is unknown; did you mean gu2021"):
        evaluate(clashing_run(), Frame(source="gu2012"))


def test_room_to_coil_bind_is_a_number_of_the_spring():
    found = design_quantities(SPRING)
    assert found["coil_bind_lift"] == pytest.approx(
        found["solid_compression"] - found["installed_compression"]
    )
    assert design_quantities(
        InstalledSpring(card=SpringCard(20e3, 100.0, None, 35e-3, solid_height=24e-3))
    )["coil_bind_lift"] == pytest.approx(11e-3)
