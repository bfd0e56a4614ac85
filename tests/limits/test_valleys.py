"""Limits: a search says which quantities designs as good as its best leave open, of functions whose
valleys are known.
"""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.views.results import answer_of

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
    """Least 2, anywhere on x + y = 1 with z = 0.3."""
    return {"height": 1.0 + x + y + 100 * (z - 0.3) ** 2, "sum": x + y}


def bowl(x: float, y: float, z: float) -> dict[str, float]:
    """Least 1 at one place alone."""
    away = (x - 0.7) ** 2 + (y - 0.6) ** 2 + (z - 0.3) ** 2
    return {"height": 1.0 + 100 * away, "sum": x + y}


def test_a_valley_is_told_by_the_designs_at_its_ends() -> None:
    """Truth known: x and y trade places over their whole range, z does not move."""
    found = searched(trough)
    valley = found.best.valley
    assert sorted(valley.open) == [0, 1]
    assert float(found.best.trial.objectives[0]) == pytest.approx(2.0, abs=0.02)
    for place in (0, 1):
        low, high = valley.ends(place)
        assert valley.values[low, place] < 0.05 and valley.values[high, place] > 0.95
    assert np.all(valley.values[:, :2].sum(axis=1) >= 1.0)
    assert np.all(np.abs(valley.objectives - found.best.trial.objectives[0]) <= 0.01 * 2.02)
    assert "O128" in answer_of(found).findings.codes


def test_where_every_quantity_is_settled_no_valley_is_told() -> None:
    """False: there is no valley in a bowl."""
    found = searched(bowl)
    assert found.best.valley.open == ()
    assert "O128" not in answer_of(found).findings.codes


def test_several_seeds_tell_the_spread_of_what_they_end_at() -> None:
    found = searched(trough, trials=30, seeds=3)
    bests = np.array([found.history(seed)[-1] for seed in found.seeds])
    assert np.ptp(bests) < 0.1
    assert sorted(found.best_by_seed.values()) == sorted(bests)
