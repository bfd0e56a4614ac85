"""The spring definition against closed forms of helices, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from spring_shapes import FunctionCurve, conical, cylindrical
from valvetrain.errors import InputError
from valvetrain.parameters.curves import (
    Constant,
    PiecewiseLinear,
)
from valvetrain.parameters.material import MATERIALS, OTEVA_90_SC, Material, material_by_name
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import OPEN_END, EndCoil

WIRE, DIAMETER, PITCH, TURNS = 4e-3, 24e-3, 7e-3, 6.0
OPEN = {"lower_end": OPEN_END, "upper_end": OPEN_END}


@pytest.fixture(scope="module")
def helix():
    return cylindrical(WIRE, DIAMETER, PITCH, TURNS, **OPEN)


def test_a_plain_helix_has_the_length_and_mass_of_its_unrolled_wire(helix):
    length = TURNS * np.hypot(np.pi * DIAMETER, PITCH)
    assert helix.wire_length == pytest.approx(length, rel=1e-12)
    assert helix.mass == pytest.approx(
        np.pi / 4 * WIRE**2 * length * OTEVA_90_SC.density, rel=1e-12
    )
    assert helix.active_mass == pytest.approx(helix.mass, rel=1e-12)
    assert helix.active_coils == pytest.approx(TURNS)


def test_a_plain_helix_has_its_diameters_and_gaps_everywhere(helix):
    coil = np.linspace(0, TURNS, 7)
    np.testing.assert_allclose(helix.index(coil), DIAMETER / WIRE)
    np.testing.assert_allclose(helix.outer_diameter(coil), DIAMETER + WIRE)
    np.testing.assert_allclose(helix.coil_gap([1.0, 3.3, TURNS]), PITCH - WIRE, rtol=1e-12)
    assert np.all(np.isinf(helix.coil_gap([0.0, 0.99])))


def test_open_ends_stand_on_the_tips_of_the_wire(helix):
    assert helix.free_length == pytest.approx(TURNS * PITCH + WIRE)
    touching = np.hypot(
        1.0, WIRE / (np.pi * DIAMETER)
    )  # coils that touch lie at the angle of the wire
    assert helix.solid_height == pytest.approx((TURNS * touching + 1) * WIRE, rel=1e-4)
    assert helix.free_coils == (0.0, TURNS)


def test_closed_and_ground_ends_take_a_turn_and_a_half_of_wire_off():
    ends = EndCoil("closed-ground", 0.75, 0.75)
    spring = cylindrical(WIRE, DIAMETER, PITCH, 8.0, lower_end=ends, upper_end=ends)
    # pitch: one turn closed, half a turn of ramp, five turns of full pitch, and the same again
    rise = 2 * WIRE + 2 * 0.5 * (WIRE + PITCH) / 2 + 5 * PITCH
    assert spring.free_length == pytest.approx(rise - 2 * 0.75 * WIRE + WIRE, rel=1e-9)
    stack = (8 - 1.5 + 1) * WIRE
    assert stack < spring.solid_height < stack + 0.02 * WIRE
    assert spring.free_coils == (0.75, 7.25)


@pytest.mark.parametrize(("hand", "sign"), [("right", 1), ("left", -1)])
def test_the_hand_is_that_of_a_screw(helix, hand, sign):
    spring = helix.replace(hand=hand)
    axis = spring.centreline(np.linspace(0, 0.3, 4))
    first, second, third = np.diff(axis, axis=0)
    assert np.sign(np.cross(first, second) @ third) == sign
    np.testing.assert_allclose(np.hypot(axis[:, 0], axis[:, 1]), DIAMETER / 2)


def test_a_cone_has_the_arc_length_of_its_spiral():
    spring = conical(3e-3, 30e-3, 18e-3, 8e-3, TURNS, **OPEN)
    growth = -6e-3 / TURNS

    def rate(u):
        return np.sqrt((2 * np.pi * (15e-3 + growth * u)) ** 2 + growth**2 + 8e-3**2)

    assert spring.wire_length == pytest.approx(quad(rate, 0, TURNS, epsabs=1e-14)[0], rel=1e-10)
    middle = spring.integrate_along_wire(between=(2.0, 3.5))
    assert middle == pytest.approx(quad(rate, 2.0, 3.5, epsabs=1e-14)[0], rel=1e-10)


def test_a_steep_cone_nests_flat():
    spring = conical(3e-3, 60e-3, 20e-3, 4e-3, 3.0, **OPEN)
    assert 3e-3 <= spring.solid_height < 1.2 * 3e-3


def build(**changes):
    values = {
        "wire_diameter": Constant(WIRE), "mean_diameter": Constant(DIAMETER), "pitch": Constant(PITCH),
        "total_coils": TURNS, "material": OTEVA_90_SC, "lower_end": OPEN_END, "upper_end": OPEN_END,
    }  # fmt: skip
    return SpringDefinition(**(values | changes))


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        ({"total_coils": float("nan")}, "total_coils of the spring: .* not a finite number"),
        (
            {"lower_end": EndCoil("closed", 3.0), "upper_end": EndCoil("closed", 2.8)},
            "of which 5.8 are inactive",
        ),
        ({"wire_diameter": Constant(0.0)}, "wire diameter is not positive"),
        (
            {"mean_diameter": PiecewiseLinear((0.0, TURNS), (24e-3, -1e-3))},
            "mean coil diameter is not positive",
        ),
        ({"pitch": FunctionCurve(lambda u: PITCH / (u - 3.0))}, "pitch is not a finite number"),
        (
            {"pitch": PiecewiseLinear((0.0, 3.0, 4.0, TURNS), (PITCH, PITCH, -1e-3, -1e-3))},
            "runs back through itself",
        ),
        ({"mean_diameter": Constant(WIRE)}, "widen the coil"),
        (
            {"pitch": PiecewiseLinear((0.0, 3.0, 3.0 + 1e-9, TURNS), (PITCH, PITCH, 12e-3, 12e-3))},
            "pitch jumps",
        ),
        ({"pitch": Constant(0.9 * WIRE)}, "overlaps the one below"),
    ],
)
def test_an_impossible_spring_is_refused_with_its_reason(wrong, reason):
    with pytest.raises(InputError, match=reason), np.errstate(divide="ignore", invalid="ignore"):
        build(**wrong)
    assert build().name == "spring"


def test_constructors_take_units_and_refuse_slips():
    plain = cylindrical(4e-3, 24e-3, 8e-3, 7.0)
    assert cylindrical("4 mm", "24 mm", "8 mm", 7.0) == plain
    with pytest.raises(InputError, match=r"3\.8 m of wire diameter can only be meant as 3\.8 mm"):
        cylindrical(3.8, 22e-3, 7e-3, 7)
    with pytest.raises(InputError, match="7 m of pitch"):
        cylindrical(3.8e-3, 22e-3, 7, 7)
    with pytest.raises(
        InputError,
        match="206 Pa of modulus can only be meant as 206 GPa",
    ):
        Material("steel", 206, 79.6e9, 7850)


def test_ends_and_constructors_refuse_what_cannot_be():
    with pytest.raises(InputError, match="kind of the end: 'ground'"):
        EndCoil("ground")
    with pytest.raises(InputError, match="at most 3"):
        EndCoil(inactive_coils=3.5)
    with pytest.raises(InputError, match="no space between the closed ends"):
        cylindrical(WIRE, DIAMETER, PITCH, 2.5)


#: Young's and shear modulus (GPa) and density (kg/m3) at room temperature, put in by hand.
PRINTED = {
    "OTEVA 90 SC": (206, 79.6, 7850), "OTEVA 91 SC": (206, 79.5, 7850), "EN 10270-1 SH": (206, 81.5, 7850),
    "EN 10270-2 VDC": (206, 79.5, 7850), "EN 10270-2 VDCrV": (206, 79.5, 7850), "EN 10270-2 VDSiCr": (206, 79.5, 7850),
    "EN 10270-3 1.4310": (185, 70, 7900), "EN 10270-3 1.4568": (195, 73, 7800), "AISI 4340": (205, 80, 7850),
}  # fmt: skip


def test_every_material_of_the_library_has_its_own_numbers():
    known = {
        name: (one.youngs_modulus / 1e9, one.shear_modulus / 1e9, one.density)
        for name, one in MATERIALS.items()
    }
    assert known == PRINTED


@pytest.mark.parametrize("name", MATERIALS)
def test_a_material_is_known_however_its_name_is_spaced_and_capitalised(name):
    writings = {
        name,
        name.upper(),
        name.lower(),
        name.title(),
        name.replace(" ", ""),
        name.replace(" ", "  "),
        f" {name} ",
        name.swapcase(),
    }
    assert {material_by_name(one) for one in writings} == {MATERIALS[name]}
    with pytest.raises(InputError, match="not in the library"):
        material_by_name(f"{name} X")


@pytest.mark.parametrize("part", ["10", "40", "SC", "68"])
def test_a_part_of_a_name_is_no_material(part):
    """Contract: a wire goes by the last word of its name, where one has it, and by no fragment of that."""
    assert material_by_name("VDSiCr") == MATERIALS["EN 10270-2 VDSiCr"]
    assert material_by_name("4340") == MATERIALS["AISI 4340"]
    with pytest.raises(InputError, match="not in the library"):
        material_by_name(part)
