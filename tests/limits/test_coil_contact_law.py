"""Closed form: a law of contact between coils of one's own, force of power 1.4, in chain and rod;
twin: the linear law through the same door gives the numbers of the built-in one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numba import njit
from scipy.optimize import brentq

from valvetrain.coil_contact.law import (
    LINEAR,
    CoilContactLaw,
    contact_response,
    law_of,
)
from valvetrain.errors import InputError
from valvetrain.integrate.leapfrog_kernel import advance
from valvetrain.parameters.installed_spring import CoilContact
from valvetrain.parameters.loading import load_case
from valvetrain.springs.chain_layout import ChainLayout, CoilContacts
from valvetrain.springs.chain_statics import solve_static
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.spec import spring_model
from valvetrain.system.build import build

EQUAL_OVERLAP = 2e-6
LOWER_MASS, UPPER_MASS, STIFFNESS, GAP, VELOCITY = 2e-3, 1e-3, 4e5, 1e-4, 1.5
REDUCED_MASS = LOWER_MASS * UPPER_MASS / (LOWER_MASS + UPPER_MASS)


@njit
def power_kernel(parameters, damping_time, overlap):
    tangent = (overlap / parameters[0]) ** 0.4
    force = overlap * tangent
    return force, 1.4 * tangent, force * overlap / 2.4, damping_time * tangent


@njit
def linear_kernel(parameters, damping_time, overlap):
    return overlap, 1.0, 0.5 * overlap * overlap, damping_time


@dataclass(frozen=True)
class PowerLaw:
    """f = g (g / g0)^0.4."""

    equal_overlap: float = EQUAL_OVERLAP
    name = "power-law"
    kernel = power_kernel
    steepest = 1.4 * (1e-4 / EQUAL_OVERLAP) ** 0.4

    def parameters(self):
        return (self.equal_overlap,)


@dataclass(frozen=True)
class LinearTwin:
    """The linear law by a kernel of its own."""

    name = "linear-twin"
    kernel = linear_kernel
    steepest = 1.0

    def parameters(self):
        return ()


def two_masses(law: CoilContactLaw, held: tuple[float, float, float]) -> ChainLayout:
    """A chain of two masses whose middle element closes a contact after the gap."""
    contacts = CoilContacts(
        np.array([2]),
        np.array([1]),
        np.zeros(1),
        np.array([GAP]),
        np.array([STIFFNESS]),
        np.array([2.0]),
        law=law,
    )
    masses = np.array([LOWER_MASS, UPPER_MASS])
    return ChainLayout(np.array(held), masses, np.arange(4.0), 1e-3, 1e-3, contacts)


def test_a_law_of_its_own_meets_the_contract():
    assert isinstance(PowerLaw(), CoilContactLaw) and isinstance(LINEAR, CoilContactLaw)


@pytest.mark.parametrize("overlap", [1e-7, 2e-6, 5e-5])
def test_force_energy_and_tangent_of_a_contact_are_those_of_the_power(overlap):
    found = contact_response(PowerLaw(), [overlap, -overlap])
    force = overlap**1.4 / EQUAL_OVERLAP**0.4
    assert found.force == pytest.approx([force, 0.0], rel=1e-12)
    assert found.energy == pytest.approx([force * overlap / 2.4, 0.0], rel=1e-12)
    assert found.tangent == pytest.approx([1.4 * force / overlap, 0.0], rel=1e-12)


def test_static_force_of_two_coils_pressed_together_is_that_of_the_law():
    """Elements of 1 N/mm in line, the middle one beside the contact: one equation for its travel."""
    rate, compression = 1e3, 2e-3

    def surplus(middle: float) -> float:
        overlap = max(middle - GAP, 0.0)
        pressed = STIFFNESS * overlap * (overlap / EQUAL_OVERLAP) ** 0.4
        return rate * middle + pressed - rate * (compression - middle) / 2

    middle = brentq(surplus, 0.0, compression, xtol=1e-18)
    nodes = solve_static(two_masses(PowerLaw(), (rate, rate, rate)), compression)
    assert nodes[2] - nodes[1] == pytest.approx(middle, rel=1e-9)
    assert middle > GAP


def test_two_masses_that_collide_part_as_they_met_and_store_all_energy_between():
    """Without damping: 1/2 mu v^2 = k g^2.4 / (2.4 g0^0.4) at the deepest overlap."""
    law, time_step, steps = PowerLaw(), 2e-8, 20_000
    model = MultiMassSpring(two_masses(law, (1e-3, 1e-3, 1e-3)), 0.0, contact_damping_time=0.0)
    state = model.initial_state(0.0)
    state[:4] = 0.0, 0.0, 0.0, VELOCITY
    still, states = np.zeros(steps + 1), np.zeros((steps // 10 + 1, len(state)))
    arrays = (model.parameters(), model.integers(), state, still, still, time_step, 10)
    watch = model.contact_watch()
    pressed = np.empty((steps, watch.entries))
    ends = np.zeros((steps + 1, 2))
    assert (
        advance(model.kernel, *arrays, ends, states, watch.stretches, 1, pressed, 0, 1) == steps + 1
    )
    deepest = (0.5 * REDUCED_MASS * VELOCITY**2 * 2.4 * EQUAL_OVERLAP**0.4 / STIFFNESS) ** (1 / 2.4)
    assert np.max(states[:, 1] - states[:, 0]) - GAP == pytest.approx(deepest, rel=2e-3)
    assert states[-1, 3] - states[-1, 2] == pytest.approx(-VELOCITY, rel=1e-3)


@pytest.mark.parametrize("model", ["multi-mass", "finite-element"])
def test_the_linear_law_by_a_kernel_of_its_own_is_the_built_in_one(model):
    """Static force where coils touch, of job C: relative difference of rounding."""
    (spring,) = build(load_case("job-c"), spring_models=(model,)).springs
    plain = spring_model(model).build(spring)
    if model == "multi-mass":
        contacts = replace(plain.layout.contacts, law=LinearTwin())
        twin = replace(plain, layout=replace(plain.layout, contacts=contacts))
    else:
        twin = replace(plain, dynamics=replace(plain.dynamics, contact_law=LinearTwin()))
    for lift in (0.0, 5e-3):
        first, second = plain.initial_state(lift), twin.initial_state(lift)
        assert twin.force(second, lift, 0.0) == pytest.approx(
            plain.force(first, lift, 0.0), rel=1e-9
        )
        assert twin.tangent(second, lift) == pytest.approx(plain.tangent(first, lift), rel=1e-9)


def test_an_unknown_law_or_value_is_answered_with_those_that_there_are():
    with pytest.raises(InputError, match=r"linaer.*linear"):
        law_of(CoilContact(law="linaer"))
    with pytest.raises(InputError, match="no value 'exponent'"):
        law_of(CoilContact(values={"exponent": 1.4}))
    assert law_of(CoilContact()) is LINEAR


@pytest.mark.parametrize("law", ["linaer", "power"])
def test_a_case_that_names_an_unknown_law_is_refused_at_its_key(law):
    with pytest.raises(InputError) as refused:
        load_case("job-c", {"spring.contact": {"law": law}})
    assert "spring.contact.law" in str(refused.value) and "linear" in str(refused.value)
