"""Limits: the solid height of a wire is where the curve of the finite-element rod becomes steep, and one for everybody."""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.parameters.loading import case_of
from valvetrain.parameters.solid import closing_forces
from valvetrain.quantities.statics import design_quantities
from valvetrain.springs.spec import spring_model

STEEL = {
    "name": "steel",
    "youngs_modulus": "206 GPa",
    "shear_modulus": "79.3 GPa",
    "density": "7850 kg/m^3",
}
#: The turn that winds up from the closed ends stacks higher than its wire, and both ends meet it at another angle.
WIRES = {
    "whole turns": {"wire_diameter": "3.8 mm", "mean_diameter": "22 mm", "total_coils": 7, "free_length": "47.7276 mm"},
    "broken turns": {"wire_diameter": "4.75 mm", "mean_diameter": "28.27 mm", "total_coils": 5.615, "free_length": "54.51 mm"},
}  # fmt: skip


def case(wire, **more):
    block = {**wire, "material": STEEL, "ends": "closed-ground", "precompression": "7 mm"}
    return case_of(vt.Case(name="wire", spring={**block, **more}))


@pytest.mark.parametrize("name", WIRES)
def test_the_curve_becomes_steep_at_the_solid_height(name):
    """A tenth of the wire above it has less than three times the rate, a tenth below it ten times; it bears the force that closes it."""
    spring = case(WIRES[name]).springs[0]
    wire = spring.wire
    thick = float(wire.wire_diameter.value(1.0))
    assert wire.solid_height > (wire.total_coils + 0.1) * thick
    rod = spring_model("finite-element").build(spring)
    down = np.array([-0.15, -0.1, 0.0, 0.05, 0.1]) * thick + wire.solid_compression
    force = np.asarray(rod.static_forces(down - spring.precompression))
    before, _, _, after = np.diff(force) / np.diff(down)
    rate = design_quantities(spring)["estimated_rate"]
    assert before < 3 * rate and after > 10 * rate
    closing = float(np.max(closing_forces(wire, np.linspace(*wire.free_coils, 4001))))
    assert force[2] == pytest.approx(closing, rel=0.03)


def test_a_stated_height_counts_and_another_of_the_wire_is_named():
    for wire, code in (
        (case(WIRES["whole turns"]), 0),
        (case(WIRES["whole turns"], solid_height="26.6 mm"), 1),
    ):
        spring = wire.springs[0]
        found = design_quantities(spring)
        assert ("computed_solid_height" in found) == code
        assert found["coil_bind_lift"] == pytest.approx(
            spring.installed_height - spring.wire.solid_height
        )
        assert spring.wire.solid_height == pytest.approx(26.6e-3 if code else 27.39e-3, abs=0.02e-3)
    with pytest.raises(vt.InputError, match="solid_height"):
        case(WIRES["whole turns"], solid_height="48 mm")


def cone(shift, turns=6):
    """An open conical wire of 2 mm, whose radius falls by ``shift`` (mm) a turn; small against its mean diameter."""
    last = 80 - 2 * shift * turns
    diameter = {"coils": [0, turns], "values": ["80 mm", f"{last:.4f} mm"]}
    wire = {"wire_diameter": "2 mm", "mean_diameter": diameter, "total_coils": turns, "free_length": "60 mm"}  # fmt: skip
    spring = {**wire, "material": STEEL, "ends": "open", "precompression": "1 mm"}
    return case_of(vt.Case(name="cone", spring=spring)).springs[0].wire


@pytest.mark.parametrize("shift", [0.0, 0.5, 1.0])
def test_turns_of_a_cone_stack_by_the_square_root(shift):
    """Six turns lie (d^2 - shift^2)^(1/2) above one another, and the last is one wire high."""
    by_hand = 6 * np.sqrt(4 - shift**2) + 2
    assert 1e3 * cone(shift).solid_height == pytest.approx(by_hand, rel=0.01)


def test_turns_that_pass_one_another_are_bound_by_the_seats_alone():
    """The height of a cone does not jump where its turns begin to pass, and falls on towards one wire."""
    touching, passing, far = (1e3 * cone(shift).solid_height for shift in (1.999, 2.001, 3.0))
    assert touching > passing > far > 2.0
    assert touching - passing < 0.25 * 2.0 and far < 1.75 * 2.0
