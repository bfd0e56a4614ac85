"""Contract: a result that passes a limit carries a mark and a sentence in terminal, JSON, page and
workbench, from one table; published: strengths of wires. The engine is an own one.
"""

from __future__ import annotations

import math

import pytest

import valvetrain as vt
from valvetrain.findings.table import findings_of
from valvetrain.parameters.material import material_by_name, tensile_strength
from valvetrain.quantities.limits import OF_CASE, passed_limits

#: A thin wire pressed far: tau = 8 F D / (pi d^3) without factor, 1.13 GPa.
CASE = vt.Case(
    name="thin-wire",
    spring={
        "wire_diameter": "3 mm", "mean_diameter": "22 mm", "total_coils": 5, "ends": "open", "pitch": "14 mm",
        "precompression": "22 mm", "material": "EN 10270-2 VDSiCr",
    },
    lift_law={
        "kind": "polynomial", "exponents": "3-4-5", "maximum_lift": "14 mm", "opening_start": "100 deg", "opening_end": "180 deg",
        "closing_start": "180 deg", "closing_end": "260 deg",
    },
    engine_speeds="1000 rpm",
)  # fmt: skip


@pytest.fixture(scope="module")
def study():
    return vt.simulate(CASE, models="massless")


def test_stress_is_held_against_the_named_wire(study):
    (run,) = study.solutions
    (found,) = passed_limits(run.quantities).values()
    assert found.quantity == "open_uncorrected_shear_stress"
    assert found.limit == pytest.approx(0.56 * 1910e6) and found.value > found.limit
    force, mean, diameter = run.quantities["peak_spring_force"], 22e-3, 3e-3
    assert found.value == pytest.approx(8 * force * mean / (math.pi * diameter**3), rel=0.02)


def test_the_corrected_stress_passes_no_limit_at_rest():
    """A spring pressed less, whose stress with the factor for curvature alone is above 0.56 of the
    strength, was said to be above its limit.
    """
    run = vt.simulate(CASE.set({"spring.precompression": "18 mm"}), models="massless").solutions[0]  # fmt: skip
    found = run.quantities
    assert found["open_nominal_shear_stress"] > found["permitted_shear_stress"]
    assert not passed_limits(found) and "limit" not in run.verdict


def test_a_case_sets_its_own_limit_of_the_seating_velocity_and_nothing_moves():
    """Contract: it is a finding, over speed too; the motion is the same to the last bit."""
    law = {"kind": "cam-card", "angle_of": "crank", "valve_lift": "8.3 mm", "duration": "244 deg", "duration_lift": "1 mm"}  # fmt: skip
    train = {
        "kind": "direct", "contacts": "steel", "cam": {"base_radius": "14 mm", "width": "9 mm"}, "follower": {"shape": "flat", "mass": "16 g"},
        "valve": {"mass": "32 g"}, "springs": {"one": [{"preload": "230 N", "rate": "36 N/mm", "mass": "25 g"}]}, "spring_model": "massless",
    }  # fmt: skip
    case = vt.Case(name="own", lift_law=law, train=train)
    own = case.set({"train.valve.permitted_seating_velocity": "10 mm/s"})
    studies = [vt.simulate(one, "6000 rpm", workers=1) for one in (case, own)]
    runs = [one.solutions[0] for one in studies]
    assert not passed_limits(runs[0].quantities) and "V101" not in findings_of(studies[0]).codes
    assert "V101" in findings_of(studies[1]).codes
    assert passed_limits(runs[1].quantities)["seating_velocity"].reason == OF_CASE
    velocity = [run.quantities["seating_velocity"] for run in runs]
    assert velocity[0] == velocity[1] > 0.01
    swept = own.sweep("5000:6000:500 rpm", critical_speeds=False)
    assert "V101" in findings_of(swept).codes


@pytest.mark.parametrize(
    ("values", "passed"),
    [
        ({"seating_velocity": 12.5}, {"seating_velocity"}),
        ({"seating_velocity": 0.4}, set()),
        ({"seating_velocity": 0.6, "permitted_seating_velocity": 0.7}, set()),
        ({"seating_velocity": 0.4, "permitted_seating_velocity": 0.3}, {"seating_velocity"}),
        ({"outer_coil_bind_clearance": -1e-4, "inner_coil_bind_clearance": 1e-3}, {"outer_coil_bind_clearance"}),
        ({"open_uncorrected_shear_stress": 1050e6, "permitted_shear_stress": 1040e6}, {"open_uncorrected_shear_stress"}),
        ({"peak_shear_stress": 1361e6, "open_nominal_shear_stress": 1361e6, "permitted_shear_stress": 1040e6}, set()),
        ({"open_uncorrected_shear_stress": 2361e6}, set()),  # of a wire whose strength is unknown
    ],
)  # fmt: skip
def test_what_passes_a_limit(values, passed):
    assert set(passed_limits(values)) == passed


@pytest.mark.parametrize(
    ("wire", "diameter", "strength"),
    [
        ("EN 10270-2 VDSiCr", 1.0, 2080.0),
        ("EN 10270-2 VDSiCr", 4.5, 1860.0),
        ("EN 10270-2 VDSiCr", 4.6, 1810.0),
        ("OTEVA 91 SC", 3.0, 2130.0),
        ("OTEVA 91 SC", 12.0, None),
        ("AISI 4340", 4.0, None),
    ],
)
def test_strengths_of_wires(wire, diameter, strength):
    found = tensile_strength(material_by_name(wire), diameter * 1e-3)
    assert found == (None if strength is None else pytest.approx(strength * 1e6))
