"""Optimisation files that say what cannot be: one sentence with the place and the remedy."""

from __future__ import annotations

from pathlib import Path

import pytest

import valvetrain as vt
from unit.cli_parts import call, sentence
from valvetrain.explore import optimise
from valvetrain.explore.files import FileText
from valvetrain.explore.objective import read_optimum
from valvetrain.explore.optimum_file import OptimumModel
from valvetrain.parameters.templates import template_text

FILE = """
case = "gu2021-beehive-blind"
engine_speeds = "8000 rpm"
[[objective]]
quantity = "peak_spring_force"
direction = "minimise"
[[constraint]]
quantity = "preload"
at_least = "1.0 x case"
[[vary]]
key = "spring.wire_diameter"
low = "3.5 mm"
high = "4.1 mm"
[search]
trials = 8
"""
LIMIT = """[[objective]]
limit_speed = { quantity = "clash_energy", at_most = "5 mJ", engine_speeds = "5000:9000:500 rpm" }
direction = "maximise"
"""


def plan_of(text: str):
    return read_optimum(FileText(text, "search.toml", Path(), OptimumModel))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('direction = "minimise"', "", "line 4, objective.0.direction"),
        ('direction = "minimise"', 'direction = "down"', "objective.0.direction"),
        ('quantity = "peak_spring_force"', 'quantity = "peak_force"', "'peak_force' is no quantity; did you mean peak_stem_force, "),
        ('quantity = "peak_spring_force"', "", "objective.0: names nothing; give one of the two"),
        ('at_least = "1.0 x case"', "", "has no bound; give at_most, at_least or both"),
        ('at_least = "1.0 x case"', 'at_least = "200 mm"', "constraint.0.at_least"),
        ('at_least = "1.0 x case"', "at_least = 200", "constraint.0.at_least"),
        ('at_least = "1.0 x case"', 'at_least = "1.0 x csae"', "constraint.0.at_least"),
        ('quantity = "preload"', 'quantity = "preload"\nengine_speeds = "8000 rpm"', "belongs to springs at rest, at no engine speed"),
        ('low = "3.5 mm"\nhigh = "4.1 mm"', 'mean = "3.8 mm"\nstandard_deviation = "0.1 mm"', "between low and high or through values"),
        ('key = "spring.wire_diameter"', 'key = "engine_speed"', "engine speed"),
        ('key = "spring.wire_diameter"\nlow = "3.5 mm"\nhigh = "4.1 mm"', 'key = "engine_speed"\nlow = "3000 rpm"\nhigh = "4000 rpm"',
         "is no part of a design; give engine_speeds, or a limit_speed"),
        ("trials = 8", "trials = 0", "search.trials"),
        ("trials = 8", "trials = 8\nmethod = 'cma-es'", "search.method"),
        ("trials = 8", "trials = 8\nmethod = 'nsga2'\nper_round = 2", "a generation of nsga2 has 4 trials or more"),
        ("trials = 8", "trials = 8\nlocal = 1.5", "search.local"),
        ("[search]", "[[confirm]]\nlabel = 'finer'\n[search]", "confirms nothing; name a spring_model, or changes"),
        ("[search]", "[[confirm]]\nspring_model = 'wave-rods'\n[search]", "wave-rod"),
        ("[search]", "confirm = 3\n[search]", "vary.0"),
        ('case = "gu2021-beehive-blind"', 'case = "gu2021-beehive-blind"\nspring_sets = ["stock"]', "has no spring set stock"),
        ('case = "gu2021-beehive-blind"', 'case = "gu2021-beehive-blind"\nspring_models = "chain"', "spring_models"),
        ('case = "gu2021-beehive-blind"', 'case = "gu2021-behive"', "gu2021-beehive-blind"),
        ('case = "gu2021-beehive-blind"', 'case = "gu2021-beehive-blind"\nconfirm = 3', "is no row of models"),
        ('case = "gu2021-beehive-blind"', 'case = "gu2021-beehive-blind"\nobjectives = 3', "did you mean objective?"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_where_it_stands(old, new, words):
    assert old in FILE
    with pytest.raises(vt.InputError) as refused:
        plan_of(FILE.replace(old, new))
    assert (
        words in str(refused.value)
        and "search.toml" in str(refused.value)
        and "\n" not in str(refused.value)
    )


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('at_most = "5 mJ", ', "", "has one bound: give at_most or at_least"),
        ('at_most = "5 mJ", ', 'at_most = "5 mJ", at_least = "1 mJ", ', "has one bound: give at_most or at_least"),
        ('at_most = "5 mJ"', 'at_most = "5 mm"', "objective.0.limit_speed"),
        ("clash_energy", "preload", "belongs to springs at rest, so it has no limit speed"),
        ("clash_energy", "clash_energie", "is no quantity; did you mean clash_energy?"),
        ("5000:9000:500 rpm", "5000 rpm", "holds one speed; give a range"),
        ('"5000:9000:500 rpm"', '"5000:9000:500 rpm", resolution = "0 rpm"', "the resolution is not positive"),
        ('direction = "maximise"', 'direction = "maximise"\nengine_speeds = "4000 rpm"', "has engine_speeds of its own"),
        ('direction = "maximise"', 'direction = "maximise"\nquantity = "clash_count"', "names both a quantity and a limit_speed"),
    ],
)  # fmt: skip
def test_a_limit_speed_that_cannot_be_is_refused_where_it_stands(old, new, words):
    begin, end = FILE.index("[[objective]]"), FILE.index("[[constraint]]")
    text = FILE[:begin] + LIMIT + FILE[end:]
    assert old in text
    with pytest.raises(vt.InputError) as refused:
        plan_of(text.replace(old, new))
    assert words in str(refused.value) and "\n" not in str(refused.value)


def test_two_objectives_alike_are_refused():
    objective = FILE[FILE.index("[[objective]]") : FILE.index("[[constraint]]")]
    with pytest.raises(vt.InputError, match="is there twice"):
        plan_of(FILE.replace(objective, objective * 2))


def test_a_bound_that_is_a_share_of_a_case_without_that_number_is_refused():
    """With a lift beyond coil bind nothing of the case is known."""
    text = FILE.replace(
        'case = "gu2021-beehive-blind"',
        'case = "gu2021-beehive-blind"\nchanges = { "lift_law.maximum_lift" = "20 mm" }',
    )
    with pytest.raises(
        vt.InputError,
        match="the case itself cannot be computed, and a bound is a share of its numbers",
    ):
        vt.optimise(text.replace('"preload"', '"coil_bind_clearance"'), workers=1)


def test_fewer_than_one_worker_is_refused():
    with pytest.raises(vt.InputError, match="workers must be 1 or more"):
        vt.optimise(FILE, workers=0)


def test_an_empty_text_removes_a_key_of_the_case():
    """As on the command line, so that installed_height may take the place of the compression."""
    swap = 'changes = { "spring.precompression" = "", "spring.installed_height" = "39 mm" }'
    plan = plan_of(
        FILE.replace('case = "gu2021-beehive-blind"', f'case = "gu2021-beehive-blind"\n{swap}')
    )
    (spring,) = plan.case.springs
    assert spring.wire.free_length - spring.precompression == pytest.approx(39e-3)


@pytest.mark.parametrize("command", ["run", "study", "optimise"])
def test_a_folder_with_a_zero_byte_in_its_name_is_refused(command):
    """No shell can say it, a program that calls the command can."""
    result = call(command, "job-c", "--output=\0")
    assert result.exit_code == 2 and "holds a zero byte" in sentence(result)


DESIGN = {"train.springs.card.0.preload": vt.Uniform("200 N", "260 N")}


@pytest.mark.parametrize(
    ("name", "bounds"),
    [
        ("peak_shear_stress", {}),  # a card has no wire
        ("clash_count", {}),  # a model without mass has no coils
        ("card_rate", {"clash_energy": {"at_most": "1 mJ"}}),
        ("outer_card_rate", {}),  # one spring is no pair
    ],
)
def test_a_number_that_no_run_gives_is_refused_before_the_first_design(name, bounds, monkeypatch):
    designs = []
    own = optimise._Search.round
    monkeypatch.setattr(
        optimise._Search,
        "round",
        lambda *given, **options: designs.append(1) or own(*given, **options),
    )
    case = vt.Case(template_text("direct", cards=True))
    with pytest.raises(vt.InputError):
        case.optimise(
            DESIGN,
            {name: "minimise"},
            bounds,
            engine_speeds="3000 rpm",
            models="massless",
            search={"trials": 24},
            workers=1,
        )
    assert not designs


def test_what_is_varied_may_be_the_objective_and_a_bound():
    """Rate of a card: loads at two heights, so that the least open load with it is known."""
    case = vt.Case(template_text("direct", cards=True))
    key, other = "train.springs.card.0.open_load", "train.springs.card.0.preload"
    varied = {key: vt.Uniform("500 N", "600 N"), other: vt.Uniform("200 N", "260 N")}
    bounds = {"card_rate": {"at_least": "35 N/mm"}, other: {"at_least": "230 N"}}
    found = case.optimise(varied, {key: "minimise"}, bounds, search={"trials": 40}, workers=1)
    assert found.best is not None
    assert float(found.best.trial.objectives[0]) == pytest.approx(230.0 + 35e3 * 9e-3, rel=2e-3)
    assert float(found.best.trial.objectives[0]) == found.best.trial.values[0]
    assert float(found.case.objectives[0]) == 560.0 and found.case.state == "feasible"


def test_the_total_of_a_pair_may_be_the_objective():
    case = vt.Case(template_text("direct", cards=True))
    keys = [f"train.springs.dual.{place}.open_load" for place in (0, 1)]
    varied = {keys[0]: vt.Uniform("300 N", "350 N"), keys[1]: vt.Uniform("180 N", "220 N")}
    found = case.optimise(
        varied, {"pair_card_open_force": "minimise"}, {"outer_card_rate": {"at_least": "18 N/mm"}},
        spring_set="dual", search={"trials": 40}, workers=1,
    )  # fmt: skip
    assert float(found.case.objectives[0]) == pytest.approx(540.0, rel=1e-12)
    assert float(found.best.trial.objectives[0]) == pytest.approx(150 + 18e3 * 9e-3 + 180, rel=2e-3)
