"""Unit: every rule on a search, in a result in which it holds and in one in which it does not; codes and numbers, no
sentences.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

import valvetrain as vt
from unit.test_optimise_command import LIGHT, light
from valvetrain.explore.measure import Measured
from valvetrain.explore.optimum import Confirmed, Optimum
from valvetrain.explore.optimum_answer import OptimumAnswer
from valvetrain.explore.optimum_rules import RULES
from valvetrain.solution.uncertainty import Uncertainty

pytest.importorskip("optuna")
EVEN = vt.explore.Prior("uniform", 0.0, 1.0)
LEAST = [{"quantity": "height", "direction": "minimise"}]


def searched(function, trials: int = 12, goals=LEAST, **search) -> Optimum:
    outputs = vt.Outputs([one["quantity"] for one in goals], function=function)
    space = vt.Space({"x": EVEN, "y": EVEN})
    return vt.Experiment(None, space, outputs).optimise(
        goals, (), {"trials": trials, **search}, workers=1
    )


def trough(x: float, y: float) -> dict[str, float]:
    return {"height": 1.0 + (x - 0.3) ** 2, "other": 2.0 - x}


def no_number(x: float, y: float) -> dict[str, float]:
    raise ValueError("no such spring")


@cache
def lighter() -> Optimum:
    """The case meets every bound, and so do lighter designs."""
    text = LIGHT.replace("1.1 x case", "0.9 x case")
    return vt.optimise(text, workers=1)


@cache
def runs() -> Optimum:
    return vt.optimise(
        """
case = "job-c"
engine_speeds = "4000 rpm"
spring_models = ["modal-uniform"]
vary = [{ key = "spring.precompression", low = "5 mm", high = "6.5 mm" }]
objective = [{ quantity = "peak_spring_force", direction = "minimise" }]
search = { trials = 2, per_round = 2, local = 0.0 }
""",
        workers=1,
    )


@cache
def front() -> Optimum:
    goals = [*LEAST, {"quantity": "other", "direction": "minimise"}]
    return searched(trough, 24, goals, method="nsga2", per_round=8)


@cache
def impossible() -> Optimum:
    return vt.optimise(LIGHT.replace("1.1 x case", "400 N/mm"), workers=1)  # fmt: skip


def by_another(found: Optimum, share: float) -> Optimum:
    """The search with another model that confirms this share of the gain."""
    goal, best = found.plan.objectives[0].measure, found.best
    before, after = (float(one.objectives[0]) for one in (found.case, best.trial))
    value = before + share * (after - before)
    other = replace(best.trial, measured=Measured({**best.trial.measured.values, goal: value}, {}))
    confirmed = (Confirmed("a finer mesh", found.case, other),)
    return replace(found, confirmed=confirmed)


def barred(found: Optimum, share: float) -> Optimum:
    """The search with an error bar of its objective, a share of the best value."""
    goal, value = found.plan.objectives[0].measure, float(found.best.trial.objectives[0])
    row = Uncertainty(goal.quantity, 419.0, value, share * value, None, value, 0.0, (value,) * 2, (value,) * 2, "rod")  # fmt: skip
    return replace(found, error_bars=(row,))


def missing(found: Optimum) -> Optimum:
    """The search with another model by which the best design misses the bound on the rate."""
    found = by_another(found, 1.0)
    (one,), bound = found.confirmed, found.plan.constraints[0]
    measured = Measured({**one.design.measured.values, bound.measure: 0.5 * bound.bound}, {})
    one = replace(one, design=replace(one.design, measured=measured))
    return replace(found, confirmed=(one,))


def doubted(text: str) -> Optimum:
    return replace(lighter(), doubt=text)


#: Code -> a result in which the rule holds, and one in which it does not.
CASES = {
    "O101": (lambda: searched(no_number, 2), lighter),
    "O103": (impossible, lighter),
    "O104": (front, lighter),
    "O105": (lambda: searched(lambda x, y: {"height": abs(x - 0.5) + abs(y - 0.5)}, 2, local=0.0), lighter),
    "O106": (lambda: by_another(lighter(), 0.5), lambda: by_another(lighter(), 0.95)),
    "O107": (lambda: barred(lighter(), 2.0), lambda: barred(lighter(), 0.001)),
    "O108": (light, lighter),
    "O109": (lighter, light),
    "O120": (lambda: replace(lighter(), finished=False), lighter),
    "O121": (lambda: missing(lighter()), lambda: by_another(lighter(), 1.0)),
    "O122": (lambda: doubted("4.2 turns are few. Take more"), lighter),
    "O123": (light, runs),
    "O126": (lambda: barred(lighter(), 0.6), lambda: barred(lighter(), 0.3)),
    "O127": (runs, lighter),
    "O128": (lambda: searched(trough), lighter),
}  # fmt: skip


@pytest.mark.parametrize("code", CASES)
def test_a_rule_holds_in_one_result_and_not_in_the_other(code):
    holds, differs = CASES[code]
    assert code in OptimumAnswer(holds()).findings.codes
    assert code not in OptimumAnswer(differs()).findings.codes


def test_every_rule_is_tried():
    assert [one.code for one in RULES] == list(CASES)


def test_the_verdict_has_the_numbers_of_case_and_best():
    found = lighter()
    answer = OptimumAnswer(found, Path("out"))
    fields = answer.verdict.fields
    assert fields["before"].value == found.case.objectives[0]
    assert fields["after"].value == found.best.trial.objectives[0]
    assert answer.next_step == "valvetrain run out/best.toml"
    assert 4 <= len(answer.lines) <= 12 and all(len(one.cells) == 3 for one in answer.lines)


def test_a_missed_bound_is_named_with_what_is_missing():
    found = impossible()
    nearest = found.nearest
    verdict = OptimumAnswer(found).verdict
    assert verdict.fields["by"].value == pytest.approx(400e3 - float(nearest.constraints[0]))
