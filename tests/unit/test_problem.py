"""A problem: what a case builds, which members it makes, how often each part is made, and who may
see a case.
"""

from __future__ import annotations

import ast
import pickle
from pathlib import Path

import numpy as np
import pytest

import valvetrain
from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.system.build import build
from valvetrain.system.contract import PRESCRIBED, TRAIN, System
from valvetrain.system.prescribed import PrescribedSpring
from valvetrain.system.problem import Problem
from valvetrain.system.train_system import TrainSystem

SOURCE = Path(valvetrain.__file__).parent
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


def test_members_are_the_variants_of_a_train_or_each_set_by_each_model():
    case = load_case("tdi-pushrod")
    assert [member.label for member in build(case).members] == [
        variant.label for variant in case.train.variants if not variant.replica
    ]
    asked = build(
        case,
        spring_models=["massless", "wave-rod", "massless"],
        spring_set=["stock", "performance"],
    )
    assert [member.label for member in asked.members] == [
        f"{s}, {m}" for s in ("stock", "performance") for m in ("massless", "wave-rod")
    ]
    assert [member.spring_set for member in asked.members] == [
        "stock",
        "stock",
        "performance",
        "performance",
    ]
    assert len({id(member.gear) for member in asked.members}) == 1  # one mechanism for all


def test_models_of_a_spring_of_ones_own_follow_what_is_known_of_it():
    words = lambda text: tuple(member.label for member in build(parse_case(text)).members)
    assert words(CARD.format(mass='mass = "40 g"')) == ("modal-uniform",)
    assert words(CARD.format(mass="")) == ("massless",)
    assert tuple(member.label for member in build(load_case("uniform-spring")).members) == (
        "finite-element",
        "modal-varied",
    )


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


@pytest.mark.parametrize("name", ["job-t", "vaz-ohc"])
def test_a_problem_travels_between_processes(name):
    problem = build(load_case(name), spring_models=["multi-mass"])
    again = pickle.loads(pickle.dumps(problem))
    assert (
        isinstance(again, Problem)
        and again.record == problem.record
        and again.engine_speeds == problem.engine_speeds
    )
    angle = np.linspace(0, 2 * np.pi, 91)
    assert np.array_equal(again.valve_lift.lift(angle), problem.valve_lift.lift(angle))
    one, two = problem.members[0].system(), again.members[0].system()
    assert [spring.name for spring in one.springs] == [spring.name for spring in two.springs]
    for first, second in zip(one.springs, two.springs, strict=True):
        assert np.array_equal(first.parameters(), second.parameters())


#: Who may take a case: what loads it, what builds from it, and the entries of studies, commands and
#: figures of a case.
MAY_SEE_A_CASE = (
    "parameters", "cli", "api", "system/build.py", "runs", "explore", "workbench", "lift", "film", "rig", "scan", "compare_test",
    "views/motion/still.py",
)  # fmt: skip


#: Modules that give the names of a case.
HOMES = ("valvetrain.parameters.case", "valvetrain.parameters.loading")


def _case_takers() -> set[str]:
    """``file:function`` of every function or method of the package whose parameters name the
    :class:`Case` of ``parameters.case``.
    """
    found = set()
    for path in sorted(SOURCE.rglob("*.py")):
        tree = ast.parse(path.read_text())
        imports = [
            node
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom) and node.module in HOMES
        ]
        known = {
            one.asname or one.name
            for node in imports
            for one in node.names
            if one.name in ("Case", "AnyCase")
        }
        if path.name == "case.py" and path.parent.name == "parameters":
            known = {"Case"}
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef):
                given = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
                named = {
                    n.id
                    for a in given
                    if a.annotation is not None
                    for n in ast.walk(a.annotation)
                    if isinstance(n, ast.Name)
                }
                if named & known:
                    found.add(f"{path.relative_to(SOURCE).as_posix()}:{node.name}")
    return found


def test_no_function_beyond_build_and_the_entries_of_studies_takes_a_case():
    takers = _case_takers()
    # the scan sees annotations
    assert {
        "system/build.py:build",
        "runs/run.py:run_study",
        "parameters/case.py:diff",
    } <= takers
    assert not {one for one in takers if not one.startswith(MAY_SEE_A_CASE)}


def test_nothing_that_is_built_holds_a_case():
    seen: set[int] = set()

    def walk(item: object, depth: int = 0) -> None:
        if id(item) in seen or depth > 8:
            return
        seen.add(id(item))
        assert not isinstance(item, Case)
        if isinstance(item, tuple | list):
            for one in item:
                walk(one, depth + 1)
        elif isinstance(item, dict):
            walk(tuple(item.values()), depth + 1)
        elif type(item).__module__.startswith("valvetrain"):
            names = getattr(type(item), "__dataclass_fields__", {})
            walk(tuple(getattr(item, name) for name in names), depth + 1)

    walk(build(load_case("vaz-ohc")))
    assert len(seen) > 50
