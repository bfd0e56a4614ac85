"""The red line of a case beside what a sweep says of control."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from synthetic_study import train_study
from valvetrain.errors import InputError
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.templates import template_text
from valvetrain.solution.critical import (
    CriticalSpeed,
    CriticalSpeeds,
    Crossing,
    RangeMember,
    SpeedBracket,
)
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.study import Study

RPM = math.pi / 30


def run(speed: float, **values: float):
    """A run at a speed (rpm) in contact."""
    first = train_study().solutions[0]
    origin = replace(first.provenance, engine_speed=speed * RPM, label="a, modal-uniform", spring_set="a", notes=())  # fmt: skip
    held = {"loss_of_contact_duration": 0.0, "surge_amplitude_force": 10.0, **values}
    return replace(first, events=(), quantities=held, provenance=origin)


def row(at: float | None) -> CriticalSpeed:
    """A search from 1000 to 8000 rpm that finds a loss ``at`` some rpm, or none."""
    found = () if at is None else (Crossing(SpeedBracket((at - 1) * RPM, at * RPM)),)
    nominal = {} if at is None else {"nominal_engine_speed": at * RPM}
    return CriticalSpeed(
        "a, modal-uniform",
        "float",
        5e-5,
        1000 * RPM,
        8000 * RPM,
        RPM,
        at is not None,
        "valve",
        *found,
        **nominal,
    )


def sweep(red_line: float | None, *rows: CriticalSpeed) -> Study:
    """A sweep of two runs; ``red_line`` in rpm."""
    line = None if red_line is None else red_line * RPM
    runs = tuple(run(speed, minimum_cam_contact_force=50.0) for speed in (6000, 7000))
    record = CaseRecord("own", red_line=line)
    return Study(record, "sweep", runs, critical_speeds=CriticalSpeeds(rows))


@pytest.mark.parametrize(
    ("red_line", "at", "words"),
    [
        (6200, 6598, "Controlled to 6598 rpm, 398 rpm above the red line of 6200, where the valve floats"),
        (7000, 6598, "Controlled to 6598 rpm, 402 rpm below the red line of 7000, where"),
        (6598, 6598, "Controlled to 6598 rpm, the red line of 6598, where"),
        (None, 6598, "Controlled to 6598 rpm, where the valve floats"),
        (6200, None, "Controlled up to 8000 rpm, the highest speed searched, 1800 rpm above the red line of 6200, minimum cam"),
        (9000, None, "the highest speed searched, 1000 rpm below the red line of 9000"),
    ],
)  # fmt: skip
def test_a_sweep_says_how_far_control_reaches_beside_the_red_line(red_line, at, words):
    """Contract: the difference of the two speeds in whole rpm."""
    assert words in sweep(red_line, row(at)).verdict


def test_a_range_that_reaches_below_the_red_line_is_named():
    """Contract: control to 6598 with a range from 6450 on is no margin above a red line of 6500."""
    found = row(6598)
    wide = replace(found, members=(RangeMember("model", "own", 6450 * RPM),))
    assert (
        "98 rpm above the red line of 6500, which its range reaches below"
        in sweep(6500, wide).verdict
    )
    assert "which its range" not in sweep(6400, wide).verdict


def test_a_sweep_without_search_says_it_of_its_runs():
    """Contract: the highest run in contact, or the first that is not."""
    assert "in contact from 6000 to 7000 rpm, 800 rpm above the red line of 6200" in sweep(6200).verdict.lower()  # fmt: skip
    study = sweep(6200)
    lost = replace(study.solutions[1], quantities={"loss_of_contact_duration": 1e-3})
    study = replace(study, solutions=(study.solutions[0], lost))
    assert "first at 7000 rpm, 800 rpm above the red line of 6200" in study.verdict


def test_a_case_states_its_red_line_in_crank_speed():
    """Contract: read with its unit, shown by check, in the record; what users call it is known."""
    text = template_text("pushrod").replace('# red_line = "6200 rpm"', 'red_line = "6200 rpm"')
    case = parse_case(text, "v8")
    assert case.operation.red_line == pytest.approx(6200 * RPM) == case.record().red_line
    from valvetrain.cli.case_facts import case_facts

    assert ("red line", "6200 rpm of the crank") in case_facts(case)
    assert parse_case(template_text("pushrod"), "v8").operation.red_line is None
    with pytest.raises(InputError, match="that is red_line here"):
        parse_case(text.replace("red_line = ", "rated_speed = "), "v8")
    with pytest.raises(InputError, match=r"operation\.red_line.*6200 rpm"):
        parse_case(text.replace('red_line = "6200 rpm"', "red_line = 6200"), "v8")
