"""The red line of a case beside what a sweep says of control."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from synthetic_study import train_study
from valvetrain.cam.cam_card import CamCard
from valvetrain.cli.case_facts import case_quantities
from valvetrain.errors import InputError
from valvetrain.findings.rules_case import CaseFacts
from valvetrain.parameters.case import Operation
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.templates import template_text
from valvetrain.quantities.valve_events import closing_ramp
from valvetrain.runs.requests import sweep_speeds
from valvetrain.solution.critical import (
    CriticalSpeed,
    CriticalSpeeds,
)
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.study import Study
from valvetrain.system.build import build
from valvetrain.views.case_answer import CaseAnswer

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
    answer = CaseAnswer(CaseFacts(case, {}))
    assert answer.title.endswith("(red line 6200)")
    assert parse_case(template_text("pushrod"), "v8").operation.red_line is None
    with pytest.raises(InputError, match="that is red_line here"):
        parse_case(text.replace("red_line = ", "rated_speed = "), "v8")
    with pytest.raises(InputError, match=r"operation\.red_line.*6200 rpm"):
        parse_case(text.replace('red_line = "6200 rpm"', "red_line = 6200"), "v8")


@pytest.mark.parametrize("word", ["loads", "rate"])
def test_what_is_needed_leaves_a_fifth_of_the_inertia_force(word):
    """Closed form: a spring with the loads, or with the rate, that are needed has a margin of 1.2."""
    text = template_text("direct", True)

    def margins(preload: float, rate: float) -> dict[str, float]:
        card = f'preload = "{preload!r} N"\ninstalled_height = "36 mm"\nrate = "{rate!r} N/m"\nmass = "30 g"\n'
        old = text[text.index('preload = "240 N"') : text.index("[train.springs.card.damping]")]
        case = parse_case(text.replace(old, card), "engine")
        return case_quantities(case, build(case))

    rate = 320 / 9e-3
    before = margins(240.0, rate)
    needed = (before["needed_closed_spring_force"], rate) if word == "loads" else (240.0, before["needed_spring_rate"])  # fmt: skip
    after = margins(*needed)
    assert before["minimum_spring_margin_ratio"] != pytest.approx(1.2, rel=0.02)
    assert after["minimum_spring_margin_ratio"] == pytest.approx(1.2, rel=1e-6)
    if word == "loads":
        assert after["open_spring_force"] == pytest.approx(before["needed_open_spring_force"], rel=1e-6)  # fmt: skip


@pytest.mark.parametrize(
    ("operation", "last", "count"),
    [("", 9000, 81), ('red_line = "15500 rpm"', 18600, 89), ('engine_speeds = "3000, 4000 rpm"', 4800, 39)],
)  # fmt: skip
def test_a_sweep_goes_a_fifth_beyond_the_speeds_of_its_case(operation, last, count):
    text = template_text("direct")
    lines = [one for one in text.splitlines() if not one.startswith("engine_speeds")]
    case = parse_case("\n".join(lines).replace("[operation]", f"[operation]\n{operation}"), "own")
    speeds = sweep_speeds(case)
    assert len(speeds) == count and speeds[-1] * 30 / math.pi == pytest.approx(last)


def test_the_closing_ramp_is_from_its_lift_to_rest():
    card = CamCard(maximum_lift=8e-3, nose=math.pi, duration=math.radians(118))
    begin, end = closing_ramp(card).values()
    assert math.pi < begin < end and card.lift(begin) == pytest.approx(card.ramp_lift, rel=1e-9)
    assert 0 <= card.lift(end) < 1e-15 and card.lift(end - 1e-3) > 1e-11


def test_speeds_that_were_written_with_their_unit_stay_when_something_else_changes():
    operation = Operation(engine_speeds="15500 rpm", red_line="16000 rpm").replace(cycles=3)
    assert operation.cycles == 3
    assert operation.engine_speeds == pytest.approx((15500 * RPM,))
    assert operation.red_line == pytest.approx(16000 * RPM)
    with pytest.raises(InputError, match="without a unit"):
        operation.replace(engine_speeds=(15500 * RPM,))
