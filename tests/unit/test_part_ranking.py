"""Parts by the engine speed that each gains: changed trains (closed forms), gains of roots written by hand, the rules on
them, and a train of one mass whose limits rigid theory gives.
"""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

import valvetrain as vt
from train_parts import SINGLE_MASS
from unit.cli_parts import call
from valvetrain.errors import InputError
from valvetrain.runs.part_ranking import (
    LOADS,
    NOMINAL,
    Part,
    _change,
    limits_of,
    parts_of,
    stiffer_pushrods,
)
from valvetrain.solution.critical import (
    RPM,
    CriticalSpeed,
    CriticalSpeeds,
    RangeMember,
    SpeedBracket,
)
from valvetrain.solution.part_ranking import PartChange, PartRanking
from valvetrain.system.build import build
from valvetrain.system.train_rest import rest_of
from valvetrain.views.parts import PartsAnswer

TRAIN = vt.load_case("tdi-pushrod").train
INCH = 0.0254
WORDS = ("study", "--parts", "--spring-set", "card")


def changed(name: str) -> object:
    return next(one.train for one in parts_of(TRAIN, "stock") if one.name == name)


def test_a_changed_train_differs_in_one_part() -> None:
    assert changed("valve 10 % lighter").valve.mass == pytest.approx(0.9 * TRAIN.valve.mass)
    retainer = TRAIN.valve.mass - changed("titanium retainer").valve.mass
    assert retainer == pytest.approx(0.16 * (1 - 4.43 / 7.85) * TRAIN.valve.mass)
    assert changed("rocker 10 % lighter").lever.inertia == pytest.approx(0.9 * TRAIN.lever.inertia)
    for one in parts_of(TRAIN, "stock"):
        fields = [name for name in ("valve", "follower", "lever", "pushrod", "springs", "lash")
                  if getattr(one.train, name) != getattr(TRAIN, name)]  # fmt: skip
        assert len(fields) == 1, one.name


@pytest.mark.parametrize("springs", ["wire", "card"])
def test_springs_are_shimmed_stiffened_and_made_lighter(springs: str) -> None:
    """A wire and a card: by their own force law."""
    case = vt.load_case("template:pushrod")
    trains = {one.name: one.train for one in parts_of(case.train, springs)}

    def loads(train: object) -> tuple[float, float]:
        """Seat load, and what 5 mm of lift add."""
        run = build(case.replace(train=train), spring_models="multi-mass", spring_set=springs)
        system = run.members[0].system({}, run.built)
        closed, lifted = rest_of(system).static_spring_force([0.0, 5e-3])
        return float(closed), float(lifted - closed)

    seat, rise = loads(case.train)
    for newtons in (25, 50):
        more, same = loads(trains[f"seat load +{newtons} N"])
        assert more - seat == pytest.approx(newtons, rel=0.02)
        assert same == pytest.approx(rise, rel=0.02)
    springs_in_use = case.train.spring_parts(springs)
    close = {one.name: one.train for one in parts_of(case.train, springs, 10e-3)}[
        "1.4 mm to coil bind"
    ]
    left = min(one.room for one in close.spring_parts(springs)) - 10e-3
    assert left == pytest.approx(1.4e-3) and close.spring_parts(springs) != springs_in_use
    same, more = loads(trains["rate 10 % stiffer"])
    assert same == pytest.approx(seat, rel=0.02) and more == pytest.approx(1.1 * rise, rel=0.02)
    assert loads(trains["spring 10 % lighter"]) == pytest.approx((seat, rise), rel=1e-6)


def test_changes_are_named_in_the_units_of_the_case() -> None:
    """Pounds and inches where a value of the file has pounds, by definition 4.448 N; a comment or a source is no value."""
    train = vt.load_case("template:pushrod").train.replace(lash=0.2e-3)
    metric, pounds = (
        [one.name for one in parts_of(train, "card", 10e-3, text)]
        for text in ('preload = "90 N" # or "20 lbf"', 'preload = { value = "20 lbf" }')
    )
    assert {"seat load +25 N", "1.4 mm to coil bind", "lash 0.05 mm more"} <= {*metric}
    assert {"seat load +5 lbf", "0.055 in to coil bind", "lash 0.002 in more"} <= {*pounds}
    assert LOADS["lbf", "in"] == pytest.approx((5 * 4.4482216, 10 * 4.4482216))


def test_a_rigid_rocker_may_bend_and_an_elastic_one_is_stiffened() -> None:
    lever = replace(TRAIN.lever, stiffness=None)
    rigid, elastic = TRAIN.replace(lever=lever), TRAIN.replace(lever=replace(lever, stiffness=30e6))
    (bent,) = (one for one in parts_of(rigid, "stock") if not one.chosen)
    assert (bent.train.lever.stiffness, bent.train.lever.inertia) == (40e6, lever.inertia)
    stiffer = {
        one.name: one.train.lever.stiffness for one in parts_of(elastic, "stock") if one.chosen
    }
    assert stiffer["rocker 10 % stiffer"] == pytest.approx(33e6)


def test_pushrods_are_steel_tubes() -> None:
    tube = {"length": 7.4 * INCH, "outer_diameter": 0.3125 * INCH, "wall_thickness": 0.08 * INCH}
    pushrod = vt.parameters.train_parts.PushrodParameters(lower_end=(0.0, 0.05), **tube)
    (name, _, thin), (thick_name, mass, thick) = stiffer_pushrods(pushrod)
    assert name.startswith("pushrod 3/8") and "0.120" in thick_name
    area = math.pi * 0.12 * (0.375 - 0.12) * INCH**2
    assert thick == pytest.approx(206e9 * area / (7.4 * INCH))
    assert mass == pytest.approx(7850 * area * 7.4 * INCH)
    assert pushrod.stiffness < thin < thick
    given = replace(pushrod, length=None)  # the same tube by its mass and stiffness
    assert [one[2] for one in stiffer_pushrods(given)] == pytest.approx([thin, thick])  # fmt: skip
    assert not list(stiffer_pushrods(None)) and not list(stiffer_pushrods(replace(pushrod, stiffness=None)))  # fmt: skip


def row(kind: str, begin: float, **members: float) -> CriticalSpeed:
    """A loss from ``begin`` (rpm) to the last speed, with roots of damping by the name of the factor."""
    ranges = (SpeedBracket(begin * RPM, 8000 * RPM),) if begin < math.inf else ()
    found = tuple(RangeMember("damping", name, at * RPM) for name, at in members.items())
    return CriticalSpeed("own", kind, 0.0, 4000 * RPM, 8000 * RPM, ranges, members=found)


def limits(*rows: CriticalSpeed) -> dict[tuple[str, str], tuple[float, float]]:
    found = limits_of(CriticalSpeeds(rows))
    return {key: tuple(one / RPM for one in pair) for key, pair in found.items()}


def test_the_limit_is_the_first_loss_that_stays() -> None:
    found = limits(row("contact-loss", 6700, less=6500, more=6800), row("float", 7500, less=6400))
    assert found[NOMINAL] == pytest.approx((6700, 6700))
    assert found["damping", "less"] == pytest.approx((6400, 6400))
    assert found["damping", "more"] == pytest.approx((6800, 6800))
    short = replace(row("contact-loss", 5000), ranges=(SpeedBracket(5000 * RPM, 5040 * RPM),), short_count=1)  # fmt: skip
    assert limits(short, row("float", math.inf))[NOMINAL] == (math.inf, math.inf)
    assert limits(row("float", 0.0))[NOMINAL] == (0, 0)


def test_a_range_pairs_trains_with_the_same_thing_changed() -> None:
    ranking = PartRanking("own", "stock", 6700 * RPM, 6000 * RPM, 8000 * RPM)
    before = {NOMINAL: (6700 * RPM,) * 2, ("damping", "×0.6"): (6500 * RPM,) * 2}
    after = {NOMINAL: (6800 * RPM,) * 2, ("damping", "×0.6"): (6560 * RPM,) * 2, ("revolution", ""): (6790 * RPM, 6850 * RPM)}  # fmt: skip
    one = _change(Part("x", "", TRAIN), ranking, before, after)
    assert [one.gain / RPM, one.least_gain / RPM, one.largest_gain / RPM] == pytest.approx([100, 60, 150])  # fmt: skip
    beyond = _change(Part("x", "", TRAIN), ranking, before, {NOMINAL: (math.inf,) * 2})
    assert beyond.gain / RPM == pytest.approx(1300)


def change(part: str, gain: float, half: float = 5.0, **more: object) -> PartChange:
    speed = (6700 + gain) * RPM
    return PartChange(part, "", speed, gain * RPM, (gain - half) * RPM, (gain + half) * RPM, **more)


WHOLE = PartRanking("own", "stock", 6700 * RPM, 6000 * RPM, 8400 * RPM, (
    change("pushrod", 480, 30), change("titanium retainer", 60), change("rate 10 % softer", -80, seat_load_change=-4.0),
    PartChange("lash", refusal="no"), change("damping ×0.6", -250, 0, chosen=False),
), 667.0, 7000 * RPM)  # fmt: skip


def codes(ranking: PartRanking) -> tuple[str, ...]:
    return PartsAnswer(ranking).findings.codes


def test_findings_say_what_gains_most_and_what_is_not_known() -> None:
    shown = PartsAnswer(WHOLE)
    assert codes(WHOLE) == ("W301", "A120")
    assert len(f"{shown.verdict}".split()) <= 25
    assert [one.mark for one in shown.lines] == ["", "ok", "ok", "bad", "warn", ""]
    assert codes(replace(WHOLE, red_line=7300 * RPM))[0] == "W302"
    assert codes(replace(WHOLE, red_line=None))[0] == "W301"
    bends = replace(WHOLE, lift_loss=0.16e-3, time_lost=0.07, changes=(
        change("pushrod", 480, lift_loss=0.1e-3, time_lost=0.05), change("rate 10 % softer", -80, lift_loss=0.09e-3),
        *(replace(one, lift_loss=0.16e-3) for one in WHOLE.changes[1:])
    ))  # fmt: skip
    (flex,) = PartsAnswer(bends).findings.by("W312")
    assert (flex.fields["part"], flex.fields["less"].value) == ("pushrod", 0.1e-3)
    (flex,) = PartsAnswer(replace(bends, changes=bends.changes[1:])).findings.by("W312")
    assert not flex.fields["part"]  # the others leave it as it is, or lose control
    vague = replace(WHOLE, changes=(change("pushrod", 20, 40), WHOLE.changes[-1]))
    assert codes(vague) == ("W303", "W311")
    assert PartsAnswer(vague).lines[-1].mark == "warn"  # damping decides more than any part
    # a part that surely gains decides; another whose range reaches into its range is named with it
    sure = replace(
        WHOLE,
        changes=(
            change("pushrod", 70, 90),
            change("valve", 50, setting="--set 'a=1'"),
            change("lash", 20, 15),
        ),
    )
    told = PartsAnswer(sure)
    assert codes(sure) == ("W302",) and sure.best.part == "valve"
    assert told.verdict.fields["rival"] == "pushrod" and told.next_step.endswith("--set 'a=1'")
    assert not shown.verdict.fields["rival"] and len(f"{told.verdict}".split()) <= 25
    assert [one.mark for one in told.lines] == ["", "", "ok", "ok"]
    assert codes(PartRanking("own", "stock", math.inf, 1000 * RPM, 8400 * RPM)) == ("W304",)
    assert codes(PartRanking("own", "stock", 0.0, 1000 * RPM, 8400 * RPM)) == ("W305",)


def test_what_ends_control_is_said_of_the_train_and_of_parts_that_change_it() -> None:
    parts = tuple(replace(one, loss="contact-loss") for one in WHOLE.changes)
    other = (replace(parts[0], loss="bounce"), *parts[1:])
    shown = PartsAnswer(replace(WHOLE, loss="contact-loss", changes=other))
    assert ["bounces" in one.remark for one in shown.lines] == [
        False,
        True,
        *[False] * len(parts[1:]),
    ]
    assert "cam" in shown.lines[0].remark


def test_a_shim_that_leaves_little_to_coil_bind_has_no_tick() -> None:
    shim = change("seat load", 300, bind_clearance=0.4e-3)
    shown = PartsAnswer(replace(WHOLE, changes=(shim, *WHOLE.changes[1:])))
    assert shown.lines[1].mark == "warn" and shown.ranking.best.part == "titanium retainer"
    alone = PartsAnswer(replace(WHOLE, changes=(shim,)))
    assert alone.verdict.fields["left"].value == 0.4e-3
    roomy = PartsAnswer(replace(WHOLE, changes=(replace(shim, bind_clearance=1.1e-3),)))
    assert roomy.lines[1].mark == "ok" and not roomy.verdict.fields["left"]


def test_a_ranking_shows_bars_with_ranges_and_is_saved(tmp_path: Path) -> None:
    (bars,) = WHOLE.plot().data
    assert list(bars.x) == pytest.approx([480, 60, -80, -250])
    assert list(bars.error_x.array) == pytest.approx([30, 5, 5, 0])
    assert WHOLE.best.part == "pushrod" and "+480" in WHOLE._repr_html_()
    table = WHOLE.to_pandas()
    assert table.attrs["units"]["gain"] == "rad/s" and len(table) == 5
    assert repr(vt.load(WHOLE.save(tmp_path / "parts.nc"))) == repr(WHOLE)


@pytest.mark.slow
def test_gains_of_one_mass_are_those_of_rigid_theory(tmp_path: Path) -> None:
    """Limit: one mass on a stiff cam under a spring without waves, whose contact moves each limit by less than half a per
    cent; by the command, whose folder holds the ranking.
    """
    path, folder = tmp_path / "one-mass.toml", tmp_path / "out"
    path.write_text(SINGLE_MASS)
    told = json.loads(
        call(
            *WORDS,
            "--output",
            str(folder),
            "--json",
            "--set",
            "operation.red_line=7000 rpm",
            str(path),
        ).stdout
    )
    rows, names = told["parts"]["rows"], {one.name for one in folder.iterdir()}
    assert told["findings"][0]["code"] in ("W301", "W302") and {"report.html", "run.json"} <= names
    assert told["parts"]["units"]["gain"] == "rad/s" and set(rows[0]) == set(told["parts"]["units"])
    ranking, case = vt.load(folder / "parts.nc"), vt.load_case(path)
    assert [one["gain"] for one in rows] == [one.gain for one in ranking.changes]

    def rigid(one: vt.parameters.Case) -> float:
        return vt.simulate(one, "3000 rpm").still["card"]["rigid_contact_loss_engine_speed"]

    own = rigid(case)
    assert ranking.engine_speed == pytest.approx(own, rel=5e-3)
    trains = {one.name: one.train for one in parts_of(case.train, "card", 9e-3)}
    assert {one.part for one in ranking.choices} == {*trains}
    for one in ranking.choices:
        wanted = rigid(case.replace(train=trains[one.part])) - own
        assert one.gain == pytest.approx(wanted, abs=5e-3 * own), one.part
    assert ranking.choices[0].gain > 0 > ranking.choices[-1].gain
    assert all(
        0 <= one.lift_loss < 2e-6 for one in ranking.changes if one.chosen
    )  # its cam alone yields
    assert all(math.isnan(one.stress_change) for one in ranking.changes)  # a card has no wire
    held = vt.Case(path).parts("1000:2000:500 rpm", workers=1)
    assert held.best is None and PartsAnswer(held).verdict.code == "W304"


def test_wrong_requests_are_refused(tmp_path: Path) -> None:
    wrong = call("study", str(tmp_path / "study.toml"), "--set", "train.lash=0 mm")
    assert wrong.exit_code == 2 and "--parts" in wrong.output
    with pytest.raises(InputError, match="no \\[train\\]"):
        vt.Case("job-t").parts()
    with pytest.raises(InputError, match="one spring set"):
        vt.Case("tdi-pushrod").parts(spring_sets=["stock", "performance"])
