"""Contract: the verdict on a grid tells where the output jumps, or from where on little is gained."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from valvetrain.explore.study import StudyText, read_plan
from valvetrain.explore.study_verdict import study_verdict
from valvetrain.explore.table import StudyTable
from valvetrain.solution.status import COMPLETED

TEXT = """
kind = "points"
title = "Shape"
case = "vaz-ohc"
spring_models = "massless"
spring_sets = "nested"
{speed}
outputs = ["{output}"]
points = {{ sampler = "grid" }}
vary = [
  {varied}
  {{ key = "train.lash", values = "0, 0.1, 0.2, 0.3, 0.4 mm", label = "lash" }},
]
"""
OVER_SPEED = '{ key = "engine_speed", values = "2000, 4000 rpm" },'


def told(function, output="seating_velocity", over_speed=True) -> str:
    """The verdict where the output is a function of lash (mm) and share of the highest speed."""
    speed = "" if over_speed else 'engine_speeds = "4000 rpm"'
    text = TEXT.format(output=output, varied=OVER_SPEED if over_speed else "", speed=speed)
    plan = read_plan(StudyText(text, "study", Path()))
    inputs = plan.sampler.first(plan.varied, plan.options)
    share = inputs[:, 0] / inputs[:, 0].max() if over_speed else np.ones(len(inputs))
    values = np.array(
        [[function(lash, one)] for lash, one in zip(1e3 * inputs[:, -1], share, strict=True)]
    )
    return study_verdict(StudyTable(plan, inputs, plan.runs * len(inputs), values, (COMPLETED,) * len(inputs)))  # fmt: skip


def test_a_jump_is_told_for_the_worst_engine_speed():
    ramp = told(lambda lash, speed: speed * (0.1 + 0.1 * lash if lash < 0.25 else 0.5 + lash))
    assert ramp == (
        "At every engine speed seating velocity stays within 0.12 m/s up to lash 0.2 mm, but 0.8 m/s at 0.3 mm."
    )
    fallen = told(lambda lash, speed: speed * (0.1 if lash > 0.25 else 0.9))
    assert "stays within 0.1 m/s from lash 0.3 mm on, but 0.9 m/s at 0.2 mm" in fallen


def test_where_more_is_better_the_least_is_what_stays():
    held = told(lambda lash, speed: 300.0 if lash < 0.15 else 100.0 - lash, "minimum_spring_force")
    assert (
        "minimum spring force stays at 300 N or more up to lash 0.1 mm, but 99.8 N at 0.2 mm"
        in held
    )


@pytest.mark.parametrize(
    ("function", "wanted"),
    [
        (lambda lash, _: np.exp(-12 * lash), "nine tenths of the gain are there from lash 0.2 mm"),
        (lambda lash, _: np.exp(-12 * (0.4 - lash)), "nine tenths of the gain are there up to lash 0.2 mm"),
        (lambda lash, _: 1.0 - lash, ""),
        (lambda lash, _: 1.0, ""),
    ],
)  # fmt: skip
def test_what_levels_off_says_from_where_on_and_a_straight_line_nothing(function, wanted):
    said = told(function, over_speed=False)
    assert (wanted in said) if wanted else "gain" not in said


def test_a_slope_over_engine_speeds_is_no_jump():
    said = told(lambda lash, speed: speed * (0.1 + lash))
    assert said.startswith("Best is engine speed 2000 rpm, lash 0 mm")
