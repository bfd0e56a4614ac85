"""Bars in the cells of the terminal: whose they are, and when they are left out."""

from __future__ import annotations

import pytest

from valvetrain.cli.published import ErrorBars
from valvetrain.report.headlines import HeadlineColumn, HeadlineRow
from valvetrain.solution.uncertainty import Uncertainty

SPEED = 418.879
STOCK, OTHER = HeadlineColumn("stock", SPEED), HeadlineColumn("other", SPEED)


def row(name: str, *values):
    return HeadlineRow("", name, "words", "", values, (None,) * len(values))


def bars(name: str, value: float, numerical: float, label: str = "stock") -> ErrorBars:
    return ErrorBars(
        {
            name: [
                Uncertainty(
                    name,
                    SPEED,
                    value,
                    numerical,
                    None,
                    value,
                    0.0,
                    (value, value),
                    (value, value),
                    label,
                )
            ]
        }
    )


def test_a_bar_stands_beside_its_own_number_in_its_own_unit():
    held = bars("seating_velocity", 0.3405, 0.0153)
    assert held.cells(row("seating_velocity", 0.3405, 0.3405), (STOCK, OTHER)) == [
        "0.3405 ± 0.015",
        "0.3405",
    ]
    assert bars("bounce_height", 1.5e-4, 2.5e-5).cells(row("bounce_height", 0.15), (STOCK,)) == [
        "0.15 ± 0.025"
    ]
    rod = HeadlineColumn("finite-element", SPEED)
    assert bars("peak_spring_force", 965.0, 2.0, "finite-element").cells(
        row("peak_spring_force", 965.0, None, 965.0), (rod, rod, STOCK)
    ) == ["965 ± 2", "–", "965"]


@pytest.mark.parametrize(
    ("value", "numerical", "speed"),
    [(965.0, 0.04, SPEED), (970.0, 2.0, SPEED), (965.0, 2.0, 300.0), (0.0, 2.0, SPEED)],
)
def test_no_bar_of_another_number_and_none_that_moves_no_digit(value, numerical, speed):
    held = bars("peak_spring_force", 965.0, numerical)
    assert (
        "±" not in held.cells(row("peak_spring_force", value), (HeadlineColumn("stock", speed),))[0]
    )


@pytest.mark.parametrize(
    ("value", "numerical", "words"),
    [
        (965.0, 0.051, "965 ± 0.051"),
        (965.0, 0.049, "965"),
        (9.65, 6e-4, "9.65 ± 0.0006"),
        (9.65, 4e-4, "9.65"),
        # Half of the last of four digits of 0.5 is 0.00005; bars below 0.0001 are left out all the
        # same.
        (0.5, 1.1e-4, "0.5 ± 0.00011"),
        (0.5, 9e-5, "0.5"),
        (0.5, 6e-5, "0.5"),
        (-965.0, 0.051, "-965 ± 0.051"),
    ],
)
def test_a_bar_moves_the_fourth_digit_and_is_a_ten_thousandth_at_least(value, numerical, words):
    (cell,) = bars("peak_spring_force", value, numerical).cells(
        row("peak_spring_force", value), (STOCK,)
    )
    assert cell.replace("−", "-") == words
