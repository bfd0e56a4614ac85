"""Nominal value, ranges and kind of critical speeds on margins written by hand (closed form), and
the form in which they are printed (contract).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from valvetrain.report.json import _critical_object
from valvetrain.runs.critical_repeats import repeated, scattered
from valvetrain.runs.critical_search import Limit, Search, SpeedSample
from valvetrain.runs.critical_speeds import CriticalOptions, critical_speed
from valvetrain.solution.critical import RPM, CriticalSpeed, Crossing, SpeedBracket

KIND = "contact-loss"
Margin = Callable[[float], float]


def sampler(margin: Margin, repeats: Callable[[float], bool] = lambda speed: True):
    """A train whose margin is a function of the speed alone."""

    def run(engine_speed: float, orbit: object = None) -> SpeedSample:
        value = margin(engine_speed)
        places, values = {KIND: "cam"}, {KIND: max(0.0, value)}
        return SpeedSample(values, places, "motion", {KIND: value}, repeats(engine_speed))

    return run


def found(margin: Margin, others: dict[str, list[Margin]], **options) -> CriticalSpeed:
    """The result between 6000 and 9000 rad/s with the margins of changed trains by group."""
    run = sampler(margin, **options)
    grid = {6000.0 + 100 * k: run(6000.0 + 100 * k) for k in range(31)}
    search = Search(run, grid, (Limit(KIND, None, 100.0),), 10.0)
    row = critical_speed(search, KIND, "own", 6000.0, 9000.0, CriticalOptions())
    repeats = [(group, sampler(one)) for group, some in others.items() for one in some]
    return repeated(row, search, run, repeats, 400.0)


def falling(zero: float) -> Margin:
    return lambda speed: min(400.0, (zero - speed) * (1 + speed / 9000))


def test_the_nominal_speed_is_the_zero_and_the_ranges_are_those_of_the_repeats() -> None:
    others = {
        "numerical": [falling(7001.5), falling(7000.0)],
        "damping": [falling(6820.0), falling(7150.0)],
    }
    one = found(falling(7003.17), others)
    assert one.engine_speed == pytest.approx(7003.17, abs=1e-3) and one.onset == "sharp"
    assert one.numerical is not None and one.damping is not None
    ends = [
        one.numerical.lower_engine_speed,
        one.numerical.upper_engine_speed,
        one.damping.lower_engine_speed,
        one.damping.upper_engine_speed,
    ]
    assert ends == pytest.approx([7000.0, 7003.17, 6820.0, 7150.0], abs=0.06)


def test_a_force_that_just_reaches_zero_is_a_graze_whose_range_holds_the_next_loss() -> None:
    """A dip 10 deep below zero at 6500 of a margin of 1000; control is lost for good at 7400."""

    def margin(speed: float) -> float:
        dip = 410 * math.exp(-(((speed - 6500) / 60) ** 2))
        return min(400 - dip, 7400 - speed)

    one = found(margin, {"numerical": [margin], "damping": [margin, margin]})
    assert one.onset == "graze" and 6480 < one.engine_speed < 6500
    assert one.numerical is not None and one.numerical.upper_engine_speed > 7390
    assert one.numerical.lower_engine_speed < 6480


def test_a_loss_that_other_damping_removes_has_an_open_range() -> None:
    others = {"damping": [falling(6900.0), lambda speed: 100.0]}
    one = found(falling(7003.0), others)
    assert one.damping is not None and one.damping.upper_engine_speed == math.inf
    assert "or more over damping" in one.text


def test_a_never_that_other_damping_makes_a_loss_is_not_a_plain_never() -> None:
    def dip(depth: float) -> Margin:
        return lambda speed: 400 - depth * math.exp(-(((speed - 7500) / 300) ** 2))

    one = found(dip(300), {"damping": [dip(450), dip(200)]})
    assert not one.found and one.damping is not None
    assert 7000 < one.damping.lower_engine_speed < 7500
    assert one.text.startswith("none up to") and "or more over damping" in one.text
    assert found(dip(300), {"damping": [dip(320), dip(200)]}).onset == ""


def test_where_motion_does_not_repeat_the_range_reaches_over_those_speeds() -> None:
    """Between 6900 and 7200 the last revolution decides: here by the digits of the speed."""

    def margin(speed: float) -> float:
        loose = 6900 < speed < 7200
        return math.sin(speed) if loose else 7000 - speed

    loose = lambda speed: not 6900 < speed < 7200
    one = found(margin, {"numerical": [falling(1.0)], "damping": []}, repeats=loose)
    assert one.onset == "non-repeating" and one.numerical is not None
    assert one.numerical.lower_engine_speed <= 6900 and one.numerical.upper_engine_speed >= 7200
    # such a motion has no branch that a rising or falling speed could follow
    assert one.begins == Crossing(one.begins.from_rest)
    ends = scattered(KIND, 7000.0, sampler(margin, loose), (6000.0, 7100.0))
    assert ends.upper_engine_speed == 7100.0


def test_one_form_is_printed_and_json_carries_its_parts() -> None:
    bracket = SpeedBracket(7297 * RPM, 7305 * RPM)
    one = CriticalSpeed(
        "card",
        "float",
        5e-5,
        3000 * RPM,
        9000 * RPM,
        10 * RPM,
        True,
        "valve",
        Crossing(bracket),
        nominal_engine_speed=7301.5 * RPM,
        numerical=SpeedBracket(7301.2 * RPM, 7301.5 * RPM),
        damping=SpeedBracket(7212.3 * RPM, math.inf),
        onset="sharp",
    )
    text = "7302 (7301–7302 over step and mesh, 7212 or more over damping ×0.6 to ×1.5)"
    assert one.text == text
    carried = _critical_object(one)
    assert carried["text"] == text and carried["onset"] == "sharp"
    assert carried["engine_speed"]["value"] == pytest.approx(7301.5)
    assert carried["numerical"]["lower"]["value"] == pytest.approx(7301.2)
    assert carried["damping"]["upper"] is None
    assert one.printed is not None and one.printed.upper_engine_speed == math.inf
