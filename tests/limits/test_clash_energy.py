"""Clash of two masses against its closed form, and the rod's contact energy against the overlaps of its coils."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.cosserat.transient import simulate
from valvetrain.integrate.clash import PairSeries, find_clashes, steps_between
from valvetrain.integrate.leapfrog_kernel import advance
from valvetrain.parameters.loading import load_case
from valvetrain.springs.chain_layout import ChainLayout, CoilContacts
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.spec import spring_model
from valvetrain.system.build import build

LOWER_MASS, UPPER_MASS, STIFFNESS, GAP, VELOCITY = 2e-3, 1e-3, 4e5, 1e-4, 1.5
REDUCED_MASS = LOWER_MASS * UPPER_MASS / (LOWER_MASS + UPPER_MASS)


def blow(damping_time: float):
    """The one clash of a mass that runs into another at rest; the elements that hold them are next to nothing."""
    contacts = CoilContacts(np.array([2]), np.array([1]), np.zeros(1), np.array([GAP]), np.array([STIFFNESS]), np.array([2.0]))
    layout = ChainLayout(np.full(3, 1e-3), np.array([LOWER_MASS, UPPER_MASS]), np.arange(4.0), 1e-3, 1e-3, contacts)
    model, steps = MultiMassSpring(layout, 0.0, contact_damping_time=damping_time), 20_000
    watch, time_step = model.contact_watch(), 2e-8
    spacing = steps_between(watch, time_step)
    state, still = model.initial_state(0.0), np.zeros(steps + 1)
    state[2:4] = 0.0, VELOCITY
    pressed = np.empty(((steps - 1) // spacing + 1, watch.entries))
    arrays = (model.parameters(), model.integers(), state, still, still, time_step, 1, np.zeros((steps + 1, 2)), np.zeros((0, len(state))))
    assert advance(model.kernel, *arrays, watch.stretches, spacing, pressed) == steps + 1
    time = spacing * time_step * np.arange(len(pressed))
    (event,) = find_clashes(PairSeries(time, 300.0 * time, *watch.read(pressed, spacing * time_step, time_step)))
    return event, state


def test_all_energy_of_two_masses_stands_in_their_contact_at_the_peak():
    event, state = blow(0.0)
    natural = np.sqrt(STIFFNESS / REDUCED_MASS)
    assert event.details["energy"] == pytest.approx(0.5 * REDUCED_MASS * VELOCITY**2, rel=2e-3)
    assert event.size == pytest.approx(VELOCITY * np.sqrt(STIFFNESS * REDUCED_MASS), rel=2e-3)
    assert event.details["impulse"] == pytest.approx(2 * REDUCED_MASS * VELOCITY, rel=2e-3)
    assert event.duration == pytest.approx(np.pi / natural, abs=3e-6)
    assert event.time == pytest.approx(GAP / VELOCITY, abs=2e-6)
    assert state[3] == pytest.approx(VELOCITY - 2 * REDUCED_MASS * VELOCITY / UPPER_MASS, rel=1e-4)


def test_a_damped_contact_stores_what_its_overlap_says():
    """Kelvin-Voigt contact of damping ratio zeta: its overlap is a decaying sine, whose first peak is known."""
    natural, damping_time = np.sqrt(STIFFNESS / REDUCED_MASS), 2e-5
    zeta = 0.5 * damping_time * natural
    root = np.sqrt(1 - zeta**2)
    overlap = VELOCITY / natural * np.exp(-zeta / root * np.arccos(zeta))
    event, _ = blow(damping_time)
    assert 0.05 < zeta < 1
    assert event.details["energy"] == pytest.approx(0.5 * STIFFNESS * overlap**2, rel=5e-3)


def test_stored_energy_of_the_rod_is_that_of_its_overlaps():
    (spring,) = build(load_case("job-c"), spring_models=("finite-element",)).springs
    rod = spring_model("finite-element").build(spring)
    _, pair_of = rod.coil_pairs
    made = simulate(
        rod.mesh, rod.installed.state, lambda time: rod.precompression + 0.006 * np.sin(2 * np.pi * 160 * time) ** 2, 1e-5, 400,
        rod.dynamics, rod.stable_time_step(), discard=100, pair_of=pair_of,
    )  # fmt: skip
    gaps = np.stack([rod.statics.gaps(position) for position in np.ascontiguousarray(made.position)])
    overlap = np.maximum(-np.where(np.isfinite(gaps), gaps, 0.0), 0.0)
    points = 0.5 * rod.dynamics.contact_stiffness * np.sum(rod.mesh.contact.length * overlap**2, axis=1)
    stored = points.sum(axis=1)
    recorded = np.interp(made.time, made.pair_time, made.pair_energy.sum(axis=1))
    assert stored.max() > 1e-5
    assert np.max(np.abs(recorded - stored)) < 0.02 * stored.max()
