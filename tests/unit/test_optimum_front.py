"""Unit: which designs of a front a search names, worked out by hand, and how the page and the case
file of a design name them.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from valvetrain.explore.files import FileText
from valvetrain.explore.measure import Measured, OptimumModel
from valvetrain.explore.objective import read_optimum
from valvetrain.explore.optimum import Optimum, case_text
from valvetrain.explore.search import Trial

FILE = """
title = "Light and quick"
case = "job-c"
objective = [
  { quantity = "wire_mass", direction = "minimise" },
  { quantity = "estimated_surge_frequency", direction = "maximise" },
]
vary = [{ key = "spring.wire_diameter", low = "3 mm", high = "4.2 mm" }]
search = { method = "nsga2", trials = 160, per_round = 16 }
"""
#: Mass (g) and surge frequency (Hz) of the case and of the trials after it, the last of which are
#: beaten by others.
MADE = [(50, 90), (10, 100), (20, 200), (30, 350), (40, 380), (25, 150), (40, 370)]


def search(made: list[tuple[float, float]]) -> Optimum:
    plan = read_optimum(FileText(FILE, "search.toml", Path(), OptimumModel))
    trials = tuple(
        Trial(
            place,
            np.array([3e-3 + 1e-5 * place]),
            Measured(dict(zip(plan.measures, (1e-3 * mass, rate), strict=True)), {}),
            plan,
        )
        for place, (mass, rate) in enumerate(made)
    )
    return Optimum(plan, trials)


def test_balanced_is_nearest_to_the_best_of_both_and_the_ends_are_the_best_by_each():
    """Spans 30 g and 280 Hz: squared distances to (10 g, 380 Hz) are 1, 0.52, 0.46 and 1."""
    found = search(MADE)
    assert [one.number for one in found.front] == [1, 2, 3, 4]
    words = [(one.trial.number, one.chosen.partition(":")[0]) for one in found.designs]
    assert words == [(3, "balanced"), (1, "best wire mass"), (4, "best estimated surge frequency")]


def test_the_case_file_of_a_design_says_which_one_it_is():
    found = search(MADE)
    told = [tomllib.loads(case_text(found, one)) for one in found.designs]
    ends = ("balanced", "best wire mass", "best estimated surge frequency")
    assert [one["title"] for one in told] == [f"Light and quick, {end}" for end in ends]
    assert [one["spring"]["wire_diameter"] for one in told] == [
        f"{value!r} m" for value in (3.03e-3, 3.01e-3, 3.04e-3)
    ]
    assert [one["description"].split()[:2] for one in told] == [
        ["Trial", "3"],
        ["Trial", "1"],
        ["Trial", "4"],
    ]


@pytest.mark.parametrize(
    ("direction", "better", "worse"), [("minimise", 1.0, 2.0), ("maximise", 2.0, 1.0)]
)
def test_feasible_designs_go_first_then_those_that_miss_less_then_those_that_failed(
    direction, better, worse
):
    text = FILE.replace('direction = "minimise"', f'direction = "{direction}"')
    bound = 'constraint = [{ quantity = "estimated_rate", at_least = "40 N/mm" }]'
    plan = read_optimum(FileText(f"{text}{bound}", "search.toml", Path(), OptimumModel))

    def trial(number: int, mass: float, rate: float, failure: str = "") -> Trial:
        measured = Measured(dict(zip(plan.measures, (mass, 1.0, rate), strict=True)), {}, failure)
        return Trial(number, np.array([3e-3]), measured, plan)

    order = [
        trial(5, better, 50e3), trial(4, worse, 50e3), trial(3, better, 39e3), trial(2, better, 20e3),
        trial(0, better, 50e3, "diverged"), trial(1, better, 50e3, "diverged"),
    ]  # fmt: skip
    assert sorted(reversed(order), key=lambda one: one.rank) == order
