"""Compiled step of a spring reduced from its rod (tables: ``springs.reduced_rod_tables``).

The potential energy in the coordinates z at the retainer displacement y is, with d = z - rest(y),
W(y) + load(y) d + d K(y) d / 2 + sum of k max(0, o)^2 / 2, o = overlap(y) + G(y) d: the wire's
elastic energy to second order about its equilibrium, contacts exact in o. Accelerations are its
slope by z, the force on the retainer that by y, and the force on the seat follows from the
momentum of the wire. Tables are straight between their lifts. Stiffness damping acts on the rate
of the elastic forces, that of contacts on the rate of o; both at the half-step velocity.

``integers`` = [m coordinates, p points, f fine lifts, c coarse lifts, fine per coarse, 1 where ends
pull, q coil pairs], pair of each point (p; -1: a seat).
``parameters`` = header (see ``HEADER``), contact stiffness (p), most that an acceleration of size
one moves the point (p), rest (f, m), load (f, m), overlap (f, p), wire's force (f), stiffness (c,
m, m), gradient (c, p, m), momentum (c, m).
``state`` = z (m), velocities (m), then (``HEAD``) dissipated energy, clock (s), time until which
the list of near points holds, their number, first position and velocity as left, size of the
accelerations and twice that with which times were set; scratch (4 m), the list (p), times when a
point is due (p), forces and stored energies of the pairs (q each). An open point is looked at again
when it may have closed, and all are where positions were changed from outside.
"""

from __future__ import annotations

import math
from typing import Any

from valvetrain.compiled import njit

#: First lift (m), spacing of fine lifts (m), mass damping (1/s), stiffness damping (s), contact
#: damping time (s).
HEADER = 5
#: Values between velocities and scratch; integers before the pairs.
HEAD, INTEGERS = 8, 7
#: Time (s) for which a list of near points is made and longest that a point is left alone; what
#: its closing speed (m/s) may gain on the way beside what the acceleration, which may double, gives.
HORIZON, LONGEST, SPARE_SPEED = 12e-6, 150e-6, 0.5
FAST = {"reassoc", "contract", "nsz"}
KERNEL: dict[str, Any] = {"cache": True, "error_model": "numpy", "_nrt": False, "fastmath": FAST}
INNER: dict[str, Any] = {**KERNEL, "forceinline": True}


def state_size(coordinates: int, points: int, pairs: int) -> int:
    """Length of the state buffer, scratch included."""
    return pairs_place(coordinates, points) + 2 * pairs


def pull_place(coordinates: int) -> int:
    """Place in the state of the accelerations by elastic, contact and stiffness damping forces."""
    return 5 * coordinates + HEAD


def pairs_place(coordinates: int, points: int) -> int:
    """Place in the state of the forces (N) of the coil pairs; their stored energies (J) follow."""
    return 6 * coordinates + HEAD + 2 * points


@njit(**INNER)
def _products(values, at, next_at, state, departure, rate, count):
    """Row of a table times departure and rate, at a lift and at the next."""
    here, there, here_rate, there_rate = 0.0, 0.0, 0.0, 0.0
    low, high = values[at : at + count], values[next_at : next_at + count]
    first, second = state[departure : departure + count], state[rate : rate + count]
    for i in range(count):
        here += low[i] * first[i]
        there += high[i] * first[i]
        here_rate += low[i] * second[i]
        there_rate += high[i] * second[i]
    return here, there - here, here_rate, there_rate - here_rate


@njit(**INNER)
def _row(values, at, next_at, state, departure, rate, count):
    """Row of the stiffness times departure, at a lift and how it grows to the next, and times rate."""
    here, there, damped = 0.0, 0.0, 0.0
    low, high = values[at : at + count], values[next_at : next_at + count]
    first, second = state[departure : departure + count], state[rate : rate + count]
    for i in range(count):
        here += low[i] * first[i]
        there += high[i] * first[i]
        damped += low[i] * second[i]
    return here, there - here, damped


@njit(**INNER)
def _push(parameters, at, next_at, state, place, count, low_share, high_share):
    """Add two rows of a table, each times a share, to a stretch of the state."""
    low, high = parameters[at : at + count], parameters[next_at : next_at + count]
    target = state[place : place + count]
    for i in range(count):
        target[i] += low_share * low[i] + high_share * high[i]


@njit(**KERNEL)
def advance_reduced(
    parameters, integers, state, retainer_displacement, retainer_velocity, time_step
):
    """One step of the spring contract for a spring reduced from its rod (see the module text)."""
    m, p, fines, coarses = integers[0], integers[1], integers[2], integers[3]
    velocity, beta, tau = retainer_velocity, parameters[3], parameters[4]
    per_fine = 1.0 / parameters[1]
    per_coarse = per_fine / integers[4]
    place = (retainer_displacement - parameters[0]) * per_fine
    fine = min(max(math.floor(place), 0), fines - 2)
    coarse = fine // integers[4]
    tf, tc = place - fine, place / integers[4] - coarse
    rest_at = HEADER + 2 * p + fine * m
    load_at = rest_at + fines * m
    overlap_at = HEADER + 2 * p + 2 * fines * m
    force_at = overlap_at + fines * p
    stiffness_at = force_at + fines
    gradient_at = stiffness_at + coarses * m * m
    momentum_at = gradient_at + coarses * p * m + coarse * m
    head = 2 * m
    apart, rate = head + HEAD, head + HEAD + m
    slope_at, pull_at = head + HEAD + 2 * m, head + HEAD + 3 * m
    for i in range(m):
        low = parameters[rest_at + i]
        step = parameters[rest_at + m + i] - low
        state[apart + i] = state[i] - low - tf * step
        state[slope_at + i] = step * per_fine
        state[rate + i] = state[m + i] - velocity * step * per_fine
    retainer = parameters[force_at + fine]
    growth = (parameters[force_at + fine + 1] - retainer) * per_fine
    retainer += tf * growth / per_fine + beta * growth * velocity
    lost = beta * growth * velocity * velocity
    for i in range(m):
        at = stiffness_at + (coarse * m + i) * m
        here, grows, damped = _row(parameters, at, at + m * m, state, apart, rate, m)
        low = parameters[load_at + i]
        turned = (parameters[load_at + m + i] - low) * per_fine
        viscous = beta * (damped + turned * velocity)
        state[pull_at + i] = -(here + tc * grows + low + tf * turned / per_fine + viscous)
        retainer += state[apart + i] * (turned + 0.5 * grows * per_coarse)
        lost += viscous * state[rate + i]
    listed, pairs = 6 * m + HEAD, integers[6]
    due, pressed = listed + p, listed + 2 * p
    clock = state[head + 1]
    every = time_step == 0.0 or state[0] != state[head + 4] or state[m] != state[head + 5]
    if every or clock >= state[head + 2] or state[head + 6] > state[head + 7]:
        every = every or state[head + 6] > state[head + 7]
        state[head + 7] = 2.0 * state[head + 6]
    strength = state[head + 7]
    if every or clock >= state[head + 2]:
        near = 0
        for c in range(p):
            if every or state[due + c] < clock + HORIZON:
                state[listed + near] = c
                near += 1
        state[head + 2], state[head + 3] = clock + HORIZON, near
    for pair in range(2 * pairs):
        state[pressed + pair] = 0.0
    for entry in range(int(state[head + 3])):
        c = int(state[listed + entry])
        if clock < state[due + c] and not every:
            continue
        low = overlap_at + fine * p + c
        step = (parameters[low + p] - parameters[low]) * per_fine
        at = gradient_at + (coarse * p + c) * m
        here, grows, moved, more = _products(parameters, at, at + p * m, state, apart, rate, m)
        overlap = parameters[low] + tf * step / per_fine + here + tc * grows
        by_travel = step + grows * per_coarse
        closing = by_travel * velocity + moved + tc * more
        state[due + c] = clock
        if overlap <= 0.0:
            start = abs(closing) + SPARE_SPEED
            gain = 2.0 * strength * parameters[HEADER + p + c]
            wait = -2.0 * overlap / (start + math.sqrt(start * start - gain * overlap))
            state[due + c] = clock + min(wait, LONGEST)
            continue
        elastic = parameters[HEADER + c] * overlap
        force = max(0.0, elastic + tau * parameters[HEADER + c] * closing)
        retainer += force * by_travel
        lost += (force - elastic) * closing
        if integers[INTEGERS + c] >= 0:
            state[pressed + integers[INTEGERS + c]] += force
            state[pressed + pairs + integers[INTEGERS + c]] += 0.5 * elastic * overlap
        _push(parameters, at, at + p * m, state, pull_at, m, (tc - 1.0) * force, -tc * force)
    seat, size = 0.0, 0.0
    for i in range(m):
        size += state[pull_at + i] * state[pull_at + i]
        low = parameters[momentum_at + i]
        retainer += state[slope_at + i] * state[pull_at + i]
        seat += (low + tc * (parameters[momentum_at + m + i] - low)) * state[pull_at + i]
    seat += retainer
    if time_step > 0.0:
        half = math.exp(-0.5 * parameters[2] * time_step) if parameters[2] > 0.0 else 1.0
        taken = 0.0
        for i in range(m):
            old = state[m + i]
            kicked = half * old + time_step * state[pull_at + i]
            taken += (old * old + kicked * kicked) * (1.0 - half * half)
            state[m + i] = half * kicked
            state[i] += time_step * half * kicked
        state[head] += time_step * lost + 0.5 * taken
        state[head + 1], state[head + 4], state[head + 5] = clock + time_step, state[0], state[m]
        state[head + 6] = math.sqrt(size)
    if integers[5] == 0:
        return max(retainer, 0.0), max(seat, 0.0)
    return retainer, seat
