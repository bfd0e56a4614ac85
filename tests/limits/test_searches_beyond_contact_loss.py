"""A search where every design loses contact: its least contact force is zero alike, and yet one is nearest."""

from __future__ import annotations

import itertools

import pytest

import valvetrain as vt
from valvetrain.parameters.templates import template_text
from valvetrain.views.results import answer_of

FORCE = "minimum_cam_contact_force"
KEYS = ("train.springs.card.0.preload", "train.springs.card.0.open_load")


@pytest.fixture(scope="module")
def case() -> vt.Case:
    """A light bucket tappet, which needs some 780 N of open load at 15 500 rpm."""
    text = template_text("direct", cards=True).replace("3000, 5500 rpm", "15500 rpm")
    return vt.Case(text.replace('"45 g"', '"16 g"').replace('"95 g"', '"30 g"'))


@pytest.fixture(scope="module")
def found(case):
    varied = {KEYS[0]: vt.Uniform("150 N", "260 N"), KEYS[1]: vt.Uniform("440 N", "680 N")}
    return case.optimise(
        varied, {"card_rate": "minimise"}, {FORCE: {"at_least": "20 N"}},
        models="massless", search={"trials": 12}, workers=1,
    )  # fmt: skip


def test_the_nearest_design_is_the_one_with_the_shortest_loss_of_contact(case, found):
    """Rigid theory, which knows nothing of the run, puts the designs in the same order."""
    assert found.best is None and all(one.constraints[0] == 0.0 for one in found.trials)
    nearest = found.nearest
    assert nearest.number > 0 and nearest is min(found.trials, key=lambda one: one.losses[0])
    assert nearest is min(found.trials, key=lambda one: one.losses[2])
    ordered = sorted(found.trials, key=lambda one: one.rank)
    margins = [one.losses[2] for one in ordered]
    assert sum(a > b for a, b in itertools.pairwise(margins)) <= len(margins) // 4
    # the search went where contact is lost for a shorter time
    assert nearest.values[1] > 0.9 * max(one.values[1] for one in found.trials[:9])


def test_the_verdict_names_the_force_that_is_missing(found):
    assert answer_of(found).verdict.code == "O103"


@pytest.mark.slow
def test_of_designs_alike_in_their_best_force_of_zero_the_nearest_is_the_best(case):
    """As an objective the force is zero alike too."""
    found = case.optimise(
        {KEYS[1]: vt.Uniform("440 N", "680 N")}, {FORCE: "maximise"}, models="massless", search={"trials": 6}, workers=1,
    )  # fmt: skip
    assert all(one.objectives[0] == 0.0 for one in found.trials)
    assert found.best.trial is min(found.trials, key=lambda one: one.losses[0])
    assert found.best.trial.number > 0
