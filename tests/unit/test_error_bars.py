"""Bars in the cells of the terminal: whose they are, when they are left out, and how they give way
to a narrow table.
"""

from __future__ import annotations

from dataclasses import replace

import pytest

from synthetic_study import train_run, train_study
from valvetrain.cli.answers import show_study
from valvetrain.cli.outcome import output_console
from valvetrain.cli.published import NARROW, RESTS, ErrorBars, fitting
from valvetrain.report.headlines import HeadlineColumn, HeadlineRow
from valvetrain.solution.uncertainty import ErrorBars as StudyBars
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


@pytest.mark.parametrize(("wide", "between"), [(NARROW, " "), (NARROW + 2, ""), (NARROW + 4, None)])
def test_bars_stand_closer_in_a_table_of_eighty_columns_and_never_give_way(wide, between):
    """Contract: trains of four labels lost them; None lets the table be parted."""
    chosen = fitting(
        bars("peak_spring_force", 965.0, 2.0),
        lambda one: wide - {" ": 0, "": 2}[one.between] if one.rows else NARROW,
    )
    assert (chosen and chosen.between) == between


def test_four_trains_side_by_side_keep_their_bars(tmp_path, monkeypatch):
    """Contract: 0.208 ± 0.21 ms stood without its bar beside labels that fill the width."""
    labels = [f"performance with a name, zeta {number}" for number in range(4)]
    runs = [train_run(label=one) for one in labels]
    value = runs[0].quantities["peak_retainer_force"]
    name, speed, same = "peak_retainer_force", runs[0].engine_speed, (value, value)
    rows = [
        Uncertainty(name, speed, value, 2.0, None, value, 0.0, same, same, one) for one in labels
    ]
    study = replace(train_study(), solutions=tuple(runs), error_bars=StudyBars(tuple(rows)))
    console = output_console()
    with console.capture() as told:
        show_study(console, study, tmp_path, None)
    assert told.get().count("±") == 4


def test_a_range_stands_below_its_value_and_a_mark_where_none_was_computed():
    """Contract: both were in JSON and on the page alone."""
    value = bars("peak_clash_force", 988.0, 2.0).rows["peak_clash_force"][0]
    clash = row("peak_clash_force", 988.0)
    ranged = ErrorBars({"peak_clash_force": [replace(value, contact_stiffness=(979.0, 989.0))]})
    assert ranged.ranges(clash, (STOCK,)) == ["979 to 989"]
    assert "1" in ranged.legend([clash], (STOCK,)) and RESTS not in ranged.cells(clash, (STOCK,))[0]
    bare = ErrorBars({"peak_clash_force": [value]})
    assert bare.ranges(clash, (STOCK,)) == [""] and RESTS in bare.cells(clash, (STOCK,))[0]
    assert bare.legend([clash], (STOCK,))
    smooth = row("peak_spring_force", 965.0)
    held = bars("peak_spring_force", 965.0, 2.0)
    assert RESTS not in held.cells(smooth, (STOCK,))[0] and not held.legend([smooth], (STOCK,))


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
