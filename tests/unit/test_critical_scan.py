"""Scan and roots on measures written by hand (closed form): ranges, dips between speeds, hysteresis, runs that say nothing;
ranges of changed trains; and the form in which they are printed (contract).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import pytest

from valvetrain.errors import InputError
from valvetrain.parameters.case import Limits
from valvetrain.parameters.loading import load_case
from valvetrain.runs.critical_ranges import Variant
from valvetrain.runs.critical_scan import Scan, SpeedSample
from valvetrain.runs.critical_speeds import (
    CriticalOptions,
    critical_speed,
    sample_of,
    with_range,
)
from valvetrain.runs.prepared import PreparedRun
from valvetrain.runs.requests import Sweep
from valvetrain.solution.critical import RPM, CriticalSpeed, RangeMember, SpeedBracket
from valvetrain.solution.result import Solution, empty_channels
from valvetrain.views.json import _critical_object

KIND, RESOLUTION, STEP = "contact-loss", 10.0, 50.0
OPTIONS = CriticalOptions(RESOLUTION)
Margin = Callable[[float], float]
Holds = Callable[[float], bool]


def never(speed: float) -> bool:
    return False


def scan_of(
    margin: Margin, repeats: Holds = lambda speed: True, pulls: Holds = never, beside: Scan | None = None
) -> Scan:  # fmt: skip
    """A train whose measure is a function of the speed alone."""

    def run(engine_speed: float, orbit: object, precise: bool) -> SpeedSample:
        unknown = frozenset({KIND} if pulls(engine_speed) else ())
        return SpeedSample(
            {KIND: margin(engine_speed)}, {KIND: ("cam",)}, None, repeats(engine_speed),
            unknown=unknown, pulls=pulls(engine_speed),
        )  # fmt: skip

    return Scan(run, RESOLUTION, beside)


def filled(scan: Scan, speeds: Sequence[float]) -> Scan:
    """A scan between the speeds of a sweep."""
    for speed in speeds:
        scan.at(speed)
    scan.fill(STEP)
    scan.look_into_dips(KIND)
    return scan


def grid(step: float, first: float = 6000.0, last: float = 9000.0) -> list[float]:
    return [first + step * place for place in range(round((last - first) / step) + 1)]


def row_of(margin: Margin, step: float = 100.0, **options: Holds) -> CriticalSpeed:
    return critical_speed(KIND, filled(scan_of(margin, **options), grid(step)), "own", OPTIONS)


def found(margin: Margin, others: dict[str, list[Margin]], **options: Holds) -> CriticalSpeed:
    """The result between 6000 and 9000 rad/s with the measures of changed trains by cause."""
    scan = filled(scan_of(margin, **options), grid(100))
    row = critical_speed(KIND, scan, "own", OPTIONS)
    changed = {
        Variant(cause, f"change {place}", PreparedRun(None, None)): scan_of(one, **options)  # type: ignore[arg-type]
        for cause, some in others.items()
        for place, one in enumerate(some)
    }
    return with_range(row, scan, changed, 400.0)


def speeds_of(row: CriticalSpeed, cause: str) -> list[float]:
    return [one.engine_speed for one in row.members if one.cause == cause]


def falling(zero: float) -> Margin:
    return lambda speed: min(400.0, (zero - speed) * (1 + speed / 9000))


def dip(centre: float, half_width: float, depth: float = 400.0) -> Margin:
    """300 but for a resonance (a Lorentz curve) that passes zero half a width to either side."""
    width = half_width / math.sqrt(depth / 300 - 1)
    return lambda speed: 300 - depth / (1 + ((speed - centre) / width) ** 2)


def ends(row: CriticalSpeed) -> list[float]:
    return [end for one in row.ranges for end in (one.lower_engine_speed, one.upper_engine_speed)]


@pytest.mark.parametrize("step", [1000, 200, 130, 20])
@pytest.mark.parametrize(("centre", "half_width"), [(7451, 150), (7333, 40), (8170, 60)])
def test_both_ends_of_a_range_are_roots_on_any_grid(step, centre, half_width) -> None:
    """Also of one that lies between two speeds of the scan."""
    row = row_of(dip(centre, half_width), step)
    assert ends(row) == pytest.approx([centre - half_width, centre + half_width], rel=2e-6)


def test_a_margin_that_is_far_from_zero_costs_no_more_than_the_scan() -> None:
    scan = filled(scan_of(lambda speed: 300.0 - 0.001 * speed), grid(100))
    assert scan.lost_ranges(KIND) == ([], []) and scan.runs_count == 61


def test_every_range_is_given_by_its_roots_and_the_last_lasts() -> None:
    low, high = dip(7000, 60), dip(8400, 200)
    row = row_of(lambda speed: min(low(speed), high(speed), 8950 - speed))
    assert ends(row) == pytest.approx([6940, 7060, 8200, 8600, 8950, 9000], rel=2e-6)
    assert row.engine_speed == row.ranges[0].lower_engine_speed and row.places == ("cam",)


def test_what_is_lost_from_the_first_speed_on_has_no_onset() -> None:
    row = row_of(lambda speed: speed - 6500)
    assert row.found and row.engine_speed == 6000.0 and row.text.startswith("below")
    assert ends(row) == pytest.approx([0.0, 6500.0], rel=2e-6)


def test_a_run_without_numbers_counts_as_lost() -> None:
    row = row_of(lambda speed: math.nan if speed >= 7040 else 100.0)
    assert row.engine_speed == pytest.approx(7040, rel=2e-6)
    failed = sample_of(Solution(empty_channels()), OPTIONS)
    assert all(failed.lost(kind) for kind in failed.measures)


def test_a_run_that_ended_early_does_not_end_a_range_of_bounces() -> None:
    """Contract: a valve "bounces from 8246 to 8424 and again from 8635" where the run between ended by coil bind."""
    ended = lambda speed: 8000 < speed < 8200 or 8420 < speed < 8635
    row = row_of(lambda speed: 8246 - speed, pulls=ended)
    assert ends(row) == pytest.approx([8246, 9000], abs=RESOLUTION)
    numbers = {
        "quantities": {"float_excess_lift": 0.0},
        "statistics": {"least_cam_contact_force": 9.0},
    }
    assert sample_of(replace(Solution(empty_channels()), **numbers), OPTIONS).unknown == {"bounce"}


def hysteresis(back: float, pulls: Holds = never) -> Scan:
    """A motion that jumps up at 7650 as the speed rises and back at ``back`` as it falls."""

    def run(engine_speed: float, orbit: object, precise: bool) -> SpeedSample:
        lost = engine_speed > (back if orbit == "high" else 7650)
        margin = -100.0 if lost else 7700 - engine_speed
        unknown = frozenset({KIND} if pulls(engine_speed) else ())
        return SpeedSample(
            {KIND: margin}, {KIND: ("cam",)}, "high" if lost else "low", unknown=unknown
        )  # type: ignore[arg-type]

    return filled(Scan(run, RESOLUTION), grid(100))


def test_rising_and_falling_speed_show_a_hysteresis() -> None:
    """Rising, the motion of the speed below is followed up to its end; falling, that of the speed above."""
    row = critical_speed(KIND, hysteresis(7120), "own", OPTIONS)
    assert row.engine_speed == pytest.approx(7650, rel=2e-6) and row.both_motions is not None
    assert row.both_motions[0] == pytest.approx(7120, abs=STEP / 2)
    assert critical_speed(KIND, hysteresis(7600), "own", OPTIONS).both_motions is None


@pytest.mark.parametrize(
    ("pulls", "regained"),
    [(never, 7120), (lambda one: one < 7200, 7200), (lambda one: 7400 < one < 7640, math.nan)],
)
def test_two_motions_are_claimed_only_where_runs_say_what_is_kept(
    pulls: Holds, regained: float
) -> None:
    """Contract: speeds at which the runs of the rising one said nothing were called those of two motions."""
    found = hysteresis(7120, pulls).falling(KIND, 7650, STEP / 2)
    assert found == pytest.approx(regained, abs=STEP / 2, nan_ok=True)


def test_options_are_read_with_their_units_and_refused_where_they_cannot_be_meant() -> None:
    case = load_case("job-t").replace(limits=Limits(bounce="0.2 mm"))
    given = {"resolution": "20 rpm", "float_lift": "0.03 mm"}
    read = Sweep.read({"case": case, **given}).critical_options
    numbers = read.resolution * 30 / math.pi, read.float_lift, read.bounce_height
    assert numbers == pytest.approx((20, 3e-5, 2e-4))
    for name, text in (("resolution", "0 rpm"), ("float_lift", "-1 mm"), ("resolution", "10 mm")):
        with pytest.raises(InputError) as refused:
            Sweep.read({"case": "job-t", **given, name: text})
        assert refused.value.where == name


def test_a_case_without_a_train_has_no_critical_speeds() -> None:
    import valvetrain as vt

    with pytest.raises(InputError, match="no train"):
        vt.critical_speeds(load_case("job-t"), "1000 rpm", models=["massless"])


@pytest.mark.parametrize("step", [100, 50, 10])
@pytest.mark.parametrize(("repeats", "width"), [(False, 30), (True, 30), (False, 300)])
def test_a_short_range_of_motion_that_does_not_repeat_is_no_onset(step, repeats, width) -> None:
    """Property: an island at 6700 counts where its motion repeats or it is wider than 2 % of its speed; elsewhere the
    onset at 8003 does, on any grid, and what the samples saw of the island is named beside it.
    """

    def margin(speed: float) -> float:
        return min(300.0, 3 * (abs(speed - 6700) - width / 2), 8003 - speed)

    row = row_of(margin, step, repeats=lambda speed: repeats or not 6500 < speed < 6900)
    counts = repeats or width > 0.02 * 6700
    assert row.engine_speed == pytest.approx(6700 - width / 2 if counts else 8003, abs=RESOLUTION)
    assert bool(row.passed) is not counts and ("single revolutions" in row.later_text) is not counts


def test_the_nominal_speed_is_the_root_and_the_range_is_that_of_changed_trains() -> None:
    others = {
        "step": [falling(7001.5)],
        "mesh": [falling(7000.0)],
        "damping": [falling(6820.0), falling(6990.0)],
        "model": [falling(7150.0)],
    }
    row = found(falling(7003.17), others)
    assert row.engine_speed == pytest.approx(7003.17, rel=1e-6) and row.onset == "sharp"
    each = [member.engine_speed for member in row.members]
    assert each == pytest.approx([7001.5, 7000.0, 6820.0, 6990.0, 7150.0], abs=0.25)
    assert row.span is not None and row.causes == ("damping", "model")
    assert [row.span.lower_engine_speed, row.span.upper_engine_speed] == pytest.approx([6820.0, 7150.0], abs=0.25)  # fmt: skip


def test_a_force_that_just_reaches_zero_is_a_graze_whose_range_holds_the_next_loss() -> None:
    """A dip 10 deep below zero at 6500 of a margin of 400; control is lost for good at 7400."""

    def margin(speed: float) -> float:
        bottom = 410 * math.exp(-(((speed - 6500) / 60) ** 2))
        return min(400 - bottom, 7400 - speed)

    row = found(margin, {"mesh": [margin], "damping": [margin, margin]})
    assert row.onset == "graze" and 6480 < row.engine_speed < 6500
    assert row.span is not None and row.causes == ("force",)
    assert row.span.upper_engine_speed > 7390 and row.span.lower_engine_speed < 6480


def test_a_loss_that_other_damping_removes_has_an_open_range() -> None:
    row = found(falling(7003.0), {"damping": [falling(6900.0), lambda speed: 100.0]})
    assert row.span is not None and row.span.upper_engine_speed == math.inf
    assert row.causes == ("damping",)


def test_a_member_that_cannot_run_is_named_and_moves_no_end() -> None:
    """Contract: it was left out of the range without a word."""
    scan = filled(scan_of(falling(7003.0)), grid(100))
    row = critical_speed(KIND, scan, "own", OPTIONS)
    ran = Variant("damping", "×0.6", PreparedRun(None, None))  # type: ignore[arg-type]
    refused = Variant("mesh", "×1.5", PreparedRun(None, None, refusal="the wire has no volume"))  # type: ignore[arg-type]
    told = with_range(row, scan, {ran: scan_of(falling(6900.0)), refused: scan}, 400.0)
    assert told.span is not None and told.causes == ("damping",) and "mesh ×1.5" in told.text
    assert told.span.lower_engine_speed == pytest.approx(6900.0, abs=0.25)
    member = _critical_object(told)["members"][-1]
    assert member["refusal"] == "the wire has no volume" and member["engine_speed"] is None
    alone = with_range(row, scan, {refused: scan}, 400.0)
    assert alone.span is None and "nominal" in alone.text and "mesh ×1.5" in alone.text


def test_a_never_that_other_damping_makes_a_loss_is_not_a_plain_never() -> None:
    def bell(depth: float) -> Margin:
        return lambda speed: 400 - depth * math.exp(-(((speed - 7500) / 300) ** 2))

    row = found(bell(300), {"damping": [bell(450), bell(200)]})
    assert not row.found and row.span is not None and row.causes == ("damping",)
    assert 7000 < row.span.lower_engine_speed < 7500 and row.span.upper_engine_speed == math.inf
    assert str(round(row.span.lower_engine_speed / RPM))[:3] in row.text
    assert found(bell(300), {"damping": [bell(320), bell(200)]}).onset == ""


def test_where_motion_does_not_repeat_the_range_reaches_over_those_speeds() -> None:
    """Between 6900 and 7200 the last revolution decides: here by the digits of the speed."""

    def margin(speed: float) -> float:
        return math.sin(speed) if 6900 < speed < 7200 else 7000 - speed

    row = found(margin, {"step": [falling(1.0)], "damping": []}, repeats=lambda speed: not 6900 < speed < 7200)  # fmt: skip
    assert row.onset == "non-repeating" and row.span is not None
    assert row.causes == ("revolution",) and not speeds_of(row, "step")
    assert row.span.lower_engine_speed <= 6900 and row.span.upper_engine_speed >= 7200
    assert row.both_motions is None


@pytest.mark.parametrize(("cause", "width"), [("damping", 55), ("model", 155)])
def test_a_lower_loss_of_another_model_or_damping_is_found_below_the_onset(cause, width) -> None:
    """Control of the changed train is lost from 6830 on over a range a little wider than the speeds looked at are apart,
    and again, as that of the train itself, from 7003.
    """

    def changed(speed: float) -> float:
        return min(7003 - speed, 3 * (abs(speed - 6830 - width / 2) - width / 2))

    row = found(lambda speed: 7003 - speed, {cause: [changed]})
    assert speeds_of(row, cause) == pytest.approx([6830.0], abs=0.25) and row.causes == (cause,)


def test_runs_whose_ends_would_pull_give_no_critical_speed() -> None:
    """Control is lost from 6500 to 6600, where the ends would pull, and from 7400 on; without the first it is the second."""

    def margin(speed: float) -> float:
        return min(20 * (abs(speed - 6550) - 50), 7400 - speed)

    pulls = lambda speed: 6480 < speed < 6620
    row = found(margin, {"damping": [margin]}, pulls=pulls)
    assert row.engine_speed == pytest.approx(7400, rel=1e-6)
    assert speeds_of(row, "damping") == pytest.approx([7400], abs=0.25)
    (span,) = row.pulled
    assert 6480 < span.lower_engine_speed <= 6500 and 6600 <= span.upper_engine_speed < 6620
    assert row.members[0].pulled and f"{span.lower_engine_speed / RPM:.0f}" in row.text
    # nothing is known above a range of lost control either
    lower = lambda speed: abs(speed - 6250) - 50
    above = found(lambda speed: min(lower(speed), margin(speed)), {}, pulls=pulls)
    assert ends(above)[:2] == pytest.approx([6200, 6300], rel=1e-6) and above.pulled == row.pulled
    # the same run counts where the ends do not pull, and where they pull everywhere nothing is lost
    assert found(margin, {}).engine_speed == pytest.approx(6500, rel=1e-6)
    nothing = found(margin, {}, pulls=lambda speed: speed > 6480)
    assert not nothing.found and nothing.pulled[0].upper_engine_speed == 9000


def test_a_loss_that_begins_where_ends_would_pull_lies_between_what_is_known() -> None:
    """Control is kept to 6480 and lost from 6620, in between the ends would pull."""
    margin, pulls = lambda speed: 6550 - speed, lambda speed: 6480 < speed < 6620
    row = found(margin, {"damping": [margin]}, pulls=pulls)
    assert row.span is not None and row.causes == ("ends",)
    assert row.span.lower_engine_speed <= 6480 and 6620 <= row.engine_speed <= 6620 + STEP
    assert row.span.upper_engine_speed >= row.engine_speed


@pytest.mark.parametrize(("pull", "onset"), [(6842, 6830.0), (6815, 7003.0)])
def test_a_loss_just_below_speeds_whose_ends_would_pull_is_found(pull, onset) -> None:
    """Less damping loses control from 6830 on, between two speeds looked at, the upper of which pulls: that loss counts
    where it comes before the pull.
    """
    changed = lambda speed: min(7003 - speed, 3 * (abs(speed - 6880) - 50))
    row = found(lambda speed: 7003 - speed, {"damping": [changed]}, pulls=lambda speed: pull < speed < 6935)  # fmt: skip
    assert speeds_of(row, "damping") == pytest.approx([onset], abs=0.25)


def test_one_form_is_printed_and_json_carries_its_parts() -> None:
    lost = (SpeedBracket(7301.5 * RPM, 9000 * RPM),)
    row = CriticalSpeed(
        "card", "float", 5e-5, 3000 * RPM, 9000 * RPM, lost, ("valve",), onset="sharp",
        members=(
            RangeMember("mesh", "×1.5", 7301.2 * RPM),
            RangeMember("model", "multi-mass", 6600.3 * RPM, (SpeedBracket(6300 * RPM, 6400 * RPM),)),
            RangeMember("damping", "×1.5", math.inf),
        ),
    )  # fmt: skip
    carried = _critical_object(row)
    assert carried["text"] == row.text and carried["onset"] == "sharp"
    assert all(part in row.text for part in ("7302", "6600", "model, damping", "6300–6400"))
    assert carried["engine_speed"]["value"] == pytest.approx(7301.5)
    assert carried["range"]["lower"]["value"] == pytest.approx(6600.3)
    assert carried["range"]["upper"] is None and carried["range_causes"] == ["model", "damping"]
    mesh, model, damping = carried["members"]
    assert (mesh["cause"], mesh["change"]) == ("mesh", "×1.5")
    assert mesh["engine_speed"]["value"] == pytest.approx(7301.2)
    assert model["pulled"][0]["upper"]["value"] == pytest.approx(6400)
    assert damping["engine_speed"] is None and not damping["lost_from_the_first"]


@pytest.mark.parametrize(
    ("margin", "pulls", "silent"),
    [
        (lambda one: 7500 - one, lambda one: one > 7380, True),
        (lambda one: abs(one - 7500) - 20, lambda one: 7380 < one < 7620, False),
        (lambda one: abs(one - 7500) - 100, lambda one: 7380 < one < 7620, True),
        (lambda one: 100.0, lambda one: one > 7380, False),
        (lambda one: 7500 - one, lambda one: 7000 < one < 7200, False),
    ],
)
def test_control_is_not_known_where_runs_that_pull_lose_it(
    margin: Margin, pulls: Holds, silent: bool
) -> None:
    """Over more than 2 % of the speed or up to the last one; runs that pull and keep control contradict nothing."""
    row = row_of(margin, pulls=pulls)
    assert row.pulled and bool(row.silent) is silent
    assert bool(_critical_object(row)["silent"]) is silent
    if silent:
        (one,) = row.silent
        assert 7380 <= one.lower_engine_speed < 7500 <= one.upper_engine_speed
