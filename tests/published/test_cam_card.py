"""A cam card in, the same card out: durations, valve events and lift of a published hydraulic
flat-tappet cam, and bounds on its shape.

The card is that of the Comp Cams XE268H-10 for the small-block Chevrolet (catalogue values):
duration 268 (intake) and 280 (exhaust) crank
degrees at 0.006 in, 224 and 230 at 0.050 in, lobe lift 0.318 and 0.320 in, intake lobe centre 106
degrees, lobe separation 110. Valve
timing at 0.006 in: intake opens 28 before top dead centre, closes 60 after bottom; exhaust opens 74
before bottom, closes 26 after top.

The card was not compared with its print. Two public parts lists give 224 and 230 degrees, 110
degrees, valve lifts of 0.477 and 0.480 in,
and the first test holds the rest to each other: a number that was copied wrong would not fit.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from valvetrain.cam.cam_card import CamCard, angle_before_nose
from valvetrain.cam.contract import build_lift_law
from valvetrain.cam.flanks import HalfLobe
from valvetrain.errors import InputError, UnusualValueWarning
from valvetrain.parameters.loading import parse_case
from valvetrain.quantities.valve_events import lift_crossings

INCH = 25.4e-3
CARDS = {
    "intake": ("0.318 in", 224, 268, 106, {0.006: (-28, 180 + 60), 0.050: (106 - 112, 106 + 112)}),
    "exhaust": (
        "0.320 in",
        230,
        280,
        114,
        {0.006: (-180 - 74, 26), 0.050: (-114 - 115, -114 + 115)},
    ),
}


def card(valve: str, more: str = "") -> CamCard:
    lift, duration, advertised, centre, _ = CARDS[valve]
    text = f"""
        [lift_law]
        kind = "cam-card"
        angle_of = "crank"
        lobe_lift = "{lift}"
        duration = "{duration} deg"
        advertised_duration = "{advertised} deg"
        lobe_centre = "{centre} deg"
        valve = "{valve}"
        {more}
    """
    return build_lift_law(parse_case(text).lift_law)


def test_the_card_fits_itself():
    """Durations are the angles between the events, centres their middles, the separation half the
    way between the centres (in crank
    degrees, of the cam), and lobe lifts the valve lifts of the lists over the engine's ratio of
    1.5."""
    centres = {}
    for valve, (lift, duration, advertised, centre, events) in CARDS.items():
        for height, angle in ((0.006, advertised), (0.050, duration)):
            assert events[height][1] - events[height][0] == angle
        centres[valve] = sum(events[0.006]) / 2
        assert (
            centres[valve] == sum(events[0.050]) / 2 == (centre if valve == "intake" else -centre)
        )
        assert float(lift.split()[0]) * 1.5 == pytest.approx(
            {"intake": 0.477, "exhaust": 0.480}[valve], abs=1e-12
        )
    assert (centres["intake"] - centres["exhaust"]) / 2 == 110


@pytest.mark.parametrize("valve", CARDS)
@pytest.mark.parametrize("height", [0.006, 0.050])
def test_the_valve_events_of_the_card_come_out(valve, height):
    """Crank degrees from top dead centre of gas exchange, which stands at 180 cam degrees; a card
    rounds to whole degrees.
    """
    opens, closes = lift_crossings(card(valve).lift, height * INCH)
    found = [2 * (math.degrees(angle) - 180) for angle in (opens, closes)]
    assert found == pytest.approx(CARDS[valve][4][height], abs=1e-6)


@pytest.mark.parametrize("valve", CARDS)
def test_the_lobe_is_what_a_flat_tappet_of_that_engine_takes(valve):
    """Velocity (the distance of the contact from the axis) below the radius of a tappet of 0.842
    in; acceleration of two signs, and
    of a plausible size (a band of our own): 0.0004 to 0.0009 in/deg^2 up, 0.0002 to 0.0004 in/deg^2
    down."""
    law = card(valve)
    angle = np.linspace(0, math.tau, 200_001)
    lift, velocity, acceleration = (law.lift(angle, order) for order in range(3))
    assert np.max(lift) == pytest.approx(float(CARDS[valve][0].split()[0]) * INCH, rel=1e-9)
    assert np.max(velocity) < 0.421 * INCH
    up, down = (
        value / INCH * math.radians(1) ** 2
        for value in (np.max(acceleration), -np.min(acceleration))
    )
    assert 0.0004 < up < 0.0009 and 0.0002 < down < 0.0004
    turns = np.sign(acceleration[np.abs(acceleration) > 1e-9 * np.max(acceleration)])
    assert np.count_nonzero(np.diff(turns)) == 2


def test_a_third_duration_is_met_too():
    law = card("intake", 'upper_duration = "136 deg"')
    for height, duration in ((0.006, 268), (0.050, 224), (0.200, 136)):
        opens, closes = lift_crossings(law.lift, height * INCH)
        assert 2 * math.degrees(closes - opens) == pytest.approx(duration, abs=1e-6)


@pytest.mark.parametrize(
    ("duration", "fits"), [(1.225, False), (1.227, True), (1.3405, True), (1.3412, False)]
)
def test_a_nose_is_as_full_as_between_its_bounds(duration, fits):
    """A fullness of -1 has 1.2261 rad at 5 mm, one of 1 has 1.3409 rad."""
    given = {"maximum_lift": 9e-3, "nose": 1.9, "duration": 2.0, "duration_lift": 1.27e-3}
    given |= {"upper_lift": 5e-3, "upper_duration": duration}
    if fits:
        lift = CamCard(**given).half_lobe.before_nose(duration / 2)
        assert lift == pytest.approx(5e-3, abs=1e-8)
    else:
        with pytest.raises(InputError):
            CamCard(**given)


def test_cam_degrees_and_a_valve_lift_tell_the_same_lobe():
    crank = card("intake")
    text = """
        [lift_law]
        kind = "cam-card"
        angle_of = "cam"
        valve_lift = "0.477 in"
        rocker_ratio = 1.5
        duration = "112 deg"
        advertised_duration = "134 deg"
        lobe_centre = "53 deg"
    """
    cam = build_lift_law(parse_case(text).lift_law)
    angle = np.linspace(0, math.tau, 999)
    assert cam.lift(angle, 2) == pytest.approx(crank.lift(angle, 2), abs=1e-12)


def test_a_lift_that_is_of_the_valve_is_not_divided_by_the_ratio_of_the_rocker():
    """Closed form: 11.6 mm at the valve is 11.6 mm there, and 8.855 mm at a tappet behind a ratio of 1.31."""
    text = """
[lift_law]
kind = "cam-card"
lift_of = "{of}"
angle_of = "crank"
duration = "252 deg"
rocker_ratio = 1.31
{lift}
[[spring]]
rate = "40 N/mm"
preload = "250 N"
"""
    lifts = [("valve", "valve_lift = '11.6 mm'"), ("tappet", "valve_lift = '11.6 mm'")]
    for (of, lift), most in zip(lifts, (11.6e-3, 8.855e-3), strict=True):
        law = build_lift_law(parse_case(text.format(of=of, lift=lift)).lift_law)
        assert float(np.max(law.lift(np.linspace(0, 2 * np.pi, 7201)))) == pytest.approx(
            most, rel=2e-4
        )


def test_a_solid_card_with_its_lash_gets_a_ramp_above_it():
    """282 degrees at 0.020 in, which stands at the end of the ramp over 0.022 in of lash at a ratio
    of 1.5.
    """
    text = """
        [lift_law]
        kind = "cam-card"
        angle_of = "crank"
        lobe_lift = "0.330 in"
        duration = "236 deg"
        advertised_duration = "282 deg"
        advertised_lift = "0.020 in"
        rocker_ratio = 1.5
        lash = "0.022 in"
    """
    law = build_lift_law(parse_case(text).lift_law)
    opens, _ = lift_crossings(law.lift, 0.022 / 1.5 * INCH)
    velocity = float(law.lift(opens, 1))
    assert float(law.lift(opens, 2)) == pytest.approx(0.0, abs=1e-9), (
        "the lash is taken up at constant velocity"
    )
    assert velocity / INCH * math.radians(1) == pytest.approx(0.0005, rel=1e-6)
    opens, closes = lift_crossings(law.lift, 0.020 * INCH)
    assert 2 * math.degrees(closes - opens) == pytest.approx(282, abs=1e-6)


HALF = {"maximum_lift": 0.318 * INCH, "nose": math.pi, "duration": math.radians(112)}


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"advertised_duration": math.radians(200)}, "they leave .* to .* crank deg"),
        ({"advertised_duration": math.radians(110)}, "must be longer and at a lower lift"),
        ({"upper_duration": math.radians(100)}, "they leave"),
        ({"maximum_lift": 1e-3}, "below the lobe lift"),
        ({"duration": math.radians(358)}, "does not go with the other values"),
        ({"ramp_lift": 9e-3}, "ramp_lift must be"),
        (
            {"ramp_lift": 1.2e-3, "ramp_blend": 1.0, "advertised_duration": math.radians(134)},
            "gathers velocity",
        ),
    ],
)
def test_a_card_that_contradicts_itself_is_refused_with_what_is_possible(more, words):
    with pytest.raises(InputError, match=words):
        CamCard(**HALF | more)


def test_lash_and_ratio_are_told_once_or_alike():
    from valvetrain.parameters.templates import TEMPLATES

    text = (TEMPLATES / "pushrod.toml").read_text(encoding="utf-8")
    train = parse_case(text.replace('lash = "0 in"', 'lash = "0.010 in"')).train
    assert train.lash == pytest.approx(0.010 * INCH) and train.lever.valve_arm == pytest.approx(
        1.6 * train.lever.drive_arm
    )
    # the lash that is set may differ from the card's, for which the ramp is ground
    other = parse_case(text.replace("spring_set =", 'lash = "0.2 mm"\nspring_set =', 1))
    assert other.train.lash == pytest.approx(0.2e-3)
    assert other.lift_law == parse_case(text).lift_law
    with pytest.raises(InputError, match=r"lever's arms make 1\.667"):
        parse_case(
            text.replace('drive_arm = "0.90 in"', 'drive_arm = "0.90 in"\nvalve_arm = "1.5 in"')
        )


@pytest.mark.parametrize("fullness", [-0.6, 0.0, 0.6])
def test_a_flank_passes_each_of_its_lifts_at_one_angle_and_its_straight_ramp_beyond(fullness):
    """Line of 0.2 mm and 2 mm a radian before a flank of 1.1 rad: 0.1 mm lie 0.05 rad further out."""
    half = HalfLobe(9e-3, (0.2e-3, 2e-3), 1.1, 0.3, fullness)
    for lift, angle in ((0.2e-3, 1.1), (0.1e-3, 1.15), (0.0, 1.2), (-0.1e-3, 1.25)):
        assert angle_before_nose(half, lift) == pytest.approx(angle, rel=1e-12)
        assert half.before_nose(angle) == pytest.approx(lift, abs=1e-15)
    angles = np.linspace(0.02, 1.09, 30)
    lifts = [half.before_nose(angle) for angle in angles]
    assert np.all(np.diff(lifts) < 0) and half.before_nose(0.0) == pytest.approx(9e-3)
    assert [angle_before_nose(half, lift) for lift in lifts] == pytest.approx(angles, abs=1e-9)


#: Solid cams as their makers list them: lobe lift (in), rocker ratio, lash (in), crank degrees at
#: ``lift`` (in) and at 0.050 in, and whether the follower is flat. Listed values, not compared with
#: a print of the card.
SOLID = {
    "Comp Cams 282S": (0.330, 1.5, 0.022, 282, 0.015, 236, True),
    "Comp Cams XS274S, exhaust": (0.340, 1.5, 0.018, 280, 0.015, 242, True),
    "Comp Cams XR292R": (0.384, 1.5, 0.016, 292, 0.015, 254, False),
    "a solid roller of a user": (0.390, 1.6, 0.018, 288, 0.015, 255, False),
    "its exhaust lash": (0.390, 1.6, 0.020, 288, 0.015, 255, False),
    "General Motors 30-30": (0.3234, 1.5, 0.030, 287, 0.020, 254, True),
}


def solid_card(lobe, ratio, lash, advertised, height, duration, more=""):
    text = f"""
        [lift_law]
        kind = "cam-card"
        angle_of = "crank"
        lobe_lift = "{lobe} in"
        duration = "{duration} deg"
        advertised_duration = "{advertised} deg"
        advertised_lift = "{height} in"
        rocker_ratio = {ratio}
        lash = "{lash} in"
        {more}
    """
    return build_lift_law(parse_case(text).lift_law)


@pytest.mark.parametrize("name", SOLID)
@pytest.mark.filterwarnings("error")
def test_a_solid_cam_comes_out_as_its_card_says(name):
    """Published: both durations, the lash taken up on a ramp no faster than 0.001 in/deg. Bounds of
    our own: a flat tappet of 0.842 in, 0.0015 in/deg^2, two turns of the acceleration's sign.
    """
    *values, flat = SOLID[name]
    law = solid_card(*values)
    lobe, ratio, lash, advertised, height, duration = values
    for lift, length in ((height, advertised), (0.050, duration)):
        opens, closes = lift_crossings(law.lift, lift * INCH)
        assert 2 * math.degrees(closes - opens) == pytest.approx(length, abs=1e-6)
    assert law.ramp_lift >= lash / ratio * INCH - 1e-12
    angle = np.linspace(0, math.tau, 100_001)
    lift, velocity, acceleration = (law.lift(angle, order) for order in range(3))
    assert np.max(lift) == pytest.approx(lobe * INCH, rel=1e-9)
    on_ramp = (lift > 0) & (lift < law.ramp_lift)
    assert np.max(np.abs(velocity[on_ramp])) / INCH * math.radians(1) < 0.001 * (1 + 1e-9)
    assert not flat or np.max(velocity) < 0.421 * INCH
    assert np.max(np.abs(acceleration)) / INCH * math.radians(1) ** 2 < 0.0015
    turns = np.sign(acceleration[np.abs(acceleration) > 1e-6 * np.max(acceleration)])
    assert np.count_nonzero(np.diff(turns)) == 2


def test_a_ramp_leaves_the_lobe_room_before_the_advertised_lift():
    """Contract: two thirds of the way from the lash at the lobe, at most 0.1 mm, never below it."""
    for lash, height, end in (
        (0.018, 0.015, 0.012 + 0.002),
        (0.022, 0.020, 0.022 / 1.5 + 2 / 3 * (0.020 - 0.022 / 1.5)),
        (0.0, 0.006, 0.1 / 25.4),
        (0.030, 0.020, 0.020),
        (0.030, 0.006, 0.020 + 0.1 / 25.4),
    ):
        law = solid_card(0.330, 1.5, lash, 350 if height < lash / 1.5 else 300, height, 236)
        assert law.ramp_lift == pytest.approx(end * INCH, rel=1e-9)


def test_a_duration_counted_below_the_lash_is_met_by_ramp_and_flank():
    """Contract: at 0.015 in under 0.020 in of lash the ramp takes up to 0.001 in/deg, then the flank
    the rest; longer and shorter durations follow without a jump.
    """
    laws = [solid_card(0.330, 1.5, 0.030, length, 0.015, 236) for length in (300, 320, 340, 420)]
    for law, length in zip(laws, (300, 320, 340, 420), strict=True):
        opens, closes = lift_crossings(law.lift, 0.015 * INCH)
        assert 2 * math.degrees(closes - opens) == pytest.approx(length, abs=1e-6)
    speeds = [law.half_lobe.start[1] / INCH * math.radians(1) for law in laws]
    assert speeds == sorted(speeds, reverse=True) and speeds[0] == pytest.approx(0.001)
    assert laws[0].half_lobe.share < 0.27 == laws[-1].half_lobe.share


def test_a_solid_card_that_contradicts_itself_is_refused_in_one_sentence():
    """Contract: 260 crank degrees at 0.015 in leave 6 cam degrees to 0.050 in; no lobe does that."""
    with pytest.raises(
        InputError, match=r"260 crank deg at .*0\.015 in.* they leave 265\.4 crank deg"
    ):
        solid_card(0.330, 1.5, 0.022, 260, 0.015, 236)
    with pytest.raises(InputError, match=r"the ramp ends at .*0\.0239 in.*lower ramp_lift"):
        solid_card(0.330, 1.5, 0.030, 270, 0.015, 236)


def test_a_crossing_on_a_station_is_found_there():
    """Contract: a lift that passes the height at a station of the grid by rounding alone above it
    (280 degrees of a card came out as 280.5)."""
    for name in SOLID:
        law = solid_card(*SOLID[name][:-1])
        for share in np.linspace(0.02, 0.98, 49):
            opens, closes = lift_crossings(law.lift, share * law.maximum_lift)
            assert float(law.lift(opens)) == pytest.approx(share * law.maximum_lift, abs=1e-12)
            assert float(law.lift(closes)) == pytest.approx(share * law.maximum_lift, abs=1e-12)


def test_a_ramp_that_is_steep_all_the_same_is_doubted():
    """Contract: a hydraulic card, 288 degrees at 0.006 in, under 0.35 mm of lash at the lobe: neither a
    usual ramp nor the flank meets it."""
    with pytest.warns(UnusualValueWarning, match="times as fast as a typical one.*ramp_lift"):
        law = solid_card(0.353, 1.6, 0.022, 288, 0.006, 236)
    opens, closes = lift_crossings(law.lift, 0.006 * INCH)
    assert 2 * math.degrees(closes - opens) == pytest.approx(288, abs=1e-6)
