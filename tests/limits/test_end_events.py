"""Ends of a spring of its own at a speed at which they would pull. Limit between models: each that
can lifts them. Closed form: the blow of an end coil on its seat. Contract: what a run tells of it.
"""

from __future__ import annotations

from importlib import resources

import numpy as np
import pytest

import valvetrain as vt
from fact_parts import with_code
from valvetrain.errors import InputError
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.system.build import build

SPEED = "9000 rpm"


def lift(cam_angle: float) -> float:
    return 8e-3 * max(0.0, 1 - ((cam_angle - np.pi) / 1.1) ** 2) ** 4


def case_of(end_contact: str | None, **more) -> vt.Case:
    given = {} if end_contact is None else {"end_contact": end_contact}
    spring = vt.Spring(
        wire_diameter="4 mm", mean_diameter="24 mm", total_coils=8, pitch="8.4 mm", material="EN 10270-2 VDSiCr",
        precompression="3.5 mm", damping={"ratio": 0.02, "ratio_frequency": "400 Hz"}, **given, **more,
    )  # fmt: skip
    return vt.Case(spring=spring, lift_law=lift, operation={"cycles": 2})


def ends_of(run, kind: str):
    return [event for event in run.events if event.kind == kind]


@pytest.mark.parametrize("model", ["multi-mass", "wave-rod", "finite-element"])
def test_bonded_ends_pull_and_others_lift_off_and_strike(model):
    bonded, lifting = (case_of(ends).run(SPEED, models=model) for ends in ("bonded", None))
    assert bonded.quantities["minimum_spring_force"] < -100
    assert not [event for event in bonded.events if event.kind.startswith("end-")]
    assert lifting.quantities["minimum_spring_force"] == pytest.approx(0.0, abs=1e-9)
    assert float(lifting["retainer_force"].min()) >= -1e-9
    assert {event.where for event in ends_of(lifting, "end-lift-off")} == {"seat", "retainer"}
    assert max(event.size for event in ends_of(lifting, "end-strike")) > 1.0


def test_the_blow_of_an_end_coil_is_that_of_its_mass_on_its_contact():
    """Closed form: a mass that meets a linear contact at ``v`` presses with ``v sqrt(k m)``; what
    damping takes and the wire adds is within a tenth.
    """
    case = case_of("lifting")
    run = case.run(SPEED, models="finite-element")
    (spring,) = build(case.parameters, spring_models=["finite-element"]).members[0].system().springs
    assert isinstance(spring, FiniteElementRod) and spring.dynamics.ends is not None
    mass = spring.dynamics.ends.masses(spring.mesh)[0]
    stiffness = spring.dynamics.ends.stiffnesses(spring.mesh, spring.dynamics.contact_stiffness)[0]
    strike = max(event.size for event in ends_of(run, "end-strike") if event.where == "seat")
    peak = run.quantities["raw_peak_spring_force"]
    assert peak == pytest.approx(strike * np.sqrt(stiffness * mass), rel=0.1)


def test_modes_say_that_they_cannot_lift_an_end_that_would_pull():
    study = case_of(None).compare(SPEED, ["modal-uniform"])
    kinds = {event.kind for event in study.solutions[0].events}
    assert "end-pull" in kinds and "end-strike" not in kinds
    (fact,) = with_code(study.facts, "ends-pull")
    assert fact.fields["label"] == "modal-uniform"
    assert fact.fields["engine_speed"] == pytest.approx(9000 * np.pi / 30)
    bonded = case_of("bonded").compare(SPEED, ["modal-uniform"])
    assert not with_code(bonded.facts, "ends-pull")


def test_a_card_may_be_bonded_and_clamps_do_not_lift():
    card = vt.Spring(preload="60 N", rate="30 N/mm", mass="50 g", end_contact="bonded")
    assert card.parameters.pulls
    with pytest.raises(InputError, match="ends between clamps cannot lift"):
        case_of("lifting", seats="clamps")
    with pytest.raises(InputError, match="end_contact"):
        case_of("loose")


def test_in_a_train_lifting_ends_move_the_valve_as_bonded_ones_until_they_lift():
    """Limit: the inertia of the end coil is carried by its contact instead of the valve's mass."""
    path = resources.files("valvetrain").joinpath("templates/pushrod.toml")
    case = vt.Case(path.read_text(encoding="utf-8"))
    spring = "train.springs.wire.0"
    coarse = {f"{spring}.options.finite-element.elements_per_coil": 12}
    runs = {
        ends: case.set({f"{spring}.end_contact": ends} | coarse).run(
            "4500 rpm", models="finite-element", spring_sets="wire"
        )
        for ends in ("bonded", "lifting")
    }
    bonded, lifting = (run.quantities for run in runs.values())
    assert not [event for event in runs["lifting"].events if event.kind.startswith("end-")]
    for name in ("peak_cam_contact_force", "minimum_cam_contact_force", "seating_velocity"):
        assert lifting[name] == pytest.approx(bonded[name], rel=2e-3), name
    assert lifting["cycle_work_energy"] == pytest.approx(bonded["cycle_work_energy"], rel=0.02)


def test_ends_that_stay_pressed_are_those_of_bonded_ones():
    """Limit: below the speed at which an end would pull, the rod of a spring that may lift is the bonded one."""
    free, bonded = (
        case_of(ends).run("4000 rpm", models="finite-element") for ends in (None, "bonded")
    )
    assert bonded.quantities["minimum_spring_force"] > 0
    assert free.quantities["peak_spring_force"] == bonded.quantities["peak_spring_force"]
    assert not ends_of(free, "end-lift-off")
