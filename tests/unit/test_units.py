"""Units at the interface: exact conversions, dimensions kept apart, and refusals that say what to
write.
"""

from __future__ import annotations

import math
from decimal import Decimal

import numpy as np
import pint
import pytest

from valvetrain.errors import InputError, UnusualValueWarning
from valvetrain.units import (
    DIMENSIONS,
    PLAUSIBLE,
    dimension_of,
    format_quantity,
    parse_quantities,
    parse_quantity,
    si,
    si_each,
    si_speeds,
    to_unit,
    unit_factor,
)
from valvetrain.units.dimensions import DEFAULT
from valvetrain.units.text import dimension_powers

# Exact by definition (international inch, pound, standard gravity).
EXACT = [
    ("4.0 mm", "length", 4.0e-3),
    ("1 inch", "length", 0.0254),
    ("1 in", "length", 0.0254),
    ("1 thou", "length", 2.54e-5),
    ("1 lbf", "force", 4.4482216152605),
    ("1 lbf/in", "stiffness", 175.12683524647636),
    ("1 psi", "pressure", 6894.757293168361),
    ("41.3 N/mm", "stiffness", 41300.0),
    ("206 GPa", "modulus", 206e9),
    ("1 MPa", "pressure", 1e6),
    ("30.49 g", "mass", 0.03049),
    ("7850 kg/m^3", "density", 7850.0),
    ("7.85 g/cm³", "density", 7850.0),
    ("630 Hz", "frequency", 630.0),
    ("1/s", "damping rate", None),
    ("28 1/s", "damping rate", 28.0),
    ("49.92 N s/mm", "damping", 49920.0),
    ("2e4 N/mm/mm", "line stiffness", 2e10),
    ("1e5 N/mm^1.5", "N/m^1.5", 1e5 * 1e3**1.5),
    ("5.49e6 mm/s^2", "acceleration", 5490.0),
    ("41.6 us", "time", 4.16e-5),
    ("41.6 µs", "time", 4.16e-5),
    ("180 deg", "angle", math.pi),
    ("180°", "angle", math.pi),
    ("3/8 in", "length", 9.525e-3),
    ("-1 3/8in", "length", -34.925e-3),
    ("1.6 %", "ratio", 0.016),
    ("0.5", "ratio", 0.5),
    (7, "ratio", 7.0),
]


@pytest.mark.parametrize(
    ("text", "dimension", "expected"), [row for row in EXACT if row[2] is not None]
)
def test_known_conversions(text, dimension, expected):
    assert parse_quantity(text, dimension) == pytest.approx(expected, rel=1e-14)


def test_engine_speed_is_radians_per_second_of_the_crank():
    assert parse_quantity("4200 rpm", "angular speed") == pytest.approx(
        4200 / 60 * 2 * math.pi, rel=1e-15
    )


REFUSED = [
    (4.0, "length", "write '4.0 mm'"),
    ("4.0", "length", "write '4.0 mm'"),
    ("5 N", "length", "is a force, but a length is needed"),
    ("35 Hz", "angular speed", "is a frequency, but a rotational speed"),
    ("2100 rpm", "frequency", "is a rotational speed, but a frequency"),
    ("3 lb/in", "stiffness", "write '3 lbf/in' (lb and kg are masses, lbf and kgf forces)"),
    ("204 psi/in", "stiffness", "write '204 lbf/in' if the card means pounds of force"),
    ("73.55 psi", "force", "write '73.55 lbf' if the card means pounds of force"),
    ("800 g", "force", "write '800 gf'"),
    ("107 - 125 N", "force", "its middle '116 N'"),
    ("5 mmm", "length", "did you mean"),
    ("5 (mm)", "length", "cannot be read"),
    ("6000-8000 rpm", "angular speed", "a range is written first:last:step"),
    ("0,036 kg", "mass", "write the number with a point"),
    ("5 mm^9^9^9", "length", "cannot be read"),
    ("1e999 mm", "length", "not a finite number"),
    ("nan mm", "length", "not a number with a unit"),
    ("", "length", "not a number with a unit"),
    (True, "length", "not a number with a unit"),
    (None, "length", "not a number with a unit"),
    ([1], "length", "not a number with a unit"),
    (10**400, "ratio", "not a finite number"),
    ("5 mm", "ratio", "a plain number is needed"),
]


@pytest.mark.parametrize(("text", "dimension", "words"), REFUSED)
def test_refusals_name_the_remedy(text, dimension, words):
    with pytest.raises(InputError) as caught:
        parse_quantity(text, dimension, "somewhere")
    assert words in str(caught.value)
    assert str(caught.value).startswith("somewhere: ")


def test_lists_share_the_unit_at_their_end():
    assert parse_quantities("0, 1.5, -3 mm", "length") == pytest.approx((0.0, 1.5e-3, -3e-3))
    assert parse_quantities(["1 mm", "1 inch"], "length") == pytest.approx((1e-3, 0.0254))
    with pytest.raises(InputError, match="write the numbers, then one unit"):
        parse_quantities("0 mm, 1 mm", "length")


@pytest.mark.parametrize("name", DIMENSIONS)
def test_every_usual_unit_has_its_dimension(name):
    dimension = DIMENSIONS[name]
    assert parse_quantity(f"1 {dimension.default_unit}".strip(), name) > 0
    assert unit_factor(dimension.si_unit) == pytest.approx(1.0, rel=1e-15)


@pytest.mark.parametrize("unit", DEFAULT)
def test_the_table_of_default_units_holds_the_very_floats_of_pint(unit):
    """The library that reads every other unit is the oracle; a shipped table must not move a number
    by its last digit.
    """
    by_pint = f"{unit}*s/s"  # equal, and in no table
    assert unit_factor(by_pint) == unit_factor(unit) == DEFAULT[unit][0]
    assert dimension_powers(f"1 {by_pint}") == dict(DEFAULT[unit][1])


def test_every_unit_that_is_proposed_or_ships_is_in_the_table():
    wanted = {dimension.si_unit for dimension in DIMENSIONS.values()} | {
        dimension.default_unit for dimension in DIMENSIONS.values()
    }
    assert wanted - {""} <= DEFAULT.keys()


def test_formatting():
    assert format_quantity(0.0041, "mm") == "4.1 mm"
    assert format_quantity(0.5, "") == "0.5"
    assert to_unit(math.pi, "deg") == pytest.approx(180.0)
    assert dimension_of("kg") == "mass"
    assert dimension_of("kg^3") is None


PINT = pint.UnitRegistry()
GIVEN = [
    (3.8e-3, "wire_diameter", 3.8e-3),
    (np.float32(0.5), "ratio", 0.5),
    (np.int64(300), "engine_speed", 300.0),
    (np.array(0.022), "mean_diameter", 0.022),
    (Decimal("0.0038"), "wire_diameter", 3.8e-3),
    ("3.8 mm", "wire_diameter", 3.8e-3),
    ("0.15 inch", "wire_diameter", 3.81e-3),
    ("3000 rpm", "engine_speed", 100 * math.pi),
    ("30000 rpm", "engine_speed", 1000 * math.pi),
    (PINT.Quantity(3.8, "mm"), "wire_diameter", 3.8e-3),
    (PINT.Quantity(3000, "rpm"), "engine_speed", 100 * math.pi),
    (PINT.Quantity(206, "GPa"), "modulus", 206e9),
    (PINT.Quantity(45, "g"), "mass", 0.045),
    (PINT.Quantity(41, "N/mm"), "spring_rate", 41e3),
    (PINT.Quantity(106, "degree"), "cam_angle", math.radians(106)),
    (PINT.Quantity(0.5), "ratio", 0.5),
    (0, "compression", 0.0),
    (-0.001, "compression", -0.001),
]


@pytest.mark.parametrize(("value", "quantity", "expected"), GIVEN)
def test_a_public_function_takes_si_text_and_quantities(value, quantity, expected):
    assert si(value, quantity) == pytest.approx(
        expected, rel=1e-6 if isinstance(value, np.float32) else 1e-14
    )
    assert type(si(value, quantity)) is float


SLIPS = [
    (
        3.8,
        "wire_diameter",
        "3.8 m of wire diameter can only be meant as 3.8 mm; write 0.0038 or '3.8 mm'",
    ),
    (0.15, "wire_diameter", "can only be meant as 0.15 inch"),
    (3.8e-6, "wire_diameter", "is outside 0.2 mm to 20 mm; check the number and its unit"),
    (7, "pitch", "7 m of pitch can only be meant as 7 mm"),
    (22, "mean_diameter", "can only be meant as 22 mm"),
    (
        3000,
        "engine_speed",
        "engine speed 28647.9 rpm; did you mean '3000 rpm'? If not, write '28647.9 rpm'",
    ),
    (28648, "engine_speed", "can only be meant as 28648 rpm"),
    (PINT.Quantity(35, "Hz"), "engine_speed", "is a frequency, but a rotational speed is needed"),
    (106, "cam_angle", "can only be meant as 106 deg"),
    (41, "spring_rate", "can only be meant as 41 N/mm"),
    (206, "modulus", "can only be meant as 206 GPa"),
    (206_000, "modulus", "can only be meant as 206000 MPa"),
    (0.00785, "density", "can only be meant as 0.00785 g/mm^3"),
    (7.85, "density", "write 7850 or '7.85 g/cm^3'"),
    (45, "mass", "can only be meant as 45 g"),
    ("3.8", "wire_diameter", "has no unit"),
    (True, "wire_diameter", "is no single number"),
    (None, "wire_diameter", "is no single number"),
    (1j, "wire_diameter", "is no single number"),
    (np.ones(2), "wire_diameter", "is no single number"),
    (PINT.Quantity(np.ones(2), "mm"), "wire_diameter", "is no single number"),
    (10**400, "wire_diameter", "not a finite number"),
    (math.nan, "wire_diameter", "not a finite number"),
]


@pytest.mark.parametrize(("value", "quantity", "words"), SLIPS)
def test_slips_of_units_are_refused_with_the_likely_meaning(value, quantity, words):
    with pytest.raises(InputError) as caught:
        si(value, quantity, "somewhere")
    assert words in str(caught.value)
    assert str(caught.value).startswith("somewhere: ")


@pytest.mark.parametrize("name", PLAUSIBLE)
def test_the_ends_of_every_window_are_inside_it(name):
    window = PLAUSIBLE[name]
    for end in (window.low, window.high):
        assert si(format_quantity(end, window.default_unit, None), name) == pytest.approx(end)
    assert si(min(window.high, window.bare_high), name) > 0


SPEEDS = [
    ("1000:9000:100 rpm", 81, 1000),
    ("4000:8000:250", 17, 4000),
    ("4000-8000", 21, 4000),
    ("1000 to 9300 rpm", 18, 1000),
    ("4200, 5600 rpm", 2, 4200),
    (["3000 rpm", PINT.Quantity(4000, "rpm")], 2, 3000),
    (PINT.Quantity([3000.0, 4000.0, 4000.0], "rpm"), 2, 3000),
    (PINT.Quantity(3000, "rpm"), 1, 3000),
    (np.array([100.0, 200.0]) * np.pi, 2, 3000),
    (np.float64(100 * np.pi), 1, 3000),
    (100 * math.pi, 1, 3000),
]


@pytest.mark.parametrize(("values", "count", "first"), SPEEDS)
def test_speeds_come_one_by_one_in_sequences_and_in_ranges(values, count, first):
    speeds = si_speeds(values)
    assert len(speeds) == count
    assert speeds[0] == pytest.approx(first * math.pi / 30)


@pytest.mark.parametrize(
    ("text", "quantity", "value"),
    [
        ("1 N/m", "spring_rate", 1.0),
        (PINT.Quantity(3.8, "m"), "wire_diameter", 3.8),
        ("5 rpm", "engine_speed", math.pi / 6),
    ],
)
def test_a_unit_that_is_written_is_believed_with_a_warning(text, quantity, value):
    with pytest.warns(UnusualValueWarning, match="is unusual .* and taken as written"):
        assert si(text, quantity) == pytest.approx(value)
    with pytest.raises(InputError):
        si(value, quantity)  # without its unit it can only be a slip


def test_rows_and_ranges_with_a_unit_are_believed_with_one_warning():
    with pytest.warns(UnusualValueWarning, match="900000 rpm of engine speed") as seen:
        assert len(si_speeds("1000:900000:1000 rpm")) == 900
    assert len(seen) == 1
    with pytest.warns(UnusualValueWarning):
        assert si_each("1, 2 N/m", "spring_rate") == (1.0, 2.0)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ([3000, 4000], "did you mean '3000 rpm'"),
        ("9000:1000:100 rpm", "the last speed is below the first"),
        ("1:9000:0.1 rpm", "more than 10000 speeds"),
        (range(100, 100_000), "more than 10000 speeds"),
        ((), "holds no speed"),
        ("0 rpm", "is not positive"),
        ([-1.0], "is not positive"),
        (None, "no single number"),
        ([[100.0]], "no single number"),
    ],
)
def test_speeds_that_lead_nowhere_are_refused(values, words):
    with pytest.raises(InputError, match=words):
        si_speeds(values)
