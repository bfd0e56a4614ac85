"""Order in the time step of every spring model that has a state, against its declaration."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from spring_parts import UNIFORM, curved_modal, drive, straight_modal
from valvetrain.springs.modal_uniform import ModalUniform
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.wave_rod import WaveRod


def chain(**damping) -> MultiMassSpring:
    return MultiMassSpring.from_card(
        UNIFORM.rate, 250.0, UNIFORM.active_mass, elements=24, **damping
    )


#: The shared leapfrog is of second order, damping included.
DECLARED = {
    "chain": (chain(), 2),
    "chain, mass damping": (chain(mass_damping=200.0), 2),
    "chain, stiffness damping": (chain(stiffness_damping=4e-6), 2),
    "wave-rod": (WaveRod(UNIFORM, 24, friction=100.0), 2),
    "modal-uniform": (ModalUniform(UNIFORM, 4), 2),
    "modal, damped": (ModalUniform(UNIFORM, 4, damping_ratio=0.03), 2),
    "modal, mass damping": (ModalUniform(UNIFORM, 4, mass_damping=100.0), 2),
    "modal-varied": (straight_modal(), 2),
    "modal-varied, damped": (straight_modal(0.03), 2),
    "modal-varied on a curve": (curved_modal(), 2),
}


def seat_force(model, steps: int) -> np.ndarray:
    """Seat force at 200 instants over 8 ms, with a smooth lift of 4 mm in the first 5 ms."""
    time = np.arange(steps + 1) * 8e-3 / steps
    phase = np.where(time < 5e-3, np.pi * time / 5e-3, 0.0)
    lift = 4e-3 * np.sin(phase) ** 4
    speed = 16e-3 * np.pi / 5e-3 * np.sin(phase) ** 3 * np.cos(phase)
    return drive(model, model.initial_state(0.0), lift, speed, 8e-3 / steps)[:: steps // 200, 1]


@pytest.mark.parametrize("name", DECLARED)
def test_observed_order_is_the_declared_one(name):
    model, declared = DECLARED[name]
    traces = [seat_force(model, steps) for steps in (800, 1600, 3200, 6400)]
    steps = [np.sqrt(np.mean((fine - coarse) ** 2)) for coarse, fine in itertools.pairwise(traces)]
    orders = np.log2(np.array(steps[:-1]) / steps[1:])
    assert orders[-1] == pytest.approx(declared, abs=0.15)
