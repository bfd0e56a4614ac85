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
)
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.study import Study

RPM = math.pi / 30


def run(speed: float, **values: float):
    """A run at a speed (rpm) in contact."""
    first = train_study().solutions[0]
    origin = replace(first.provenance, engine_speed=speed * RPM, label="a, modal-uniform", spring_set="a", facts=())  # fmt: skip
    held = {"loss_of_contact_duration": 0.0, "surge_amplitude_force": 10.0, **values}
    return replace(first, events=(), quantities=held, provenance=origin)


def sweep(red_line: float | None, *rows: CriticalSpeed) -> Study:
    """A sweep of two runs; ``red_line`` in rpm."""
    line = None if red_line is None else red_line * RPM
    runs = tuple(run(speed, minimum_cam_contact_force=50.0) for speed in (6000, 7000))
    record = CaseRecord("own", red_line=line)
    return Study(record, "sweep", runs, critical_speeds=CriticalSpeeds(rows))


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
