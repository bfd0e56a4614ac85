"""A case from what a person has: every answer arrives in the case, what was left open is called assumed, and a part of a
card, a wrong unit or a value that another contradicts is refused at its option.
"""

from __future__ import annotations

import io
import math
import sys

import numpy as np
import pytest

import valvetrain as vt
from unit.cli_parts import call, sentence
from valvetrain.cli.case_facts import case_facts
from valvetrain.errors import InputError
from valvetrain.explore.new_command import write_template
from valvetrain.parameters.card_case import card_case_text, questions_of
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.parameters.templates import QUESTIONS, TRAINS
from valvetrain.system.build import build

SPRING = {"seat_load": "76 lbf", "height": "1.80 in", "rate": "300 lbf/in"}
LBF, INCH = 4.4482216152605, 25.4e-3


@pytest.mark.parametrize("kind", TRAINS)
def test_answers_arrive_and_the_rest_is_assumed(kind):
    answers = SPRING | {
        "lift": "0.472 in",
        "valve_mass": "100 g + 20 g + 5 g",
        "red_line": "6000 rpm",
    }
    case = parse_case(card_case_text(kind, answers))
    (spring,) = case.train.spring_parts()
    assert spring.card.preload == pytest.approx(76 * LBF)
    assert spring.card.rate == pytest.approx(300 * LBF / INCH)
    assert spring.card.solid_height is None  # that of the template is another spring's
    assert case.train.valve.mass == pytest.approx(0.125)
    assert case.operation.red_line == pytest.approx(200 * math.pi)
    assert max(case.operation.engine_speeds) == pytest.approx(200 * math.pi, rel=1e-3)
    assumed = case.record().assumed
    assert {"spring mass", "spring damping", "duration"} <= set(assumed)
    assert not {"valve mass", "spring preload", "valve lift"} & set(assumed)
    assert dict(case_facts(case))["assumed"].split(", ") == list(assumed)
    run = vt.Case(case).run("3000 rpm", "massless")
    assert run.quantities["peak_valve_lift"] == pytest.approx(0.472 * INCH, rel=0.05)


@pytest.mark.parametrize("kind", TRAINS)
def test_a_case_with_every_answer_assumes_no_card_and_each_question_has_a_value(kind):
    answers = {name: default for name, _, default in questions_of(kind) if default}
    answers |= {"spring_mass": "60 g"} if "wire" not in answers else {}
    if "wire" in answers:
        answers.pop("spring_mass", None)
    named = set(parse_case(card_case_text(kind, answers)).record().assumed)
    lever = ("pivot", "drive arm", "drive angle", "valve angle", "holding torque")
    places = {"cam", *(f"lever {one}" for one in lever)}
    assert {name for name in named if not name.endswith("damping")} <= places
    assert all(one.meaning and one.follows for one in QUESTIONS.values())


@pytest.mark.parametrize(
    ("answers", "option"),
    [
        ({"seat_load": "76 lbf"}, "--height"),
        ({"seat_load": "76 lbf", "height": "1.8 in", "open_load": "220 lbf"}, "--open-height"),
        (SPRING | {"wire": "4 mm"}, "--outer-diameter"),
        (SPRING | {"seat_load": "76"}, "--seat-load"),
        (SPRING | {"coil_bind": "2 in"}, "--coil-bind"),
        ({"valve_mass": "100 g + 2 mm"}, "--valve-mass"),
        ({"red_line": "6000 mm"}, "--red-line"),
        ({"lift": "-1 mm"}, "--lift"),
        ({"duration": "230 mm"}, "--duration"),
    ],
)
def test_a_wrong_answer_is_refused_at_its_option(answers, option, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = [
        part for name, value in answers.items() for part in (f"--{name.replace('_', '-')}", value)
    ]
    made = call("new", "mine", "--kind", "pushrod", *words)
    assert made.exit_code == 2 and sentence(made).startswith(f"error: {option}")
    assert not (tmp_path / "mine.toml").exists()


def test_a_number_whose_unit_is_the_only_one_in_use_needs_none():
    """Crank degrees, rpm, and no lash; a bare length stays refused (above)."""
    bare = {"duration": "232", "lobe_centre": "110", "red_line": "6800", "lash": "0"}
    written = {
        "duration": "232 deg",
        "lobe_centre": "110 deg",
        "red_line": "6800 rpm",
        "lash": "0 in",
    }
    assert parse_case(card_case_text("pushrod", bare)) == parse_case(
        card_case_text("pushrod", written)
    )


@pytest.mark.parametrize("length", ["6.8 in", "7.4 in", "290 mm"])
def test_the_rocker_sits_where_the_pushrod_that_was_measured_reaches(length):
    train = parse_case(card_case_text("pushrod", {"pushrod_length": length})).train
    lever, rod = train.lever, train.pushrod
    ball = [
        lever.pivot[0] + lever.drive_arm * math.cos(lever.drive_angle),
        lever.pivot[1] + lever.drive_arm * math.sin(lever.drive_angle),
    ]
    assert math.dist(ball, rod.lower_end) == pytest.approx(rod.length, rel=1e-5)


@pytest.mark.parametrize(
    ("words", "option"),
    [(("--kind", "direct", "--ratio", "1.6"), "--ratio"), (("--lift", "9 mm"), "--kind")],
)
def test_an_answer_that_a_kind_does_not_have(words, option, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert sentence(call("new", "mine", *words)).startswith(f"error: {option}")


def test_a_terminal_is_asked_and_enter_takes_what_is_in_brackets(tmp_path, monkeypatch):
    from valvetrain.explore import new_command

    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    monkeypatch.setattr(
        sys, "stdin", Terminal("\n".join(["76 lbf", "1.8 in", "300 lbf/in", "1.1 in"]))
    )
    answers = new_command._asked("pushrod")  # open load and height go with no rate
    assert answers == {
        "seat_load": "76 lbf",
        "height": "1.8 in",
        "rate": "300 lbf/in",
        "coil_bind": "1.1 in",
    }


@pytest.mark.parametrize(("kind", "bar"), [("finger", 1.0), ("rocker", 0.766), ("pushrod", 0.766)])
def test_a_measured_rocker_is_not_assumed_and_without_its_inertia_it_is_a_uniform_bar(kind, bar):
    """Its geometry stays assumed value by value. A bar about its end has m b^2/3, with an arm a = b/1.6 on the
    other side 1 - a/b + (a/b)^2 = 0.766 of it.
    """
    answers = {"ratio": "1.6", "rocker_mass": "140 g", "rocker_stiffness": "30 kN/mm"}
    weighed = {**answers, "rocker_inertia": "21 kg mm^2"}
    case = parse_case(card_case_text(kind, weighed))
    lever = case.train.lever
    assert (lever.inertia, lever.mass, lever.stiffness) == pytest.approx((21e-6, 0.14, 30e6))
    assert lever.valve_arm == pytest.approx(1.6 * lever.drive_arm)
    assumed = {key for key, note in case.notes.items() if note.status == "assumed"}
    assert {"train.lever.pivot", "train.lever.damping"} <= assumed
    assert not assumed & {
        "train.lever",
        "train.lever.inertia",
        "train.lever.mass",
        "lift_law.rocker_ratio",
    }
    lever = parse_case(card_case_text(kind, answers)).train.lever
    assert lever.inertia == pytest.approx(bar * 0.14 * lever.valve_arm**2 / 3, rel=1e-2)


def test_a_cam_under_a_flat_face_has_room_for_its_nose(tmp_path, monkeypatch):
    """Contract: the assumed base circle of 18 mm made a cusp of a card of 10.2 mm and 232 degrees, which no run takes."""
    monkeypatch.chdir(tmp_path)
    card = {"lift": "10.2 mm", "duration": "232 deg", "checking_lift": "1 mm", "lash": "0.25 mm"}
    case = load_case(write_template("steep", "direct", SPRING | card))
    assert case.train.cam.base_radius > 18e-3
    gear = build(case).members[0].gear
    law = gear.mechanism.kinematics.law
    angle = np.linspace(0, 2 * np.pi, 14401)
    least = case.train.cam.base_radius + np.min(law.lift(angle) + law.lift(angle, 2))
    assert 3e-3 <= least < 4.1e-3  # h + h'' under a flat face, a base circle of whole mm
    gentle = load_case(write_template("gentle", "direct", SPRING | {"lift": "6 mm"}))
    assert gentle.train.cam.base_radius == pytest.approx(18e-3)


def test_a_card_that_no_cam_has_is_refused_before_the_case_is_written(tmp_path, monkeypatch):
    """Contract: 288 degrees at 0.006 in, within the ramp of a lash of 0.016 in, were written with "next: run"."""
    monkeypatch.chdir(tmp_path)
    card = {
        "lift": "0.630 in",
        "duration": "248 deg",
        "lash": "0.016 in",
        "ratio": "1.6",
        "advertised": "288 deg",
    }
    with pytest.raises(InputError) as refused:
        write_template("solid", "pushrod", card)
    assert refused.value.where == "--advertised" and not list(tmp_path.iterdir())
    assert load_case(
        write_template("solid", "pushrod", card | {"advertised_lift": "0.020 in"})
    ).train
