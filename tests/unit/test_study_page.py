"""The files of a study."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from valvetrain.explore.files import FileText
from valvetrain.explore.results import answer_json
from valvetrain.explore.study import StudyModel, analysed, read_plan
from valvetrain.explore.study_answer import StudyAnswer
from valvetrain.explore.table import StudyTable
from valvetrain.solution.status import COMPLETED, Status
from valvetrain.views.page import page_of

TEXT = """
title = "Two <b>quantities</b>"
case = "gu2021-beehive-blind"
engine_speeds = "6000 rpm"
spring_models = "massless"
outputs = ["peak_spring_force", "peak_valve_lift"]
points = {{ sampler = "{sampler}", count = 256 }}
vary = [
  {{ key = "spring.precompression", low = "6 mm", high = "8 mm", label = "installed <i>compression</i>" }},
  {{ key = "lift_law.maximum_lift", as = "factor", low = 0.9, high = 1.1 }},
]
"""


def made(sampler="latin-hypercube", function=None, failed=()) -> StudyTable:
    """A table whose outputs are a function of the inputs, no run behind it."""
    plan = read_plan(FileText(TEXT.format(sampler=sampler), "study", Path(), StudyModel))
    inputs = plan.sampler.draw(plan.varied, plan.options)
    cube = (inputs - inputs.min(axis=0)) / np.ptp(inputs, axis=0)
    found = (function or (lambda c: 800 + 40 * c[:, 0] + 5 * c[:, 1] ** 2))(cube)
    values = np.column_stack([found, np.full(len(found), 9e-3)])
    statuses = [
        Status("refused", "the coils overlap") if row in failed else COMPLETED
        for row in range(len(inputs))
    ]
    values[list(failed)] = np.nan
    return analysed(
        StudyTable(plan, inputs, (plan.runs[0],) * len(inputs), values, tuple(statuses))
    )


def test_a_page_stands_where_nothing_came_out():
    table = made(failed=range(256))
    shown = StudyAnswer(table)
    assert shown.verdict.code == "J101" and "<h1" in page_of(shown) and not shown.figures()


def test_the_json_answer_holds_the_indices_and_the_findings():
    table = made("saltelli", failed=(3,))
    data = json.loads(json.dumps(answer_json(StudyAnswer(table)), default=lambda x: x.tolist()))
    (first, _) = data["sensitivities"]
    assert first["dropped"] == 1 and first["names"][0] == "installed <i>compression</i>"
    assert first["total"][0] == pytest.approx(0.98, abs=0.03)
    assert data["units"]["peak_spring_force"] == "N"
    assert [one["code"] for one in data["findings"]] == ["J122", "J130"]
    assert data["findings"][0]["value"]["unit"] == "N"


LIST = """
title = "Springs compared"
case = "gu2021-beehive-blind"
engine_speeds = "6000 rpm"
spring_models = "finite-element"
outputs = ["{names[0]}", "{names[1]}", "peak_valve_lift"]
points = {{ sampler = "list" }}
vary = [
  {{ key = "spring.precompression", values = {first}, label = "compression" }},
  {{ key = "lift_law.maximum_lift", as = "factor", values = {second}, label = "lift factor" }},
]
"""


def listed(
    first, second, forces, failed=(), names=("minimum_spring_force", "peak_spring_force"), text=LIST
) -> StudyTable:
    """A list of points whose first two outputs are ``forces`` and twice them; no run behind it."""
    text = text.format(first=[f"{one} mm" for one in first], second=second, names=names)
    plan = read_plan(FileText(text, "study", Path(), StudyModel))
    inputs = plan.sampler.draw(plan.varied, plan.options)
    values = np.column_stack([forces, 2 * np.array(forces), np.full(len(forces), 9e-3)])
    values[list(failed)] = np.nan
    statuses = [
        Status("refused", "the coils overlap") if row in failed else COMPLETED
        for row in range(len(forces))
    ]
    return StudyTable(plan, inputs, plan.runs * len(forces), values, tuple(statuses))


def test_what_rigid_theory_gives_is_no_input():
    names = ("rigid_contact_loss_engine_speed", "minimum_spring_margin_force")
    train = LIST.replace("gu2021-beehive-blind", "tdi-pushrod").replace(
        "spring.precompression", "train.cam.base_radius"
    )
    table = listed([7.0, 9.0], [1.0, 1.1], [800.0, 820.0], names=names, text=train)
    assert StudyAnswer(table).verdict.quantity == names[0]


def test_a_study_of_surge_is_judged_by_surge_whatever_force_stands_first():
    for second in ("surge_amplitude_force", "minimum_spring_force"):
        table = listed([7.0, 9.0], [1.0, 1.1], [800.0, 1200.0], names=("peak_spring_force", second))
        by_surge = second.startswith("surge")
        assert (StudyAnswer(table).verdict.quantity == second) is by_surge


@pytest.mark.parametrize("put_in", ["coil_bind_clearance", "outer_coil_bind_clearance"])
def test_the_best_point_is_that_of_what_the_motion_gives_not_of_what_was_put_in(put_in):
    """The largest clearance was named best of a study that sets the clearance."""
    table = listed([7.0, 9.0], [1.0, 1.1], [5.74e-3, 3.74e-3], names=(put_in, "clash_energy"))
    (verdict,) = StudyAnswer(table).findings
    assert verdict.code == "J113" and verdict.quantity == "clash_energy"
    assert verdict.value == pytest.approx(7.48e-3) and verdict.fields["reference"].value == pytest.approx(11.48e-3)  # fmt: skip
