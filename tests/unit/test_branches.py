"""Branches of motion: ranges of points written by hand (closed form), and the two motions of a train that were marched by
plain revolutions (limit).
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

import valvetrain as vt
from unit.cli_parts import call
from valvetrain.errors import InputError
from valvetrain.solution.branches import Branches, BranchPoint
from valvetrain.solution.critical import RPM
from valvetrain.views.branches import BranchesAnswer


def point(rpm: float, rising: bool, value: float, period: int = 1, **more: object) -> BranchPoint:
    values = tuple(value + 1e-4 * place for place in range(period or 5))
    return BranchPoint(rpm * RPM, rising, period, values, **more)  # type: ignore[arg-type]


#: Two motions from 200 to 300, an orbit that repels at 400, chaos at 500 and 600.
POINTS = (
    *(point(rpm, True, 1e-3) for rpm in (100, 200, 300)),
    *(point(rpm, False, 1e-3 if rpm < 200 else 2e-3) for rpm in (100, 200, 300)),
    *(point(400, rising, 1e-3, 2) for rising in (True, False)),
    point(400, True, 1.05e-3, repels="flip", multiplier=1.2),
    *(point(rpm, rising, 1e-3, 0, exponent=0.4) for rpm in (500, 600) for rising in (True, False)),
)
WHOLE = Branches("own", "loft_gap", POINTS, 100)


def ends(spans: object) -> list[tuple[float, float]]:
    return [(one.lower_engine_speed / RPM, one.upper_engine_speed / RPM) for one in spans]  # type: ignore[attr-defined]


def test_ranges_are_those_of_neighbouring_speeds() -> None:
    assert ends(WHOLE.hysteresis) == [pytest.approx((200, 300))]
    assert ends(WHOLE.ranges("chaotic")) == [pytest.approx((500, 600))]
    assert (
        ends(WHOLE.ranges("period 2"))
        == ends(WHOLE.ranges("repels by flip"))
        == [pytest.approx((400, 400))]
    )


def test_findings_name_chaos_hysteresis_and_what_repels(tmp_path: Path) -> None:
    shown = BranchesAnswer(WHOLE)
    assert shown.findings.codes == ("W201", "W202", "W211")
    little = tuple(point(rpm, True, 1e-6, 0, exponent=0.4) for rpm in (500, 600))
    small = [replace(one, values=tuple(1e-2 * value for value in one.values)) for one in little]
    assert BranchesAnswer(Branches("own", "loft_gap", tuple(small), 9)).findings.codes == ("W204",)
    alone = Branches("own", "loft_gap", POINTS[:1], 3)
    assert BranchesAnswer(alone).findings.codes == ("W203",)
    assert (
        "W214"
        in BranchesAnswer(Branches("own", "loft_gap", POINTS[:1], 3, complete=False)).findings.codes
    )
    figure = WHOLE.plot()
    names = {"stable, rising", "stable, falling", "unstable", "scatter"}
    assert {one.name for one in figure.data} == names
    read = vt.load(WHOLE.save(tmp_path / "branches.nc"))
    assert repr(read.points) == repr(POINTS) and read.hysteresis == WHOLE.hysteresis


@pytest.fixture(scope="module")
def marched() -> Branches:
    return vt.Case("tdi-pushrod").branches("9450:9650:50 rpm", spring_sets="stock")


def test_a_march_shows_the_hysteresis_that_plain_revolutions_show(marched: Branches) -> None:
    """Plain revolutions jump up at 9592 and down at 9495.5 rpm; 1.9 against 2.5 mm of loft."""
    assert marched.complete and ends(marched.hysteresis) == [pytest.approx((9500, 9550))]
    up, down = (
        next(
            one
            for one in marched.attracting(rising)
            if one.engine_speed == pytest.approx(9500 * RPM)
        )
        for rising in (True, False)
    )
    assert up.values[0] == pytest.approx(1.88e-3, abs=0.02e-3)
    assert down.values[0] == pytest.approx(2.48e-3, abs=0.02e-3)
    slow = [one.multiplier for one in marched.points if one.multiplier == one.multiplier]
    assert slow and all(0.3 < one < 1 for one in slow)


def test_a_march_ends_within_its_revolutions() -> None:
    short = vt.Case("tdi-pushrod").branches(
        "8700:8900:50 rpm", spring_sets="stock", revolutions=300
    )
    assert not short.complete and short.revolutions < 800
    assert short.points[0].motion == "chaotic" and short.points[0].exponent > 0.1


def test_wrong_requests_are_refused() -> None:
    with pytest.raises(InputError, match="seating_velocity"):
        vt.Case("tdi-pushrod").branches("3000 rpm", spring_sets="stock", quantity="colour")
    with pytest.raises(InputError, match="no train"):
        vt.Case("job-t").branches("3000 rpm")


def test_the_command_prints_its_points_as_an_object(tmp_path: Path) -> None:
    words = ("branches", "tdi-pushrod", "--spring-set", "stock", "--rpm", "3000:3100:50")
    told = json.loads(call(*words, "--output", str(tmp_path / "out"), "--json").stdout)
    assert [one["motion"] for one in told["points"]] == ["period 1"] * 6
    assert told["findings"][0]["code"] == "W203" and (tmp_path / "out" / "branches.nc").exists()
