"""Limits: a search says which quantities designs as good as its best leave open, of functions whose
valleys are known.
"""

from __future__ import annotations

import pytest

import valvetrain as vt
from valvetrain.views.results import answer_of, figures_of

pytest.importorskip("optuna")
EVEN = vt.explore.Prior("uniform", 0.0, 1.0)
SPACE = vt.Space({"x": EVEN, "y": EVEN, "z": EVEN})


def searched(function, **search) -> vt.explore.Optimum:
    outputs = vt.Outputs(["height", "sum"], function=function)
    return vt.Experiment(None, SPACE, outputs).optimise(
        [{"quantity": "height", "direction": "minimise"}],
        [{"quantity": "sum", "at_least": 1.0}],
        {"trials": 60, **search},
        workers=1,
    )


def trough(x: float, y: float, z: float) -> dict[str, float]:
    """Least 1, anywhere with z = 0.3; within 1 % of it where z is within 0.04 of that."""
    return {"height": 1.0 + 6.25 * (z - 0.3) ** 2, "sum": x + y}


def bowl(x: float, y: float, z: float) -> dict[str, float]:
    """Least 1 at one place alone."""
    away = (x - 0.7) ** 2 + (y - 0.6) ** 2 + (z - 0.3) ** 2
    return {"height": 1.0 + 100 * away, "sum": x + y}


def test_a_valley_is_told_by_the_designs_as_good() -> None:
    """Truth known: x and y do not matter, z does not move."""
    found = searched(trough)
    facts = answer_of(found).facts
    assert float(found.best.trial.objectives[0]) == pytest.approx(1.0, abs=0.01)
    assert facts.alike(0) and facts.alike(1) and not facts.alike(2)
    assert "O128" in answer_of(found).findings.codes
    # of more than two quantities the designs are drawn over the trials, the best of them as a star
    star = figures_of(answer_of(found))["designs"].data[-1]
    assert (star.name, list(star.x)) == ("best", [found.best.trial.number])


def test_where_every_quantity_is_settled_no_valley_is_told() -> None:
    """False: there is no valley in a bowl."""
    found = searched(bowl)
    assert not any(map(answer_of(found).facts.alike, range(3)))
    assert "O128" not in answer_of(found).findings.codes
