"""The assumed wires of the valve-gear case meet the loads of the service manual by the finite-element rod."""

from __future__ import annotations

import pytest

from valvetrain.parameters.loading import load_case
from valvetrain.system.spring_choice import build_springs

OPEN = 9.7e-3  # m between the two loads of either spring


def test_wires_meet_the_manuals_loads():
    outer, inner = build_springs(load_case("vaz-ohc").train, "finite-element", "nested", elements_per_coil=16)
    for spring, loads in ((outer, (283.4, 452.1)), (inner, (136.3, 275.5))):
        closed, opened = (spring.force(spring.initial_state(lift), lift).retainer for lift in (0.0, OPEN))
        assert closed == pytest.approx(loads[0], rel=0.005)
        assert opened == pytest.approx(loads[1], rel=0.02)


def test_cards_are_the_manuals_lines():
    outer, inner = load_case("vaz-ohc").train.springs["nested-cards"]
    assert outer.preload + outer.rate * OPEN == pytest.approx(452.1, abs=0.2)
    assert inner.preload + inner.rate * OPEN == pytest.approx(275.5, abs=0.2)
    assert outer.preload / outer.rate == pytest.approx(50e-3 - 33.7e-3, rel=1e-3)  # straight from the free length


def test_a_finite_element_spring_runs_in_the_train_beside_the_cheap_ones():
    from valvetrain.integrate.train_run import TrainOptions, runner
    from valvetrain.system.build_train import build_train

    case = load_case("vaz-ohc")
    lifts = {}
    for model, options in (("wave-rod", {}), ("finite-element", {"elements_per_coil": 8})):
        built = build_train(case, spring_model=model, spring_set="nested", **options)
        ready = runner(built, case.operation.cam_speeds[0], TrainOptions(samples=720))
        _, record = ready.cycle(ready.initial_state())
        assert record.status.completed
        lifts[model] = record.q[:, built.mechanism.index("valve")]
    # the train's stiffness hides the spring: lifts agree to its elasticity, forces need not
    assert lifts["finite-element"] == pytest.approx(lifts["wave-rod"], abs=8e-5)


@pytest.mark.parametrize("name", ["stock", "performance"])
def test_a_wire_made_from_a_card_has_its_loads_and_mass(name):
    train = load_case("tdi-pushrod").train
    (card,) = train.springs[name]
    (spring,) = build_springs(train, "finite-element", name, elements_per_coil=12)
    forces = [spring.force(spring.initial_state(lift), lift).retainer for lift in (0.0, card.open_lift)]
    assert forces == pytest.approx([card.preload, card.open_load], rel=0.01)
    assert spring.definition.mass == pytest.approx(card.mass, rel=0.01)
    assert 4 < float(spring.definition.index(2.0)) < 12  # a spring that could be wound
