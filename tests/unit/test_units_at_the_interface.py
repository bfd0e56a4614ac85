"""Every public function and class takes an SI number, text with a unit or a pint quantity, and
refuses what can only be a slip of units.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pint
import pytest

import valvetrain as vt
from valvetrain.parameters import (
    Constant,
    Material,
    PiecewiseLinear,
    SpringDefinition,
    Table,
    barrel,
    beehive,
    conical,
    cylindrical,
    hourglass,
    variable_pitch,
)

PINT = pint.UnitRegistry()
SPRING = cylindrical("3.8 mm", "22 mm", "7 mm", total_coils=7)
STEEL = SPRING.material
EVEN = SPRING.pitch
CASE = vt.load_case("job-t")
UNIFORM = vt.springs.EquivalentSpring(40e3, 300.0, 0.05)


@dataclass(frozen=True)
class Entry:
    """One place that takes a number: ``make`` with the value in SI, ``text`` and ``pint`` of the
    same, and a ``slip`` (None: none known).

    ``read`` takes from what was made the number that must be the same however it was given.
    """

    name: str
    make: Callable[[Any], Any]
    si: float
    number: float
    unit: str
    slip: float | None
    read: Callable[[Any], Any]


def kept(name: str) -> Callable[[Any], Any]:
    return lambda made: getattr(made, name)


MILLIMETRES = (0.007, 7.0, "mm")
ENTRIES = [
    Entry("Constant", Constant, *MILLIMETRES, None, kept("level")),
    Entry("PiecewiseLinear", lambda x: PiecewiseLinear((0, 7), (x, x)), *MILLIMETRES, None, kept("values")),
    Entry("Table", lambda x: Table((0, 7), (x, x)), *MILLIMETRES, None, kept("values")),
    Entry("Material", lambda x: Material("steel", x, 79.6e9, 7850.0), 206e9, 206.0, "GPa", 206.0, kept("youngs_modulus")),
    Entry("cylindrical", lambda x: cylindrical(x, 22e-3, 7e-3, 7), 0.0038, 3.8, "mm", 3.8, kept("free_length")),
    Entry("conical", lambda x: conical(3e-3, x, 18e-3, 6e-3, 6), 0.026, 26.0, "mm", 26.0, kept("wire_length")),
    Entry("barrel", lambda x: barrel(4e-3, 20e-3, x, 8e-3, 7), 0.026, 26.0, "mm", 26.0, kept("wire_length")),
    Entry("hourglass", lambda x: hourglass(4e-3, 26e-3, x, 8e-3, 7), 0.020, 20.0, "mm", 20.0, kept("wire_length")),
    Entry("beehive", lambda x: beehive(3.8e-3, 22e-3, 18e-3, 4, x, 7), *MILLIMETRES, 7.0, kept("free_length")),
    Entry("variable_pitch", lambda x: variable_pitch(3.8e-3, 22e-3, x, 7), *MILLIMETRES, 7.0, kept("free_length")),
    Entry("SpringDefinition wire", lambda x: SpringDefinition(x, 22e-3, EVEN, 7, STEEL), 0.0038, 3.8, "mm", 3.8, kept("mass")),
    Entry("SpringDefinition coil", lambda x: SpringDefinition(3.8e-3, x, EVEN, 7, STEEL), 0.022, 22.0, "mm", 22.0, kept("mass")),
    Entry("SpringDefinition curves", lambda x: SpringDefinition(Constant(x), Constant(22e-3), EVEN, 7, STEEL), 0.0038, 3.8, "mm",
          3.8, kept("mass")),
    Entry("beehive by a curve", lambda x: beehive(3.8e-3, 22e-3, 18e-3, 4, Constant(x), 7, ends="open"), *MILLIMETRES, 7.0,
          kept("free_length")),
    Entry("FiniteElementRod", lambda x: vt.springs.FiniteElementRod(SPRING, x), 0.005, 5.0, "mm", 5.0, kept("precompression")),
    Entry("MultiMassSpring", lambda x: vt.springs.MultiMassSpring.from_definition(SPRING, x), 0.005, 5.0, "mm", 5.0, kept("precompression")),
    Entry("MultiMassSpring card", lambda x: vt.springs.MultiMassSpring.from_card(x, 300.0, 0.05), 40e3, 40.0, "N/mm", 40.0,
          kept("precompression")),
    Entry("WaveRodWithClash", lambda x: vt.springs.WaveRodWithClash.from_definition(SPRING, x).spring, 0.005, 5.0, "mm", 5.0, kept("preload")),
    Entry("EquivalentSpring", lambda x: vt.springs.EquivalentSpring(x, 300.0, 0.05), 40e3, 40.0, "N/mm", 40.0, kept("rate")),
    Entry("EquivalentSpring mass", lambda x: vt.springs.EquivalentSpring(40e3, 300.0, x), 0.05, 50.0, "g", 50.0, kept("active_mass")),
    Entry("EquivalentSpring wire", lambda x: vt.springs.EquivalentSpring.from_definition(SPRING, x), 0.005, 5.0, "mm", 5.0, kept("preload")),
    Entry("MasslessSpring", lambda x: vt.springs.MasslessSpring(x, 300.0), 40e3, 40.0, "N/mm", 40.0, kept("rate")),
    Entry("MasslessTable", lambda x: vt.springs.MasslessTable((0.0, x), (0.0, 300.0)), 0.008, 8.0, "mm", 8.0, kept("displacements")),
    Entry("ModalUniform", lambda x: vt.springs.ModalUniform(UNIFORM, 1, (x,)), 450.0, 0.45, "kHz", None, kept("natural_frequencies")),
    Entry("ModalVaried", lambda x: vt.springs.ModalVaried((450.0,), 0.01, (0.0, 0.02), (0.0, 800.0), x), 0.005, 5.0, "mm", 5.0,
          kept("precompression")),
    Entry("ModalVaried.solve", lambda x: vt.springs.ModalVaried((450.0,), 0.01, (0.0, 0.02), (0.0, 800.0), 5e-3).solve(np.zeros(64), x),
          1000 * np.pi / 30, 1000.0, "rpm", 1000.0, kept("valve_lift")),
    Entry("WaveRod", lambda x: vt.springs.WaveRod(UNIFORM, friction=x), 25.0, 25.0, "1/s", None, kept("friction")),
    Entry("build_contact_law", lambda x: vt.contact.build_contact_law("linear", contact_stiffness=x), 60e6, 60.0, "kN/mm", None,
          kept("contact_stiffness")),
    Entry("build_contact_law for another law", lambda x: vt.contact.build_contact_law("hunt-crossley", contact_stiffness=x, stiffness_exponent=1),
          60e6, 60.0, "kN/mm", None, kept("contact_stiffness")),
    Entry("Case.replace", lambda x: vt.load_case("gu2021-beehive-blind").replace({"springs.0.precompression": x}).springs[0], 0.006, 6.0, "mm",
          6.0, kept("precompression")),
    Entry("Case.replace of speeds", lambda x: CASE.replace({"operation.engine_speeds": [x]}).operation, 2000 * np.pi / 30, 2000.0, "rpm",
          2000.0, kept("engine_speeds")),
    Entry("Quantity", lambda x: vt.solution.Quantity("peak_seat_force", x, "rod"), 2000 * np.pi / 30, 2000.0, "rpm", None, kept("engine_speed")),
]  # fmt: skip


@pytest.mark.parametrize("entry", ENTRIES, ids=kept("name"))
def test_a_number_may_be_given_in_three_forms(entry):
    plain = entry.read(entry.make(entry.si))
    assert plain == pytest.approx(
        entry.read(entry.make(f"{entry.number:g} {entry.unit}")), rel=1e-12
    )
    assert plain == pytest.approx(
        entry.read(entry.make(PINT.Quantity(entry.number, entry.unit))), rel=1e-12
    )


@pytest.mark.parametrize(
    "entry", [entry for entry in ENTRIES if entry.slip is not None], ids=kept("name")
)
def test_a_slip_of_units_is_refused_with_the_likely_meaning(entry):
    with pytest.raises(vt.InputError, match=f"{entry.unit}|solid at"):
        entry.make(entry.slip)


@pytest.mark.parametrize("entry", ENTRIES, ids=kept("name"))
@pytest.mark.parametrize("wrong", ["3 apples", "3 kg^2", "none"])
def test_text_that_is_no_such_quantity_is_refused_with_a_sentence(entry, wrong):
    with pytest.raises(vt.InputError):
        entry.make(wrong)


def test_a_quantity_is_found_by_the_speed_in_any_form():
    values = vt.solution.Quantities(
        {vt.solution.Quantity("peak_seat_force", 2000 * np.pi / 30 * (1 + 1e-12), "rod"): 820.0}
    )
    assert values[vt.solution.Quantity("peak_seat_force", "2000 rpm", "rod")] == 820.0
    with pytest.raises(KeyError):
        values[vt.solution.Quantity("peak_seat_force", "2100 rpm", "rod")]
    with pytest.raises(vt.InputError, match="'2000 rpm'"):
        values[vt.solution.Quantity("peak_seat_force", 2000, "rod")]
