"""Optimisation files that say what cannot be: one sentence with the place and the remedy."""

from __future__ import annotations

from pathlib import Path

import pytest

import valvetrain as vt
from unit.cli_parts import call, sentence
from valvetrain.explore import optimise
from valvetrain.explore.files import FileText
from valvetrain.explore.measure import OptimumModel
from valvetrain.explore.objective import read_optimum
from valvetrain.explore.optimum_rules import SearchFacts
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


def plan_of(text: str):
    return read_optimum(FileText(text, "search.toml", Path(), OptimumModel))


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
    with pytest.raises(vt.InputError, match="workers"):
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


def test_the_least_open_load_of_a_rate_is_that_of_its_card():
    """Rate of a card: loads at two heights, so that the least open load with it is known."""
    case = vt.Case(template_text("direct", cards=True))
    key, other = "train.springs.card.0.open_load", "train.springs.card.0.preload"
    varied = {key: vt.Uniform("500 N", "600 N"), other: vt.Uniform("200 N", "260 N")}
    bounds = {"card_rate": {"at_least": "35 N/mm"}, "card_preload": {"at_least": "230 N"}}
    found = case.optimise(
        varied, {"card_open_force": "minimise"}, bounds, search={"trials": 40}, workers=1
    )
    assert found.best is not None
    assert float(found.best.trial.objectives[0]) == pytest.approx(230.0 + 35e3 * 9e-3, rel=2e-3)
    assert float(found.best.trial.objectives[0]) == found.best.trial.values[0]
    assert float(found.case.objectives[0]) == 560.0 and found.case.state == "feasible"
    assert (
        SearchFacts(found, "best.toml", "case.toml").step
        == "valvetrain compare-springs case.toml best.toml"
    )


def test_the_total_of_a_pair_may_be_the_objective():
    case = vt.Case(template_text("direct", cards=True))
    keys = [f"train.springs.dual.{place}.open_load" for place in (0, 1)]
    varied = {keys[0]: vt.Uniform("300 N", "350 N"), keys[1]: vt.Uniform("180 N", "220 N")}
    found = case.optimise(
        varied, {"pair_card_open_force": "minimise"}, {"outer_card_rate": {"at_least": "18 N/mm"}},
        spring_sets="dual", search={"trials": 40}, workers=1,
    )  # fmt: skip
    assert float(found.case.objectives[0]) == pytest.approx(540.0, rel=1e-12)
    assert float(found.best.trial.objectives[0]) == pytest.approx(150 + 18e3 * 9e-3 + 180, rel=2e-3)
