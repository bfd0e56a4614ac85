"""Contract: the verdict on a grid tells how far its output stays near the best, on any grid."""

from __future__ import annotations

import re
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
  {{ key = "{key}", values = "{lashes}", label = "{label}" }},
]
"""
OVER_SPEED = '{ key = "engine_speed", values = "2000, 4000 rpm" },'


LASHES = "0, 0.1, 0.2, 0.3, 0.4 mm"


def told(
    function,
    output="seating_velocity",
    over_speed=True,
    lashes=LASHES,
    key="train.cam.width",
    angle=None,
) -> str:
    """The verdict where the output is a function of lash (mm), here of a width, and share of the highest
    speed; ``angle``: cam angle (deg) of the touch as such a function.
    """
    speed = "" if over_speed else 'engine_speeds = "4000 rpm"'
    text = TEXT.format(
        output=output if angle is None else f'{output}", "seating_cam_angle',
        varied=OVER_SPEED if over_speed else "",
        speed=speed,
        lashes=lashes,
        key=key,
        label=key.rpartition(".")[2],
    )
    plan = read_plan(StudyText(text, "study", Path()))
    inputs = plan.sampler.first(plan.varied, plan.options)
    share = inputs[:, 0] / inputs[:, 0].max() if over_speed else np.ones(len(inputs))
    values = np.array(
        [
            [function(lash, one), *([] if angle is None else [np.radians(angle(lash, one))])]
            for lash, one in zip(1e3 * inputs[:, -1], share, strict=True)
        ]
    )
    return study_verdict(StudyTable(plan, inputs, plan.runs * len(inputs), values, (COMPLETED,) * len(inputs)))  # fmt: skip


def ramp(lash: float, speed: float) -> float:
    """Touch on a ramp of 0.25 mm, then on the flank."""
    return speed * (0.1 + 0.1 * lash if lash <= 0.25 else 0.125 + 4 * (lash - 0.25))


def test_a_finer_grid_moves_the_edge_by_less_than_a_step():
    """Property: the end of the flat part is that of the function, to a step of the coarser grid."""
    fine = ", ".join(f"{0.02 * step:g}" for step in range(21))
    said = told(ramp, lashes=f"{fine} mm")
    edge = re.search(r"up to width ([0-9.]+) mm", said)
    assert edge and 0.2 <= float(edge[1]) < 0.3


@pytest.mark.parametrize(
    ("function", "wanted"),
    [
        (lambda lash, _: np.exp(-12 * lash), "stays within 0.0907 m/s from width 0.2 mm on, but 0.301 m/s at 0.1 mm"),
        (lambda lash, _: np.exp(-12 * (0.4 - lash)), "stays within 0.0907 m/s up to width 0.2 mm, but 0.301 m/s at 0.3 mm"),
        (lambda lash, _: 1.0 - lash, ""),
        (lambda lash, _: 1.0, ""),
        (lambda lash, _: (lash - 0.2) ** 2, ""),
        (lambda lash, _: 0.5 - abs(lash - 0.2), ""),
    ],
)  # fmt: skip
def test_only_a_flat_part_at_the_better_end_is_told(function, wanted):
    said = told(function, over_speed=False)
    assert (wanted in said) if wanted else "stays" not in said


def test_engine_speed_alone_is_told_and_never_chosen():
    """Contract: of points that differ in engine speed none is best."""
    text = TEXT.format(
        output="seating_velocity", varied="", speed="", lashes="2000, 4000, 6000 rpm", key="engine_speed", label="engine speed"
    )  # fmt: skip
    plan = read_plan(StudyText(text, "study", Path()))
    inputs = plan.sampler.first(plan.varied, plan.options)
    values = np.array([[0.1], [0.2], [0.4]])
    said = study_verdict(StudyTable(plan, inputs, plan.runs * 3, values, (COMPLETED,) * 3))
    assert said == (
        "The seating velocity is between 0.1 m/s with engine speed 2000 rpm and 0.4 m/s with engine speed 6000 rpm."
    )
