"""The train case printed in the guide runs, and the guide names every key of the schema."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.train import PARTS, TrainParameters
from valvetrain.runs.api import simulate

GUIDE = (Path(__file__).parents[2] / "docs" / "case-files-trains.md").read_text(encoding="utf-8")
(EXAMPLE,) = re.findall(r"```toml\n(.*?)```", GUIDE, re.DOTALL)


def test_the_printed_case_runs():
    study = simulate(parse_case(EXAMPLE), workers=1)
    assert study.labels == ("as built", "rod, no lash")
    assert all(run.status.completed for run in study.solutions)
    lifts = [run.quantities["peak_rigid_valve_lift"] for run in study.solutions]
    assert lifts == pytest.approx([7.9e-3, 8e-3], rel=1e-6)
    for run in study.solutions:
        assert run.quantities["lift_loss_displacement"] == pytest.approx(0, abs=5e-5)


def test_the_printed_case_holds_one_spring_with_its_options():
    (spring,) = parse_case(EXAMPLE).train.spring_parts()
    assert (spring.card.preload, spring.damping.mass_damping, spring.options_of("multi-mass")) == (
        250.0,
        50.0,
        {"elements": 8},
    )


def test_every_key_is_named():
    for model in (TrainParameters, *PARTS.values()):
        for key in model.model_fields:
            assert f"`{key}`" in GUIDE or f"[train.{key}" in GUIDE or f"[[train.{key}" in GUIDE, (
                f"{model.__name__}.{key}"
            )
