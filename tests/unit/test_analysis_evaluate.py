"""Numbers of a run beside those of `known_quantities`: nested springs, worst places, runs that end early."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synthetic_spring import clashing_run, run
from synthetic_train import ANGLE, CAM_SPEED, train
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import CoilContact, InstalledSpring
from valvetrain.parameters.loading import load_case
from valvetrain.quantities.cycle import Frame
from valvetrain.quantities.evaluate import evaluate
from valvetrain.springs.stress import nominal_stress_per_force

WIRE = load_case("uniform-spring").spring
SPRING = InstalledSpring(wire=WIRE, precompression=5e-3)


def test_surge_of_a_train_is_taken_from_its_own_static_force():
    run = train(seat_force=520 + 7 * np.cos(11 * ANGLE), static_retainer_force=500 + 0 * ANGLE)
    frame = Frame(surge_frequencies=(11 * CAM_SPEED / (2 * np.pi), 15.0 * CAM_SPEED))
    assert evaluate(run, frame).quantities["surge_amplitude_force"] == pytest.approx(7.0)


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
