"""Compiled step of the modal spring: oscillators hung between seat and retainer, each stepped
exactly.
"""

from __future__ import annotations

import math
from typing import Any

from valvetrain.compiled import njit

HEADER = 4
PER_MODE = 5
#: Nothing is allocated, so no reference counting.
OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy", "_nrt": False}


@njit(**OPTIONS)
def _prepare(parameters, n, state, time_step):
    """Step factors of every mode: decay exp(-2 z w h) and pull (1 + decay - 2 exp(-z w h) cos(w_d
    h)) / h.
    """
    for i in range(n):
        base = HEADER + PER_MODE * i
        omega, ratio = parameters[base + 1], parameters[base + 2]
        fade = math.exp(-ratio * omega * time_step)
        turned = math.cos(omega * math.sqrt(1.0 - ratio * ratio) * time_step)
        state[2 * n + 2 + i] = fade * fade
        state[3 * n + 2 + i] = (1.0 + fade * fade - 2.0 * fade * turned) / time_step
    state[2 * n + 1] = time_step


@njit(**OPTIONS)
def advance_modal(parameters, integers, state, retainer_displacement, retainer_velocity, time_step):
    """``parameters`` = preload (N), rate (N/m), mass damping (1/s), 1 where it cannot pull, then
    per mode:
    shape share c (-), circular frequency (rad/s),
    damping ratio (-), modal stiffness (N/m), seat factor (N/m). ``integers`` = [n modes]. ``state``
    = positions (n), velocities (n),
    dissipated energy, last step, decay and pull of every mode at that step.

    Mode n moves p = q + c x (absolute), q being the departure from the static shape; it is pulled
    by its stiffness times (p - c x) and
    damped on its rate (p' - c x'). With constant x the sampled motion is the exact damped
    oscillation at any step. While stepping, the
    rate at t_n is the mean of the half-step velocities around it, so the damping forces are of
    second order too.
    """
    n = integers[0]
    force = parameters[0] + parameters[1] * retainer_displacement
    retainer, seat, lost, fade = force, force, 0.0, 1.0
    if time_step > 0.0:
        if state[2 * n + 1] != time_step:
            _prepare(parameters, n, state, time_step)
        fade = math.exp(-0.5 * parameters[2] * time_step)
    for i in range(n):
        base = HEADER + PER_MODE * i
        share, omega, stiffness = parameters[base], parameters[base + 1], parameters[base + 3]
        departure, before, carried = (
            state[i] - share * retainer_displacement,
            state[n + i],
            share * retainer_velocity,
        )
        now = before
        if time_step > 0.0:
            kicked = (
                carried
                + state[2 * n + 2 + i] * (fade * before - carried)
                - state[3 * n + 2 + i] * departure
            )
            state[n + i] = fade * kicked
            state[i] += time_step * fade * kicked
            now = 0.5 * (before + fade * kicked)
            lost += (
                0.5
                * stiffness
                / (omega * omega)
                * (1.0 - fade * fade)
                * (before * before + kicked * kicked)
            )
        lag = 2.0 * parameters[base + 2] / omega * (now - carried)
        retainer -= share * stiffness * (departure + lag)
        seat += parameters[base + 4] * (departure + lag)
        lost += time_step * stiffness * lag * (now - carried)
    state[2 * n] += lost
    if parameters[3] > 0.0:
        retainer, seat = max(retainer, 0.0), max(seat, 0.0)
    return retainer, seat


@njit(**OPTIONS)
def advance_modal_varied(
    parameters, integers, state, retainer_displacement, retainer_velocity, time_step
):
    """As :func:`advance_modal` with a static curve: ``parameters`` = precompression (m), mass
    damping (1/s), 0, 1 where it cannot pull, per
    mode share,
    circular frequency, damping ratio, stiffness over k(x), seat factor over k(x); then compressions
    (m) and forces (N) of the curve.
    ``integers`` = [n modes, points of the curve]. The modes move as with constant stiffness; their
    forces are scaled by k(x) = F(x) / x.
    """
    n, points = integers[0], integers[1]
    at, curve = parameters[0] + retainer_displacement, HEADER + PER_MODE * n
    low, high = 0, points - 1
    while high - low > 1:
        middle = (low + high) // 2
        if parameters[curve + middle] <= at:
            low = middle
        else:
            high = middle
    x, f = curve + low, curve + points + low
    slope = (parameters[f + 1] - parameters[f]) / (parameters[x + 1] - parameters[x])
    force = parameters[f] + slope * (at - parameters[x])
    varied = force / at if at > 0.0 else slope
    retainer, seat, lost = force, force, 0.0
    if time_step > 0.0 and state[2 * n + 1] != time_step:
        _prepare(parameters, n, state, time_step)
    for i in range(n):
        base = HEADER + PER_MODE * i
        share, omega, stiffness = (
            parameters[base],
            parameters[base + 1],
            varied * parameters[base + 3],
        )
        departure, before, carried = (
            state[i] - share * retainer_displacement,
            state[n + i],
            share * retainer_velocity,
        )
        now = before
        if time_step > 0.0:
            kicked = (
                carried
                + state[2 * n + 2 + i] * (before - carried)
                - state[3 * n + 2 + i] * departure
            )
            state[n + i] = kicked
            state[i] += time_step * kicked
            now = 0.5 * (before + kicked)
        lag = 2.0 * parameters[base + 2] / omega * (now - carried)
        retainer -= share * stiffness * (departure + lag)
        seat += varied * parameters[base + 4] * (departure + lag)
        lost += time_step * stiffness * lag * (now - carried)
    state[2 * n] += lost
    if parameters[3] > 0.0:
        retainer, seat = max(retainer, 0.0), max(seat, 0.0)
    return retainer, seat
