"""Compiled step of a chain of masses with unilateral coil contact. Free of allocation.

``integers`` = [n inner masses, p contacts, r of them in the regular run, then p upper and p lower nodes]; nodes 0 = seat, n + 1 =
retainer. In the run both nodes count up by one and the fraction is constant, so its overlaps are one vectorised loop.
``parameters`` = [initial compression (m), mass damping (1/s), stiffness damping (s), contact damping time (s)],
stiffness (n + 1), masses (n), inverse masses (n), then per contact gap, stiffness, fraction (p each).
``state`` = positions (n), velocities (n), dissipated energy, node forces (n + 2, scratch), overlaps (p,
scratch), damping impulse of the last step per contact (p): its work is taken half at the rate before, half at the rate after the
kick, which closes the energy balance to second order.

Each vectorised loop is a small function of its own that slices the whole arrays and holds no branch: slices that live across a
call or a branch are reference-counted (atomically), which tripled the time of a 77-mass step.
"""

from __future__ import annotations

import math

from numba import njit

HEADER = 4
INTEGER_HEADER = 3
#: Sums may be reordered (vectorised); nothing that hides a NaN.
FAST = {"reassoc", "contract", "nsz"}


def state_size(masses: int, contacts: int) -> int:
    """Length of the state buffer, scratch included."""
    return 3 * masses + 3 + 2 * contacts


@njit(cache=True)
def _across(parameters, integers, state, start, top, c):
    """Difference across contact ``c`` of the nodal values at ``state[start:]`` (0 at the seat, ``top`` at the retainer)."""
    n, p = integers[0], integers[1]
    upper, lower, share = integers[INTEGER_HEADER + c], integers[INTEGER_HEADER + p + c], parameters[HEADER + 3 * n + 1 + 2 * p + c]
    low = 0.0 if lower == 0 else (top if lower == n + 1 else state[start + lower - 1])
    if share > 0.0:
        high = top if lower == n else state[start + lower]
        low += share * (high - low)
    return (top if upper == n + 1 else state[start + upper - 1]) - low


@njit(cache=True, fastmath=FAST)
def _regular_overlaps(parameters, integers, state):
    """Overlap (m) of the contacts of the run into the scratch of ``state``."""
    n, p, run = integers[0], integers[1], integers[2]
    start = HEADER + 3 * n + 1
    gaps, depths = parameters[start : start + run], state[3 * n + 3 : 3 * n + 3 + run]
    share, first, second = parameters[start + 2 * p], integers[INTEGER_HEADER] - 1, integers[INTEGER_HEADER + p] - 1
    upper, lower, next_lower = state[first : first + run], state[second : second + run], state[second + 1 : second + 1 + run]
    for c in range(run):
        depths[c] = upper[c] - (1.0 - share) * lower[c] - share * next_lower[c] - gaps[c]


@njit(cache=True)
def _contact_forces(parameters, integers, state, top_velocity, time_step):
    """Add the forces of closed contacts to the node forces; returns the energy lost in them since the last step."""
    n, p = integers[0], integers[1]
    start, force_at, depth_at, tau, lost = HEADER + 3 * n + 1, 2 * n + 1, 3 * n + 3, parameters[3], 0.0
    for c in range(p):
        depth, pending = state[depth_at + c], state[depth_at + p + c]
        if depth > 0.0 or pending != 0.0:
            rate = _across(parameters, integers, state, n, top_velocity, c)
            damping = 0.0
            if depth > 0.0:
                lower, share = integers[INTEGER_HEADER + p + c], parameters[start + 2 * p + c]
                elastic = parameters[start + p + c] * depth
                force = max(0.0, elastic + parameters[start + p + c] * tau * rate)
                damping = force - elastic
                state[force_at + integers[INTEGER_HEADER + c]] -= force
                state[force_at + lower] += (1.0 - share) * force
                if share > 0.0:
                    state[force_at + lower + 1] += share * force
            if time_step > 0.0:
                lost += 0.5 * rate * (pending + time_step * damping)
                state[depth_at + p + c] = time_step * damping
    return lost


@njit(cache=True, fastmath=FAST)
def _element_forces(parameters, integers, state, start, factor):
    """Add ``factor`` times the net element force of the nodal values at ``state[start:]`` to nodes 2 .. n - 1."""
    n = integers[0]
    lower, upper = parameters[HEADER + 1 : HEADER + n - 1], parameters[HEADER + 2 : HEADER + n]
    below, here, above = state[start : start + n - 2], state[start + 1 : start + n - 1], state[start + 2 : start + n]
    inner = state[2 * n + 3 : 3 * n + 1]
    for i in range(n - 2):
        inner[i] += factor * (upper[i] * (above[i] - here[i]) - lower[i] * (here[i] - below[i]))


@njit(cache=True)
def _end_elements(parameters, integers, state, start, top, factor):
    """The same for the two end nodes on either side (seat, 1, n, retainer)."""
    n = integers[0]
    first = factor * parameters[HEADER] * state[start]
    last = factor * parameters[HEADER + n] * (top - state[start + n - 1])
    state[2 * n + 1] += first
    state[2 * n + 2] -= first
    state[3 * n + 1] += last
    state[3 * n + 2] -= last
    if n > 1:
        state[2 * n + 2] += factor * parameters[HEADER + 1] * (state[start + 1] - state[start])
        state[3 * n + 1] -= factor * parameters[HEADER + n - 1] * (state[start + n - 1] - state[start + n - 2])


@njit(cache=True, fastmath=FAST)
def _element_loss(parameters, integers, state, top):
    """Sum of stiffness times squared rate over the elements (W per s of stiffness damping)."""
    n = integers[0]
    stiffness, below, above = parameters[HEADER + 1 : HEADER + n], state[n : 2 * n - 1], state[n + 1 : 2 * n]
    lost = 0.0
    for i in range(n - 1):
        lost += stiffness[i] * (above[i] - below[i]) ** 2
    return lost + parameters[HEADER] * state[n] ** 2 + parameters[HEADER + n] * (top - state[2 * n - 1]) ** 2


@njit(cache=True, fastmath=FAST)
def _clear(integers, state):
    forces = state[2 * integers[0] + 1 : 3 * integers[0] + 3]
    for i in range(forces.shape[0]):
        forces[i] = 0.0


@njit(cache=True, fastmath=FAST)
def _kick_and_drift(parameters, integers, state, time_step):
    n = integers[0]
    inverse = parameters[HEADER + 2 * n + 1 : HEADER + 3 * n + 1]
    positions, velocities, inner = state[:n], state[n : 2 * n], state[2 * n + 2 : 3 * n + 2]
    for i in range(n):
        velocities[i] += time_step * inverse[i] * inner[i]
        positions[i] += time_step * velocities[i]


@njit(cache=True, fastmath=FAST)
def _kick_and_drift_damped(parameters, integers, state, half, time_step):
    """Half damping, kick, half damping (symmetric, exact for the damping alone), drift; returns the energy lost."""
    n, lost = integers[0], 0.0
    masses, inverse = parameters[HEADER + n + 1 : HEADER + 2 * n + 1], parameters[HEADER + 2 * n + 1 : HEADER + 3 * n + 1]
    positions, velocities, inner = state[:n], state[n : 2 * n], state[2 * n + 2 : 3 * n + 2]
    for i in range(n):
        before = velocities[i]
        kicked = half * before + time_step * inverse[i] * inner[i]
        lost += masses[i] * (before * before + kicked * kicked)
        velocities[i] = half * kicked
        positions[i] += time_step * half * kicked
    return 0.5 * (1.0 - half * half) * lost


@njit(cache=True)
def advance_chain(parameters, integers, state, retainer_displacement, retainer_velocity, time_step):
    """One step of the spring contract for a chain (see the module text for the arrays)."""
    n, p, run, lost = integers[0], integers[1], integers[2], 0.0
    contact_loss = 0.0
    top, beta = parameters[0] + retainer_displacement, parameters[2]
    _clear(integers, state)
    _element_forces(parameters, integers, state, 0, 1.0)
    _end_elements(parameters, integers, state, 0, top, 1.0)
    if beta > 0.0:
        _element_forces(parameters, integers, state, n, beta)
        _end_elements(parameters, integers, state, n, retainer_velocity, beta)
        lost += beta * _element_loss(parameters, integers, state, retainer_velocity)
    if run > 0:
        _regular_overlaps(parameters, integers, state)
    for c in range(run, p):
        state[3 * n + 3 + c] = _across(parameters, integers, state, 0, top, c) - parameters[HEADER + 3 * n + 1 + c]
    if p > 0:
        contact_loss = _contact_forces(parameters, integers, state, retainer_velocity, time_step)
    retainer, seat = -state[3 * n + 2], state[2 * n + 1]
    if time_step > 0.0:
        heat = 0.0
        if parameters[1] > 0.0:
            heat = _kick_and_drift_damped(parameters, integers, state, math.exp(-0.5 * parameters[1] * time_step), time_step)
        else:
            _kick_and_drift(parameters, integers, state, time_step)
        state[2 * n] += time_step * lost + heat + contact_loss
    return retainer, seat
