"""The main lift event of a law, the windows about it, and the stages of the beehive study over
them.
"""

from __future__ import annotations

import numpy as np
import pytest

from synthetic_spring import EVENT, beehive_reader, bump, run
from valvetrain.cam.contract import build_lift_law
from valvetrain.cam.event import find_lift_event
from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.parameters.loading import load_case
from valvetrain.solution.study import LiftEvent

DEG = np.pi / 180


def event_of(parameters: LiftLawParameters) -> LiftEvent | None:
    return find_lift_event(build_lift_law(parameters), parameters)


def _sine(first: float, last: float) -> LiftLawParameters:
    return LiftLawParameters(
        "sine-power",
        {"maximum_lift": 9e-3, "opening_start": first * DEG, "closing_end": last * DEG, "power": 2},
    )


def test_beehive_keeps_the_stages_of_its_source():
    assert event_of(load_case("gu2021-beehive-blind").lift_law) == EVENT


def test_shaped_law_gives_its_own_event():
    law = load_case("gu2021-beehive-blind").lift_law
    assert event_of(law.replace(ramp_start=80 * DEG, event_start=110 * DEG)) == LiftEvent(
        np.radians(110.0), np.radians(250.0)
    )


def test_ramped_law_gives_its_own_event():
    angles = {"ramp_start": 90, "event_start": 100, "event_end": 230, "ramp_end": 250}
    law = LiftLawParameters(
        "ramped",
        {"maximum_lift": 9e-3, "ramp_lift": 3e-4}
        | {key: angle * DEG for key, angle in angles.items()},
    )
    assert event_of(law) == LiftEvent(np.radians(100.0), np.radians(230.0))


@pytest.mark.parametrize(
    ("end", "expected"),
    [({}, 240.0), ({"event_end": None}, 240.0), ({"event_end": 233 * DEG}, 233.0)],
)
def test_a_shaped_law_gives_its_own_event_mirrored_or_not(end, expected):
    values = {
        "maximum_lift": 9e-3,
        "ramp_lift": 3e-4,
        "ramp_start": 80 * DEG,
        "event_start": 120 * DEG,
        "nose": 180 * DEG,
    }
    law = LiftLawParameters("shaped", values | {"flank_shape": (1.0, 1.0, -1.0, -1.0, -1.0)} | end)
    assert event_of(law) == LiftEvent(np.radians(120.0), np.radians(expected))


def test_other_laws_give_where_the_lift_passes_4_percent():
    event = event_of(_sine(100.0, 260.0))
    # sin^2 passes 4 % where the sine is 0.2
    edge = 160 * np.arcsin(0.2) / np.pi
    assert np.degrees([event.start, event.end]) == pytest.approx([100 + edge, 260 - edge], abs=0.06)


@pytest.mark.parametrize(
    "law", [LiftLawParameters("zero"), _sine(-70.0, 70.0), _sine(290.0, 430.0)]
)
def test_no_event_without_lift_or_across_the_zero(law):
    assert event_of(law) is None
    assert find_lift_event(None) is None


@pytest.mark.parametrize("ripple", [60, 120])
def test_a_ripple_on_the_rising_flank_is_no_maximum_of_stage_2(ripple):
    """Below the middle of the forces, however far it stands out: the two maxima and the valley stay
    those of the lifted valve.
    """

    def two_maxima(degrees):
        return (
            300
            + 400 * bump(degrees, 180, 90)
            + 100 * bump(degrees, 163, 25)
            + 120 * bump(degrees, 197, 25)
        )

    names = [
        f"stage_2_{word}_{what}"
        for word in ("first_peak", "valley", "second_peak")
        for what in ("force", "cam_angle")
    ]
    smooth, rippled = (
        beehive_reader(run({"seat_force": force})).found
        for force in (
            two_maxima,
            lambda degrees: two_maxima(degrees) + ripple * bump(degrees, 143, 6),
        )
    )
    assert {name: rippled[name] for name in names} == {name: smooth[name] for name in names}
    assert np.degrees(smooth["stage_2_first_peak_cam_angle"]) == pytest.approx(165, abs=5)
