"""The assumed wires of the valve-gear case meet the loads of the service manual by the
finite-element rod.
"""

from __future__ import annotations

import pytest

from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import load_case
from valvetrain.springs.contract import SpringModel
from valvetrain.springs.spec import spring_model

OPEN = 9.7e-3  # m between the two loads of either spring


def rods(case: Case, spring_set: str, elements_per_coil: int) -> list[SpringModel]:
    """The springs of a set by the finite-element rod."""
    word = "finite-element"
    parts = case.train.spring_parts(spring_set)
    return [
        spring_model(word).build(part.with_options(word, elements_per_coil=elements_per_coil))
        for part in parts
    ]


def test_wires_meet_the_manuals_loads():
    outer, inner = rods(load_case("vaz-ohc"), "nested", 16)
    for spring, loads in ((outer, (283.4, 452.1)), (inner, (136.3, 275.5))):
        closed, opened = (
            spring.force(spring.initial_state(lift), lift).retainer for lift in (0.0, OPEN)
        )
        assert closed == pytest.approx(loads[0], rel=0.005)
        assert opened == pytest.approx(loads[1], rel=0.02)


def test_cards_are_the_manuals_lines():
    outer, inner = (part.card for part in load_case("vaz-ohc").train.spring_parts("nested-cards"))
    assert outer.preload + outer.rate * OPEN == pytest.approx(452.1, abs=0.2)
    assert inner.preload + inner.rate * OPEN == pytest.approx(275.5, abs=0.2)
    assert outer.preload / outer.rate == pytest.approx(
        50e-3 - 33.7e-3, rel=1e-3
    )  # straight from the free length


def test_a_finite_element_spring_runs_in_the_train_beside_the_cheap_ones():
    from valvetrain.integrate.contract import Cycles, RunOptions
    from valvetrain.integrate.run import run
    from valvetrain.system.build import build

    case = load_case("vaz-ohc")
    train = case.train
    coarse = tuple(
        part.with_options("finite-element", elements_per_coil=8)
        for part in train.spring_parts("nested")
    )
    case = case.replace(train=train.replace(springs={**train.springs, "nested": coarse}))
    problem = build(case, spring_models=("wave-rod", "finite-element"), spring_set=("nested",))
    lifts = {}
    for member in problem.members:
        found = run(
            member.system(), problem.engine_speeds[0] / 2, Cycles(1), RunOptions(samples=720)
        )
        assert found.status.completed
        lifts[member.model.word] = found.channel("valve_lift")
    # the train's stiffness hides the spring: lifts agree to its elasticity, forces need not
    assert lifts["finite-element"] == pytest.approx(lifts["wave-rod"], abs=8e-5)


@pytest.mark.parametrize("name", ["stock", "performance"])
def test_a_wire_made_from_a_card_has_its_loads_and_mass(name):
    case = load_case("tdi-pushrod")
    (card,) = (part.card for part in case.train.spring_parts(name))
    (spring,) = rods(case, name, 12)
    forces = [
        spring.force(spring.initial_state(lift), lift).retainer for lift in (0.0, card.open_lift)
    ]
    assert forces == pytest.approx([card.preload, card.open_load], rel=0.01)
    assert spring.definition.mass == pytest.approx(card.mass, rel=0.01)
    assert 4 < float(spring.definition.index(2.0)) < 12  # a spring that could be wound
