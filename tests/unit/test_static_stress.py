"""Stress by EN 13906-1 is that of loads at rest; what the wire bears in motion is that of its own sections."""

from __future__ import annotations

from dataclasses import replace

import pytest

from valvetrain.parameters.loading import load_case
from valvetrain.quantities.statics import solid_quantities
from valvetrain.runs.api import simulate
from valvetrain.runs.statics import force_of
from valvetrain.springs.spec import spring_model
from valvetrain.springs.stress import nominal_stress_per_force

AT_REST = ("open_nominal_shear_stress", "closed_nominal_shear_stress", "open_uncorrected_shear_stress")  # fmt: skip


def numbers(word: str, stiffness: float) -> dict[str, float]:
    case = load_case("job-c")
    (spring,) = case.springs
    contact = replace(spring.contact, stiffness=stiffness * spring.contact.stiffness)
    changed = case.replace(springs=(replace(spring, contact=contact),))
    return dict(simulate(changed, models=(word,), workers=1).solutions[-1].quantities)


@pytest.mark.slow
def test_contact_constants_move_no_stress_by_the_standard():
    found = [numbers("multi-mass", factor) for factor in (0.25, 1.0, 4.0)]
    for name in AT_REST:
        assert [one[name] for one in found] == pytest.approx([found[1][name]] * 3, rel=1e-9), name
    (spring,) = load_case("job-c").springs
    factor = nominal_stress_per_force(spring.wire)
    assert found[1]["open_nominal_shear_stress"] < factor * found[1]["raw_peak_spring_force"]
    at_solid = factor * solid_quantities(spring.wire)["solid_force"]
    assert (
        found[1]["closed_nominal_shear_stress"] < found[1]["open_nominal_shear_stress"] < at_solid
    )


def test_contact_constants_hardly_move_the_stress_of_the_rod():
    found = [numbers("finite-element", factor)["peak_shear_stress"] for factor in (0.25, 1.0, 4.0)]
    assert found == pytest.approx([found[1]] * 3, rel=0.01)


def test_it_is_that_of_the_rod_at_rest_whatever_the_speed():
    case = load_case("job-t")
    runs = simulate(
        case, engine_speeds=[200.0, 400.0], models=("finite-element", "massless"), workers=1
    ).solutions
    found = [run.quantities["open_nominal_shear_stress"] for run in runs]
    assert found == pytest.approx([found[0]] * 4, rel=1e-9)
    (spring,) = case.springs
    opened = spring.precompression + runs[0].quantities["peak_valve_lift"]
    force = force_of(spring, spring_model("finite-element").build(spring), opened)
    # the standard's load is that of torsion alone, some per cent above that of the rod
    assert found[0] == pytest.approx(nominal_stress_per_force(spring.wire) * force, rel=0.05)
