"""The case files printed in the guide are cases, and the guide names every kind of lift law and
every key.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from valvetrain import registry
from valvetrain.cam import build_lift_law
from valvetrain.parameters.case import Operation
from valvetrain.parameters.installed_spring import CoilContact, DampingParameters, Rubbing
from valvetrain.parameters.lift_law import LiftModel
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.spring_blocks import CARD, OF_CARD, OF_WIRE

GUIDE = (Path(__file__).parents[2] / "docs" / "case-files.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```toml\n(.*?)```", GUIDE, re.DOTALL)


@pytest.mark.parametrize("text", EXAMPLES, ids=range(len(EXAMPLES)))
def test_printed_cases_load(text):
    case = parse_case(text)
    assert case.springs or build_lift_law(case.lift_law).lift(3.0) > 0


def test_every_kind_and_key_is_named():
    assert len(EXAMPLES) >= 4
    laws = {kind: registry.find("lifts", kind).table for kind in registry.BUILT_IN["lifts"]}
    options = {
        word: registry.find("springs", word).options for word in registry.BUILT_IN["springs"]
    }
    tables = [(laws, set(LiftModel.model_fields)), (options, set())]
    blocks = (SpringDefinition, DampingParameters, CoilContact, Rubbing, Operation)
    installed = {*CARD, *OF_CARD, *OF_WIRE}
    names = {
        name
        for table, common in tables
        for word, model in table.items()
        for name in (word, *set(model.model_fields) - common)
    }
    for key in sorted(
        (names | {name for model in blocks for name in model.model_fields} | installed | {"study"})
        - {"name", "values"}
    ):
        assert f"`{key}`" in GUIDE or f"{key} = " in GUIDE, key
