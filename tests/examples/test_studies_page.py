"""The studies of the guide and of the folder of examples are read, and their first points run; the
guide's tables are whole.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from valvetrain import registry
from valvetrain.explore.files import FileText, VaryModel
from valvetrain.explore.outputs import Task
from valvetrain.explore.requests import Study
from valvetrain.explore.study import StudyModel, read_plan

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "studies.md").read_text(encoding="utf-8")
FILES = sorted((ROOT / "examples" / "studies").glob("*.toml"))
BLOCKS = re.findall(r"^```toml\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)


def first_point_runs(plan) -> None:
    draws = plan.sampler.draw(plan.varied, plan.options)
    outcome = plan.experiment.evaluate(
        draws[0], Task(plan.runs[0], plan.experiment.outputs.request)
    )
    assert outcome.status.completed, outcome.status.sentence()
    quantities = plan.experiment.outputs.quantities  # limit speeds take many runs
    assert set(outcome.values) == set(quantities) or not quantities


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_the_first_point_of_an_example_runs(path):
    first_point_runs(Study.read({"file": path}).plan)
    assert (
        f"valvetrain study {path.relative_to(ROOT).as_posix()}" in path.read_text()
        and path.name in PAGE
    )


@pytest.mark.parametrize("text", BLOCKS, ids=range(len(BLOCKS)))
def test_the_first_point_of_a_study_of_the_guide_runs(text):
    first_point_runs(read_plan(FileText(text, "guide", Path(), StudyModel)))


def test_the_guide_names_every_key_and_every_sampler():
    named = set(re.findall(r"`([\w-]+)`", PAGE)) | set(re.findall(r"`(\w+) = ", PAGE))
    keys = {
        field.alias or name
        for model in (StudyModel, VaryModel)
        for name, field in model.model_fields.items()
    }
    assert not keys - named - {"points", "vary", "as"} and set(registry.names("samplers")) <= named
    options = {
        key
        for word in registry.names("samplers")
        for key in registry.find("samplers", word).options.model_fields
    }
    assert options <= named
