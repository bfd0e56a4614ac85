"""The searches of the guide and of the folder of examples are read, and their first designs
computed; the guide's tables are whole.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from valvetrain.explore.engine import Engine
from valvetrain.explore.files import FileText, LimitSpeedModel
from valvetrain.explore.measure import (
    ConstraintModel,
    ObjectiveModel,
    OptimumModel,
    SearchModel,
    measure_designs,
)
from valvetrain.explore.objective import read_optimum
from valvetrain.explore.optimise import case_of_plan, search_cost
from valvetrain.explore.requests import Optimise

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "optimisation.md").read_text(encoding="utf-8")
FILES = sorted((ROOT / "examples").glob("optimise-*.toml"))
BLOCKS = [
    text
    for text in re.findall(r"^```toml\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    if "[search]" in text or "search =" in text
]


def case_is_measured(text: FileText[OptimumModel]) -> None:
    """All that a search asks of the case is there."""
    plan = read_optimum(text)
    assert search_cost(plan, 2).seconds < 600  # within the usual bound
    case = case_of_plan(plan)
    with Engine([plan.experiment], 1, None) as engine:
        (measured,) = measure_designs(
            engine, plan.experiment, [case], plan.measures, plan.rest_model
        )
    assert (
        not measured.failure
        and set(measured.values) == set(plan.measures)
        and all(map(np.isfinite, measured.values.values()))
    )


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_the_case_of_an_example_is_computed(path):
    case_is_measured(Optimise.read({"file": path}).text)
    assert (
        f"valvetrain optimise {path.relative_to(ROOT).as_posix()}" in path.read_text()
        and path.name in PAGE
    )


@pytest.mark.parametrize("text", BLOCKS, ids=range(len(BLOCKS)))
def test_the_case_of_the_guide_is_computed(text):
    assert len(BLOCKS) == 2
    case_is_measured(FileText(text, "guide", Path(), OptimumModel))


def test_the_guide_names_every_key():
    named = set(re.findall(r"`([\w-]+)`", PAGE)) | set(re.findall(r"`?(\w+) = ", PAGE))
    models = (
        OptimumModel,
        ObjectiveModel,
        ConstraintModel,
        LimitSpeedModel,
        SearchModel,
    )
    assert not {name for model in models for name in model.model_fields} - named
    assert {"tpe", "nsga2"} <= named
