"""Every number that the pushrod study prints, and what of the valve-gear paper can be computed,
with honest tolerances.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from validation.explained import BANDS
from validation.sources import rows_of

from book_page import assert_page_holds
from valvetrain.parameters.loading import load_case
from valvetrain.quantities.kinematics import rigid_table
from valvetrain.runs.api import simulate, sweep
from valvetrain.runs.requests import Run
from valvetrain.runs.run import run_problem
from valvetrain.system.build import build

RPM = math.pi / 30


@pytest.fixture(scope="module")
def pushrod():
    case = load_case("tdi-pushrod")
    return simulate(case, spring_sets=("as printed",), workers=1)


@pytest.fixture(scope="module")
def valve_gear():
    """The study of the case without its finite elements, which take most of its time."""
    problem = build(load_case("vaz-ohc"))
    cheap = replace(
        problem, members=tuple(one for one in problem.members if one.model.word != "finite-element")
    )
    return run_problem(cheap, problem.engine_speeds, Run(case=load_case("vaz-ohc"), workers=1))


def computed(study, name):
    (row,) = [row for row in study.comparisons if row.quantity == name]
    return row.computed


def test_springs_of_the_table_have_the_printed_rates():
    train = load_case("tdi-pushrod").train
    assert train.spring_parts("stock")[0].card.rate == pytest.approx(
        21470, abs=5
    )  # printed with two decimals of N/mm
    assert train.spring_parts("performance")[0].card.rate == pytest.approx(30880, abs=5)


def test_every_published_number_is_met_or_its_miss_is_explained_and_the_book_says_so(pushrod):
    rows = rows_of("pushrod train", "multibody4b17", pushrod.comparisons)
    assert len(rows) == 8 and not [row.name for row in rows if row.status == "FAILS"]
    assert_page_holds(rows)
    assert not [row.name for row in rows if row.within and row.band is not None]
    assert {name for band in BANDS.values() for name in band if "(as printed)" in name} <= {
        row.name for row in rows
    }


def test_what_the_published_numbers_were_used_for(pushrod):
    """What shaped the case is no prediction: the ratio of the arms, springs without their seat
    load, the lift law.
    """
    used = {row.quantity for row in pushrod.comparisons if row.role == "calibration"}
    nose = {"stock_nose_cam_contact_force", "performance_nose_cam_contact_force"}
    assert used == nose | {
        "stock_peak_valve_lift",
        "peak_lever_speed_valve_lift",
    }
    assert all(row.used_for for row in pushrod.comparisons if row.role == "calibration")


def test_printed_contact_forces_are_those_of_springs_without_seat_load(pushrod):
    """rate x 8 mm x ratio 1.6 is 275 and 395 N; weight and inertia of an unknown profile explain up
    to 5 %.
    """
    assert computed(pushrod, "stock_nose_cam_contact_force") == pytest.approx(283, rel=0.05)
    assert computed(pushrod, "performance_nose_cam_contact_force") == pytest.approx(400, rel=0.05)
    # at the nose the valve stands still, so that its damper adds nothing to the 395 N
    damped = pushrod.solution("performance, as printed, zeta 1").quantities
    assert damped["nose_cam_contact_force"] == pytest.approx(395, rel=0.02)
    # its peak, which the print's 412 N are stated as, is twice that: c v = 388 N at the valve, off the nose
    assert computed(pushrod, "performance_damped_peak_cam_contact_force") == pytest.approx(
        828, rel=0.02
    )
    assert computed(pushrod, "contact_force_rise_ratio") == pytest.approx(0.4, abs=0.05)


def test_with_the_seat_load_the_forces_are_those_of_statics(pushrod):
    """(preload + rate x 8 mm) x 1.6: 588 and 944 N, less what contact compliance takes off the lift
    and weight.
    """
    for label, force in (("stock", 588.0), ("performance", 944.0)):
        assert pushrod.solution(label).quantities["nose_cam_contact_force"] == pytest.approx(
            force, rel=0.03
        )


def test_lift_and_rocker_speed(pushrod):
    assert computed(pushrod, "stock_peak_valve_lift") == pytest.approx(8e-3, rel=0.02)
    assert computed(pushrod, "peak_lever_speed_valve_lift") == pytest.approx(4e-3, rel=0.02)
    # 384 deg/s is a misprint or another quantity: the ratio to any usual arm is seven and more
    assert np.degrees(computed(pushrod, "peak_lever_speed")) > 5 * 384


def test_all_runs_of_both_cases_settle(pushrod, valve_gear):
    for study in (pushrod, valve_gear):
        assert study.solutions and not study.failures
        for run in study.solutions:
            assert run.status.completed, f"{run.label}: {run.status.sentence()}"
            assert run.quantities["motion_period_count"] == 1


def test_claims_of_both_sources(pushrod, valve_gear):
    """The stiffer spring loses more lift and raises the force by more than 40 %; the damper is not the cause of
    412 N. Six masses and rods differ more in the second half, and one mass per spring is far off.
    """
    assert {item.place: item.verdict for item in pushrod.findings} == {
        "section 7": "not seen",
        "section 5.2": "agrees",
        "section 6": "not seen",
    }
    assert [item.verdict for item in valve_gear.findings] == ["agrees"] * 4


def test_lash_is_taken_from_the_lift(valve_gear):
    lifts = [
        valve_gear.solution(f"rod, lash {lash}").quantities["peak_rigid_valve_lift"]
        for lash in ("0 mm", "0.1 mm")
    ]
    assert lifts[0] - lifts[1] == pytest.approx(1e-4, rel=1e-6)
    assert lifts[0] == pytest.approx(9.7e-3, rel=1e-6)  # between the two loads of the manual


def test_rod_and_chain_of_many_masses_are_the_same_spring():
    """In a train, too, the chain runs into the rod as its masses multiply."""
    case = load_case("vaz-ohc")
    train = case.train

    def spring_force(word, **options):
        parts = tuple(
            part.with_options(word, **options) for part in train.spring_parts("nested-cards")
        )
        changed = case.replace(
            train=train.replace(springs={**train.springs, "nested-cards": parts})
        )
        return (
            simulate(changed, models=(word,), spring_sets=("nested-cards",), workers=1)
            .solution(word)
            .channel("retainer_force")
        )

    rod = spring_force("wave-rod")
    gaps = [
        np.sqrt(np.mean((spring_force("multi-mass", elements=elements) - rod) ** 2))
        for elements in (5, 20, 80)
    ]
    assert gaps[1] < 0.4 * gaps[0] and gaps[2] < 0.5 * gaps[1]
    assert gaps[2] < 2.0  # N, of 720


@pytest.mark.slow
def test_contact_is_lost_at_the_speed_of_rigid_theory_and_later_with_the_stiffer_spring():
    case = load_case("tdi-pushrod")
    for chosen, speeds in (
        ("stock", (6900, 7100, 7200, 7900, 8000)),
        ("performance", (8700, 8900, 9050, 9900, 10000)),
    ):
        study = sweep(
            case,
            [speed * RPM for speed in speeds],
            models=("massless",),
            spring_sets=(chosen,),
            workers=1,
        )
        control, rigid = (
            study.still["massless"],
            study.still[chosen]["rigid_contact_loss_engine_speed"],
        )
        assert not study.failures
        assert control["contact_loss_engine_speed"] == pytest.approx(rigid, rel=0.01)
        assert speeds[1] * RPM < rigid < speeds[2] * RPM
        assert speeds[2] * RPM < control["float_engine_speed"] <= speeds[3] * RPM
        if chosen == "stock":
            assert rigid / RPM == pytest.approx(
                7148, abs=2
            )  # golden: moves when case or kinematics move


def test_a_case_changes_spring_and_contact_by_one_word():
    case = load_case("tdi-pushrod")
    assert [
        member.model.word
        for member in build(case, spring_models=("wave-rod", "modal-uniform")).members
    ] == [
        "wave-rod",
        "modal-uniform",
    ]
    flores = case.train.contact("cam").replace(
        law="hertz-point", values={"contact_stiffness": 3.16e9}
    )
    changed = case.replace(
        train=case.train.replace(contacts={**case.train.contacts, "cam": flores})
    )
    (member,) = build(changed, spring_models=("massless",)).members
    table = rigid_table(member.system(), member.gear.parameters, 2000 * RPM)
    assert table["contact_force"].max() == pytest.approx(588, rel=0.03)
    one = simulate(changed, models=("wave-rod",), workers=1)
    assert one.solutions and not one.failures
