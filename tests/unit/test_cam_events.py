"""Events of a cam against dead centre: typed in, of a case and read off a lift; closed forms of the trade."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from unit.cli_parts import call as invoke
from valvetrain.cam import build_lift_law
from valvetrain.errors import InputError
from valvetrain.measured.cam_events import CamEvents, against_dead_centre, events_in
from valvetrain.parameters.loading import parse_case

TYPED = "IVO 5 ATDC, IVC 32.5 ABDC; EVO 40 deg before bottom, EVC 10 after top dead centre"
CARD = 'name = "own"\n[lift_law]\nkind = "cam-card"\nlift_of = "valve"\nangle_of = "crank"\nvalve_lift = "8 mm"\n'
EVENTS = 'intake_opens = "5 deg after top"\nintake_closes = "32.5 deg after bottom"\n'
EXHAUST = 'exhaust_opens = "40 BBDC"\nexhaust_closes = "10 ATDC"\n'


def lift(*words: str) -> dict[str, float]:
    """Timing (deg) that the command prints."""
    result = invoke("lift", *words, "--json")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)["timing"]
    return {name: math.degrees(one["value"]) for name, one in found.items()}


@pytest.mark.parametrize(
    ("valve", "opens", "closes", "duration", "centre"),
    [
        ("intake", "5 after top", "32.5 after bottom", 207.5, 108.75), ("intake", "15 BTDC", "45° ABDC", 240.0, 105.0),
        ("exhaust", "55 deg before bottom", "25 ATDC", 260.0, 105.0), ("exhaust", "40 bbdc", "10 B TDC", 210.0, 115.0),
    ],
)  # fmt: skip
def test_duration_and_centre_of_typed_events(valve, opens, closes, duration, centre):
    first, last = (f"{valve[0].upper()}V{end}" for end in "OC")
    cam = CamEvents.of({first: opens, last: closes}, valve)
    assert (math.degrees(cam.duration), math.degrees(cam.centre)) == pytest.approx((duration, centre))  # fmt: skip
    for turns in (0, 4 * math.pi, -4 * math.pi):
        again = against_dead_centre(cam.opens + turns, cam.closes + turns)
        assert list(again) == [first, last]


def test_two_cams_have_separation_and_overlap(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = lift("--events", TYPED)
    expected = {
        "ivo_at_50_thou": -5, "ivc_at_50_thou": 32.5, "evo_at_50_thou": 40, "evc_at_50_thou": 10, "event_duration_intake": 207.5,
        "event_centre_intake": 108.75, "event_centre_exhaust": 105, "lobe_separation": 106.875, "overlap_at_50_thou": 5
    }  # fmt: skip
    assert {name: found[name] for name in expected} == pytest.approx(expected)
    Path("own.toml").write_text(CARD + EVENTS + EXHAUST)
    of_case = lift("own.toml")
    assert {name: of_case[name] for name in expected} == pytest.approx(expected, abs=1e-3)


def test_events_are_read_off_a_lift_of_known_timing(tmp_path, monkeypatch):
    """A lobe of 9 mm about 140 cam degrees; its half width at 0.050 in is a closed form."""
    monkeypatch.chdir(tmp_path)
    angles = np.arange(0.0, 360.0)
    lifts = 9 * np.clip(1 - ((angles - 140) / 60) ** 2, 0, None) ** 3
    rows = [f"{angle:g};{height:.5f}" for angle, height in zip(angles, lifts, strict=True)]
    Path("lobe.csv").write_text("\n".join(["cam angle [deg]; valve lift [mm]", *rows]))
    half = 120 * math.sqrt(1 - (1.27 / 9) ** (1 / 3))
    for words, first, last in (
        (("--top-dead-centre", "86 deg"), ("ivo", half - 108), ("ivc", half - 72)),
        (("--lobe-centre=-106 deg",), ("evo", half - 74), ("evc", half - 106)),
    ):
        found = lift("lobe.csv", *words)
        for event, expected in (first, last):
            assert found[f"{event}_at_50_thou"] == pytest.approx(expected, abs=0.02)


def test_a_card_by_its_events_is_the_card_by_duration_and_centre():
    places = 'duration = "207.5 deg"\nlobe_centre = "108.75 deg"\n'
    laws = [parse_case(CARD + more, "own").lift_law for more in (EVENTS, places, EXHAUST)]
    assert laws[0].values == pytest.approx(laws[1].values) and laws[0].top_dead_centre == math.pi
    law = build_lift_law(laws[2])
    for crank in (-220, 10):
        assert law.lift(math.pi + math.radians(crank / 2)) == pytest.approx(1.27e-3, abs=1e-9)


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        ('intake_opens = "5 deg"\nintake_closes = "32.5 deg"\n', 'write intake_opens = "5 deg before top"'),
        ('intake_opens = "5 BTDC"\n', "add intake_closes"), (EVENTS + 'duration = "200 deg"\n', "give one of both"), ("", "give one of both"),
        (EVENTS.replace("32.5 deg after", "190 deg after"), "up to 180 degrees"),
        ('intake_opens = "5 after bottom"\nintake_closes = "5 before bottom"\n', "crank degrees apart"),
    ],
)  # fmt: skip
def test_events_that_say_no_side_or_no_cam_are_refused(more, sentence):
    with pytest.raises(InputError, match=sentence):
        parse_case(CARD + more, "own")


def test_a_word_for_an_angle_is_refused_before_the_other_event_is_asked_for():
    for events, where in (({"IVO": "five"}, "intake_opens"), ({"IVO": "5 before top"}, "")):
        with pytest.raises(InputError) as refused:
            CamEvents.of(events, "intake")
        assert refused.value.where == where


def test_a_list_of_other_events_is_refused():
    for text in ("5 ATDC", "IVO 5 ATDC, IVO 6 ATDC", "", "XYZ 5 ATDC"):
        with pytest.raises(InputError):
            events_in(text)
