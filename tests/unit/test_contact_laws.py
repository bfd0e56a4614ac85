"""Contact laws: compiled kernel against the written law, tangents, losses, Hertz closed forms,
refused values.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from valvetrain import registry
from valvetrain.contact import kernels
from valvetrain.contact.dissipative import Flores, HuntCrossley, LankaraniNikravesh
from valvetrain.contact.elastic import HertzLine, HertzPoint, LinearContact
from valvetrain.contact.friction import CoulombFriction
from valvetrain.contact.impact import ImpactAsPrinted, ImpactContact, cubic_step
from valvetrain.contact.law import ContactLaw
from valvetrain.contact.library import build_contact_law
from valvetrain.errors import InputError

EXAMPLES = {
    "linear": LinearContact(2e7, 50.0),
    "hertz-point": HertzPoint(3e9),
    "hertz-line": HertzLine(1e9),
    "hunt-crossley": HuntCrossley(3e9, 0.4, 1.5),
    "lankarani-nikravesh": LankaraniNikravesh(3e9, 0.8, 1.5),
    "flores": Flores(3e9, 0.5, 2.0),
    "impact": ImpactContact(1e5 * 1e3**1.5, 49.92e3, 2e-5),
    "impact-as-printed": ImpactAsPrinted(1e5 * 1e3**1.5, 49.92e3, 2e-5),
}
depths = st.floats(-1e-4, 2e-4)
rates = st.floats(-3.0, 3.0)


def test_every_law_of_the_library_is_tested_here():
    assert set(EXAMPLES) == set(registry.names("contacts"))


@pytest.mark.parametrize("name", EXAMPLES)
@settings(max_examples=60, deadline=None)
@given(depth=depths, rate=rates, impact_rate=st.floats(0.0, 4.0))
def test_kernel_equals_the_law(name, depth, rate, impact_rate):
    law = EXAMPLES[name]
    assert isinstance(law, ContactLaw)
    row = law.parameters()
    assert row.shape == (kernels.WIDTH,)
    force = kernels.contact_force(law.code, row, impact_rate, depth, rate)
    assert force == pytest.approx(float(law.force(depth, rate, impact_rate)), rel=1e-12, abs=1e-12)
    assert force >= 0 and (depth > 0 or force == 0)
    assert float(law.dissipated_power(depth, rate, impact_rate)) >= -1e-12


@pytest.mark.parametrize("name", EXAMPLES)
def test_tangent_equals_finite_difference(name):
    law, step = EXAMPLES[name], 1e-11
    for depth, rate in [(1e-6, 0.3), (1e-5, -0.2), (3e-5, 0.5), (1e-4, -0.1)]:
        slope = (law.force(depth + step, rate, 0.6) - law.force(depth - step, rate, 0.6)) / (
            2 * step
        )
        assert float(law.tangent(depth, rate, 0.6)) == pytest.approx(float(slope), rel=2e-4)
    elastic = (law.force(3e-5 + step, 0.0) - law.force(3e-5 - step, 0.0)) / (2 * step)
    assert law.stiffness(3e-5) == pytest.approx(float(elastic), rel=2e-4)


def test_impact_memory_holds_the_greatest_rate_since_touch():
    law, memory = EXAMPLES["flores"], np.zeros(3)
    assert law.states == 2 and EXAMPLES["linear"].states == 0
    story = [
        (-1e-6, 0.9, 0.0),
        (1e-7, 0.5, 0.5),
        (1e-6, 0.3, 0.5),
        (1e-6, -0.7, 0.7),
        (-1e-9, -0.4, 0.0),
        (1e-9, 0.0, 1e-3),
    ]
    for depth, rate, expected in story:
        kernels.update_impact(memory, 1, law.parameters()[kernels.SLOWEST], depth, rate)
        assert memory[1 + kernels.IMPACT_RATE] == expected
        assert memory[1 + kernels.TOUCHING] == (depth > 0)
    assert memory[0] == 0.0  # the place of another interaction


def test_impact_law_reproduces_the_figures_of_its_source():
    """283 N at 0.02 mm for 1e5 N/mm**1.5 at rest; the print adds the bare damping number on top."""
    meant, printed = EXAMPLES["impact"], EXAMPLES["impact-as-printed"]
    assert float(meant.force(2e-5, 0.0)) == pytest.approx(282.84, abs=0.01)
    assert float(printed.force(2e-5, -5.0)) == pytest.approx(282.84 + 49.92, abs=0.01)
    assert float(cubic_step(0.5)) == 0.5 and float(cubic_step(0.25)) == pytest.approx(0.15625)


def test_friction_saturates_opposes_and_dissipates():
    law = CoulombFriction(0.12, 0.02)
    velocity = np.linspace(-1, 1, 41)
    force = law.force(500.0, velocity)
    assert np.all(force * velocity <= 0) and np.all(law.dissipated_power(500.0, velocity) >= 0)
    assert force[0] == pytest.approx(60.0) and abs(law.force(500.0, 0.08)) == pytest.approx(
        60.0, rel=1e-3
    )
    slope = -(law.force(500.0, 1e-7) - law.force(500.0, -1e-7)) / 2e-7
    assert law.damping(500.0) == pytest.approx(float(slope), rel=1e-6)


def test_hertz_laws_of_steel_are_those_of_the_handbooks():
    modulus = 206e9 / (2 * (1 - 0.09))
    # Palmgren for steel in mm and N: d = 3.84e-5 F**0.9 / L**0.8.
    line = HertzLine(modulus * 10e-3 ** (8 / 9) / 1.36 ** (10 / 9))
    assert line.force(1e-3 * 3.84e-5 * 1000.0**0.9 / 10.0**0.8, 0.0) == pytest.approx(
        1000.0, rel=4e-3
    )
    # A sphere touches over a circle of radius sqrt(R d), and its mean pressure there is two thirds
    # of 2 E* a / (pi R).
    point, depth = HertzPoint(4 / 3 * modulus * np.sqrt(10e-3)), 5e-6
    radius = np.sqrt(10e-3 * depth)
    assert point.force(depth, 0.0) == pytest.approx(
        2 / 3 * (2 * modulus * radius / (np.pi * 10e-3)) * np.pi * radius**2
    )


BAD = [
    (lambda: LinearContact(0.0), "contact_stiffness"),
    (lambda: LinearContact(1e6, -1.0), "damping"),
    (lambda: HertzPoint(float("nan")), "contact_stiffness"),
    (lambda: HuntCrossley(1e9, 0.1, 0.5), "exponent"),
    (lambda: LankaraniNikravesh(1e9, 1.2), "restitution"),
    # a force that does not grow with penetration
    *((lambda law=law, exponent=exponent: law(1e9, 0.7, exponent=exponent), "exponent")
      for law in (LankaraniNikravesh, Flores) for exponent in (0.0, -1.5, float("nan"))),
    (lambda: Flores(1e9, 0.0), "restitution"),
    (lambda: ImpactContact(1e9, 10.0, 0.0), "full_damping_depth"),
    (lambda: ImpactAsPrinted(1e9, -10.0, 1e-5), "damping"),
    (lambda: CoulombFriction(-0.1), "coefficient"),
    (lambda: build_contact_law("hunt-crosley", contact_stiffness=1e9), "did you mean hunt-crossley"),
    (lambda: build_contact_law("linear", stiffnes=1e9), "stiffnes"),
    (lambda: build_contact_law("flores", restitution=0.5), "needs contact_stiffness"),
]  # fmt: skip


@pytest.mark.parametrize(("build", "word"), BAD)
def test_impossible_values_are_refused_with_the_reason(build, word):
    with pytest.raises(InputError, match=word):
        build()
