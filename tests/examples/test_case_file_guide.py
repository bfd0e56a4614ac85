"""The case files printed in the guide are cases, and the guide names every kind of lift law and every key."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from valvetrain.cam import build_lift_law
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.schema_lift import MODELS, LiftModel

GUIDE = (Path(__file__).parents[2] / "docs" / "case-files.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```toml\n(.*?)```", GUIDE, re.DOTALL)


@pytest.mark.parametrize("text", EXAMPLES, ids=range(len(EXAMPLES)))
def test_printed_cases_load(text):
    case = parse_case(text)
    assert case.spring or case.spring_card or build_lift_law(case.lift_law).lift(3.0) > 0


def test_every_kind_and_key_is_named():
    assert len(EXAMPLES) >= 4
    for kind, model in MODELS.items():
        for key in (kind, *(name for name in model.model_fields if name not in LiftModel.model_fields)):
            assert f"`{key}`" in GUIDE, key
