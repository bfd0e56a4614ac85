"""Limits of the modal spring's step: free modes decay as damped oscillators do, and all of their
energy is booked as lost.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from valvetrain.springs import modal_kernels as kernels

MODES = (
    (1.25, 2 * math.pi * 600, 41e3, 17e3),
    (-0.4, 2 * math.pi * 1130, 52e3, -9e3),
)  # share, rad/s, N/m, N/m
START, STEP, STEPS = np.array([0.8e-3, -0.3e-3]), 2e-6, 10_000
CURVE = (
    np.array([0.0, 4e-3, 10e-3]),
    np.array([0.0, 180.0, 480.0]),
)  # a stiffness of 45 000 N/m and 50 000 above


def free_modes(kind: str, ratio: float, mass_damping: float, steps: int):
    """Both modes let go at ``START`` with the retainer at rest: forces of the last step and the
    state.
    """
    rows = [
        number
        for share, omega, stiffness, seat in MODES
        for number in (share, omega, ratio, stiffness, seat)
    ]
    state = np.zeros(4 * len(MODES) + 2)
    state[: len(MODES)] = START
    if kind == "varied":
        precompression = 8e-3
        numbers, counts = (
            [precompression, mass_damping, 0.0, 0.0, *rows, *CURVE[0], *CURVE[1]],
            np.array([len(MODES), len(CURVE[0])]),
        )
        step = kernels.advance_modal_varied.py_func
    else:
        numbers, counts, step = (
            [300.0, 45e3, mass_damping, 0.0, *rows],
            np.array([len(MODES)]),
            kernels.advance_modal.py_func,
        )
    forces = [step(np.array(numbers), counts, state, 0.0, 0.0, STEP) for _ in range(steps)][-1]
    return forces, state


@pytest.mark.parametrize(
    ("kind", "ratio", "mass_damping"),
    [("plain", 0.05, 0.0), ("plain", 0.0, 700.0), ("plain", 0.03, 400.0), ("varied", 0.05, 0.0)],
)
def test_the_energy_of_free_modes_is_booked_as_lost(kind, ratio, mass_damping):
    """Half the stiffness times the square of the first departure, of every mode; of the varied one
    times k(x) = F(x) / x.
    """
    factor = float(np.interp(8e-3, *CURVE)) / 8e-3 if kind == "varied" else 1.0
    stiffness = factor * np.array([mode[2] for mode in MODES])
    _, state = free_modes(kind, ratio, mass_damping, STEPS)
    assert np.abs(state[:2]).max() < 0.05 * np.abs(START).max()
    left = (
        np.sum(stiffness * (state[:2] ** 2 + (state[2:4] / [mode[1] for mode in MODES]) ** 2)) / 2
    )
    assert state[4] + left == pytest.approx(np.sum(stiffness * START**2) / 2, rel=6e-3)


@pytest.mark.parametrize("kind", ["plain", "varied"])
@pytest.mark.parametrize("ratio", [0.0, 0.04])
def test_free_modes_swing_as_damped_oscillators_and_pull_on_both_ends(kind, ratio):
    steps = 700
    forces, state = free_modes(kind, ratio, 0.0, steps)
    omega = np.array([mode[1] for mode in MODES])
    damped, now = omega * math.sqrt(1 - ratio**2), steps * STEP
    expected = (
        START
        * np.exp(-ratio * omega * now)
        * (np.cos(damped * now) + ratio * omega / damped * np.sin(damped * now))
    )
    assert state[:2] == pytest.approx(expected, abs=0.01 * np.abs(START).max())
    if ratio == 0.0:  # without a force that lags
        share, stiffness, seat = (np.array([mode[place] for mode in MODES]) for place in (0, 2, 3))
        factor = float(np.interp(8e-3, *CURVE)) / 8e-3 if kind == "varied" else 1.0
        base = factor * 8e-3 if kind == "varied" else 300.0
        before = START * np.cos(omega * (now - STEP))  # forces belong to the beginning of a step
        due = (
            base - factor * np.sum(share * stiffness * before),
            base + factor * np.sum(seat * before),
        )
        assert forces == pytest.approx(due, abs=0.02 * np.abs(np.array(due) - base).max())
