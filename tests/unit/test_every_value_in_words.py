"""A value of a case in words: every form that a value has, with its unit."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from valvetrain.parameters.curves import Constant, FunctionCurve, PiecewiseLinear, Table
from valvetrain.parameters.material import Material
from valvetrain.parameters.train import ContactParameters, SupportParameters, ValveParameters
from valvetrain.parameters.words import value_words, words_at


@pytest.mark.parametrize(
    ("item", "key", "words"),
    [
        (None, "pitch", ""), (True, "gravity", "true"),
        (False, "gravity", "false"), (0.0038, "wire_diameter", "3.8 mm"), (7, "cycles", "7"),
        (Constant(0.007), "pitch", "7 mm"), ("right", "hand", "right"), ((0.01, 0.02), "pivot", "10, 20 mm"), ((2, 4), "exponents", "2, 4"),
        (PiecewiseLinear((0.0, 2.0), (4e-3, 6e-3)), "pitch", "4 at 0, 6 at 2 (mm at coil number)"),
        (Table((0.0, 1.0, 2.5), (4e-3, 5e-3, 6e-3)), "pitch", "4 at 0, 5 at 1, 6 at 2.5 (mm at coil number)"),
        (Material("own", 206e9, 79e9, 7850.0), "material", "own: E 206 GPa, G 79 GPa, density 7850 kg/m³"),
        (SimpleNamespace(kind="three_arc_lobe"), "lift_law", "three arc lobe"),
        (FunctionCurve(lambda coil: coil), "pitch", "FunctionCurve"),
        (SupportParameters(5e7, 0.1), "support", "stiffness 50 kN/mm, mass 100 g"),
        (ValveParameters(0.1, damping=3.0), "valve", "mass 100 g, damping 3 N s/m"),
        (
            ContactParameters("linear", {"contact_stiffness": 3e7, "damping": 300.0}), "cam",
            "linear, contact stiffness 30 kN/mm, damping 300 N s/m",
        ),
        (ContactParameters("hertz-point", {"contact_stiffness": 3e9}), "cam", "hertz-point, contact stiffness 3·10⁹ N/m^1.5"),
    ],
)  # fmt: skip
def test_a_value_is_told_with_its_unit(item, key, words):
    assert value_words(item, key) == words


def test_a_value_is_found_by_its_path_and_a_set_of_one_as_a_table():
    holder = SimpleNamespace(train=SimpleNamespace(lash=2e-4, springs={"stock": (SimpleNamespace(preload=250.0),)}), values={"power": 4})
    assert words_at(holder, "train.lash") == "0.2 mm" and words_at(holder, "power") == "4"
    assert words_at(holder, "train.springs.stock.preload") == words_at(holder, "train.springs.stock.0.preload") == "250 N"
    assert words_at(holder, "train.springs.stock.1.preload") == "" == words_at(holder, "train.nothing.here")
    assert words_at(SimpleNamespace(contact=SimpleNamespace(stiffness=2e10)), "contact.stiffness") == "20000 N/mm²"
