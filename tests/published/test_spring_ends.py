"""Published evidence: ends, lengths, pitch and rate of cylindrical springs by Shigley's table 10-1
and example 10-1, and EN 13906-1.
"""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt
from spring_shapes import barrel, beehive, conical, cylindrical
from valvetrain.errors import InputError
from valvetrain.parameters.curves import Constant
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.material import Material
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import EndCoil

INCH, LBF, KPSI = 0.0254, 4.4482216, 6.894757e6
#: Shigley, example 10-1: number 16 music wire, outside diameter 7/16 in, ends squared (closed),
#: 12.5 turns, free length 2.06 in.
MUSIC_WIRE = Material("music wire", 28.5e3 * KPSI, 11.85e3 * KPSI, 7850.0)


def test_shigley_example_10_1():
    """k = 4.13 lbf/in, solid length 0.500 in, pitch 0.186 in, from what a user writes. The book was
    not at hand: its numbers are held to
    its own formulas first (modulus of music wire 11.85 Mpsi at that diameter; k = G d^4 / 8 D^3
    N_a, N_t + 1 wires, N_a pitches and three
    wires)."""
    wire, mean, turns, active, free = 0.037, 0.400, 12.5, 10.5, 2.06
    assert mean == pytest.approx(7 / 16 - wire, abs=6e-4)
    assert 11.85e6 * wire**4 / (8 * mean**3 * active) == pytest.approx(4.13, abs=0.005)
    assert wire * (turns + 1) == pytest.approx(0.500, abs=0.0006) and (
        free - 3 * wire
    ) / active == pytest.approx(0.186, abs=5e-4)
    spring = cylindrical(
        "0.037 inch",
        "0.400 inch",
        total_coils=12.5,
        free_length="2.06 inch",
        ends="closed",
        material=MUSIC_WIRE,
    )
    assert float(spring.pitch.value(6.0)) / INCH == pytest.approx(0.186, abs=5e-4)
    assert 0.500 < spring.solid_height / INCH < 0.500 + STACKED * wire
    assert spring.free_length / INCH == pytest.approx(2.06, rel=1e-12)
    assert spring.active_coils == pytest.approx(10.5, abs=1e-9)
    rod = vt.static_curve(spring, "20 mm", steps=2)
    assert rod.stiffness[0] * INCH / LBF == pytest.approx(4.13, rel=0.01)


#: Wires by which bonded end turns stack higher than the sum of wires that the book calls solid: the coils lie tilted.
STACKED = 1.35
#: Kind -> solid length, free length at a pitch p, of N turns of wire d (table 10-1).
TABLE = {
    "open": (lambda d, n: d * (n + 1), lambda p, d, n: p * n + d),
    "open-ground": (None, lambda p, d, n: p * n),
    "closed": (lambda d, n: d * (n + 1), lambda p, d, n: p * (n - 2) + 3 * d),
    "closed-ground": (lambda d, n: d * n, lambda p, d, n: p * (n - 2) + 2 * d),
}
INACTIVE = {"open": 0, "open-ground": 1, "closed": 2, "closed-ground": 2}


@pytest.mark.parametrize("ends", TABLE)
@pytest.mark.parametrize(
    ("wire", "diameter", "turns", "pitch"),
    [(4e-3, 24e-3, 8.0, 7.5e-3), (1.2e-3, 14e-3, 11.3, 3.1e-3)],
)
def test_table_10_1(ends, wire, diameter, turns, pitch):
    """The free length of the table gives back its pitch, solid length and number of active turns."""
    solid, free = TABLE[ends]
    spring = cylindrical(
        wire, diameter, total_coils=turns, free_length=free(pitch, wire, turns), ends=ends
    )
    assert float(np.max(spring.pitch.value(np.linspace(0, turns, 201)))) == pytest.approx(
        pitch, rel=1e-9
    )
    assert spring.free_length == pytest.approx(free(pitch, wire, turns), rel=1e-9)
    assert spring.free_coils[1] - spring.free_coils[0] == pytest.approx(turns - INACTIVE[ends])
    if solid is not None:
        assert 0.0 < spring.solid_height - solid(wire, turns) < STACKED * wire


@pytest.mark.parametrize("ends", TABLE)
def test_the_rate_is_that_of_the_active_turns(ends):
    """G d^4 / (8 D^3 n) of EN 13906-1, from free to two thirds of the way to solid: the rod within
    the 1.5 % that its curvature makes.
    """
    spring = cylindrical("4 mm", "28 mm", total_coils=9, free_length="66 mm", ends=ends)
    rate = spring.material.shear_modulus * 4e-3**4 / (8 * 28e-3**3 * (9 - INACTIVE[ends]))
    curve = vt.static_curve(spring, 0.66 * (spring.free_length - spring.solid_height), steps=6)
    assert curve.stiffness == pytest.approx(rate, rel=0.015)


BLOCK = '[spring]\nwire_diameter = "4 mm"\nmean_diameter = "24 mm"\ntotal_coils = 8\nmaterial = "OTEVA 90 SC"\n'


def test_a_bare_pitch_is_that_between_closed_ends():
    """Without a word on its ends a spring is closed and ground; a length for the pitch then is no
    constant pitch.
    """
    (bare,) = parse_case(f'{BLOCK}pitch = "7 mm"\n').springs
    assert bare.wire == cylindrical("4 mm", "24 mm", "7 mm", 8.0, name=bare.wire.name)
    assert bare.wire.pitch.value([0.0, 4.0, 8.0]) == pytest.approx([4e-3, 7e-3, 4e-3])


def test_every_shape_takes_a_free_length_and_keeps_it():
    shapes = (
        conical("3 mm", "26 mm", "22 mm", total_coils=7, free_length="45 mm"),
        barrel("3 mm", "20 mm", "26 mm", total_coils=7, free_length="45 mm", ends="closed"),
        beehive("3 mm", "22 mm", "18 mm", 4, total_coils=7, free_length="45 mm"),
        cylindrical(
            "3 mm",
            "22 mm",
            total_coils=7,
            free_length="45 mm",
            lower_end=EndCoil("closed-ground", 0.75, 0.75),
        ),
        cylindrical("3 mm", "22 mm", total_coils=7, free_length="45 mm", upper_end=EndCoil("open")),
    )
    assert [one.free_length for one in shapes] == pytest.approx([45e-3] * 5, rel=1e-12)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "neither pitch nor height nor free_length is given"),
        ({"pitch": "7 mm", "free_length": "52 mm"}, "pitch and free_length are both given"),
        (
            {"free_length": "31 mm"},
            r"leaves no gap between 8 turns of 4 mm wire, which are solid at 32 mm",
        ),
        (
            {"free_length": "52 mm", "ends": "ground"},
            "ends.* 'ground' is not among 'closed-ground'",
        ),
        (
            {"free_length": "52 mm", "ends": "open", "lower_end": EndCoil()},
            "'ends' speaks for both ends",
        ),
        ({"free_length": 52}, "can only be meant as 52 mm"),
    ],
)
def test_what_cannot_be_wound_is_refused_in_one_sentence(given, words):
    with pytest.raises(InputError, match=words) as caught:
        cylindrical("4 mm", "24 mm", total_coils=8, **given)
    assert "\n" not in str(caught.value)


def test_grinding_that_takes_the_whole_tip_is_refused():
    """Three quarters of a turn at 7 mm of pitch rise 5.25 mm, more than the 4 mm of the wire."""
    usual = {
        "wire_diameter": 4e-3,
        "mean_diameter": 24e-3,
        "pitch": Constant(7e-3),
        "total_coils": 8.0,
        "material": MUSIC_WIRE,
    }
    with pytest.raises(
        InputError,
        match=r"grinding 0\.75 turns of its closed-ground end takes the whole tip of the 4 mm wire",
    ):
        SpringDefinition(**usual)
    SpringDefinition(
        **usual, lower_end=EndCoil("open-ground", 0.5, 0.28), upper_end=EndCoil("open")
    )


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ('free_length = "52 mm"\npitch = "7 mm"\n', "pitch and free_length are both given"),
        ('free_length = "30 mm"\n', "leaves no gap"),
        ('free_length = "52 mm"\nends = "squared"\n', "'squared'"),
    ],
)
def test_a_case_file_that_contradicts_itself_is_refused_at_its_line(lines, words):
    with pytest.raises(InputError, match=words) as caught:
        parse_case(BLOCK + lines, where="own.toml")
    assert "own.toml, line" in str(caught.value)


def test_ends_ground_over_all_turns_are_refused():
    ends = {"lower_end": EndCoil("open-ground", 1, 1), "upper_end": EndCoil("open-ground", 1, 1)}
    with pytest.raises(InputError, match="use up all of 2 turns"):
        cylindrical("4 mm", "24 mm", total_coils=2, free_length="52 mm", **ends)
