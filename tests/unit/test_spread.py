"""What the calibration data leave open: the file that ships belongs to its case, and speaks of nothing else."""

from __future__ import annotations

import math

import pytest

from valvetrain.parameters.loading import load_case
from valvetrain.runs.stored_error_bars import (
    SPREAD_LABELS,
    Spread,
    load_spread,
    load_uncertainty,
    rows_that_hold,
    spread_sentences,
    spread_sentences_of,
    uncertainty_sentences,
)
from valvetrain.solution.provenance import PublishedValue
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
    spread, numbers = load_spread(case.record()), own_numbers(case)
    assert {one.engine_rpm for one in spread} == {4200, 5600, 8000}
    assert all(one.low <= one.middle <= one.high for one in spread)
    compared = [
        (one, value)
        for one in spread
        for key, value in numbers.items()
        if key.name == one.quantity and same_speed(key.engine_speed, one.engine_rpm * RPM)
    ]
    inside = [one.low <= value <= one.high for one, value in compared]
    assert len(inside) > 10 and sum(inside) >= 0.85 * len(inside)


def test_one_sentence_a_speed_with_the_published_value_inside_or_outside(case):
    sentences = spread_sentences(case.record(), SPEEDS, own_numbers(case))
    assert [sentence.split(",")[0] for sentence in sentences] == [
        "4200 rpm",
        "5600 rpm",
        "8000 rpm",
    ]
    spread = {(one.engine_rpm, one.quantity): one for one in load_spread(case.record())}
    published = {
        (round(value.engine_speed / RPM), value.quantity): value.value
        for value in case.published
        if value.engine_speed is not None and value.model == "solid finite elements"
    }
    told = 0
    for (rpm, quantity), one in spread.items():
        if quantity in SPREAD_LABELS and (rpm, quantity) in published:
            (sentence,) = [sentence for sentence in sentences if sentence.startswith(f"{rpm} rpm")]
            (part,) = [part for part in sentence.split("; ") if SPREAD_LABELS[quantity] in part]
            assert (
                ("inside" in part)
                == (one.low <= published[rpm, quantity] <= one.high)
                != ("outside" in part)
            )
            told += 1
    assert told >= 8
    assert spread_sentences(case.record(), SPEEDS[1:2], own_numbers(case)) == sentences[1:2]


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
    ],
    ids=lambda change: next(iter(change)),
)
def test_no_sentence_survives_a_change_of_the_case(case, change):
    other = load_case("gu2021-beehive-blind", change).record()
    assert load_spread(other) == () and spread_sentences(other, SPEEDS, own_numbers(case)) == ()
    assert uncertainty_sentences(other, SPEEDS, own_numbers(case)) == ()


def test_no_sentence_survives_a_contact_that_is_changed(case):
    from valvetrain.parameters.case import CoilContact

    (spring,) = case.springs
    stiff = case.replace(
        {"springs.0.contact": CoilContact(stiffness=2 * spring.contact.stiffness)}
    ).record()
    assert (
        load_spread(stiff) == () and uncertainty_sentences(stiff, SPEEDS, own_numbers(case)) == ()
    )


def test_no_sentence_survives_a_version_that_computes_other_numbers(case):
    """The words of the case are the same, the numbers are not: speeds at which they came out again
    are still told.
    """
    record, moved = case.record(), own_numbers(case, stage_2_peak_force=1.05)
    assert len(rows_that_hold(record, own_numbers(case))) == len(load_uncertainty(record))
    for sentences in (
        spread_sentences(record, SPEEDS, moved),
        uncertainty_sentences(record, SPEEDS, moved),
    ):
        assert [sentence.split(",")[0] for sentence in sentences] == ["4200 rpm", "5600 rpm"]


def test_every_told_range_stands_in_its_unit_beside_the_published_value_of_its_own_speed():
    """Forces in N, displacements in mm, three digits that count; values of another source, speed or
    quantity stand beside none.
    """
    rows = (
        Spread("stage_2_peak_force", 5600, 811.6, 820.0, 1234.4), Spread("stage_2_first_peak_force", 5600, 516.96, 804.0, 837.02),
        Spread("stage_2_second_peak_force", 5600, 833.3, 855.0, 903.2), Spread("stage_3_peak_force", 5600, 12345.0, 12400.0, 15678.0),
        Spread("node_2_maximum_displacement", 5600, 5.66e-5, 8.5e-5, 1.4946e-4), Spread("stage_1_minimum_force", 5600, 1.0, 2.0, 3.0),
    )  # fmt: skip

    def given(quantity, value, speed=5600.0, model="solid finite elements"):
        return PublishedValue(quantity, value, "N", engine_speed=speed * RPM, model=model)

    published = (
        given("stage_2_peak_force", 1000.0),
        given("stage_2_first_peak_force", 900.0),
        given("stage_3_peak_force", 13000.0, 8000.0),
        given("stage_2_second_peak_force", 850.0, model="analytical modal"),
        given("node_2_maximum_displacement", 1.2346e-4),
    )
    parts = (
        "Stage II peak force 812 to 1230 N (published 1000, inside)", "first Stage II peak 517 to 837 N (published 900, outside)",
        "second Stage II peak 833 to 903 N", "Stage III spike 12300 to 15700 N",
        "largest displacement of node 2 0.0566 to 0.149 mm (published 0.1235, inside)",
    )  # fmt: skip
    assert len(parts) == len(SPREAD_LABELS)
    (sentence,) = spread_sentences_of(rows, published, {5600, 8000})
    assert (
        sentence
        == f"5600 rpm, what the calibration data leave open (5 to 95 %): {'; '.join(parts)}."
    )
    assert spread_sentences_of(rows, published, {8000}) == ()
