"""Published evidence: what is said of the stress of two springs is what their sources say: a textbook
example of fatigue, and a catalogue's valve spring at full lift and at coil bind.
"""

from __future__ import annotations

import pytest

import valvetrain as vt
from spring_shapes import cylindrical
from valvetrain.parameters.material import (
    FATIGUE_RANGES,
    PERMITTED_SHEAR,
    material_by_name,
    tensile_strength,
)
from valvetrain.springs.stress import nominal_stress_per_force

INCH, POUND, KPSI = 25.4e-3, 4.4482216, 6.894757e6


def wire(diameter: float, outer: float) -> vt.SpringDefinition:
    """A cylindrical spring of wire and outer diameter (m); its pitch and turns make no stress."""
    return cylindrical(diameter, outer - diameter, 2 * diameter, 6.0)


def test_shigley_example_10_4():
    """Music wire of 0.092 in, 9/16 in outside, 5 to 35 lbf, not peened: amplitude 29.7 kpsi about 39.6
    kpsi, 1.18 times safe against fatigue by Zimmerli; at rest far from its limit (284 kpsi wire). The
    book was not at hand: its numbers are held to its own formulas.
    """
    spring = wire(0.092 * INCH, 9 / 16 * INCH)
    per_force = nominal_stress_per_force(spring) * POUND / KPSI
    assert per_force * 15 == pytest.approx(29.7, abs=0.06)
    assert per_force * 20 == pytest.approx(39.6, abs=0.06)
    least, most = (one / KPSI for one in FATIGUE_RANGES["not peened"])
    assert (most - least) / 2 / (per_force * 15) == pytest.approx(1.18, abs=0.005)
    assert (most + least) / 2 == pytest.approx(55, abs=0.05)
    least, most = (one / KPSI for one in FATIGUE_RANGES["shot-peened"])
    assert ((most - least) / 2, (most + least) / 2) == pytest.approx((57.5, 77.5), abs=0.05)
    assert (
        nominal_stress_per_force(spring, corrected=False) * 35 * POUND / KPSI
        < PERMITTED_SHEAR * 284 / 2
    )


def test_a_catalogue_spring_keeps_the_static_limit_down_to_coil_bind():
    """Comp Cams 981, a single spring for street engines: outside 1.254 in, inside 0.880 in, 105 lbf at 1.700
    in, 370 lbf/in, coil bind at 1.150 in. With the factor for curvature, which EN 13906-1 leaves to
    fatigue, it would pass its limit there.
    """
    diameter = (1.254 - 0.880) / 2 * INCH
    spring = wire(diameter, 1.254 * INCH)
    permitted = PERMITTED_SHEAR * tensile_strength(material_by_name("EN 10270-2 VDSiCr"), diameter)
    force = {"open": (105 + 370 * 0.45) * POUND, "coil bind": (105 + 370 * 0.55) * POUND}
    plain, corrected = (
        nominal_stress_per_force(spring, corrected=False),
        nominal_stress_per_force(spring),
    )
    assert plain * force["open"] == pytest.approx(0.77 * permitted, rel=0.01)
    assert plain * force["coil bind"] == pytest.approx(0.87 * permitted, rel=0.01)
    assert corrected * force["coil bind"] == pytest.approx(1.09 * permitted, rel=0.01)
