"""A problem: what a case builds, which members it makes, how often each part is made, and who may
see a case.
"""

from __future__ import annotations

import pytest

import valvetrain
from valvetrain.errors import InputError
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.system.build import build
from valvetrain.system.contract import PRESCRIBED, TRAIN, System
from valvetrain.system.prescribed import PrescribedSpring
from valvetrain.system.train_system import TrainSystem

CARD = (
    '[spring]\nrate = "30 N/mm"\npreload = "250 N"\n{mass}\n[lift_law]\nkind = "sine-power"\nmaximum_lift = "8 mm"\n'
    + (
        'opening_start = "120 deg"\nclosing_end = "240 deg"\npower = 4\n[operation]\nengine_speeds = "4000 rpm"\n'
    )
)


@pytest.mark.parametrize("name", [summary.name for summary in valvetrain.list_cases()])
def test_every_shipped_case_builds_and_its_members_answer_as_systems(name):
    case = load_case(name)
    problem = build(case)
    assert problem.record.name == name and problem.kind == (
        TRAIN if case.train is not None else PRESCRIBED
    )
    for member in problem.members:
        assert member.kind == problem.kind and not member.refusal
        if member.model.needs_rest or member.model.word == "finite-element":
            continue
        system = member.system()
        assert isinstance(system, System) and isinstance(
            system, TrainSystem if problem.kind == TRAIN else PrescribedSpring
        )
        assert system.kind == problem.kind and len(system.spring_names) == len(
            system.springs
        ) == len(member.springs)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: build(parse_case('[lift_law]\nkind = "zero"')), "holds no spring and no train"),
        (lambda: build(load_case("job-t"), spring_set=["stock"]), "has no spring sets"),
        (
            lambda: build(load_case("job-t"), spring_models=["modal-varid"]),
            "did you mean modal-varied",
        ),
        (
            lambda: build(load_case("job-t", {"lift_law.maximum_lift": "20 mm"})),
            "reaches coil bind",
        ),
        (lambda: build(load_case("tdi-pushrod").replace(lift_law=None)), "holds no lift law"),
    ],
)
def test_what_cannot_be_built_is_one_sentence(make, words):
    with pytest.raises(InputError) as error:
        make()
    assert words in str(error.value) and "\n" not in str(error.value)


def test_a_model_that_does_not_serve_says_so_before_anything_runs():
    (member,) = build(parse_case(CARD.format(mass="")), spring_models=["multi-mass"]).members
    assert "has no mass on its card" in member.refusal
    with pytest.raises(InputError, match="has no mass on its card"):
        member.system()
    solid = build(load_case("tdi-pushrod"), spring_models=["solid"]).members[0]
    assert "need its wire" in solid.refusal
    with pytest.raises(InputError, match="need its wire"):
        solid.system()
