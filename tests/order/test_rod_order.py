"""Observed order of the rod in element count and in time step against the declared second order."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from twins.rod_cases import uniform_spring
from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.cosserat.mesh import mesh_spring
from valvetrain.cosserat.modes import natural_modes
from valvetrain.cosserat.static import RodStatics, compress
from valvetrain.cosserat.transient import simulate

SPRING = uniform_spring(coils=3.0)
DYNAMICS = RodDynamics(mass_damping=200.0, stiffness_damping=4e-6)


def observed(values, refinement: float = 2.0) -> np.ndarray:
    """Order from successive differences of three or more refinements."""
    steps = np.array([np.sqrt(np.mean(np.square(np.subtract(b, a)))) for a, b in pairwise(values)])
    return np.log(steps[:-1] / steps[1:]) / np.log(refinement)


def test_static_force_is_second_order_in_the_elements():
    forces = [
        compress(RodStatics(mesh_spring(SPRING, n, contact=False)), [4e-3])[-1].retainer_force
        for n in (20, 40, 80, 160)
    ]
    assert observed(forces)[-1] == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("mode", range(6))
def test_natural_frequencies_are_second_order_in_the_elements(mode):
    found = []
    for n in (16, 32, 64):
        statics = RodStatics(mesh_spring(SPRING, n, contact=False))
        state = compress(statics, [4e-3])[-1].state
        found.append(natural_modes(statics, state, 6).natural_frequency[mode])
    assert observed(found)[0] == pytest.approx(2.0, abs=0.2)


def trace(per_coil: int, step: float | None = None, damping: RodDynamics = DYNAMICS) -> np.ndarray:
    """Seat force under a bump of 3 mm in 1 ms and after it."""
    mesh = mesh_spring(SPRING, per_coil, contact=False)
    start = compress(RodStatics(mesh), [2e-3])[-1].state
    motion = lambda t: 2e-3 + 3e-3 * np.sin(np.pi * np.clip(t / 1e-3, 0, 1)) ** 4
    return simulate(mesh, start, motion, 1e-5, 200, damping, step).seat_force


def test_transient_is_second_order_in_the_elements():
    traces = [trace(n, 5e-8) for n in (8, 16, 32)]
    assert observed(traces)[0] == pytest.approx(2.0, abs=0.25)


@pytest.mark.parametrize(
    "damping",
    [RodDynamics(), RodDynamics(mass_damping=500.0), RodDynamics(stiffness_damping=8e-6)],
    ids=["none", "mass", "stiffness"],
)
def test_transient_is_second_order_in_the_time_step(damping):
    """Differences of halved steps on one mesh; 10 per coil so that the largest step is far from the
    limit.
    """
    traces = [trace(10, step, damping) for step in (2e-7, 1e-7, 5e-8)]
    assert observed(traces)[0] == pytest.approx(2.0, abs=0.2)
