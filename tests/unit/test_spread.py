"""What the calibration data leave open: the file that ships belongs to its case, and speaks of nothing else."""

from __future__ import annotations

import math

import pytest

from valvetrain.parameters.loading import load_case
from valvetrain.runs.stored_error_bars import load_uncertainty, rows_that_hold, spread_facts
from valvetrain.solution.quantity import Quantity, same_speed

RPM = math.pi / 30
SPEEDS = tuple(speed * RPM for speed in (4200.0, 5600.0, 8000.0))


@pytest.fixture(scope="module")
def case():
    return load_case("gu2021-beehive-blind")


def own_numbers(case, **changed: float) -> dict[Quantity, float]:
    """The numbers that were refined, as a run of this version gives them; ``changed``: quantity ->
    factor on it at 8000 rpm.
    """
    rows = load_uncertainty(case.record())
    factor = {
        row: changed.get(row.quantity, 1.0) if same_speed(row.engine_speed, SPEEDS[2]) else 1.0
        for row in rows
    }
    return {
        Quantity(row.quantity, row.engine_speed, "finite-element"): row.value * factor[row]
        for row in rows
    }


def test_every_range_is_in_order_and_holds_what_the_case_computes(case):
    """The case lies at the most probable point of its own posterior: between 5 and 95 % in nearly
    all quantities.
    """
    numbers = own_numbers(case)
    spread = [one.fields for one in spread_facts(case.record(), SPEEDS, numbers)]
    assert {round(one["engine_speed"] / RPM) for one in spread} == {4200, 5600, 8000}
    assert all(one["low"] <= one["high"] for one in spread)
    compared = [
        (one, value)
        for one in spread
        for key, value in numbers.items()
        if key.name == one["quantity"] and same_speed(key.engine_speed, one["engine_speed"])
    ]
    inside = [one["low"] <= value <= one["high"] for one, value in compared]
    assert len(inside) > 10 and sum(inside) >= 0.85 * len(inside)


def test_every_range_is_a_fact_of_the_speeds_that_ran(case):
    some = spread_facts(case.record(), SPEEDS[1:2], own_numbers(case))
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
    assert not spread_facts(other, SPEEDS, own_numbers(case))


def test_no_sentence_survives_a_version_that_computes_other_numbers(case):
    """The words of the case are the same, the numbers are not: speeds at which they came out again
    are still told.
    """
    record, moved = case.record(), own_numbers(case, stage_2_peak_force=1.05)
    assert len(rows_that_hold(record, own_numbers(case))) == len(load_uncertainty(record))
    assert set(speeds_of(spread_facts(record, SPEEDS, moved))) == {4200, 5600}
