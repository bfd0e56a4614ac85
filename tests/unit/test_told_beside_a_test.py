"""Unit: runs beside a table of values and beside cycles: which places two runs are compared at, and
the columns of the files.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from synthetic_study import SPEED, modal_run, own_study, rod_run
from valvetrain.compare_test import compare as compare_test
from valvetrain.compare_test.answer import AgainstTestAnswer
from valvetrain.compare_test.comparison import ComparisonRequest
from valvetrain.measured.value_table import MeasuredValue, ValueTable

DRAWN = np.array([[1.2, -0.7, 0.4, -1.5, 0.3], [0.2, 0.9, -1.1, 0.5, -0.6]])
#: Peak and least force (N) and angle of the peak (rad) by each of two runs.
TOLD = {"finite-element": (811.0, 288.0, 3.2), "modal-varied": (806.0, 299.0, 3.1)}


def study(preload=287.0):
    runs = []
    for run in (rod_run(bounces=0), modal_run()):
        peak, least, angle = TOLD[run.model]
        numbers = {
            "peak_spring_force": peak,
            "minimum_spring_force": least,
            "peak_spring_force_cam_angle": angle,
        }
        runs.append(replace(run, quantities=numbers))
    return replace(own_study(tuple(runs)), still={"": {"preload": preload}})


def measured(quantity, centre, place=0, **more):
    return MeasuredValue(quantity, "N", centre + DRAWN[place], engine_speed=SPEED, **more)


ANGLE = {"cam_angle": 3.15, "angle_scatter": 0.02}
TABLES = {
    "one value": (measured("peak_spring_force", 810.0),),
    "one value and its angle": (measured("peak_spring_force", 810.0, **ANGLE),),
    "two values": (
        measured("peak_spring_force", 810.0),
        measured("minimum_spring_force", 290.0, 1),
    ),
    "two values, the first with its angle": (
        measured("peak_spring_force", 810.0, **ANGLE),
        measured("minimum_spring_force", 290.0, 1),
    ),
    "two values, the last with its angle": (
        measured("minimum_spring_force", 290.0, 1),
        measured("peak_spring_force", 810.0, **ANGLE),
    ),
    "a value no run tells": (measured("peak_spring_force", 810.0), measured("shoe_size", 45.0, 1)),
}


@pytest.mark.parametrize("name", TABLES)
def test_two_runs_are_compared_at_every_value_that_both_tell_and_at_no_angle(name):
    """Student's paired t, by scipy, of the squares that each repeat shows of either run."""
    test = ValueTable(TABLES[name])
    found = compare_test.judge_study(study(), ComparisonRequest(test, (SPEED,)), {})
    place = {"peak_spring_force": 0, "minimum_spring_force": 1}
    shared = [one for one in test.values if one.quantity in place]
    repeats = np.array([one.repeats for one in shared])
    off = {
        label: np.array([[numbers[place[one.quantity]]] for one in shared]) - repeats
        for label, numbers in TOLD.items()
    }
    first, second = (one.label for one in found.runs)
    (row,) = found.closer
    due = stats.ttest_rel(np.mean(off[first] ** 2, axis=0), np.mean(off[second] ** 2, axis=0))
    assert (row.first, row.second) == (first, second)
    assert (row.student, row.p_value) == pytest.approx((due.statistic, due.pvalue), rel=1e-9)
    assert row.first_square == pytest.approx(np.mean(np.mean(off[first], axis=1) ** 2))
    angles = [one for one in found.runs[0].values if one.kind == "angle"]
    assert [(one.model, one.test) for one in angles] == [
        (TOLD[first][2], 3.15) for one in test.values if np.isfinite(one.cam_angle)
    ]
    left = AgainstTestAnswer(found).findings.by("T212")
    assert [one.fields["names"] for one in left] == (
        ["shoe size"] if name == "a value no run tells" else []
    )
