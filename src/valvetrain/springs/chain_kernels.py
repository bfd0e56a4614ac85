"""Compiled step of a chain of masses with unilateral coil contact. Free of allocation.

``integers`` = [n inner masses, p contacts, r of them in the regular run, then p upper and p lower nodes]; nodes 0 = seat, n + 1 =
retainer. In the run both nodes count up by one and the fraction is constant, so its overlaps are one vectorised loop.
``parameters`` = [initial compression (m), mass damping (1/s), stiffness damping (s), contact damping time (s)],
stiffness (n + 1), masses (n), inverse masses (n), then per contact gap, stiffness, fraction (p each).
``state`` = positions (n), velocities (n), dissipated energy, scratch (forces, positions, velocities of all nodes, n + 2 each; overlaps,
p), damping impulse of the last step per contact (p): its work is taken half at the rate before, half at the rate after the
kick, which closes the energy balance to second order.

Each vectorised loop is a small function of its own that slices the whole arrays and holds no branch.
"""

from __future__ import annotations

import math

from numba import njit

HEADER = 4
INTEGER_HEADER = 3
#: Sums may be reordered (vectorised); nothing that hides a NaN.
FAST = {"reassoc", "contract", "nsz"}
#: No reference counting (nothing is allocated): a slice that lives across a call or a branch would pay for it atomically.
BRANCH = {"cache": True, "error_model": "numpy", "_nrt": False, "forceinline": True}
LOOP = {**BRANCH, "fastmath": FAST}


def state_size(masses: int, contacts: int) -> int:
    """Length of the state buffer, scratch included."""
    return 5 * masses + 7 + 2 * contacts


@njit(**LOOP)
def _place_nodes(parameters, integers, state, top, top_velocity):
    """Positions and velocities of all nodes, ends included, so that contacts need not ask which end they touch."""
    n = integers[0]
    at = 3 * n + 3
    inner, values = state[at + 1 : at + n + 1], state[:n]
    for i in range(n):
        inner[i] = values[i]
    moving, rates = state[at + n + 3 : at + 2 * n + 3], state[n : 2 * n]
    for i in range(n):
        moving[i] = rates[i]
    state[at], state[at + n + 1] = 0.0, top
    state[at + n + 2], state[at + 2 * n + 3] = 0.0, top_velocity


@njit(**LOOP)
def _regular_overlaps(parameters, integers, state):
    """Overlap (m) of the contacts of the run into the scratch of ``state``."""
    n, p, run = integers[0], integers[1], integers[2]
    start, depth_at = HEADER + 3 * n + 1, 5 * n + 7
    gaps, depths = parameters[start : start + run], state[depth_at : depth_at + run]
    share, first, second = parameters[start + 2 * p], integers[INTEGER_HEADER] - 1, integers[INTEGER_HEADER + p] - 1
    upper, lower, next_lower = state[first : first + run], state[second : second + run], state[second + 1 : second + 1 + run]
    for c in range(run):
        depths[c] = upper[c] - (1.0 - share) * lower[c] - share * next_lower[c] - gaps[c]


@njit(**BRANCH)
def _other_overlaps(parameters, integers, state):
    """The same for all other contacts."""
    n, p = integers[0], integers[1]
    start, node_at, depth_at = HEADER + 3 * n + 1, 3 * n + 3, 5 * n + 7
    for c in range(integers[2], p):
        lower, share = node_at + integers[INTEGER_HEADER + p + c], parameters[start + 2 * p + c]
        below = state[lower] + share * (state[lower + 1] - state[lower])
        state[depth_at + c] = state[node_at + integers[INTEGER_HEADER + c]] - below - parameters[start + c]


@njit(**BRANCH)
def _contact_forces(parameters, integers, state, time_step):
    """Add the forces of closed contacts to the node forces; returns the energy lost in them since the last step."""
    n, p = integers[0], integers[1]
    start, force_at, rate_at, depth_at, lost = HEADER + 3 * n + 1, 2 * n + 1, 4 * n + 5, 5 * n + 7, 0.0
    for c in range(p):
        depth, pending = state[depth_at + c], state[depth_at + p + c]
        if depth > 0.0 or pending != 0.0:
            upper, lower, share = integers[INTEGER_HEADER + c], integers[INTEGER_HEADER + p + c], parameters[start + 2 * p + c]
            below = state[rate_at + lower]
            rate = state[rate_at + upper] - below - share * (state[rate_at + lower + 1] - below)
            damping = 0.0
            if depth > 0.0:
                elastic = parameters[start + p + c] * depth
                force = max(0.0, elastic + parameters[start + p + c] * parameters[3] * rate)
                damping = force - elastic
                state[force_at + upper] -= force
                state[force_at + lower] += (1.0 - share) * force
                state[force_at + lower + 1] += share * force
            if time_step > 0.0:
                lost += 0.5 * rate * (pending + time_step * damping)
                state[depth_at + p + c] = time_step * damping
    return lost


@njit(**LOOP)
def _element_forces(parameters, integers, state, start, factor):
    """Add ``factor`` times the net element force of the nodal values at ``state[start:]`` to nodes 2 .. n - 1."""
    n = integers[0]
    lower, upper = parameters[HEADER + 1 : HEADER + n - 1], parameters[HEADER + 2 : HEADER + n]
    below, here, above = state[start : start + n - 2], state[start + 1 : start + n - 1], state[start + 2 : start + n]
    inner = state[2 * n + 3 : 3 * n + 1]
    for i in range(n - 2):
        inner[i] += factor * (upper[i] * (above[i] - here[i]) - lower[i] * (here[i] - below[i]))


@njit(**BRANCH)
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


@njit(**LOOP)
def _element_loss(parameters, integers, state, top):
    """Sum of stiffness times squared rate over the elements (W per s of stiffness damping)."""
    n = integers[0]
    stiffness, below, above = parameters[HEADER + 1 : HEADER + n], state[n : 2 * n - 1], state[n + 1 : 2 * n]
    lost = 0.0
    for i in range(n - 1):
        lost += stiffness[i] * (above[i] - below[i]) ** 2
    return lost + parameters[HEADER] * state[n] ** 2 + parameters[HEADER + n] * (top - state[2 * n - 1]) ** 2


@njit(**LOOP)
def _clear(integers, state):
    forces = state[2 * integers[0] + 1 : 3 * integers[0] + 3]
    for i in range(forces.shape[0]):
        forces[i] = 0.0


@njit(**LOOP)
def _kick_and_drift(parameters, integers, state, time_step):
    n = integers[0]
    inverse = parameters[HEADER + 2 * n + 1 : HEADER + 3 * n + 1]
    positions, velocities, inner = state[:n], state[n : 2 * n], state[2 * n + 2 : 3 * n + 2]
    for i in range(n):
        velocities[i] += time_step * inverse[i] * inner[i]
        positions[i] += time_step * velocities[i]


@njit(**LOOP)
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


@njit(cache=True, error_model="numpy", _nrt=False)
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
    if p > 0:
        _place_nodes(parameters, integers, state, top, retainer_velocity)
        if run > 0:
            _regular_overlaps(parameters, integers, state)
        _other_overlaps(parameters, integers, state)
        contact_loss = _contact_forces(parameters, integers, state, time_step)
    retainer, seat = -state[3 * n + 2], state[2 * n + 1]
    if time_step > 0.0:
        heat = 0.0
        if parameters[1] > 0.0:
            heat = _kick_and_drift_damped(parameters, integers, state, math.exp(-0.5 * parameters[1] * time_step), time_step)
        else:
            _kick_and_drift(parameters, integers, state, time_step)
        state[2 * n] += time_step * lost + heat + contact_loss
    return retainer, seat
