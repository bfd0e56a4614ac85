"""A value of a case in words: every form that a value has, with its unit."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.cam import build_lift_law
from valvetrain.parameters.curves import Constant, FunctionCurve, PiecewiseLinear, Table
from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.parameters.material import Material
from valvetrain.parameters.summary import number, value_text, value_text_at
from valvetrain.parameters.train import ContactParameters, SupportParameters, ValveParameters


@pytest.mark.parametrize(
    ("item", "key", "words"),
    [
        (None, "pitch", ""),
        (True, "gravity", "true"),
        (False, "gravity", "false"),
        (0.0038, "wire_diameter", "3.8 mm"),
        (7, "cycles", "7"),
        (Constant(0.007), "pitch", "7 mm"),
        ("right", "hand", "right"),
        ((0.01, 0.02), "pivot", "10, 20 mm"),
        ((2, 4), "exponents", "2, 4"),
        (PiecewiseLinear((0.0, 2.0), (4e-3, 6e-3)), "pitch", "4 at 0, 6 at 2 (mm at coil number)"),
        (
            Table((0.0, 1.0, 2.5), (4e-3, 5e-3, 6e-3)),
            "pitch",
            "4 at 0, 5 at 1, 6 at 2.5 (mm at coil number)",
        ),
        (
            Material("own", 206e9, 79e9, 7850.0),
            "material",
            "own: E 206 GPa, G 79 GPa, density 7850 kg/m³",
        ),
        (SimpleNamespace(kind="three_arc_lobe"), "lift_law", "three arc lobe"),
        (FunctionCurve(lambda coil: coil), "pitch", "FunctionCurve"),
        (SupportParameters(5e7, 0.1), "support", "stiffness 50 kN/mm, mass 100 g"),
        (ValveParameters(0.1, damping=3.0), "valve", "mass 100 g, damping 3 N s/m"),
        (
            ContactParameters("linear", {"contact_stiffness": 3e7, "damping": 300.0}),
            "cam",
            "linear, contact stiffness 30 kN/mm, damping 300 N s/m",
        ),
        (
            ContactParameters("hertz-point", {"contact_stiffness": 3e9}),
            "cam",
            "hertz-point, contact stiffness 3·10⁹ N/m^1.5",
        ),
    ],
)
def test_a_value_is_told_with_its_unit(item, key, words):
    assert value_text(item, key) == words


def test_a_value_is_found_by_its_path_and_a_set_of_one_as_a_table():
    holder = SimpleNamespace(
        train=SimpleNamespace(lash=2e-4, springs={"stock": (SimpleNamespace(preload=250.0),)}),
        values={"power": 4},
    )
    assert value_text_at(holder, "train.lash") == "0.2 mm" and value_text_at(holder, "power") == "4"
    assert (
        value_text_at(holder, "train.springs.stock.preload")
        == value_text_at(holder, "train.springs.stock.0.preload")
        == "250 N"
    )
    assert (
        value_text_at(holder, "train.springs.stock.1.preload")
        == ""
        == value_text_at(holder, "train.nothing.here")
    )
    assert (
        value_text_at(SimpleNamespace(contact=SimpleNamespace(stiffness=2e10)), "contact.stiffness")
        == "20000 N/mm²"
    )


LAWS = {
    "cycloidal": {"maximum_lift": 8e-3, "opening_start": 1.0, "opening_end": 2.0, "closing_start": 2.1, "closing_end": 3.0},
    "ramped": {"maximum_lift": 9e-3, "ramp_lift": 2e-4, "ramp_start": 0.5, "event_start": 1.0, "event_end": 3.0, "ramp_end": 3.5},
    "shaped": {"maximum_lift": 9e-3, "ramp_lift": 2e-4, "ramp_start": 0.5, "event_start": 1.0, "nose": 2.0, "event_end": 3.1,
               "flank_shape": (1.0, 0.5, -0.5, -1.0, -1.0)},
    "three-arc": {"base_radius": 0.018, "nose_radius": 5e-3, "maximum_lift": 9e-3, "nose": 3.1, "opening_start": 2.0},
}  # fmt: skip


@pytest.mark.parametrize("kind", LAWS)
def test_every_number_of_a_lift_law_is_told_in_its_unit_and_changed_by_text_with_one(kind):
    """Angles in degrees, lengths in millimetres, ratios as they are; text with a unit makes the law
    that the SI number makes.
    """
    case = vt.load_case("gu2021-beehive-blind").replace(
        {"lift_law": LiftLawParameters(kind, LAWS[kind])}
    )
    changes = {}
    for key, value in LAWS[kind].items():
        if isinstance(value, tuple):
            continue
        length = "lift" in key or "radius" in key
        unit, factor = ("mm", 1e3) if length else ("deg", 180 / math.pi)
        assert value_text_at(case, f"lift_law.{key}") == f"{number(value * factor)} {unit}"
        changes[f"lift_law.{key}"] = f"{value * factor!r} {unit}"
    told = case.replace(changes).lift_law
    assert {key: told.values[key] for key in LAWS[kind]} == {
        key: pytest.approx(value, rel=1e-12) for key, value in LAWS[kind].items()
    }
    angle = np.linspace(0.0, 6.2, 500)
    assert np.allclose(
        build_lift_law(told).lift(angle),
        build_lift_law(case.lift_law).lift(angle),
        rtol=0,
        atol=1e-12,
    )


def test_a_number_of_a_lift_law_without_its_unit_is_refused():
    case = vt.load_case("gu2021-beehive-blind").replace(
        {"lift_law": LiftLawParameters("cycloidal", LAWS["cycloidal"])}
    )
    with pytest.raises(vt.InputError, match="opening_start"):
        case.replace({"lift_law.opening_start": "120 mm"})
