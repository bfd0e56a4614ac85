"""Every verdict is made to be right once and wrong once."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from valvetrain.quantities.compare import compare, verdict
from valvetrain.runs.stored_error_bars import belongs
from valvetrain.solution.quantity import Quantity, same_speed
from valvetrain.solution.uncertainty import Uncertainty

DEG = np.pi / 180


def given(
    value: float, quantity: str = "peak_spring_force", unit: str = "N", **more
) -> SimpleNamespace:
    known = {
        "model": "m",
        "role": "prediction",
        "engine_speed": 100.0,
        "source": "s",
        "tolerance": None,
        "relation": "equal",
        "used_for": "",
        "doubt": "",
        "reading": "",
    }
    return SimpleNamespace(quantity=quantity, value=value, unit=unit, **(known | more))


@pytest.mark.parametrize(
    ("value", "difference", "words"),
    [
        (given(800.0, tolerance=24.0), 24.0, "within tolerance"),
        (given(800.0, tolerance=24.0), -24.0, "within tolerance"),
        (given(800.0, tolerance=24.0), 24.8, "misses by +3.1 %, tolerance 3.0 %"),
        (given(800.0, tolerance=24.0), -40.0, "misses by -5.0 %, tolerance 3.0 %"),
        (given(-800.0), -80.0, "differs by -10.0 %"),
        (given(800.0), 0.0, "differs by +0.0 %"),
        (given(800.0, relation="at-most"), 40.0, "stated as at most: beyond by 5.0 %"),
        (given(800.0, relation="at-most"), -40.0, "stated as at most: -5.0 %"),
        (given(800.0, relation="at-least"), 40.0, "stated as at least: +5.0 %"),
        (given(800.0, relation="at-least"), -40.0, "stated as at least: beyond by 5.0 %"),
        (
            given(2.0, "peak_spring_force_cam_angle", "deg", tolerance=2 * DEG),
            3 * DEG,
            "misses by +3.0 deg, tolerance 2.0 deg",
        ),
        (
            given(2.0, "peak_spring_force_cam_angle", "deg", tolerance=4 * DEG),
            3 * DEG,
            "within tolerance",
        ),
        (given(0.0, "coil_bind_clearance", "mm"), 2e-5, "differs by +0.02 mm"),
        (given(800.0), None, "not computed"),
        (
            given(800.0, doubt="misprint", tolerance=24.0),
            -40.0,
            "in doubt, misprint: differs by -5.0 %",
        ),
    ],
)
def test_a_published_value_is_judged_by_what_it_states(value, difference, words):
    assert verdict(value, difference) == words


def test_a_difference_is_computed_less_published_and_angles_go_round_the_circle():
    computed = {
        Quantity("peak_spring_force", 100.0, "m"): 790.0,
        Quantity("peak_spring_force_cam_angle", 100.0, "m"): 358 * DEG,
        Quantity("clash_interval_cam_angle", 100.0, "m"): 300 * DEG,
    }
    values = [
        given(800.0),
        given(1 * DEG, "peak_spring_force_cam_angle", "deg"),
        given(20 * DEG, "clash_interval_cam_angle", "deg"),
    ]
    rows = compare(values, computed, None)
    assert [row.difference for row in rows] == pytest.approx([-10.0, -3 * DEG, 280 * DEG])
    assert [row.computed for row in rows] == pytest.approx([790.0, 358 * DEG, 300 * DEG])
    assert rows[0].relative_difference == pytest.approx(-10 / 800)
    assert [row.computed for row in compare([replace_speed(values[0], 200.0)], computed, None)] == [
        None
    ]
    assert [row.computed for row in compare(values[:1], computed, {"m": "other"})] == [None]


def replace_speed(value: SimpleNamespace, engine_speed: float) -> SimpleNamespace:
    return SimpleNamespace(**{**vars(value), "engine_speed": engine_speed})


@pytest.mark.parametrize(
    ("value", "numerical", "speed", "label", "same"),
    [
        (811.0, 0.0, 100.0, "finite-element", True),
        (811.8, 0.0, 100.0, "finite-element", True),
        (812.0, 0.0, 100.0, "finite-element", False),
        (810.0, 0.0, 100.0, "finite-element", False),
        (812.0, 1.1, 100.0, "finite-element", True),
        (809.8, 1.1, 100.0, "finite-element", False),
        (811.0, 0.0, 101.0, "finite-element", False),
        (811.0, 0.0, 100.0, "modal-varied", False),
        (811.0, 0.0, None, "finite-element", False),
    ],
)
def test_a_stored_uncertainty_belongs_to_the_number_it_was_found_for(
    value, numerical, speed, label, same
):
    row = Uncertainty(
        "peak_spring_force",
        100.0,
        811.0,
        numerical,
        2.0,
        811.0,
        0.0,
        (811.0, 811.0),
        (811.0, 811.0),
        "finite-element",
    )
    assert belongs(row, {Quantity("peak_spring_force", speed, label): value}) is same
    assert not belongs(row, {Quantity("minimum_spring_force", 100.0, ""): 811.0})


def test_two_speeds_are_one_where_only_rounding_parts_them():
    speed = 5600 * np.pi / 30
    assert same_speed(speed, speed * (1 + 1e-9)) and same_speed(None, None)
    assert (
        not same_speed(speed, speed * 1.001)
        and not same_speed(speed, None)
        and not same_speed(None, speed)
    )
