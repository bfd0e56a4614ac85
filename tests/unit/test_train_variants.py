"""Unit: what a variant of a train changes of it, field by field, and that it changes nothing else."""

from __future__ import annotations

from dataclasses import fields

import pytest

from valvetrain.parameters.loading import load_case
from valvetrain.parameters.train import TrainVariant

#: Fields of a variant -> fields of the train as they are with it; the train has the sets stock and
#: performance.
CHANGES = [
    ({}, {}),
    ({"spring_set": "performance"}, {"spring_set": "performance"}),
    ({"spring_model": "massless"}, {"spring_model": "massless"}),
    ({"lash": 2e-4}, {"lash": 2e-4}),
    ({"lash": 0.0}, {"lash": 0.0}),
    ({"spring_set": "performance", "spring_model": "massless", "lash": 2e-4},
     {"spring_set": "performance", "spring_model": "massless", "lash": 2e-4}),
    ({"note": "as printed"}, {}),
]  # fmt: skip


def train():
    return load_case("tdi-pushrod", {"train.lash": "0.1 mm"}).train


@pytest.mark.parametrize(("asked", "changed"), CHANGES)
def test_a_variant_changes_what_it_names_and_nothing_else(asked, changed):
    before = train()
    after = TrainVariant("one", **asked).apply(before)
    assert (
        before.spring_set == "stock"
        and before.spring_model == "multi-mass"
        and before.lash == pytest.approx(1e-4)
    )
    for field in fields(before):
        assert getattr(after, field.name) == changed.get(field.name, getattr(before, field.name)), (
            field.name
        )


def test_a_damper_on_the_valve_adds_to_its_own():
    once = TrainVariant("one", valve_damping=3.0).apply(train())
    assert (
        once.valve.damping == 3.0
        and TrainVariant("two", valve_damping=0.5).apply(once).valve.damping == 3.5
    )


@pytest.mark.parametrize(("chosen", "other"), [("stock", "performance"), ("performance", "stock")])
def test_without_preload_the_springs_of_its_own_set_are_at_rest(chosen, other):
    before = train()
    after = TrainVariant("one", spring_set=chosen, without_preload=True).apply(before)
    assert [spring.card.preload for spring in after.springs[chosen]] == [0.0] and all(
        spring.tied for spring in after.springs[chosen]
    )
    assert (
        after.springs[other] == before.springs[other]
        and before.springs[chosen][0].card.preload > 100
    )
