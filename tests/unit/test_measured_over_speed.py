"""Limits of a shop and a measured curve over a sweep: where each passes its limit, and whether both agree."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from synthetic_study import train_study
from valvetrain.errors import InputError
from valvetrain.findings import findings_of
from valvetrain.findings.facts import Facts
from valvetrain.measured.speed_table import read_speed_table
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.templates import template_text
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.speed_curve import SpeedCurve, passing
from valvetrain.solution.study import Study
from valvetrain.views.over_speed import spin

RPM, INCH = math.pi / 30, 25.4e-3
SPEEDS = (5000, 5500, 6000, 6500)
LIMITS = (("permitted_bounce_height", 0.010 * INCH), ("permitted_loft_gap", 0.020 * INCH))
SHEET = "# synthetic\nengine speed [rpm], bounce [in], loft [mm]\n6000, 0.002, 0.1\n5000, 0.001,\n6500, 0.012, 0.6\n"


def swept(bounce: tuple[float, ...], test: tuple[float, ...] | None = None, limits=LIMITS) -> Study:
    """A sweep with bounces (thou) at SPEEDS, and those of a test there."""
    first = train_study().solutions[0]
    runs = []
    for speed, height in zip(SPEEDS, bounce, strict=True):
        origin = replace(first.provenance, engine_speed=speed * RPM, label="a", spring_set="a")
        values = {"bounce_height": height * 1e-3 * INCH, "loft_gap": 0.0}
        runs.append(replace(first, events=(), quantities=values, provenance=origin))
    measured = None
    if test is not None:
        speeds = tuple(speed * RPM for speed in SPEEDS)
        measured = SpeedCurve(
            speeds, {"bounce_height": tuple(one * 1e-3 * INCH for one in test)}, "spin.csv"
        )
    return Study(CaseRecord("own", limits=limits), "sweep", tuple(runs), measured=measured)


def test_a_sheet_is_read_in_its_units_and_sorted_by_speed(tmp_path):
    (tmp_path / "spin.csv").write_text(SHEET)
    curve = read_speed_table(tmp_path / "spin.csv")
    assert curve.engine_speeds == pytest.approx([5000 * RPM, 6000 * RPM, 6500 * RPM])
    assert curve.values["bounce_height"] == pytest.approx(
        [0.001 * INCH, 0.002 * INCH, 0.012 * INCH]
    )
    assert curve.values["loft_gap"][1:] == pytest.approx([1e-4, 6e-4])
    assert math.isnan(curve.values["loft_gap"][0])


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("bounce [in]", "bounce"), ("bounce [in]", "bounce [N]"), ("bounce [in]", "jump [in]"), ("bounce [in]", "lash [in]"),
        ("engine speed [rpm]", "angle [deg]"),
        ("6000, 0.002, 0.1", "6000, 0.002"), ("6000, 0.002", "6000, high"), ("6000,", "-6000,"), ("loft", "bounce"),
    ],
)  # fmt: skip
def test_a_wrong_sheet_is_refused_in_one_sentence(old, new, tmp_path):
    (tmp_path / "spin.csv").write_text(SHEET.replace(old, new))
    with pytest.raises(InputError) as refused:
        read_speed_table(tmp_path / "spin.csv")
    assert "spin.csv" in str(refused.value) and "\n" not in str(refused.value)


def test_a_limit_is_passed_on_the_straight_line_between_two_points():
    assert passing([1.0, 2.0, 4.0], [0.0, math.nan, 3.0], 1.0) == pytest.approx((2.0, 1.0, 4.0))
    assert passing([1.0, 2.0], [0.0, 1.0], 1.0) is None
    assert passing([1.0, 2.0], [5.0, 1.0], 1.0) == (1.0, 1.0, 1.0)


@pytest.mark.parametrize(
    ("test", "code", "apart"),
    [
        ((0, 2, 9, 11), "Y101", ""),  # both between 6000 and 6500 rpm
        ((0, 2, 2, 3), "Y102", ""),  # the test never
        ((0, 18, 20, 30), "Y102", "972 rpm"),  # the test at 5278 rpm, the model at 6250
    ],
)
def test_test_and_model_agree_where_both_pass_the_limit_between_the_same_points(test, code, apart):
    found = findings_of(swept((0, 2, 8, 12), test))
    (hit,) = found.by("Y")
    assert hit.code == code and hit.fields.get("apart", "") == apart
    assert findings_of(swept((0, 2, 8, 12))).by("Y") == []


def test_both_within_the_limit_agree():
    assert [one.code for one in findings_of(swept((0, 2, 3, 4), (0, 1, 2, 3))).by("Y")] == ["Y101"]


def test_the_limits_of_the_case_decide_what_a_bounce_and_a_gap_are():
    bounces = (0, 2, 8, 9)  # 0.009 in is 0.23 mm
    assert "C110" not in findings_of(swept(bounces)).codes + findings_of(swept((0, 0, 0, 0))).codes
    for study in (swept(bounces, limits=()), swept((0, 2, 8, 12))):
        assert {"C105", "C110"} & set(findings_of(study).codes)
    calm = swept((0, 0, 0, 0))
    gaping = replace(calm, solutions=tuple(replace(run, quantities={**run.quantities, "loft_gap": 6e-4}) for run in calm.solutions))  # fmt: skip
    assert "C111" in findings_of(gaping).codes and "C111" not in findings_of(calm).codes


def test_limits_are_read_and_change_no_digest():
    text = template_text("pushrod")
    case = parse_case(text + '\n[limits]\nbounce = "0.010 in"\nloft = "0.5 mm"\n')
    assert dict(case.record().limits) == pytest.approx(
        {"permitted_bounce_height": 0.254e-3, "permitted_loft_gap": 0.5e-3}
    )
    assert case.digest == parse_case(text).digest
    with pytest.raises(InputError, match=r"limits\.bounce"):
        parse_case(text + '\n[limits]\nbounce = "0.010"\n')


def test_the_chart_has_model_test_and_limit():
    fig = spin(Facts(swept((0, 2, 8, 12), (0, 2, 9, 11))))
    model, test = fig.data
    assert list(test.x) == pytest.approx(SPEEDS) and test.mode == "markers"
    assert max(model.y) == pytest.approx(0.012 * 25.4, rel=1e-4)
    assert fig.layout.shapes[0].y0 == pytest.approx(0.254, rel=1e-4)
    assert spin(Facts(swept((0, 0, 0, 0)))) is None
