"""Unit: the best design of a reduced model is checked by the finest one that the case allows, where that costs no more
than the search.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import valvetrain as vt
from valvetrain.explore.files import FileText
from valvetrain.explore.measure import OptimumModel
from valvetrain.explore.objective import plan_of_experiment, read_optimum
from valvetrain.views.results import answer_of

WIRE = """
case = "gu2021-beehive-blind"
engine_speeds = "6000 rpm"
spring_models = ["multi-mass"]
objective = [{ quantity = "peak_spring_force", direction = "minimise" }]
vary = [{ key = "spring.wire_diameter", low = "3.7 mm", high = "3.8 mm" }]
search = { trials = 400 }
"""
CARDS = """
case = "tdi-pushrod"
engine_speeds = "6000 rpm"
spring_models = ["multi-mass"]
spring_sets = ["stock"]
objective = [{ quantity = "minimum_cam_contact_force", direction = "maximise" }]
vary = [{ key = "train.springs.stock.0.preload", low = "120 N", high = "200 N" }]
search = { trials = 400 }
"""
CHAIN = '["multi-mass"]'
CONFIRMED = 'search = { trials = 400 }\nconfirm = ["finite-element"]'
SIZES = "peak_spring_force", "largest_outer_diameter"


@pytest.mark.parametrize(
    ("text", "labels", "unchecked"),
    [
        (WIRE, ["finite-element"], ""),
        (WIRE.replace("trials = 400", "trials = 4"), [], "finite-element"),  # it would cost more than the search
        (WIRE.replace(CHAIN, '["finite-element"]'), [], ""),
        (WIRE.replace("search = { trials = 400 }", CONFIRMED), ["finite-element"], ""),
        (WIRE.replace(*SIZES), [], ""),  # dimensions are those of any model
        (CARDS, ["wave-rod"], ""),
        (CARDS.replace(CHAIN, '["wave-rod"]'), [], ""),  # a card has no finer model
    ],
)  # fmt: skip
def test_a_search_by_a_reduced_model_is_checked_by_the_finest(text, labels, unchecked):
    plan = read_optimum(FileText(text, "search.toml", Path(), OptimumModel))
    assert list(plan.confirmations) == labels and plan.unchecked == unchecked
    for one in plan.confirmations.values():
        assert {run[1] for measure in one.measures for run in measure.runs} == set(labels)
        assert 2 * one.seconds <= 400 * plan.seconds


def test_a_function_has_no_finer_model():
    outputs = vt.Outputs("height", function=lambda x: {"height": x})
    experiment = vt.Experiment(None, vt.Space({"x": vt.Uniform(0.0, 1.0)}), outputs)
    plan = plan_of_experiment(experiment, [{"quantity": "height", "direction": "minimise"}], (), {})
    assert not plan.confirmations


@pytest.mark.slow
def test_what_the_finest_says_of_springs_at_rest_is_its_own():
    """Preload of the best by the straight line of its rate, and by the rod, whose coils close one after the other."""
    text = """
case = "gu2021-beehive-blind"
rest_model = "massless"
confirm = ["finite-element"]
objective = [{ quantity = "installed_height", direction = "maximise" }]
constraint = [{ quantity = "preload", at_least = "300 N" }]
vary = [{ key = "spring.precompression", low = "2 mm", high = "20 mm" }]
search = { trials = 24 }
"""
    found = vt.optimise(text, workers=1)
    (other,) = found.confirmed
    value = float(found.best.trial.values[0])
    rod = vt.Case("gu2021-beehive-blind").study(
        {"spring.precompression": [value]}, "preload", workers=1
    )
    preload = float(rod.values[0, 0])
    assert float(other.design.constraints[0]) == preload != float(found.best.trial.constraints[0])
    assert float(found.best.trial.constraints[0]) == pytest.approx(300.0, rel=2e-3)
    codes = answer_of(found).findings.codes
    assert ("O121" in codes) == (preload < 300.0) == (not other.design.feasible)
