"""Compiled step of a chain of masses with unilateral coil contact. Free of allocation.

``integers`` = [n inner masses, p contacts, r of them in the regular run, e with a fixed end, 1 where the ends pull, then p
upper and p lower nodes, then first node, length and place in the weights of the rows of those e, which are the last]; nodes
0 = seat, n + 1 = retainer. In the run both nodes count up by one and the fraction is constant, so its overlaps are one
vectorised loop. Ends that do not pull are open while their element is longer than free: it then carries neither elastic nor
damping force. Last in ``integers``: address of the law of contact (``coil_contact.kernels``).
``parameters`` = [initial compression (m), mass damping (1/s), stiffness damping (s), contact damping time (s)], stiffness
(n + 1), masses (n), inverse masses (n), then per contact gap, stiffness, fraction (p each), weights of the end rows, numbers
of the law of contact.

| ``state`` from | length | what |
|---|---|---|
| 0, n | n, n | positions (m) and velocities (m/s) of the inner masses |
| 2 n | 1 | dissipated energy (J) |
| 2 n + 1 | n + 2 | forces (N) of all nodes; this and the rest is scratch |
| 3 n + 3 | n + 2 | positions of all nodes |
| 4 n + 5 | n + 2 | their velocities at the half step before |
| 5 n + 7 | n + 2 | their predicted velocities |
| 6 n + 9 | p, p, p | overlap (m), damping impulse (N s) of the last step, and list of the closed contacts |

Damping works on w = v + (h/2) a, v the half-step velocity and a the acceleration by elastic and
contact forces: second order, and stable
as long as h**2 K < 4 and h C < 2 (mass-scaled), for the energy then falls by h w C (w - h C w / 2)
a step. A contact's loss is booked
half at the rate before and half at the rate after the kick.

Each vectorised loop is a small function of its own that slices the whole arrays and holds no
branch.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from valvetrain.coil_contact.kernels import (
    LINEAR,
    WIDTH,
    linear_contact,
    linear_damping,
    own_contact,
    own_damping,
)
from valvetrain.compiled import njit

HEADER = 4
INTEGER_HEADER = 5
#: Sums may be reordered (vectorised); nothing that hides a NaN.
FAST = {"reassoc", "contract", "nsz"}
#: No reference counting (nothing is allocated): a slice that lives across a call or a branch would
#: pay for it atomically.
KERNEL: dict[str, Any] = {"cache": True, "error_model": "numpy", "_nrt": False}
#: Compiled into each kernel that calls it, and stored with those alone.
BRANCH: dict[str, Any] = {**KERNEL, "cache": False, "forceinline": True}
LOOP: dict[str, Any] = {**BRANCH, "fastmath": FAST}


def state_size(masses: int, contacts: int) -> int:
    """Length of the state buffer, scratch included."""
    return 6 * masses + 9 + 3 * contacts


def overlap_place(masses: int) -> int:
    """Place in the state of the overlaps (m) of the contacts; their damping impulses (N s) of the
    last step follow.
    """
    return 6 * masses + 9


@njit(**LOOP)
def _place_nodes(integers, state, top, top_velocity):
    """Positions and velocities of all nodes, ends included, and no forces."""
    n = integers[0]
    forces, positions, velocities = (
        state[2 * n + 1 : 3 * n + 3],
        state[3 * n + 4 : 4 * n + 4],
        state[4 * n + 6 : 5 * n + 6],
    )
    inner, rates = state[:n], state[n : 2 * n]
    for i in range(n + 2):
        forces[i] = 0.0
    for i in range(n):
        positions[i] = inner[i]
    for i in range(n):
        velocities[i] = rates[i]
    state[3 * n + 3], state[4 * n + 4] = 0.0, top
    state[4 * n + 5], state[5 * n + 6] = 0.0, top_velocity


@njit(**LOOP)
def _element_forces(parameters, integers, state):
    """Add the elastic net force of the elements to every node, towards the seat."""
    n = integers[0]
    lower, upper = parameters[HEADER : HEADER + n], parameters[HEADER + 1 : HEADER + n + 1]
    below, here, above = (
        state[3 * n + 3 : 4 * n + 3],
        state[3 * n + 4 : 4 * n + 4],
        state[3 * n + 5 : 4 * n + 5],
    )
    inner = state[2 * n + 2 : 3 * n + 2]
    for i in range(n):
        inner[i] += upper[i] * (above[i] - here[i]) - lower[i] * (here[i] - below[i])
    state[2 * n + 1] += parameters[HEADER] * (state[3 * n + 4] - state[3 * n + 3])
    state[3 * n + 2] -= parameters[HEADER + n] * (state[4 * n + 4] - state[4 * n + 3])


@njit(**BRANCH)
def _loosen(parameters, integers, state):
    """Take the tension of the end elements back."""
    n = integers[0]
    low = parameters[HEADER] * (state[3 * n + 4] - state[3 * n + 3])
    high = parameters[HEADER + n] * (state[4 * n + 4] - state[4 * n + 3])
    if low < 0.0:
        state[2 * n + 1] -= low
        state[2 * n + 2] += low
    if high < 0.0:
        state[3 * n + 2] += high
        state[3 * n + 1] -= high


@njit(**BRANCH)
def _loosen_damping(parameters, integers, state):
    """Take back what the dampers of the end elements pull beyond their elastic force; returns the
    power lost too much.
    """
    n, lost = integers[0], 0.0
    rate = state[5 * n + 8] - state[5 * n + 7]
    damping = parameters[2] * parameters[HEADER] * rate
    elastic = max(parameters[HEADER] * (state[3 * n + 4] - state[3 * n + 3]), 0.0)
    excess = damping - (max(damping, -elastic) if elastic > 0.0 else 0.0)
    state[2 * n + 1] -= excess
    state[2 * n + 2] += excess
    lost += excess * rate
    rate = state[6 * n + 8] - state[6 * n + 7]
    damping = parameters[2] * parameters[HEADER + n] * rate
    elastic = max(parameters[HEADER + n] * (state[4 * n + 4] - state[4 * n + 3]), 0.0)
    excess = damping - (max(damping, -elastic) if elastic > 0.0 else 0.0)
    state[3 * n + 2] += excess
    state[3 * n + 1] -= excess
    return lost + excess * rate


@njit(**LOOP)
def _predict(parameters, integers, state, half, time_step):
    """Velocities at t_n as elastic and contact forces alone would have them, ends included."""
    n = integers[0]
    inverse, rates = parameters[HEADER + 2 * n + 1 : HEADER + 3 * n + 1], state[n : 2 * n]
    forces, predicted = state[2 * n + 2 : 3 * n + 2], state[5 * n + 8 : 6 * n + 8]
    for i in range(n):
        predicted[i] = half * rates[i] + 0.5 * time_step * inverse[i] * forces[i]
    state[5 * n + 7], state[6 * n + 8] = 0.0, state[5 * n + 6]


@njit(**LOOP)
def _element_damping(parameters, integers, state, time_step):
    """Add the element damping forces to every node; returns the power lost."""
    n, beta = integers[0], parameters[2]
    lower, upper = parameters[HEADER : HEADER + n], parameters[HEADER + 1 : HEADER + n + 1]
    below, here, above = (
        state[5 * n + 7 : 6 * n + 7],
        state[5 * n + 8 : 6 * n + 8],
        state[5 * n + 9 : 6 * n + 9],
    )
    inner, inverse = (
        state[2 * n + 2 : 3 * n + 2],
        parameters[HEADER + 2 * n + 1 : HEADER + 3 * n + 1],
    )
    first, last = (
        beta * parameters[HEADER] * state[5 * n + 8],
        beta * parameters[HEADER + n] * (state[6 * n + 8] - state[6 * n + 7]),
    )
    state[2 * n + 1] += first
    state[3 * n + 2] -= last
    lost = last * (state[6 * n + 8] - state[6 * n + 7])
    for i in range(n):
        rate = here[i] - below[i]
        force = beta * (upper[i] * (above[i] - here[i]) - lower[i] * rate)
        lost += beta * lower[i] * rate * rate - 0.5 * time_step * inverse[i] * force * force
        inner[i] += force
    return lost


@njit(**LOOP)
def _regular_overlaps(parameters, integers, state):
    """Overlap (m) of the contacts of the run into the scratch of ``state``."""
    n, p, run = integers[0], integers[1], integers[2]
    start, depth_at = HEADER + 3 * n + 1, 6 * n + 9
    gaps, depths = parameters[start : start + run], state[depth_at : depth_at + run]
    share, first, second = (
        parameters[start + 2 * p],
        integers[INTEGER_HEADER] - 1,
        integers[INTEGER_HEADER + p] - 1,
    )
    upper, lower, next_lower = (
        state[first : first + run],
        state[second : second + run],
        state[second + 1 : second + 1 + run],
    )
    for c in range(run):
        depths[c] = upper[c] - (1.0 - share) * lower[c] - share * next_lower[c] - gaps[c]


@njit(**LOOP)
def _row_dot(parameters, state, weight, node, length):
    """Product of an end row with the nodal values it spans."""
    weights, values, total = parameters[weight : weight + length], state[node : node + length], 0.0
    for i in range(length):
        total += weights[i] * values[i]
    return total


@njit(**BRANCH)
def _across(parameters, integers, state, at, c):
    """Difference across contact ``c`` of the nodal values at ``state[at:]``."""
    p, end = integers[1], c - integers[1] + integers[3]
    if end >= 0:
        start, e = INTEGER_HEADER + 2 * p + end, integers[3]
        weight = HEADER + 3 * integers[0] + 1 + 3 * p + integers[start + 2 * e]
        return _row_dot(parameters, state, weight, at + integers[start], integers[start + e])
    lower, share = (
        at + integers[INTEGER_HEADER + p + c],
        parameters[HEADER + 3 * integers[0] + 1 + 2 * p + c],
    )
    return (
        state[at + integers[INTEGER_HEADER + c]]
        - state[lower]
        - share * (state[lower + 1] - state[lower])
    )


@njit(**BRANCH)
def _press(parameters, integers, state, c, force):
    """Contact ``c`` pushes its partners apart with ``force`` (N)."""
    n, p, end = integers[0], integers[1], c - integers[1] + integers[3]
    if end >= 0:
        start, e = INTEGER_HEADER + 2 * p + end, integers[3]
        node, weight = (
            2 * n + 1 + integers[start],
            HEADER + 3 * n + 1 + 3 * p + integers[start + 2 * e],
        )
        for i in range(integers[start + e]):
            state[node + i] -= parameters[weight + i] * force
        return
    lower, share = (
        2 * n + 1 + integers[INTEGER_HEADER + p + c],
        parameters[HEADER + 3 * n + 1 + 2 * p + c],
    )
    state[2 * n + 1 + integers[INTEGER_HEADER + c]] -= force
    state[lower] += (1.0 - share) * force
    if share > 0.0:
        state[lower + 1] += share * force


def _contact_kernels(own_law: bool) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Kernels of contact forces and of their damping: by the linear law, inlined, or by the law at
    an address, so that the branches of one do not slow the other down.
    """
    respond, resist = (own_contact, own_damping) if own_law else (linear_contact, linear_damping)

    def contact_forces(parameters, integers, state):
        """Elastic contact forces; lists the contacts that are closed or were so a step ago and
        returns their number.
        """
        n, p = integers[0], integers[1]
        start, depth_at, law = HEADER + 3 * n + 1, 6 * n + 9, integers[len(integers) - 1]
        row = parameters.ctypes.data + 8 * (len(parameters) - WIDTH) if own_law else 0
        for c in range(integers[2], p):
            state[depth_at + c] = (
                _across(parameters, integers, state, 3 * n + 3, c) - parameters[start + c]
            )
        closed = 0
        for c in range(p):
            depth = state[depth_at + c]
            if depth > 0.0 or state[depth_at + p + c] != 0.0:
                state[depth_at + 2 * p + closed] = float(c)
                closed += 1
                if depth > 0.0:
                    stiffness = parameters[start + p + c]
                    _, elastic = respond(law, row, stiffness, 0.0, depth, 0.0)
                    _press(parameters, integers, state, c, elastic)
        return closed

    def contact_damping(parameters, integers, state, closed, time_step):
        """Damping forces of the ``closed`` contacts, never adhesive; returns the energy lost in
        them since the last step.
        """
        n, p = integers[0], integers[1]
        start, depth_at, lost = HEADER + 3 * n + 1, 6 * n + 9, 0.0
        law = integers[len(integers) - 1]
        row = parameters.ctypes.data + 8 * (len(parameters) - WIDTH) if own_law else 0
        for k in range(closed):
            c = int(state[depth_at + 2 * p + k])
            depth, damping = state[depth_at + c], 0.0
            if depth > 0.0:
                closing = _across(parameters, integers, state, 5 * n + 7, c)
                stiffness = parameters[start + p + c]
                damping = resist(law, row, stiffness, parameters[3], depth, closing)
                _press(parameters, integers, state, c, damping)
            if time_step > 0.0:
                rate = _across(parameters, integers, state, 4 * n + 5, c)
                lost += 0.5 * rate * (state[depth_at + p + c] + time_step * damping)
                state[depth_at + p + c] = time_step * damping
        return lost

    for kernel in (contact_forces, contact_damping):
        # compiled code of equal name from two cached runs would be taken for the same
        kernel.__qualname__ = f"{'own' if own_law else 'linear'}_{kernel.__name__}"
    compiled = njit(**(KERNEL if own_law else BRANCH))
    return compiled(contact_forces), compiled(contact_damping)


_contact_forces, _contact_damping = _contact_kernels(own_law=False)
_own_contact_forces, _own_contact_damping = _contact_kernels(own_law=True)


@njit(**LOOP)
def _kick_and_drift(parameters, integers, state, half, time_step):
    """Half damping, kick, half damping (symmetric, exact for the damping alone), drift."""
    n = integers[0]
    inverse = parameters[HEADER + 2 * n + 1 : HEADER + 3 * n + 1]
    positions, velocities, inner = state[:n], state[n : 2 * n], state[2 * n + 2 : 3 * n + 2]
    for i in range(n):
        velocity = half * (half * velocities[i] + time_step * inverse[i] * inner[i])
        velocities[i] = velocity
        positions[i] += time_step * velocity


@njit(**LOOP)
def _mass_damping_loss(parameters, integers, state, half):
    """Energy that the two half dampings took, from the velocities before and after the kick."""
    n, lost = integers[0], 0.0
    masses, before, after = (
        parameters[HEADER + n + 1 : HEADER + 2 * n + 1],
        state[4 * n + 6 : 5 * n + 6],
        state[n : 2 * n],
    )
    for i in range(n):
        kicked = after[i] / half
        lost += masses[i] * (before[i] * before[i] + kicked * kicked)
    return 0.5 * (1.0 - half * half) * lost


@njit(**KERNEL)
def advance_chain(parameters, integers, state, retainer_displacement, retainer_velocity, time_step):
    """One step of the spring contract for a chain (see the module text for the arrays)."""
    n, closed, lost = integers[0], 0, 0.0
    half = math.exp(-0.5 * parameters[1] * time_step) if parameters[1] > 0.0 else 1.0
    _place_nodes(integers, state, parameters[0] + retainer_displacement, retainer_velocity)
    _element_forces(parameters, integers, state)
    if integers[4] == 0:
        _loosen(parameters, integers, state)
    if integers[1] > 0:
        if integers[2] > 0:
            _regular_overlaps(parameters, integers, state)
        if integers[len(integers) - 1] == LINEAR:
            closed = _contact_forces(parameters, integers, state)
        else:
            closed = _own_contact_forces(parameters, integers, state)
    if closed > 0 or parameters[2] > 0.0:
        _predict(parameters, integers, state, half, time_step)
        if parameters[2] > 0.0:
            lost += time_step * _element_damping(parameters, integers, state, time_step)
            if integers[4] == 0:
                lost -= time_step * _loosen_damping(parameters, integers, state)
        if integers[len(integers) - 1] == LINEAR:
            lost += _contact_damping(parameters, integers, state, closed, time_step)
        else:
            lost += _own_contact_damping(parameters, integers, state, closed, time_step)
    retainer, seat = -state[3 * n + 2], state[2 * n + 1]
    if time_step > 0.0:
        _kick_and_drift(parameters, integers, state, half, time_step)
        if half < 1.0:
            lost += _mass_damping_loss(parameters, integers, state, half)
        state[2 * n] += lost
    return retainer, seat
