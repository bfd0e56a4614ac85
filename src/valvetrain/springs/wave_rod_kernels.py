"""Compiled step of the uniform rod on a grid whose cells a wave crosses in (nearly) one step."""

from __future__ import annotations

import math
from typing import Any

from valvetrain.compiled import njit

#: Nothing is allocated, so no reference counting; sums may be reordered, nothing that hides a NaN.
OPTIONS: dict[str, Any] = {
    "cache": True,
    "error_model": "numpy",
    "_nrt": False,
    "fastmath": {"reassoc", "contract", "nsz"},
}
#: Compiled into each kernel that calls it, and stored with those alone.
PART: dict[str, Any] = {**OPTIONS, "cache": False, "forceinline": True}


@njit(**PART)
def _kick(parameters, integers, state, time_step, half):
    """Half damping, kick, half damping on the inner nodes 2 .. n - 1; returns twice the energy over
    the node mass that was lost.
    """
    n = integers[0]
    below, here, above = state[: n - 2], state[1 : n - 1], state[2:n]
    velocities = state[n + 1 : 2 * n - 1]
    gain, lost = time_step * parameters[1] / parameters[2], 0.0
    for i in range(n - 2):
        before = velocities[i]
        kicked = half * before + gain * (above[i] - 2.0 * here[i] + below[i])
        lost += before * before + kicked * kicked
        velocities[i] = half * kicked
    return lost


@njit(**PART)
def _kick_end(state, node, n, gain, curvature, half):
    before = state[n + node]
    kicked = half * before + gain * curvature
    state[n + node] = half * kicked
    return before * before + kicked * kicked


@njit(**PART)
def _drift(integers, state, time_step):
    n = integers[0]
    positions, velocities = state[:n], state[n : 2 * n]
    for i in range(n):
        positions[i] += time_step * velocities[i]


@njit(**OPTIONS)
def advance_rod(parameters, integers, state, retainer_displacement, retainer_velocity, time_step):
    """``parameters`` = preload (N), cell stiffness (N/m), cell mass (kg), mass damping (1/s),
    shortening (m) at which
    an end cell opens; ``integers`` = [n inner nodes, n >= 2].

    ``state`` = displacements from the installed state (n), velocities (n), dissipated energy. Every
    damping factor is
    exp(-alpha h / 2) on either side of the kick, so a front decays by exactly exp(-mu t), mu =
    alpha / 2, at unit Courant number.
    """
    n = integers[0]
    top, bottom = (
        max(retainer_displacement - state[n - 1], parameters[4]),
        max(state[0], parameters[4]),
    )
    retainer, seat = parameters[0] + parameters[1] * top, parameters[0] + parameters[1] * bottom
    if time_step > 0.0:
        half = math.exp(-0.5 * parameters[3] * time_step)
        gain = time_step * parameters[1] / parameters[2]
        first, last = state[1] - state[0] - bottom, top - state[n - 1] + state[n - 2]
        lost = _kick(parameters, integers, state, time_step, half)
        lost += _kick_end(state, 0, n, gain, first, half) + _kick_end(
            state, n - 1, n, gain, last, half
        )
        _drift(integers, state, time_step)
        state[2 * n] += 0.5 * (1.0 - half * half) * parameters[2] * lost
    return retainer, seat
