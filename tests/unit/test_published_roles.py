"""What is said of the published values of a case: by role and kind, the furthest by name, what was fitted,
and why nothing is compared. Expected texts are written by hand from made-up differences.
"""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from valvetrain.report.published_verdict import (
    calibration_sentence,
    not_compared_sentence,
    published_sentences,
)
from valvetrain.solution.comparison import Comparison
from valvetrain.solution.provenance import CaseRecord, CaseValue, PublishedValue
from valvetrain.solution.study import Study

SPEED = 4200 * math.pi / 30


def row(quantity: str, published: float, difference: float | None, role: str, **more) -> Comparison:
    computed = None if difference is None else published + difference
    return Comparison(
        quantity, SPEED, "rod", "FE", "", published, computed, difference, role, None, "", **more
    )


def angle(quantity: str, degrees: float, role: str) -> Comparison:
    return row(quantity, math.radians(180.0), math.radians(degrees), role)


ROWS = (
    row("peak_spring_force", 100.0, 1.0, "calibration"),
    row("minimum_spring_force", 100.0, -3.0, "calibration"),
    row("stage_2_peak_force", 100.0, 40.0, "prediction"),
    row("node_2_maximum_displacement", 1e-3, -6e-4, "prediction"),
    row("coil_1_2_bounce_duration", 1e-3, 2e-4, "prediction"),
    angle("stage_2_peak_cam_angle", -4.0, "calibration"),
    angle("stage_3_peak_cam_angle", 50.0, "prediction"),
    angle("stage_2_valley_cam_angle", -8.0, "prediction"),
)


def test_fitted_and_predicted_values_share_no_median():
    told = published_sentences(ROWS)
    assert told.startswith("Compared with the source, median (count): 8 values. ")
    assert " Calibration: forces 2.0 % (2), angles 4 deg (1). " in told
    assert (
        " Prediction: forces 40.0 % (1), motion 60.0 % (1), angles 29 deg (2), others 20.0 % (1). "
        in told
    )
    assert "Check" not in told


def test_the_furthest_values_are_named_and_the_furthest_angle_with_them():
    told = published_sentences(ROWS).partition("Furthest")[2]
    assert told == (
        ": largest displacement of node 2 −60.0 %, Stage II peak force +40.0 %, "
        "bounce of coils 1 and 2, time +20.0 %, and of the angles Stage III peak, cam angle +50 deg."
    )
    slower = replace(ROWS[2], engine_speed=SPEED / 2)
    told = published_sentences((*ROWS[:2], slower, *ROWS[3:])).partition("Furthest")[2]
    assert told.startswith(
        ": largest displacement of node 2 at 4200 rpm −60.0 %, Stage II peak force at 2100 rpm +40.0 %, "
    )


def test_every_value_left_out_is_counted():
    left = (
        row("preload", 0.0, 1.0, "check"),
        row("stage_1_minimum_force", 1.0, None, "check"),
        row("node_1_peak_acceleration", 1.0, 9.0, "check", doubt="cannot be"),
    )
    told = published_sentences((*ROWS, *left))
    assert ": 8 of 11 values, 1 not computed, 1 is zero, 1 in doubt. " in told
    assert published_sentences(left) == ""


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        ((ROWS[0],), "peak spring force below 10 kHz differs by 1.0 %."),
        ((ROWS[5],), "Stage II peak, cam angle differs by 4 deg."),
    ],
)
def test_one_value_is_told_alone(rows, told):
    assert published_sentences(rows) == f"Compared with the source: the published value of {told}"


def published(quantity: str, role: str, speed: float | None = SPEED) -> PublishedValue:
    return PublishedValue(quantity, 1.0, "", role=role, engine_speed=speed)


FITTED = tuple(published(one.quantity, one.role) for one in ROWS)


def test_a_calibrated_case_names_what_was_fitted_to_what():
    values = (
        CaseValue("spring.wire_diameter", "4 mm", "identified"),
        CaseValue("spring.lower_end.inactive_coils", "1", "identified"),
        CaseValue("lift_law.nose", "180 deg", "identified"),
        CaseValue("spring.hand", "right", "assumed"),
    )
    case = CaseRecord("own", published=FITTED, values=values)
    assert calibration_sentence(case) == (
        "calibrated: wire diameter, lower end and lift law were fitted to 3 of its 8 published values "
        "(peak spring force below 10 kHz, minimum spring force, Stage II peak, cam angle)"
    )
    many = replace(case, published=(*FITTED, published("preload", "calibration")))
    assert calibration_sentence(many).endswith(
        "were fitted to 4 of its 9 published values (3 forces, 1 angle)"
    )
    assert calibration_sentence(replace(many, values=values[3:])) == ""  # nothing was identified


def test_a_case_that_predicts_alone_or_was_changed_is_not_called_calibrated():
    blind = tuple(replace(one, role="prediction") for one in FITTED)
    assert calibration_sentence(CaseRecord("own", published=blind)) == ""
    assert (
        calibration_sentence(CaseRecord("own", published=FITTED, changed=("spring.pitch",))) == ""
    )


@pytest.mark.parametrize(
    ("record", "command", "why"),
    [
        (CaseRecord("own"), "run", "the case gives none"),
        (CaseRecord("own", published=FITTED, changed=("spring.pitch",)), "run", "'spring.pitch' was changed"),
        (CaseRecord("own", published=FITTED), "sweep", "a sweep over engine speed"),
        (CaseRecord("own", published=FITTED), "run", "no run gave a quantity"),
    ],
)  # fmt: skip
def test_nothing_compared_says_why(record, command, why):
    told = not_compared_sentence(Study(record, command))
    assert told.startswith(f"No published value is compared: {why}") and told.endswith(".")
    assert not_compared_sentence(Study(record, command, comparisons=ROWS)) == ""
