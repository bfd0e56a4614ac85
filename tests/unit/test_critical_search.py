"""The search for critical speeds on margins written by hand: islands, grids, hysteresis, runs that
fail.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import pytest

from valvetrain.errors import InputError
from valvetrain.parameters.loading import load_case
from valvetrain.runs import critical_search
from valvetrain.runs.critical_search import Limit, Search, SpeedSample
from valvetrain.runs.critical_speeds import CriticalOptions, critical_speed, read_options, sample_of
from valvetrain.solution.critical import SpeedBracket
from valvetrain.solution.result import Solution, empty_channels

KIND = "contact-loss"
LIMITS = (Limit(KIND, None, 100.0),)
RESOLUTION = 10.0
Margin = Callable[[float], float]


def search(margin: Margin, speeds: Sequence[float], asked: list[float] | None = None) -> Search:
    """A search whose margin is a function of the speed alone; ``asked`` takes down every look."""

    def run_at(engine_speed: float, orbit: object) -> SpeedSample:
        if asked is not None:
            asked.append(engine_speed)
        return SpeedSample({KIND: margin(engine_speed)}, {KIND: ("cam",)}, "motion")

    return Search(run_at, {one: run_at(one, None) for one in speeds}, LIMITS, RESOLUTION)


def grid(step: float, first: float = 6000.0, last: float = 9000.0) -> list[float]:
    return [first + step * place for place in range(round((last - first) / step) + 1)]


def dip(centre: float, half_width: float, depth: float = 400.0) -> Margin:
    """300 but for a resonance (a Lorentz curve of a tenth of ``centre`` at most) that passes zero
    half a width to either side.
    """
    width = half_width / math.sqrt(depth / 300 - 1)
    return lambda speed: max(0.0, 300 - depth / (1 + ((speed - centre) / width) ** 2))


@pytest.mark.parametrize("step", [200, 100, 50, 20, 10])
@pytest.mark.parametrize(
    ("centre", "half_width"), [(7451, 150), (7333, 40), (8170, 60), (6411, 100)]
)
def test_an_island_is_found_to_the_resolution_on_any_grid(
    step: float, centre: float, half_width: float
) -> None:
    """Both edges of the stretch, known in closed form; coarse grids step over some of them with
    both feet.
    """
    found = search(dip(centre, half_width), grid(step))
    onset = found.onset(KIND)
    assert isinstance(onset, SpeedBracket)
    end = found.end(KIND, onset.upper_engine_speed)
    assert end is not None
    for bracket, edge in ((onset, centre - half_width), (end, centre + half_width)):
        assert bracket.lower_engine_speed <= edge <= bracket.upper_engine_speed
        assert bracket.upper_engine_speed - bracket.lower_engine_speed <= RESOLUTION * (1 + 1e-6)
    assert [one.lower_engine_speed for one in found.stretches(KIND)] == [onset.upper_engine_speed]


def test_a_flat_margin_costs_no_run_and_is_never_lost() -> None:
    asked: list[float] = []
    found = search(lambda speed: 300.0 - 0.001 * speed, grid(100), asked)
    assert found.onset(KIND) is None and len(asked) == len(grid(100)) and found.runs_count == 0


def test_the_lowest_of_several_stretches_is_the_answer_and_the_others_are_named() -> None:
    low, high = dip(7000, 60), dip(8400, 200)
    found = search(lambda speed: min(low(speed), high(speed)), grid(100))
    one = critical_speed(found, KIND, "own", 6000.0, 9000.0, CriticalOptions())
    assert one.begins is not None and one.ends is not None
    assert one.engine_speed == pytest.approx(6940, abs=RESOLUTION) and one.engine_speed >= 6940
    assert one.ends.from_rest.lower_engine_speed == pytest.approx(7060, abs=RESOLUTION)
    assert [(each.lower_engine_speed, each.upper_engine_speed) for each in one.again] == [
        (8200, 8600)
    ]


@pytest.mark.parametrize("step", [100, 130])
def test_where_a_further_range_begins_does_not_hang_on_the_grid(step: float) -> None:
    """It began at the next speed that was sampled."""
    low, high = dip(7000, 60), dip(8400, 200)
    found = search(lambda speed: min(low(speed), high(speed)), grid(step, 6050.0, 8910.0))
    one = critical_speed(found, KIND, "own", 6050.0, 8910.0, CriticalOptions())
    (again,) = one.again
    assert 0 <= again.lower_engine_speed - 8200 <= RESOLUTION


def test_what_is_lost_from_the_first_speed_on_has_no_onset() -> None:
    one = critical_speed(
        search(lambda speed: speed - 6500, grid(500)),
        KIND,
        "own",
        6000.0,
        9000.0,
        CriticalOptions(),
    )
    assert (
        one.found
        and one.begins is None
        and one.engine_speed == 6000.0
        and one.text.startswith("below")
    )
    assert (
        one.ends is not None
        and one.ends.from_rest.lower_engine_speed <= 6500 <= one.ends.from_rest.upper_engine_speed
    )


def test_a_run_without_numbers_counts_as_lost() -> None:
    onset = search(lambda speed: math.nan if speed >= 7040 else 100.0, grid(500)).onset(KIND)
    assert (
        isinstance(onset, SpeedBracket)
        and onset.lower_engine_speed < 7040 <= onset.upper_engine_speed
    )
    failed = sample_of(Solution(empty_channels()), CriticalOptions())
    assert all(failed.lost(kind) for kind in failed.margins)


def test_a_run_that_ended_early_does_not_end_a_range_of_bounces() -> None:
    """Contract: a valve "bounces from 8246 to 8424 and again from 8635" where the run between ended by coil bind."""

    def run_at(engine_speed: float, orbit: object) -> SpeedSample:
        ended = 8000 < engine_speed < 8200 or 8420 < engine_speed < 8635
        lost = not ended and engine_speed > 8246
        unknown = frozenset({KIND} if ended else ())
        return SpeedSample({KIND: 0.0 if lost else 300.0}, {KIND: ("seat",)}, "motion", unknown=unknown)  # fmt: skip

    speeds = grid(50, 7500)
    found = Search(run_at, {one: run_at(one, None) for one in speeds}, LIMITS, RESOLUTION)
    row = critical_speed(found, KIND, "own", 7500, 9000, CriticalOptions(resolution=RESOLUTION))
    assert row.engine_speed == pytest.approx(8250, abs=RESOLUTION)
    assert row.ends is None and not row.again
    numbers = {
        "quantities": {"float_excess_lift": 0.0},
        "statistics": {"least_cam_contact_force": 9.0},
    }
    assert sample_of(replace(Solution(empty_channels()), **numbers), CriticalOptions()).unknown == {"bounce"}  # fmt: skip


def test_rising_and_falling_speed_show_a_hysteresis() -> None:
    """A motion that jumps up at 7650 and back at 7120; from rest it jumps at 7400. Carried motion
    goes beyond the grid's brackets.
    """

    def run_at(engine_speed: float, orbit: object) -> SpeedSample:
        edge = {None: 7400.0, "low": 7650.0, "high": 7120.0}[orbit]  # type: ignore[index]
        lost = engine_speed > edge
        return SpeedSample(
            {KIND: 0.0 if lost else (edge - engine_speed) + 1},
            {KIND: ("cam",)},
            "high" if lost else "low",
        )

    found = Search(run_at, {one: run_at(one, None) for one in grid(100)}, LIMITS, RESOLUTION)
    one = critical_speed(found, KIND, "own", 6000.0, 9000.0, CriticalOptions())
    assert (
        one.begins is not None and one.begins.rising is not None and one.begins.falling is not None
    )
    for bracket, edge in (
        (one.begins.from_rest, 7400),
        (one.begins.rising, 7650),
        (one.begins.falling, 7120),
    ):
        assert bracket.lower_engine_speed <= edge <= bracket.upper_engine_speed
        assert bracket.upper_engine_speed - bracket.lower_engine_speed <= RESOLUTION * (1 + 1e-6)
    assert one.begins.hysteresis == pytest.approx(530, abs=2 * RESOLUTION)


def test_motion_that_never_comes_back_is_said_to_have_no_bracket() -> None:
    def run_at(engine_speed: float, orbit: object) -> SpeedSample:
        lost = orbit == "high" or engine_speed > 7400
        return SpeedSample(
            {KIND: 0.0 if lost else 7401 - engine_speed},
            {KIND: ("cam",)},
            "high" if lost else "low",
        )

    found = Search(run_at, {one: run_at(one, None) for one in grid(100)}, LIMITS, RESOLUTION)
    one = critical_speed(found, KIND, "own", 6000.0, 9000.0, CriticalOptions())
    assert one.begins is not None and one.begins.falling is None
    assert one.begins.rising is not None and one.begins.rising.apart(one.begins.from_rest) == 0
    assert math.isnan(one.begins.hysteresis)


def test_options_are_read_with_their_units_and_refused_where_they_cannot_be_meant() -> None:
    read = read_options("20 rpm", "0.03 mm", 2e-4)
    assert (read.resolution * 30 / math.pi, read.float_lift, read.bounce_height) == pytest.approx(
        (20, 3e-5, 2e-4)
    )
    for words, name in (
        (("0 rpm", "1 mm", "1 mm"), "resolution"),
        (("10 rpm", "-1 mm", "1 mm"), "float lift"),
    ):
        with pytest.raises(InputError, match=name):
            read_options(*words)
    with pytest.raises(InputError, match=r"unit|rpm"):
        read_options("10 mm", "1 mm", "1 mm")


def test_a_case_without_a_train_has_no_critical_speeds() -> None:
    import valvetrain as vt

    with pytest.raises(InputError, match="no train"):
        vt.critical_speeds(load_case("job-t"), "1000 rpm", spring_models=["massless"])


@pytest.mark.parametrize(
    ("speed", "sign", "found"),
    [(100.0, -1, 60.0), (110.0, 1, 140.0), (60.0, -1, 60.0), (140.0, 1, 140.0), (150.0, 1, 150.0)],
)
def test_a_motion_is_carried_over_from_the_nearest_speed_far_enough_from_the_change(
    speed, sign, found
):
    """Control is lost from 110 on; of speeds on the same side the first that lies away far enough,
    else the end of the bracket itself.
    """
    away = critical_search.AWAY
    search = critical_search.Search.__new__(critical_search.Search)
    search._speeds, search._resolution = (
        [60.0, 99.0, 100.0, 110.0, 112.0, 140.0, 150.0],
        30.0 / away,
    )
    search._lost = lambda kind, one: one >= 110.0
    assert search._away("float", speed, sign) == found


def test_a_jump_says_nothing_of_slopes_elsewhere() -> None:
    """Property: a margin that is whole up to a jump is sampled no finer than the narrowest range
    that the search promises (50 of its resolution), beside the bracket of the jump itself.
    """
    asked: list[float] = []
    speeds = grid(500)

    def run_at(engine_speed: float, orbit: object) -> SpeedSample:
        asked.append(engine_speed)
        return SpeedSample(
            {KIND: 300.0 if engine_speed < 8123 else -300.0}, {KIND: ("valve",)}, "motion"
        )

    limit = Limit(KIND, 300.0, 50.0)
    found = Search(run_at, {one: run_at(one, None) for one in speeds}, (limit,), RESOLUTION)
    onset = found.onset(KIND)
    assert isinstance(onset, SpeedBracket)
    assert onset.lower_engine_speed < 8123 <= onset.upper_engine_speed
    assert found.runs_count <= math.log2(500 / RESOLUTION) + 1


def test_no_motion_is_carried_over_a_long_way() -> None:
    """Property: where the next sampled speed is far, one at the wanted distance is sampled, from which
    the falling speed needs but a few steps.
    """
    found = search(lambda speed: max(0.0, 6904 - speed), grid(1000))
    onset = found.onset(KIND)
    assert isinstance(onset, SpeedBracket)
    before = found.runs_count
    crossing = found.crossing(KIND, onset)
    assert crossing.falling is not None
    assert crossing.falling.lower_engine_speed <= 6904 <= crossing.falling.upper_engine_speed
    assert found.runs_count - before <= 14


@pytest.mark.parametrize("step", [100, 50, 20, 10])
@pytest.mark.parametrize(("repeats", "width"), [(False, 30), (True, 30), (False, 300)])
def test_a_short_range_of_motion_that_does_not_repeat_is_no_onset(
    step: float, repeats: bool, width: float
) -> None:
    """Property: an island at 6700 counts where its motion repeats or it is wider than 2 % of its speed; elsewhere the
    onset at 8003 does, on any grid, and what the samples saw of the island is named beside it.
    """

    def run_at(engine_speed: float, _: object) -> SpeedSample:
        island = abs(engine_speed - 6700) < width / 2
        lost = island or engine_speed > 8003
        margin = 0.0 if lost else min(300.0, 3 * abs(engine_speed - 6700), 8003 - engine_speed)
        steady = repeats or not 6500 < engine_speed < 6900
        return SpeedSample({KIND: margin}, {KIND: ("cam",)}, "motion", repeats=steady)

    speeds = grid(step)
    found = Search(run_at, {one: run_at(one, None) for one in speeds}, LIMITS, RESOLUTION)
    row = critical_speed(found, KIND, "spring", 6000.0, 9000.0, CriticalOptions(RESOLUTION))
    assert row.begins is not None
    at = row.begins.from_rest
    onset = 6700 - width / 2 if repeats or width > 0.02 * 6700 else 8003
    assert at.lower_engine_speed <= onset <= at.upper_engine_speed
    if onset == 8003 and step <= 20:
        (short,) = row.passed
        assert abs(short.lower_engine_speed - 6700) <= 15 >= abs(short.upper_engine_speed - 6700)
        assert "single revolutions" in row.later_text
    elif onset != 8003:
        assert not row.passed
