"""Ends of the rod that lift. Closed form: free vibration and flight between impacts. Limit between
models: the chain of masses, the bonded rod.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from spring_parts import drive, raised_cosine
from spring_shapes import cylindrical
from valvetrain.cosserat.end_coil_kernels import END, SEAT
from valvetrain.cosserat.layout import row
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.spec import spring_model

WIRE = cylindrical("4 mm", "24 mm", "8 mm", 8)
#: Enough room that coils do not meet; no contact between them.
SPRING = InstalledSpring(wire=WIRE, precompression=4e-3).with_options(
    "finite-element", elements_per_coil=12, lifting_ends=True
)


def rod_of(**changes) -> FiniteElementRod:
    model = spring_model("finite-element").build(replace(SPRING, **changes))
    return model.with_time_step(model.stable_time_step())


def flying(model, state, steps, displacement=-0.05):
    """Centre of mass speed (m/s), end forces (N) and distance of the ends (m) of every step."""
    parameters, integers = model.parameters(), model.integers()
    mesh, ends = model.mesh, model.dynamics.ends.masses(model.mesh)
    inner = slice(mesh.first + 1, mesh.last)
    height, speed = row(state, "Z", mesh.vertices), row(state, "VZ", mesh.vertices)
    found = np.zeros((steps, 4))
    for n in range(steps):
        forces = model.kernel(parameters, integers, state, displacement, 0.0, model.time_step)
        momentum = mesh.node_mass[inner] @ speed[inner] + ends @ speed[[mesh.first, mesh.last]]
        found[n] = momentum, *forces, height[mesh.last] - height[mesh.first]
    return found


def mass_of(model) -> float:
    mesh = model.mesh
    return float(
        mesh.node_mass[mesh.first + 1 : mesh.last].sum() + model.dynamics.ends.masses(mesh).sum()
    )


def test_a_spring_released_at_both_ends_vibrates_as_a_free_bar_with_end_masses():
    """Closed form: ``cot(beta / 2) = mu beta``, ``mu`` end mass over mass of the free wire."""
    model = rod_of()
    state = model.initial_state(0.0)
    state[int(END) + int(SEAT)] = row(state, "LOWER", model.mesh.vertices)[:] = -1.0  # no seat
    found = flying(model, state, int(10e-3 / model.time_step))
    length = found[:, 3] - np.mean(found[:, 3])
    crossings = np.flatnonzero((length[:-1] < 0) & (length[1:] >= 0))
    period = (crossings[-1] - crossings[0]) / (len(crossings) - 1) * model.time_step
    ends = model.dynamics.ends.masses(model.mesh)
    free = mass_of(model) - ends.sum()
    beta = brentq(lambda b: 1 / np.tan(b / 2) - ends.mean() / free * b, 0.1, np.pi - 1e-9)
    rate = model.installed.retainer_force / model.precompression
    assert 1 / period == pytest.approx(beta / (2 * np.pi) * np.sqrt(rate / free), rel=0.02)
    assert np.max(np.abs(found[:, 1:3])) == 0.0
    assert np.max(np.abs(found[:, 0])) < 1e-9


def test_a_spring_thrown_on_its_seat_leaves_it_with_the_impulse_of_the_seat():
    model = rod_of()
    state = model._filled(model._equilibrium(-SPRING.precompression), -SPRING.precompression)
    speed = row(state, "VZ", model.mesh.vertices)
    speed[:] = -2.0
    before = model.energy(state, -0.05, 0.0, 0.0).total
    found = flying(model, state, int(6e-3 / model.time_step))
    after = model.energy(state, -0.05, 0.0, model.time_step)
    impulse = np.sum(found[:, 2]) * model.time_step
    assert found[-1, 0] == pytest.approx(impulse - 2.0 * mass_of(model), abs=1e-9)
    assert after.total + after.dissipated == pytest.approx(before, rel=2e-3)


def motion(model, lift, frequency):
    """Step and both end forces of one opening and closing and as long a rest."""
    step = (
        model.time_step
        if isinstance(model, FiniteElementRod)
        else min(1e-5, 0.8 * model.stable_time_step())
    )
    displacement, velocity = raised_cosine(lift, 1 / frequency, step, 1 / frequency)
    return step, drive(model, model.initial_state(0.0), displacement, velocity, step)


def test_a_spring_that_stays_on_its_seats_is_the_bonded_one():
    """Limit: the force on the seat within 0.5 % of the preload, root mean square."""
    bonded, lifting = (motion(rod_of(tied=tied), 8e-3, 120.0)[1] for tied in (True, False))
    preload = bonded[0, 1]
    assert np.min(bonded) > 0.5 * preload
    assert lifting[:, 1] == pytest.approx(bonded[:, 1], abs=5e-2 * preload)
    assert np.sqrt(np.mean((lifting[:, 1] - bonded[:, 1]) ** 2)) < 5e-3 * preload


def test_chain_and_rod_lift_alike():
    """Limit: bonded ends pull, those of chain and rod leave both seats, with equal impulses."""
    found = {}
    for name, model in {
        "chain": spring_model("multi-mass").build(SPRING),
        "rod": rod_of(),
        "bonded": rod_of(tied=True),
    }.items():
        step, forces = motion(model, 8e-3, 170.0)
        found[name] = forces.min(axis=0), forces.sum(axis=0) * step
    assert np.max(found["bonded"][0]) < -30.0
    for name in ("chain", "rod"):
        assert found[name][0] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert found["rod"][1] == pytest.approx(found["chain"][1], rel=0.02)
