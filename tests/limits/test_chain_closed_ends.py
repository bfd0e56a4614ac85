"""The chain against the finite-element rod where closed end coils wind up: the wire lifts off its
clamp as psi - sin(psi).
"""

from __future__ import annotations

import numpy as np
import pytest

from spring_parts import OPEN_SPRING
from valvetrain.parameters.loading import load_case
from valvetrain.springs.chain_layout import chain_from_definition, wire_lift_row
from valvetrain.springs.chain_statics import static_curve
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.multi_mass import MultiMassSpring

NESTED = load_case("vaz-ohc").train.spring_parts("nested")


@pytest.mark.parametrize("place", [0.1, 0.25, 0.6, 1.0])
@pytest.mark.parametrize("from_below", [True, False])
def test_under_uniform_twist_the_wire_rises_as_angle_less_sine(place, from_below):
    coil = np.linspace(0.0, 6.0, 37)
    psi = 2 * np.pi * place
    row = wire_lift_row(
        OPEN_SPRING, coil, place if from_below else 6.0 - place, from_below=from_below
    )
    assert row @ coil == pytest.approx((psi - np.sin(psi)) / (2 * np.pi), rel=1e-12)
    assert row @ np.ones(37) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("place", "inner"), [(0, "outer"), (1, "inner")])
def test_closed_ends_make_the_chain_no_stiffer_than_the_rod(place, inner):
    """Both close at the same coils. With sections taken for the wire the force was 6.2 and 5.1 %
    too high as installed, 6.7 and 8.5 % at
    full lift. What is left at full lift comes of bending that contacts share along the wire, which
    a chain does not have."""
    installed = NESTED[place]
    assert installed.wire.name == inner
    rod = FiniteElementRod(installed.wire, installed.precompression, elements_per_coil=12)
    chain = MultiMassSpring.from_definition(
        installed.wire, installed.precompression, masses_per_coil=24, contact_stiffness=2e9
    )
    errors = []
    for travel in (0.0, 4e-3, 9.7e-3):
        state, other = rod.initial_state(travel), chain.initial_state(travel)
        errors.append(chain.force(other, travel).retainer / rod.force(state, travel).retainer - 1)
    assert np.abs(errors[:2]) == pytest.approx(0.0, abs=6e-3)
    assert 0.0 < errors[2] < 0.04
    one, other = rod.outputs(state, travel), chain.outputs(other, travel)
    pressed = [
        np.unique(np.round(out.upper_coil[out.coil_contact_force > 1.0], 1)) for out in (one, other)
    ]
    assert len(pressed[0]) and all(np.min(np.abs(pressed[1] - coil)) <= 0.11 for coil in pressed[0])


def test_force_of_a_chain_with_closed_ends_settles_with_the_number_of_masses():
    spring, deep = (
        NESTED[0].wire,
        np.array([NESTED[0].precompression, NESTED[0].precompression + 9.7e-3]),
    )
    forces = [
        static_curve(chain_from_definition(spring, round(3.8177 * n), 2e9), deep)[0]
        for n in (6, 12, 24, 48)
    ]
    changes = [np.max(np.abs(force / forces[3] - 1)) for force in forces[:3]]
    assert changes[0] < 0.01  # the published kind of chain, six masses per turn
    assert changes[2] < changes[0] / 3


def test_a_static_curve_of_the_rod_is_its_states_of_rest_one_by_one():
    installed = NESTED[1]
    rod = FiniteElementRod(installed.wire, installed.precompression, elements_per_coil=12)
    travels = np.array([-1e-5, 0.0, 3e-3, 9.7e-3])
    alone = [
        rod.force(rod.initial_state(float(travel)), float(travel)).retainer for travel in travels
    ]
    assert rod.static_forces(travels) == pytest.approx(alone, rel=1e-6)
