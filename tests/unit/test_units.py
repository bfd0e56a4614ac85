"""Units at the door: exact conversions, dimensions kept apart, and refusals that say what to write."""

from __future__ import annotations

import math

import pytest

from valvetrain.errors import InputError
from valvetrain.units import DIMENSIONS, dimension_of, format_quantity, parse_quantities, parse_quantity, to_unit, unit_factor

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
    ("1.6 %", "ratio", 0.016),
    ("0.5", "ratio", 0.5),
    (7, "ratio", 7.0),
]


@pytest.mark.parametrize(("text", "dimension", "expected"), [row for row in EXACT if row[2] is not None])
def test_known_conversions(text, dimension, expected):
    assert parse_quantity(text, dimension) == pytest.approx(expected, rel=1e-14)


def test_engine_speed_is_radians_per_second_of_the_crank():
    assert parse_quantity("4200 rpm", "angular speed") == pytest.approx(4200 / 60 * 2 * math.pi, rel=1e-15)


REFUSED = [
    (4.0, "length", "write '4.0 mm'"),
    ("4.0", "length", "write '4.0 mm'"),
    ("5 N", "length", "is a force, but a length is needed"),
    ("35 Hz", "angular speed", "is a frequency, but a rotational speed"),
    ("2100 rpm", "frequency", "is a rotational speed, but a frequency"),
    ("3 lb/in", "stiffness", "lb is a mass, lbf the force"),
    ("5 mmm", "length", "did you mean"),
    ("5 (mm)", "length", "cannot be read"),
    ("5 mm^9^9^9", "length", "cannot be read"),
    ("1e999 mm", "length", "not a finite number"),
    ("nan mm", "length", "no quantity"),
    ("", "length", "no quantity"),
    (True, "length", "no quantity"),
    (None, "length", "no quantity"),
    ([1], "length", "no quantity"),
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
    assert parse_quantity(f"1 {dimension.usual_unit}".strip(), name) > 0
    assert unit_factor(dimension.si_unit) == pytest.approx(1.0, rel=1e-15)


def test_formatting():
    assert format_quantity(0.0041, "mm") == "4.1 mm"
    assert format_quantity(0.5, "") == "0.5"
    assert to_unit(math.pi, "deg") == pytest.approx(180.0)
    assert dimension_of("kg") == "mass"
    assert dimension_of("kg^3") is None
