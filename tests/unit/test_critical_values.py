"""Nominal value, ranges and kind of critical speeds on margins written by hand (closed form), and
the form in which they are printed (contract).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from valvetrain.runs.critical_repeats import Repeat, repeated, scattered
from valvetrain.runs.critical_search import Limit, Search, SpeedSample
from valvetrain.runs.critical_speeds import CriticalOptions, critical_speed
from valvetrain.solution.critical import (
    RPM,
    CriticalSpeed,
    Crossing,
    RangeMember,
    SpeedBracket,
)
from valvetrain.views.json import _critical_object

KIND = "contact-loss"
Margin = Callable[[float], float]


LIMITS = (Limit(KIND, None, 100.0),)


def sampler(
    margin: Margin,
    repeats: Callable[[float], bool] = lambda speed: True,
    pulls: Callable[[float], bool] = lambda speed: False,
):
    """A train whose margin is a function of the speed alone."""

    def run(engine_speed: float, orbit: object = None) -> SpeedSample:
        value, pulled = margin(engine_speed), pulls(engine_speed)
        places, values = {KIND: ("cam",)}, {KIND: max(0.0, value)}
        unknown = frozenset({KIND} if pulled else ())
        whole = repeats(engine_speed)
        return SpeedSample(
            values, places, "motion", {KIND: value}, whole, unknown=unknown, pulls=pulled
        )

    return run


def found(margin: Margin, others: dict[str, list[Margin]], **options) -> CriticalSpeed:
    """The result between 6000 and 9000 rad/s with the margins of changed trains by group."""
    run = sampler(margin, **options)
    grid = {6000.0 + 100 * k: run(6000.0 + 100 * k) for k in range(31)}
    search = Search(run, grid, LIMITS, 10.0)
    row = critical_speed(search, KIND, "own", 6000.0, 9000.0, CriticalOptions(resolution=10.0))
    pulls = options.get("pulls", lambda speed: False)
    repeats = [
        Repeat(cause, f"change {number}", sampler(one, pulls=pulls))
        for cause, some in others.items()
        for number, one in enumerate(some)
    ]
    return repeated(row, search, run, repeats, 400.0, LIMITS)


def speeds_of(row: CriticalSpeed, cause: str) -> list[float]:
    return [one.engine_speed for one in row.members if one.cause == cause]


def falling(zero: float) -> Margin:
    return lambda speed: min(400.0, (zero - speed) * (1 + speed / 9000))


def test_the_nominal_speed_is_the_zero_and_the_ranges_are_those_of_the_repeats() -> None:
    others = {
        "step": [falling(7001.5)],
        "mesh": [falling(7000.0)],
        "damping": [falling(6820.0), falling(6990.0)],
        "model": [falling(7150.0)],
    }
    one = found(falling(7003.17), others)
    assert one.engine_speed == pytest.approx(7003.17, abs=1e-3) and one.onset == "sharp"
    each = [member.engine_speed for member in one.members]
    assert each == pytest.approx([7001.5, 7000.0, 6820.0, 6990.0, 7150.0], abs=0.06)
    assert one.span is not None and one.causes == ("damping", "model")
    ends = [one.span.lower_engine_speed, one.span.upper_engine_speed]
    assert ends == pytest.approx([6820.0, 7150.0], abs=0.06)


def test_a_force_that_just_reaches_zero_is_a_graze_whose_range_holds_the_next_loss() -> None:
    """A dip 10 deep below zero at 6500 of a margin of 1000; control is lost for good at 7400."""

    def margin(speed: float) -> float:
        dip = 410 * math.exp(-(((speed - 6500) / 60) ** 2))
        return min(400 - dip, 7400 - speed)

    one = found(margin, {"mesh": [margin], "damping": [margin, margin]})
    assert one.onset == "graze" and 6480 < one.engine_speed < 6500
    assert one.span is not None and one.causes == ("force",)
    assert one.span.upper_engine_speed > 7390 and one.span.lower_engine_speed < 6480


def test_a_loss_that_other_damping_removes_has_an_open_range() -> None:
    others = {"damping": [falling(6900.0), lambda speed: 100.0]}
    one = found(falling(7003.0), others)
    assert one.span is not None and one.span.upper_engine_speed == math.inf
    assert one.causes == ("damping",)


def test_a_member_that_cannot_run_is_named_and_moves_no_end() -> None:
    """Contract: it was left out of the range without a word."""
    run = sampler(falling(7003.0))
    grid = {6000.0 + 100 * k: run(6000.0 + 100 * k) for k in range(31)}
    search = Search(run, grid, LIMITS, 10.0)
    row = critical_speed(search, KIND, "own", 6000.0, 9000.0, CriticalOptions(resolution=10.0))
    ran = Repeat("damping", "×0.6", sampler(falling(6900.0)))
    refused = Repeat("mesh", "×1.5", run, "the wire has no volume")
    one = repeated(row, search, run, [ran, refused], 400.0, LIMITS)
    assert one.span is not None and one.causes == ("damping",)
    assert one.span.lower_engine_speed == pytest.approx(6900.0, abs=0.06)
    assert "mesh ×1.5" in one.text
    told = _critical_object(one)["members"][-1]
    assert told["refusal"] == "the wire has no volume" and told["engine_speed"] is None
    alone = repeated(row, search, run, [refused], 400.0, LIMITS)
    assert alone.span is None and "nominal" in alone.text and "mesh ×1.5" in alone.text


def test_a_never_that_other_damping_makes_a_loss_is_not_a_plain_never() -> None:
    def dip(depth: float) -> Margin:
        return lambda speed: 400 - depth * math.exp(-(((speed - 7500) / 300) ** 2))

    one = found(dip(300), {"damping": [dip(450), dip(200)]})
    assert not one.found and one.span is not None
    assert 7000 < one.span.lower_engine_speed < 7500 and one.span.upper_engine_speed == math.inf
    assert (
        one.causes == ("damping",) and str(round(one.span.lower_engine_speed / RPM))[:3] in one.text
    )
    assert found(dip(300), {"damping": [dip(320), dip(200)]}).onset == ""


def test_where_motion_does_not_repeat_the_range_reaches_over_those_speeds() -> None:
    """Between 6900 and 7200 the last revolution decides: here by the digits of the speed."""

    def margin(speed: float) -> float:
        loose = 6900 < speed < 7200
        return math.sin(speed) if loose else 7000 - speed

    loose = lambda speed: not 6900 < speed < 7200
    one = found(margin, {"step": [falling(1.0)], "damping": []}, repeats=loose)
    assert one.onset == "non-repeating" and one.span is not None
    assert one.causes == ("revolution",) and not speeds_of(one, "step")
    assert one.span.lower_engine_speed <= 6900 and one.span.upper_engine_speed >= 7200
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
        ("valve",),
        Crossing(bracket),
        nominal_engine_speed=7301.5 * RPM,
        members=(
            RangeMember("mesh", "×1.5", 7301.2 * RPM),
            RangeMember(
                "model", "multi-mass", 6600.3 * RPM, (SpeedBracket(6300 * RPM, 6400 * RPM),)
            ),
            RangeMember("damping", "×1.5", math.inf),
        ),
        onset="sharp",
    )
    carried = _critical_object(one)
    assert carried["text"] == one.text and carried["onset"] == "sharp"
    assert all(part in one.text for part in ("7302", "6600", "model, damping", "6300–6400"))
    assert carried["engine_speed"]["value"] == pytest.approx(7301.5)
    assert carried["range"]["lower"]["value"] == pytest.approx(6600.3)
    assert carried["range"]["upper"] is None and carried["range_causes"] == ["model", "damping"]
    mesh, model, damping = carried["members"]
    assert (mesh["cause"], mesh["change"]) == ("mesh", "×1.5")
    assert mesh["engine_speed"]["value"] == pytest.approx(7301.2)
    assert model["pulled"][0]["upper"]["value"] == pytest.approx(6400)
    assert damping["engine_speed"] is None and not damping["lost_from_the_first"]


@pytest.mark.parametrize("cause", ["damping", "mesh", "step", "model"])
def test_a_lower_loss_of_any_member_is_found_below_the_bracket(cause: str) -> None:
    """Control of the changed train is lost from 6900 to 6960 and again, as that of the train itself, from 7003."""

    def changed(speed: float) -> float:
        return min(7003 - speed, 3 * (abs(speed - 6930) - 30))

    one = found(lambda speed: 7003 - speed, {cause: [changed]})
    assert speeds_of(one, cause) == pytest.approx([6900.0], abs=0.1)
    assert one.causes == (cause,)


def test_runs_whose_ends_would_pull_give_no_critical_speed() -> None:
    """Control is lost from 6500 to 6600, where the ends would pull, and from 7400 on; without the first it is the second."""

    def margin(speed: float) -> float:
        return min(20 * (abs(speed - 6550) - 50), 7400 - speed)

    pulls = lambda speed: 6480 < speed < 6620
    one = found(margin, {"damping": [margin]}, pulls=pulls)
    assert one.engine_speed == pytest.approx(7400, abs=1e-3)
    assert speeds_of(one, "damping") == pytest.approx([7400], abs=0.1)
    (span,) = one.pulled
    assert 6480 < span.lower_engine_speed <= 6500 and 6600 <= span.upper_engine_speed < 6620
    (member,) = one.members
    assert member.pulled and f"{span.lower_engine_speed / RPM:.0f}" in one.text
    # the same run counts where the ends do not pull, and where they pull everywhere nothing is lost
    assert found(margin, {}).engine_speed == pytest.approx(6500, abs=1e-3)
    never = found(margin, {}, pulls=lambda speed: speed > 6480)
    assert not never.found and never.pulled[0].upper_engine_speed == 9000


def test_a_loss_that_begins_where_ends_would_pull_lies_between_what_is_known() -> None:
    """Control is kept to 6480 and lost from 6620, in between the ends would pull."""
    pulls = lambda speed: 6480 < speed < 6620
    one = found(lambda speed: 6550 - speed, {"damping": [lambda speed: 6550 - speed]}, pulls=pulls)
    assert one.found and one.begins is not None and one.span is not None
    low, high = one.begins.from_rest.lower_engine_speed, one.begins.from_rest.upper_engine_speed
    assert low <= 6480 and 6620 <= high <= 6630 and one.engine_speed == high
    assert one.span.lower_engine_speed == low and one.causes == ("ends",)
