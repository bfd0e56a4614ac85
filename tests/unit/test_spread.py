"""What the calibration data leave open: the file that ships belongs to its case, and speaks of nothing else."""

from __future__ import annotations

import math

import pytest

from valvetrain.parameters.loading import load_case
from valvetrain.runs.stored_error_bars import load_uncertainty, spread_facts, stored_rows
from valvetrain.solution.channels import empty_channels
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.quantity import same_speed
from valvetrain.solution.result import Solution

RPM = math.pi / 30
SPEEDS = tuple(speed * RPM for speed in (4200.0, 5600.0, 8000.0))


@pytest.fixture(scope="module")
def case():
    return load_case("gu2021-beehive-blind")


def own_runs(case, speeds=SPEEDS, **changed: float) -> list[Solution]:
    """The runs that were refined, as this version gives them; ``changed``: quantity -> factor on it
    at 8000 rpm.
    """
    runs = []
    for speed in speeds:
        rows = [
            row for row in load_uncertainty(case.record()) if same_speed(row.engine_speed, speed)
        ]
        factors = changed if speed == SPEEDS[2] else {}
        numbers = {row.quantity: row.value * factors.get(row.quantity, 1.0) for row in rows}
        word = "finite-element"
        origin = Provenance(case.name, word, label=word, engine_speed=speed)
        runs.append(Solution(empty_channels(), quantities=numbers, provenance=origin))
    return runs


def test_every_range_is_in_order_and_holds_what_the_case_computes(case):
    """The case lies at the most probable point of its own posterior: between 5 and 95 % in nearly
    all quantities.
    """
    runs = own_runs(case)
    spread = [one.fields for one in spread_facts(case.record(), runs)]
    assert {round(one["engine_speed"] / RPM) for one in spread} == {4200, 5600, 8000}
    assert all(one["low"] <= one["high"] for one in spread)
    compared = [
        (one, run.quantities[one["quantity"]])
        for one in spread
        for run in runs
        if same_speed(run.engine_speed, one["engine_speed"]) and one["quantity"] in run.quantities
    ]
    inside = [one["low"] <= value <= one["high"] for one, value in compared]
    assert len(inside) > 10 and sum(inside) >= 0.85 * len(inside)


def test_every_range_is_a_fact_of_the_speeds_that_ran(case):
    some = spread_facts(case.record(), own_runs(case, SPEEDS[1:2]))
    assert some and set(speeds_of(some)) == {5600}


def speeds_of(facts):
    return [round(one.fields["engine_speed"] / RPM) for one in facts]


@pytest.mark.parametrize(
    "change",
    [
        {"lift_law.maximum_lift": "9.4 mm"},
        {"spring.damping.ratio": 0.02},
        {"spring.material.youngs_modulus": "210 GPa"},
        {"spring.options.finite-element.elements_per_coil": 30},
        {"spring.wire_diameter": "3.8 mm"},
        {"spring.mean_diameter.values": "21.7, 21.7, 17.6 mm"},
        {"spring.precompression": "6.9 mm"},
        {"operation.cycles": 3},
        {"spring.contact.stiffness": "4e4 N/mm/mm"},
    ],
    ids=lambda change: next(iter(change)),
)
def test_no_sentence_survives_a_change_of_the_case(case, change):
    other = load_case("gu2021-beehive-blind", change).record()
    assert not spread_facts(other, own_runs(case))


def test_no_sentence_survives_a_version_that_computes_other_numbers(case):
    """The words of the case are the same, the numbers are not: speeds at which they came out again
    are still told.
    """
    record, moved = case.record(), own_runs(case, stage_2_peak_force=1.05)
    of_runs = [row for row in load_uncertainty(record) if row.engine_speed is not None]
    assert sum(map(len, stored_rows(record, own_runs(case)).values())) == len(of_runs)
    assert set(speeds_of(spread_facts(record, moved))) == {4200, 5600}
