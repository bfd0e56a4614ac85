"""What a case gives and a model does not use is said or refused, never dropped in silence."""

from __future__ import annotations

from dataclasses import replace

import pytest

from fact_parts import with_code
from spring_shapes import cylindrical
from valvetrain.errors import InputError
from valvetrain.parameters.case_changes import changed_case
from valvetrain.parameters.installed_spring import DampingParameters, Guide, InstalledSpring
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.runs.api import static_curve
from valvetrain.runs.facts import case_facts
from valvetrain.system.build import build

PAIR = """
[[spring]]
preload = "300 N"
rate = "40 N/mm"
mass = "60 g"
[[spring]]
name = "inner"
preload = "150 N"
rate = "20 N/mm"
mass = "25 g"
[rubbing]
"""


@pytest.mark.parametrize(
    ("half", "missing"),
    [("coefficient = 0.1", "normal_force"), ('normal_force = "20 N"', "coefficient")],
)
def test_half_of_a_rubbing_is_refused(half, missing):
    with pytest.raises(InputError, match=f"without {missing} rubs nothing; give both"):
        parse_case(PAIR + half)


@pytest.mark.parametrize(
    "whole", ['coefficient = 0.1\nnormal_force = "20 N"', 'coefficient = 0\nnormal_force = "20 N"']
)
def test_a_whole_rubbing_may_be_switched_off_by_a_zero(whole):
    assert parse_case(PAIR + whole).rubbing.normal_force == 20.0


def codes(case, model: str) -> list[str]:
    problem = build(case, spring_models=[model])
    return [one.code for one in case_facts(problem, problem.members) if "damping" in one.code]


@pytest.mark.parametrize("model", ["multi-mass", "wave-rod", "modal-uniform"])
def test_a_spring_without_any_damping_is_named_where_it_moves(model):
    """Card values give none, and its surge then never fades; one number of any kind is enough."""

    def found(**damping):
        case = load_case("job-t")
        spring = replace(case.springs[0], damping=DampingParameters(**damping))
        case = case.replace(springs=(spring,))
        return codes(case, model)

    assert found() == ["no-damping"]
    assert found(mass_damping=20.0) == found(stiffness_damping=1e-6) == []
    assert found(ratio=0.016, ratio_frequency=400.0) == []


def test_every_spring_of_a_train_without_damping_is_named_once_and_others_are_not():
    def undamped(case, *models):
        problem = build(case, spring_models=list(models))
        found = with_code(case_facts(problem, problem.members), "no-damping")
        return [one.fields["spring"] for one in found]

    whole = load_case("vaz-ohc")
    assert undamped(whole, "multi-mass", "massless") == []
    bare = {f"train.springs.{name}.0.damping.mass_damping": "0 1/s" for name in whole.train.springs}
    case = changed_case(whole, bare)
    assert undamped(case, "multi-mass", "massless") == ["outer"]
    assert undamped(case, "massless") == []
    both = changed_case(case, {path.replace(".0.", ".1."): "0 1/s" for path in bare})
    assert sorted(undamped(both, "multi-mass")) == ["inner", "outer"]


def test_the_modal_model_presses_with_nothing_in_the_free_state():
    case = load_case("job-c", {"spring.options.finite-element.elements_per_coil": 12})
    curve = static_curve(case, "9 mm", models="modal-varied", steps=3)
    assert curve.compression[0] == 0.0 and curve.force[0] == 0.0
    assert curve.force[1] == pytest.approx(static_curve(case, "9 mm", steps=3).force[1], rel=1e-3)


def test_a_train_says_that_its_spring_buckles_by_the_formula_unless_it_is_guided():
    problem = build(load_case("vaz-ohc"))
    wire = cylindrical("1 mm", "10 mm", "4 mm", 20, ends="open", name="slender")

    def found(**how):
        spring = InstalledSpring(wire, **how)
        members = tuple(replace(member, springs=(spring,)) for member in problem.members)
        return with_code(case_facts(problem, members), "buckles")

    assert not with_code(case_facts(problem, problem.members), "buckles")
    (fact,) = found(precompression=12e-3)
    assert fact.fields["spring"] == "slender"
    assert fact.fields["compression"] == pytest.approx(15.84e-3, abs=5e-6)
    assert not found(precompression=2e-3)
    assert not found(precompression=12e-3, guide=Guide(bore="12 mm"))
