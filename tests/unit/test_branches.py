"""Branches of motion: ranges of points written by hand (closed form), and the two motions of a train that were marched by
plain revolutions (limit).
"""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import valvetrain as vt
from unit.cli_parts import call
from valvetrain.errors import InputError
from valvetrain.integrate.steady import SteadyState
from valvetrain.runs import branch_march
from valvetrain.runs.branch_march import DISTURBANCES
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
    assert BranchesAnswer(alone).findings.codes == ("W204",)
    assert (
        "W214"
        in BranchesAnswer(Branches("own", "loft_gap", POINTS[:1], 3, complete=False)).findings.codes
    )
    figure = WHOLE.plot()
    names = {"stable, rising", "stable, falling", "unstable or not resolved", "scatter"}
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


def landing(rpm: float, rising: bool, count: int, **more: object) -> BranchPoint:
    return point(rpm, rising, 1e-3, landings=count, **more)


def test_a_landing_gained_or_lost_is_a_grazing_between_its_speeds() -> None:
    """An unstable orbit, a motion of two revolutions and one that never repeats tell nothing of it."""
    march = (
        landing(100, True, 2), landing(200, True, 2), landing(300, True, 3), landing(300, False, 3), landing(200, False, 2),
        landing(400, True, 5, repels="flip"), point(500, True, 1e-3, 2, landings=4), point(600, True, 1e-3, 0, landings=9),
    )  # fmt: skip
    found = Branches("own", "loft_gap", march, 9)
    assert ends(found.grazing) == [pytest.approx((200, 300))]
    assert "W215" in BranchesAnswer(found).findings.codes
    assert not Branches("own", "loft_gap", march[:2], 9).grazing
    assert BranchesAnswer(Branches("own", "loft_gap", march[:2], 9)).findings.codes == ("W204",)


def test_an_orbit_whose_stability_is_not_resolved_is_said_to_be_so_without_a_number() -> None:
    points = (
        point(100, True, 1e-3),
        point(200, True, 1e-3, repels="unresolved"),
        point(200, True, 2e-3, 2),
    )
    found = Branches("own", "loft_gap", points, 9)
    assert ends(found.ranges("unresolved")) == [pytest.approx((200, 200))]
    assert found.attracting(True) == (points[0], points[2])
    assert BranchesAnswer(found).findings.codes == ("W211", "W213")
    assert found.to_records()[1]["multiplier"] is None


#: Multipliers of an orbit by the smaller and the larger disturbance, and what is said of it.
JUDGED = {
    "attracts": (0.47, 0.48, ""), "flips": (-1.75, -1.78, "flip"), "straddles": (0.83, 1.06, "unresolved"),
    "moves too far": (0.48, 0.94, "unresolved"), "repels, moves too far": (1.11, 1.6, "unresolved"), "fails": (0.4, math.nan, "unresolved"),
}  # fmt: skip


@pytest.mark.parametrize("name", JUDGED)
def test_stability_is_resolved_where_the_size_of_the_disturbance_does_not_matter(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    small, large, word = JUDGED[name]
    sizes = {DISTURBANCES[0]: small, DISTURBANCES[1]: large}
    monkeypatch.setattr(
        branch_march, "train_multipliers", lambda _, size: np.array([sizes[size] + 0j])
    )
    monkeypatch.setattr(branch_march._March, "_value", lambda *_: (1e-3, 2, None))
    search = SteadyState(np.zeros(1), (1.0, 0.5), 1, 2, "anderson", 1e-6)
    march = branch_march._March(None, "loft_gap", True, None)  # type: ignore[arg-type]
    assert march._attracts(100.0, SimpleNamespace(search=search, runner=None, start=None)) is (
        not word
    )  # type: ignore[arg-type]
    (judged,) = march.points
    assert judged.repels == word
    assert math.isnan(judged.multiplier) == (word == "unresolved")


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
    assert told["findings"][0]["code"] == "W204" and (tmp_path / "out" / "branches.nc").exists()
