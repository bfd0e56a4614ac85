"""Unit: up to where a train is controlled by a search over engine speed: short ranges of lost contact, and what ends control."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from synthetic_study import train_study
from valvetrain.findings.control import control_of
from valvetrain.findings.facts import Facts
from valvetrain.findings.rules_sweep import rounded
from valvetrain.findings.table import findings_of
from valvetrain.findings.words import speed_text
from valvetrain.solution.critical import (
    CriticalSpeed,
    CriticalSpeeds,
    RangeMember,
    SpeedBracket,
)
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Cause, Event
from valvetrain.solution.study import Study
from valvetrain.views.answer import Answer
from valvetrain.views.over_speed import bars

RPM = np.pi / 30
LABEL = "stock, modal-uniform"


def run(
    speed: float, name: str = "stock", events: tuple[Event, ...] = (), **values: float
) -> Solution:
    """A run of a spring set at a speed (rpm)."""
    first = train_study().solutions[0]
    held = {"loss_of_contact_duration": 0.0, "minimum_cam_contact_force": 40.0, **values}
    origin = replace(first.provenance, engine_speed=speed * RPM, label=f"{name}, modal-uniform", spring_set=name, model="modal-uniform")  # fmt: skip
    return replace(first, events=events, quantities=held, provenance=origin)


def bracket(low: float, high: float) -> SpeedBracket:
    return SpeedBracket(low * RPM, high * RPM)


def lost(
    kind: str, begin: float | None, end: float = math.inf, *again: SpeedBracket, **more: object
) -> CriticalSpeed:
    """Control lost from ``begin`` to ``end`` (rpm) of a search from 4000 to 8000 rpm, never without ``begin``."""
    place = {"contact-loss": "cam", "float": "valve", "bounce": "seat"}[kind]
    ranges = () if begin is None else (bracket(begin, min(end, 8000)), *again)
    row = CriticalSpeed(
        LABEL, kind, 0.0, 4000 * RPM, 8000 * RPM, ranges, (place,) if ranges else ()
    )
    return replace(row, **more)


def sweep(*rows: CriticalSpeed, runs: tuple[Solution, ...] = ()) -> Study:
    swept = runs or (run(4000), run(8000))
    other = min((row.engine_speed for row in rows if row.kind != "contact-loss"), default=math.inf)
    rows = tuple(row.decided(other) if row.kind == "contact-loss" else row for row in rows)
    return Study(CaseRecord("own"), "sweep", swept, critical_speeds=CriticalSpeeds(rows))


SURGE = {"cause": Cause.SURGE, "spring_force_loss": 54.6, "surge_order": 6}


def test_a_short_range_of_lost_contact_is_named_and_does_not_end_control():
    """40 rpm in which contact is lost for a moment made it "controlled to 5218 rpm"."""
    first = train_study().solutions[0]
    open_wide = float(first.cam_angle[np.argmax(first.channel("valve_lift"))])
    inertia = Event("loft", open_wide, 0.0, 1e-3, 1e-4, "m", "cam", {"cause": Cause.INERTIA})
    runs = (run(4000), run(6250, events=(inertia,), loss_of_contact_duration=1e-3), run(8000))
    found = lost("contact-loss", 5218, 5258, bracket(6100, 8000), **SURGE)
    study = sweep(found, lost("float", 6917), runs=runs)
    found = findings_of(study)
    assert found.codes[0] == "W101" and found.by("W110") and found.by("W122")
    assert found.verdict.value == pytest.approx(6100 * RPM) and "short range" not in str(
        found.verdict
    )
    bar = bars(Facts(study))[0]
    assert np.array(bar.spans) / RPM == pytest.approx(np.array([(4000, 5218), (5258, 6100)]))
    alone = findings_of(sweep(lost("contact-loss", 5218, 5258, **SURGE)))
    assert alone.codes[0] == "W103" and alone.by("W110")


def test_each_loss_has_its_speeds_cause_angle_and_size():
    """Of a bounce its largest size, how the valve lands in the first run that bounces, and no angle; no finding of a loss
    that is not there.
    """
    lands = {"bounce_height": 2e-4, "seating_velocity": 0.9, "seating_cam_angle": 5.0}
    light = lands | {"bounce_height": 1e-4, "seating_velocity": 0.2}
    runs = (run(4000), run(7300, **light), run(7500, **lands), run(8000))
    found = findings_of(sweep(lost("contact-loss", 6900, **SURGE, cam_angle=4.0), lost("bounce", 7200, 7600), runs=runs))  # fmt: skip
    (contact,), (bounce,) = found.by("W121"), found.by("W123")
    assert contact.fields["angle"].value == 4.0 and contact.fields["cause"] and not found.by("W122")
    assert (bounce.fields["size"].value, bounce.fields["angle"]) == (2e-4, "")
    assert bounce.fields["cause"].fields["velocity"].value == 0.2
    assert {one.code for one in bars(Facts(sweep(lost("bounce", 7200))))} == {"", "W123"}


@pytest.mark.parametrize(
    "rows",
    [
        (lost("contact-loss", 5218, 5400, bracket(6100, 8000)),),  # 3.5 % wide
        (lost("contact-loss", 5218, 5258, bracket(6100, 8000)), lost("float", 5230, 5240)),
        (lost("contact-loss", 5218, 5258, bracket(6100, 8000)), lost("bounce", 5000)),
        (lost("contact-loss", 5218, 5258, *(bracket(at, at + 20) for at in (5400, 5600, 6100))),),
        (lost("contact-loss", 7980),),  # up to the last speed searched
        (lost("bounce", 5218, 5258),),
    ],
)
def test_what_is_wide_or_floats_or_bounces_or_comes_often_ends_control(rows):
    begin = min(one.engine_speed for one in rows)
    study = sweep(*rows)
    control = control_of(study, LABEL)
    assert control.limit == pytest.approx(begin) and not control.islands
    assert findings_of(study).verdict.value == pytest.approx(begin)


def test_the_speed_of_every_warning_is_a_column():
    """A warning gave 430 N of surge at a speed that was none of those in the table."""
    runs = tuple(
        run(speed, bounce_height=3e-4 * (speed == 5300)) for speed in range(4000, 8001, 100)
    )
    answer = Answer(sweep(lost("contact-loss", 6940, **SURGE), runs=runs))
    (bounces,) = answer.findings.by("C110")
    assert {speed_text(bounces.engine_speed), "4000 rpm", "6900 rpm"} <= set(answer.headings)
    assert len(answer.headings) == 3


def test_the_range_of_a_critical_speed_is_that_of_the_loss_that_stays():
    """Contract: the range of a short loss at 5040 rpm was given for control that ends at 6517."""
    found = lost("contact-loss", 5040, 5060, bracket(6517, 8000)).decided(math.inf)
    row = replace(found, members=(RangeMember("mesh", "×1.5", 6600 * RPM),))
    assert row.engine_speed == 5040 * RPM and row.causes == ("mesh",)
    assert row.span == SpeedBracket(6517 * RPM, 6600 * RPM) and row.short_count == 1


def test_what_a_search_could_not_see_and_two_motions_are_named():
    pulled = sweep(lost("contact-loss", 6100, pulled=(bracket(5000, 5050),)))
    assert findings_of(pulled).by("W114") and not findings_of(pulled).by("W112")
    assert findings_of(pulled).verdict.code == "W101"
    both = sweep(lost("contact-loss", 6100, falling_engine_speed=5900 * RPM))
    assert findings_of(both).by("W112") and not findings_of(both).by("W114")
    up_to_it = sweep(lost("contact-loss", 6100, pulled=(bracket(5000, 6080),)))
    for study, code, spans in (
        (pulled, "W114", (5000, 5050)), (up_to_it, "W114", (5000, 6100)), (both, "W112", (5900, 6100))
    ):  # fmt: skip
        drawn = {one.code: one.spans for one in bars(Facts(study))}
        assert drawn[code] == [tuple(pytest.approx(one * RPM) for one in spans)]
        held = drawn[""]
        assert all(end <= spans[0] * RPM or begin >= spans[1] * RPM for begin, end in held)


@pytest.mark.parametrize(
    ("row", "silent"),
    [
        (lost("contact-loss", 6100, silent=(bracket(5000, 5200),)), 5000),
        (lost("contact-loss", None, silent=(bracket(6000, 7000),)), 6000),
        (lost("contact-loss", 6100, silent=(bracket(6500, 7000),)), math.inf),
        (lost("contact-loss", None, pulled=(bracket(6000, 7000),)), math.inf),
    ],
)
def test_no_control_is_claimed_where_runs_say_nothing_of_it(row, silent):
    """Contract: control "up to 18600 rpm" of a train that flew from 14600 rpm on, where its springs pulled."""
    study = sweep(row)
    control, verdict = control_of(study, LABEL), findings_of(study).verdict
    assert control.silent == pytest.approx(silent * RPM)
    assert (verdict.code == "W106") == math.isfinite(silent)
    assert verdict.mark != "ok" or not math.isfinite(silent)


def test_a_rounded_speed_lies_inside_its_range():
    """Contract: a root at 9822 rpm was said to be about 10000."""
    for at, low, high, text in (
        (9822, 8000, 11000, "9820"),
        (7055, 6316, 7055, "7055"),
        (6729, 6670, 6790, "6730"),
    ):
        member = (
            RangeMember("model", "multi-mass", low * RPM),
            RangeMember("damping", "×1.5", high * RPM),
        )
        row = lost("float", at, members=member)
        assert rounded(row, at * RPM, (high - low) / 2 * RPM) == text


@pytest.mark.parametrize(
    ("heavy", "other_model", "code"),
    [(6000, 6500, "D102"), (6500, 6400, "D101"), (6500, 6015, "D102")],
)
def test_of_two_springs_the_one_that_keeps_control_longer_is_named(heavy, other_model, code):
    """By every model: one that finds 5 rpm between them leaves no clear difference, whatever the others say."""
    names = ("light", "heavy")
    runs = tuple(run(speed, name) for name in names for speed in (4000, 8000))
    ends = zip(names, (6010, heavy), (6010, other_model), strict=True)
    rows = tuple(
        replace(lost("contact-loss", end, members=(RangeMember("model", "wave-rod", other * RPM),)), label=f"{name}, modal-uniform")
        for name, end, other in ends
    )  # fmt: skip
    runs += (run(5000, "light", surge_amplitude_force=300.0),)  # a speed of one spring is no column
    study = Study(CaseRecord("own"), "compare-springs", runs, critical_speeds=CriticalSpeeds(rows))
    found, headings = findings_of(study), Answer(study).headings
    assert sorted(one.split(", ")[0] for one in headings) == ["heavy", "light"]
    assert len({one.split(", ")[-1] for one in headings if "rpm" in one}) <= 1
    assert found.codes[0] == code and not found.by("W10")
    if code == "D101":
        assert found.verdict.fields["better"] == "heavy" and found.verdict.value == pytest.approx(
            6010 * RPM
        )
        assert found.verdict.fields["gain"] == "390 to 490 rpm"


@pytest.mark.parametrize(("light", "code"), [(6010, "D101"), (None, "D102")])
def test_a_spring_that_keeps_control_up_to_the_last_speed_has_no_gain(light, code):
    runs = tuple(run(speed, name) for name in ("light", "heavy") for speed in (4000, 8000))
    rows = tuple(
        replace(lost("contact-loss", end), label=f"{name}, modal-uniform")
        for name, end in (("light", light), ("heavy", None))
    )
    study = Study(CaseRecord("own"), "compare-springs", runs, critical_speeds=CriticalSpeeds(rows))
    verdict = findings_of(study).verdict
    assert (verdict.code, verdict.fields["gain"]) == (code, "")
    assert light is None or verdict.fields["better"] == "heavy"
