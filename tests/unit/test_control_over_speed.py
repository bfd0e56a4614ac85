"""Unit: how the verdict of a sweep and of two springs says up to where a train is controlled: short ranges
of lost contact, single speeds, ranges over numerics and damping, what binds first and which stress tells.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from synthetic_study import train_study
from valvetrain.quantities.forces import bind_clearances
from valvetrain.quantities.train_events import CAUSE_INERTIA, CAUSE_SURGE
from valvetrain.report.control import control_of, controlled_to
from valvetrain.report.headlines import headline_rows
from valvetrain.report.key_figures import key_figures
from valvetrain.report.sweep_chart import regime_chart
from valvetrain.runs.critical_search import Search, SpeedSample
from valvetrain.runs.critical_speeds import CriticalOptions, critical_speed
from valvetrain.solution.critical import (
    CriticalSpeed,
    CriticalSpeeds,
    Crossing,
    RangeMember,
    SpeedBracket,
)
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Event
from valvetrain.solution.study import Study

RPM = np.pi / 30
LABEL = "stock, modal-uniform"


def run(
    speed: float, name: str = "stock", events: tuple[Event, ...] = (), **values: float
) -> Solution:
    """A run of a spring set at a speed (rpm)."""
    first = train_study().solutions[0]
    held = {"loss_of_contact_duration": 0.0, "minimum_cam_contact_force": 40.0, **values}
    origin = replace(first.provenance, engine_speed=speed * RPM, label=f"{name}, modal-uniform", spring_set=name, model="modal-uniform")  # fmt: skip
    return replace(first, events=events, quantities=held, provenance=origin)


def bracket(low: float, high: float) -> SpeedBracket:
    return SpeedBracket(low * RPM, high * RPM)


def lost(
    kind: str, begin: float, end: float = math.inf, *again: SpeedBracket, **more: object
) -> CriticalSpeed:
    """Control lost from ``begin`` to ``end`` (rpm) of a search from 4000 to 8000 rpm."""
    ends = None if math.isinf(end) else Crossing(bracket(end, end + 10))
    place = {"contact-loss": "cam", "float": "valve", "bounce": "seat"}[kind]
    row = CriticalSpeed(LABEL, kind, 0.0, 4000 * RPM, 8000 * RPM, 10 * RPM, True, place,
                        Crossing(bracket(begin - 5, begin)), ends, again, nominal_engine_speed=begin * RPM)  # fmt: skip
    return replace(row, **more)


def sweep(*rows: CriticalSpeed, runs: tuple[Solution, ...] = ()) -> Study:
    swept = runs or (run(4000), run(8000))
    return Study(CaseRecord("own"), "sweep", swept, critical_speeds=CriticalSpeeds(rows))


SURGE = {"cause": CAUSE_SURGE, "spring_force_loss": 54.6, "surge_order": 6}


def test_a_short_range_of_lost_contact_is_named_and_does_not_end_control():
    """40 rpm in which contact is lost for a moment made it "controlled to 5218 rpm"."""
    first = train_study().solutions[0]
    open_wide = float(first.cam_angle[np.argmax(first.channel("valve_lift"))])
    inertia = Event("loft", open_wide, 0.0, 1e-3, 1e-4, "m", "cam", {"cause": CAUSE_INERTIA})
    runs = (run(4000), run(6250, events=(inertia,), loss_of_contact_duration=1e-3), run(8000))
    found = lost("contact-loss", 5218, 5258, bracket(6100, 8000), **SURGE)
    study = sweep(found, lost("float", 6917), runs=runs)
    assert study.verdict.startswith(
        "Controlled to 6100 rpm, where contact is lost at the cam because inertia exceeds the spring force at 6250 rpm, apart from "
        "5218 to 5258 rpm, where contact is lost at the cam because surge lowers the spring force by 54.6 N there (order 6); "
        "floats from 6917 rpm; contact opens at 180 cam deg (run at 6250 rpm)."
    )
    assert controlled_to(study, LABEL) == pytest.approx(6100 * RPM)
    bars = {layer.name: layer.x for layer in regime_chart(study).panels[1].layers}
    assert bars["controlled"][np.isfinite(bars["controlled"])] == pytest.approx([4000, 5218, 5258, 6100])  # fmt: skip
    alone = sweep(lost("contact-loss", 5218, 5258, **SURGE))
    assert alone.verdict.startswith(
        "Controlled up to 8000 rpm, the highest speed searched, apart from 5218 to 5258 rpm, where contact is lost at the cam "
        "because surge lowers the spring force by 54.6 N there (order 6), minimum cam force 40 N."
    )


@pytest.mark.parametrize(
    "rows",
    [
        (lost("contact-loss", 5218, 5400, bracket(6100, 8000)),),  # 3.5 % wide
        (lost("contact-loss", 5218, 5258, bracket(6100, 8000)), lost("float", 5230, 5240)),
        (lost("contact-loss", 5218, 5258, bracket(6100, 8000)), lost("bounce", 5000)),
        (lost("contact-loss", 5218, 5258, *(bracket(at, at + 20) for at in (5400, 5600, 6100))),),
        (lost("contact-loss", 7980),),  # up to the last speed searched
        (lost("bounce", 5218, 5258),),
    ],
)
def test_what_is_wide_or_floats_or_bounces_or_comes_often_ends_control(rows):
    begin = min(one.engine_speed for one in rows)
    study = sweep(*rows)
    assert controlled_to(study, LABEL) == pytest.approx(begin) and not control_of(study, LABEL).islands  # fmt: skip
    assert study.verdict.startswith(f"Controlled to {begin / RPM:.0f} rpm, ")


def test_a_short_range_below_two_motions_ends_control():
    """Contract: "controlled to 7300 rpm apart from 6200" stood above a loss that falling speed regains at 6190 alone."""
    ways = Crossing(bracket(6195, 6200), bracket(7290, 7300), bracket(6190, 6200))
    found = replace(lost("contact-loss", 6200, 6210, bracket(7300, 8000)), begins=ways)
    said = sweep(found).verdict
    assert said.startswith(
        "Controlled to 6200 rpm, where contact is lost at the cam, until 6210 and again from 7300 rpm; from 6190 to 7300 rpm both "
        "motions exist: rising speed keeps control, falling speed does not regain it"
    )
    narrow = replace(found, begins=replace(ways, rising=bracket(6210, 6220)))
    assert sweep(narrow).verdict.startswith("Controlled to 7300 rpm,") and "both motions" not in sweep(narrow).verdict  # fmt: skip


def test_extremes_are_those_of_the_speeds_in_use_and_then_those_beyond():
    """Contract: the surge and the largest stress were those of 8000 rpm, where nobody runs the engine."""
    runs = tuple(
        run(speed, surge_amplitude_force=surge, open_nominal_shear_stress=surge * 1e7)
        for speed, surge in ((4000, 40.0), (6000, 50.0), (8000, 90.0))
    )
    study = sweep(lost("contact-loss", 7000), runs=runs)
    assert "Worst surge amplitude 50 N at 6000 rpm, beyond control 90 N at 8000 rpm" in study.verdict  # fmt: skip
    told = dict(key_figures(study))
    assert told["shear stress"] == "500 MPa at 6000 rpm (beyond control 900 MPa at 8000 rpm)"
    row = next(one for one in headline_rows(study) if one.name == "surge_amplitude_force")
    assert row.values == (50.0,) and row.beyond is not None
    assert (row.beyond.label, row.beyond.values) == ("beyond control", (90.0,))
    line = replace(study, record=replace(study.record, red_line=6500 * RPM))
    assert dict(key_figures(line))["shear stress"] == "500 MPa at 6000 rpm (beyond the red line 900 MPa at 8000 rpm)"  # fmt: skip


def test_a_range_says_what_it_is_over_and_is_rounded_outwards():
    """It was "with other damping or division", 8106 where the table had 8105."""
    members = RangeMember("model", "own", 6400.4 * RPM), RangeMember("mesh", "×1.5", 7000.2 * RPM)
    said = sweep(lost("contact-loss", 7000, members=members)).verdict
    assert "(6400 to 7001: model, mesh)" in said
    members = RangeMember("damping", "×0.6", 6400 * RPM), RangeMember("model", "own", math.inf)
    never = sweep(lost("contact-loss", 7000, members=members)).verdict
    assert "(6400 to above 8000: damping, model)" in never and "never" not in never


def test_speeds_of_which_nothing_is_known_are_said_beside_control():
    """Ends that would pull between the speeds of a sweep left "controlled up to 8000 rpm" alone."""
    never = CriticalSpeed(LABEL, "contact-loss", 0.0, 4000 * RPM, 8000 * RPM, 10 * RPM)
    said = sweep(replace(never, pulled=(bracket(6340, 6450),))).verdict
    assert "6340 to 6450" in said and "6340" not in sweep(never).verdict


def test_ends_that_would_lift_are_said_where_they_do():
    """ "From 6500 rpm" rested on the one resonance that was run there."""
    pull = (Event("end-pull", 4.0, 0.01, 1e-3, 0.0, "N", "retainer"),)
    some = sweep(runs=(run(6000), run(6500, events=pull), run(7000), run(7500)))
    assert " At 6500 rpm the ends of the spring would lift" in some.verdict
    many = [run(speed, events=pull if speed > 6000 else ()) for speed in range(6000, 8000, 250)]
    assert " From 6250 to 7750 rpm the ends of the spring would lift" in sweep(runs=tuple(many)).verdict  # fmt: skip


def test_the_ranges_of_a_search_are_narrowed_up_to_the_first_that_is_long():
    """The speeds of a sweep made the width of a range above the first one."""

    def margin(speed: float) -> float:
        short = 5018 < speed < 5060 or 5490 < speed < 5530
        return -1.0 if short or 6512 < speed < 7333 else 100.0

    def at(speed: float, orbit: object = None) -> SpeedSample:
        value = margin(speed / RPM)
        return SpeedSample({"contact-loss": max(value, 0.0)}, {"contact-loss": "cam"}, None, {"contact-loss": value})  # fmt: skip

    swept = (4000, 4500, 5040, 5300, 5500, 6000, 6600, 7000, 8000)
    options = CriticalOptions()
    search = Search(at, {one * RPM: at(one * RPM) for one in swept}, options.limits, 10 * RPM)
    row = critical_speed(search, "contact-loss", LABEL, 4000 * RPM, 8000 * RPM, options)
    first, second = row.again
    assert first.lower_engine_speed / RPM == pytest.approx(5495, abs=5.5)
    assert first.upper_engine_speed / RPM == pytest.approx(5525, abs=5.5)
    assert second.lower_engine_speed / RPM == pytest.approx(6517, abs=5.5)
    study = sweep(replace(row, nominal_engine_speed=row.begins.from_rest.upper_engine_speed))
    assert controlled_to(study, LABEL) == second.lower_engine_speed


def test_a_pair_says_which_of_its_springs_binds_first():
    """The clearance of both was named without the spring that has it."""
    names = {"coil_bind_clearance": 1.3e-4, "outer_coil_bind_clearance": 3.6e-3, "inner_coil_bind_clearance": 1.3e-4}  # fmt: skip
    said = Study(CaseRecord("own"), "run", (run(6000, **names),)).verdict
    assert "only 0.13 mm clear of coil bind (inner spring first)" in said.lower()
    outer = {name: value for name, value in names.items() if "inner" not in name}
    alone = Study(CaseRecord("own"), "run", (run(6000, **outer | {"coil_bind_clearance": 3.6e-3}),))
    assert "lear of coil bind by 3.6 mm (outer spring; the other is not checked)" in alone.verdict
    assert bind_clearances((), 0.01) == {}


def two(light: dict[str, float], heavy: dict[str, float], *rows: CriticalSpeed) -> Study:
    runs = tuple(run(speed, name, **values) for name, values in (("light", light), ("heavy", heavy)) for speed in (4000, 8000))  # fmt: skip
    return Study(CaseRecord("own"), "compare-springs", runs, critical_speeds=CriticalSpeeds(rows))


@pytest.mark.parametrize(("share", "tells"), [(1.01, False), (1.04, False), (1.08, True)])
def test_a_small_difference_of_stress_does_not_tell_which_breaks_first(share, tells):
    """One per cent of stress amplitude was "so of equal wires it breaks first"."""
    stress = {
        "open_nominal_shear_stress": 900e6,
        "closed_nominal_shear_stress": 300e6,
        "minimum_spring_force": 200.0,
        "peak_spring_force": 600.0,
    }
    more = {name: value * (share if "stress" in name else 1.0) for name, value in stress.items()}
    said = two(stress, more).verdict
    assert ("heavy is stressed more, so of equal wires it breaks first" in said) == tells
    assert ("stress does not show which breaks first (amplitude" in said.lower()) != tells


def test_speeds_behind_ends_that_would_lift_are_doubtful_from_the_first_word():
    """Contract: "controlled to 7000 rpm" stood firm, two sentences before the model was doubted at 6500."""
    pull = (Event("end-pull", 4.0, 0.01, 1e-3, 0.0, "N", "retainer"),)
    runs = (run(6000), run(6500, events=pull), run(7500))
    said = sweep(lost("contact-loss", 7000), runs=runs).verdict
    assert said.startswith("Doubtful where ends of the spring would lift (at 6500 rpm): controlled to 7000 rpm")  # fmt: skip
    beyond = (run(6000), run(6500), run(7500, events=pull))
    assert sweep(lost("contact-loss", 7000), runs=beyond).verdict.startswith("Controlled to 7000")
