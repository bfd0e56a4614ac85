"""Compiled step of a spring reduced from its rod (tables: ``springs.reduced_rod_tables``).

The potential energy in the coordinates z at the retainer displacement y is, with d = z - rest(y),
W(y) + load(y) d + d K(y) d / 2 + sum of k max(0, o)^2 / 2, o = overlap(y) + G(y) d: the wire's
elastic energy to second order about its equilibrium, contacts exact in o. Accelerations are its
slope by z, the force on the retainer that by y, and the force on the seat follows from the
momentum of the wire. Tables are straight between their lifts.

A contact presses with the mean of its force over the step about now, along the parabola of its overlap: a
point that closes or opens within a step then presses for its part of it. Rate and bend of the parabola need
the acceleration, which is computed first with the velocities of half a step ago. Stiffness damping acts on the
rate of the elastic forces at velocities now, extrapolated from v (-1/2 step) and v (-5/2), which keeps the
stable step of v (-1/2). Both damping forces are of second order in the step.

``integers`` = [m coordinates, p points, f fine lifts, c coarse lifts, fine per coarse, 1 where ends
pull, q coil pairs], pair of each point (p; -1: a seat).
``parameters`` = header (see ``HEADER``), contact stiffness (p'), most that an acceleration of size
one moves the point (p'), rest (f, w), load (f, w), overlap (f, p'), wire's force (f'), stiffness (c,
w, w), gradient (c, p, w), momentum (c, w); w is m and zeros up to a whole number of ``LINE``, p'
and f' are so of p and f: in an aligned array (``aligned``) every row begins a cache line.
``state`` = z (m), velocities (m), then (``HEAD``) dissipated energy, clock (s), time until which
strengths hold, nothing, first position and velocity as left, size of the accelerations and twice
that with which times were set; velocities one and two steps ago (m each), forces and stored energies of
the pairs (q each), times when the first of ``LINE`` points is due (p' / LINE), and when each is (p), points
due now, their forces, overlaps and rates (p + LANES each), and scratch (``SCRATCH`` w) from the next cache
line on. An open point is looked at again when it may have closed, and all are where positions were changed
from outside.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from valvetrain.arrays import Array
from valvetrain.compiled import njit

#: First lift (m), spacing of fine lifts (m), mass damping (1/s), stiffness damping (s), contact
#: damping time (s), then nothing up to a cache line.
HEADER = 8
#: Values between velocities and scratch; integers before the pairs.
HEAD, INTEGERS = 8, 7
#: Values of a cache line, of which rows are a whole number long (one that begins within a line is read at
#: 1.2 times the time); points taken at a time; scratch, in rows: departure, rate, slope of rest,
#: accelerations, shares of the first two at both lifts, contact sums.
LINE, LANES, SCRATCH = 8, 4, 10
#: Time (s) after which the size of accelerations is computed again and longest without a look at a point; what
#: its closing speed (m/s) may gain in that time in addition to what the acceleration, which may double, gives.
HORIZON, LONGEST, SPARE_SPEED = 12e-6, 300e-6, 0.2
FAST = {"reassoc", "contract", "nsz"}
KERNEL: dict[str, Any] = {"cache": True, "error_model": "numpy", "_nrt": False, "fastmath": FAST}
#: Compiled into each kernel that calls it, and stored with those alone.
INNER: dict[str, Any] = {**KERNEL, "cache": False, "forceinline": True}


def row_size(values: int) -> int:
    """Length of a row of the tables with this many values."""
    return -(-values // LINE) * LINE


def aligned(values: Array) -> Array:
    """A copy (n,) that begins a cache line.

    >>> aligned(np.arange(3.0)).ctypes.data % 64
    0
    """
    whole = np.empty(values.size + LINE)
    first = -(whole.ctypes.data // 8) % LINE
    whole[first : first + values.size] = values
    return whole[first : first + values.size]


def state_size(coordinates: int, points: int, pairs: int) -> int:
    """Length of the state buffer, scratch included."""
    fixed = pairs_place(coordinates) + 2 * pairs + 6 * points + 4 * LANES
    return fixed + LINE + SCRATCH * row_size(coordinates)


def pairs_place(coordinates: int) -> int:
    """Place in the state of the forces (N) of the coil pairs; their stored energies (J) follow."""
    return 4 * coordinates + HEAD


@njit(**INNER)
def _scratch_place(state, m, p, pairs):
    """First place of the scratch: a cache line begins there."""
    fixed = 4 * m + HEAD + 2 * pairs + 6 * p + 4 * LANES
    return fixed + (LINE - (state.ctypes.data // 8 + fixed) % LINE) % LINE


@njit(**INNER)
def _four_rows(values, at, next_at, count, apart, rate):
    """Four rows of the stiffness times departure, at a lift and at the next, and at the lift times rate."""
    one, two = values[at : at + count], values[at + count : at + 2 * count]
    three, four = values[at + 2 * count : at + 3 * count], values[at + 3 * count : at + 4 * count]
    next_one = values[next_at : next_at + count]
    next_two = values[next_at + count : next_at + 2 * count]
    next_three = values[next_at + 2 * count : next_at + 3 * count]
    next_four = values[next_at + 3 * count : next_at + 4 * count]
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    next_a, next_b, next_c, next_d = 0.0, 0.0, 0.0, 0.0
    rate_a, rate_b, rate_c, rate_d = 0.0, 0.0, 0.0, 0.0
    for i in range(count):
        a += one[i] * apart[i]
        b += two[i] * apart[i]
        c += three[i] * apart[i]
        d += four[i] * apart[i]
        next_a += next_one[i] * apart[i]
        next_b += next_two[i] * apart[i]
        next_c += next_three[i] * apart[i]
        next_d += next_four[i] * apart[i]
        rate_a += one[i] * rate[i]
        rate_b += two[i] * rate[i]
        rate_c += three[i] * rate[i]
        rate_d += four[i] * rate[i]
    return (a, b, c, d), (next_a, next_b, next_c, next_d), (rate_a, rate_b, rate_c, rate_d)


@njit(**INNER)
def _four_points(values, places, count, more, vector, next_vector):
    """Rows of four points at a lift and, ``more`` further, at the next, times the shares of a vector there."""
    p, q, r, s = places
    one, two = values[p : p + count], values[q : q + count]
    three, four = values[r : r + count], values[s : s + count]
    next_one, next_two = values[p + more : p + more + count], values[q + more : q + more + count]
    next_three, next_four = values[r + more : r + more + count], values[s + more : s + more + count]
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    for i in range(count):
        a += one[i] * vector[i] + next_one[i] * next_vector[i]
        b += two[i] * vector[i] + next_two[i] * next_vector[i]
        c += three[i] * vector[i] + next_three[i] * next_vector[i]
        d += four[i] * vector[i] + next_four[i] * next_vector[i]
    return a, b, c, d


@njit(**INNER)
def _rows(state, at, first, count):
    """Places of the rows of four points that are listed in the state."""
    return (
        first + int(state[at]) * count,
        first + int(state[at + 1]) * count,
        first + int(state[at + 2]) * count,
        first + int(state[at + 3]) * count,
    )


@njit(**INNER)
def _push(values, places, forces, count, more, low, high):
    """Add the rows of four points, each times its force, to sums (count) at a lift and at the next."""
    p, q, r, s = places
    f, g, h, k = forces[0], forces[1], forces[2], forces[3]
    one, two = values[p : p + count], values[q : q + count]
    three, four = values[r : r + count], values[s : s + count]
    next_one, next_two = values[p + more : p + more + count], values[q + more : q + more + count]
    next_three, next_four = values[r + more : r + more + count], values[s + more : s + more + count]
    for i in range(count):
        low[i] += f * one[i] + g * two[i] + h * three[i] + k * four[i]
    for i in range(count):
        high[i] += f * next_one[i] + g * next_two[i] + h * next_three[i] + k * next_four[i]


@njit(**INNER)
def _ramp(middle, reach):
    """Mean of what is positive between ``middle`` - ``reach`` and + ``reach``."""
    if middle >= reach:
        return middle
    return (middle + reach) ** 2 / (4.0 * reach) if middle > -reach else 0.0


@njit(**INNER)
def mean_force(overlap, closing, half_step, tau):
    """Means over a step of max(0, o) and, where o > 0, of max(0, o + tau do/dt), by ``overlap`` o (m) and rate
    ``closing`` (m/s) in its middle: elastic and whole force over the stiffness of a contact.
    """
    reach, damped = half_step * abs(closing), tau * closing
    if overlap >= reach and overlap + damped >= reach:
        return overlap, overlap + damped
    elastic = _ramp(overlap, reach)
    if closing > 0.0:
        return elastic, elastic + max(overlap + reach, 0.0) / (2.0 * reach) * damped
    return elastic, _ramp(overlap + damped, reach)


@njit(**INNER)
def _wait(overlap, closing, strength, reach):
    """Longest time (s) for which an open point may be left alone."""
    start = abs(closing) + SPARE_SPEED
    gain = 2.0 * strength * reach
    return min(-2.0 * overlap / (start + math.sqrt(start * start - gain * overlap)), LONGEST)


@njit(**KERNEL)
def advance_reduced(
    parameters, integers, state, retainer_displacement, retainer_velocity, time_step
):
    """One step of the spring contract for a spring reduced from its rod (see the module text)."""
    m, p, fines, coarses = integers[0], integers[1], integers[2], integers[3]
    w = (m + LINE - 1) // LINE * LINE
    padded, pairs = (p + LINE - 1) // LINE * LINE, integers[6]
    velocity, beta, tau = retainer_velocity, parameters[3], parameters[4]
    per_fine = 1.0 / parameters[1]
    per_coarse = per_fine / integers[4]
    place = (retainer_displacement - parameters[0]) * per_fine
    fine = min(max(math.floor(place), 0), fines - 2)
    coarse = fine // integers[4]
    tf, tc = place - fine, place / integers[4] - coarse
    reach_at = HEADER + padded
    rest_at = reach_at + padded + fine * w
    load_at = rest_at + fines * w
    overlap_at = reach_at + padded + 2 * fines * w + fine * padded
    force_at = reach_at + padded + fines * (2 * w + padded)
    stiffness_from = force_at + (fines + LINE - 1) // LINE * LINE
    stiffness_at = stiffness_from + coarse * w * w
    gradient_at = stiffness_from + coarses * w * w + coarse * p * w
    momentum_at = stiffness_from + coarses * (w + p) * w + coarse * w
    head = 2 * m
    before = head + HEAD + m
    pressed = before + m
    blocks = pressed + 2 * pairs
    due = blocks + padded // LINE
    now = due + p
    forces = now + p + LANES
    deep, meets = forces + p + LANES, forces + 2 * (p + LANES)
    first = _scratch_place(state, m, p, pairs)
    apart, rate = state[first : first + w], state[first + w : first + 2 * w]
    slope, pull = state[first + 2 * w : first + 3 * w], state[first + 3 * w : first + 4 * w]
    shares, next_shares = state[first + 4 * w : first + 5 * w], state[first + 5 * w : first + 6 * w]
    rates, next_rates = state[first + 6 * w : first + 7 * w], state[first + 7 * w : first + 8 * w]
    sums, next_sums = state[first + 8 * w : first + 9 * w], state[first + 9 * w : first + 10 * w]
    older, oldest = state[head + HEAD : before], state[before:pressed]
    position, speed = state[:m], state[m : 2 * m]
    rest, next_rest = parameters[rest_at : rest_at + w], parameters[rest_at + w : rest_at + 2 * w]
    load, next_load = parameters[load_at : load_at + w], parameters[load_at + w : load_at + 2 * w]
    # loops of one result each, which a compiler turns into vector instructions
    for i in range(w):
        slope[i] = (next_rest[i] - rest[i]) * per_fine
    for i in range(m):
        apart[i] = position[i] - rest[i] - tf / per_fine * slope[i]
    for i in range(m):
        rate[i] = speed[i] - velocity * slope[i]
    for i in range(m, w):  # a state that was copied may hold anything at the ends of its rows
        apart[i], rate[i], pull[i], sums[i], next_sums[i] = 0.0, 0.0, 0.0, 0.0, 0.0
    by_lift = velocity * per_coarse
    for i in range(w):
        shares[i] = (1.0 - tc) * apart[i]
    for i in range(w):
        next_shares[i] = tc * apart[i]
    for i in range(w):
        rates[i] = (1.0 - tc) * rate[i] - by_lift * apart[i]
    for i in range(w):
        next_rates[i] = tc * rate[i] + by_lift * apart[i]
    moved = state[0] != state[head + 4] or state[m] != state[head + 5]
    if moved:
        for i in range(m):
            older[i], oldest[i] = speed[i], speed[i]
    for i in range(m):
        rate[i] += 0.25 * (speed[i] - oldest[i])
    retainer = parameters[force_at + fine]
    growth = (parameters[force_at + fine + 1] - retainer) * per_fine
    retainer += tf * growth / per_fine + beta * growth * velocity
    lost = beta * growth * velocity * velocity
    for i in range(0, m, LANES):
        at = stiffness_at + i * w
        here, there, damped = _four_rows(parameters, at, at + w * w, w, apart, rate)
        for j in range(LANES):
            pull[i + j], sums[i + j], next_sums[i + j] = here[j], there[j], damped[j]
    for i in range(w):
        here, grows, low = pull[i], sums[i] - pull[i], load[i]
        turned = (next_load[i] - low) * per_fine
        viscous = beta * (next_sums[i] + turned * velocity)
        pull[i] = -(here + tc * grows + low + tf / per_fine * turned + viscous)
        retainer += apart[i] * (turned + 0.5 * grows * per_coarse)
        lost += viscous * rate[i]
    clock, half_step = state[head + 1], 0.5 * max(time_step, 0.0)
    every = time_step == 0.0 or moved or state[head + 6] > state[head + 7]
    if every or clock >= state[head + 2]:
        state[head + 7], state[head + 2] = 2.0 * state[head + 6], clock + HORIZON
    strength = state[head + 7]
    for pair in range(2 * pairs):
        state[pressed + pair] = 0.0
    count, closed = 0, 0
    until = math.inf if every else clock
    for block in range(padded // LINE):
        if state[blocks + block] > until:
            continue
        soonest = math.inf
        for c in range(block * LINE, min((block + 1) * LINE, p)):
            found = state[due + c]
            state[now + count] = c
            count += int(found <= until)
            soonest = min(soonest, found if found > until else math.inf)
        state[blocks + block] = soonest
    for more in range(LANES - 1):
        state[now + count + more] = state[now + max(count - 1, 0)]
    next_lift = p * w
    for entry in range(0, count, LANES):
        at = now + entry
        places = _rows(state, at, gradient_at, w)
        shift = _four_points(parameters, places, w, next_lift, shares, next_shares)
        gone = _four_points(parameters, places, w, next_lift, rates, next_rates)
        for j in range(min(LANES, count - entry)):
            c = int(state[at + j])
            low = parameters[overlap_at + c]
            step = parameters[overlap_at + padded + c] - low
            overlap = low + tf * step + shift[j]
            closing = step * per_fine * velocity + gone[j]
            if overlap + half_step * abs(closing) <= 0.0:
                if time_step > 0.0:
                    wait = _wait(overlap, closing, strength, parameters[reach_at + c])
                    state[due + c] = clock + wait - half_step
                block = blocks + c // LINE
                state[block] = min(state[block], state[due + c])
                continue
            state[due + c], state[blocks + c // LINE] = clock, clock
            state[now + closed], state[deep + closed], state[meets + closed] = c, overlap, closing
            closed += 1
    for more in range(LANES - 1):
        state[now + closed + more], state[forces + closed + more] = state[now], 0.0
    # first without bends, whose accelerations give them
    for last in range(2 if closed else 0):
        for i in range(w):
            sums[i], next_sums[i] = 0.0, 0.0
        for entry in range(0, closed, LANES):
            at, by = now + entry, forces + entry
            places = _rows(state, at, gradient_at, w)
            bends = (0.0, 0.0, 0.0, 0.0)
            if last:
                bends = _four_points(parameters, places, w, next_lift, shares, next_shares)
            for j in range(min(LANES, closed - entry)):
                c, stiffness = int(state[at + j]), parameters[HEADER + int(state[at + j])]
                overlap = state[deep + entry + j] + half_step * half_step / 6.0 * bends[j]
                closing = state[meets + entry + j] + half_step * bends[j]
                elastic, force = mean_force(overlap, closing, half_step, tau)
                state[by + j] = stiffness * force
                if last:
                    step = parameters[overlap_at + padded + c] - parameters[overlap_at + c]
                    retainer += stiffness * force * step * per_fine
                    lost += stiffness * (force - elastic) * closing
                    pair = integers[INTEGERS + c]
                    if pair >= 0:
                        state[pressed + pair] += stiffness * force
                        state[pressed + pairs + pair] += 0.5 * stiffness * elastic * elastic
            _push(parameters, places, state[by : by + LANES], w, next_lift, sums, next_sums)
        for i in range(w):
            guess = pull[i] - sums[i] - tc * (next_sums[i] - sums[i])
            shares[i], next_shares[i] = (1.0 - tc) * guess, tc * guess
            if last:
                pull[i] = guess
                retainer += per_coarse * apart[i] * (next_sums[i] - sums[i])
    seat, size = 0.0, 0.0
    momentum = parameters[momentum_at : momentum_at + w]
    next_momentum = parameters[momentum_at + w : momentum_at + 2 * w]
    for i in range(w):
        size += pull[i] * pull[i]
        retainer += slope[i] * pull[i]
        seat += (momentum[i] + tc * (next_momentum[i] - momentum[i])) * pull[i]
    seat += retainer
    if time_step > 0.0:
        half = math.exp(-0.5 * parameters[2] * time_step) if parameters[2] > 0.0 else 1.0
        taken = 0.0
        for i in range(m):
            old = speed[i]
            kicked = half * old + time_step * pull[i]
            taken += (old * old + kicked * kicked) * (1.0 - half * half)
            oldest[i], older[i], speed[i] = older[i], old, half * kicked
        for i in range(m):
            position[i] += time_step * speed[i]
        state[head] += time_step * lost + 0.5 * taken
        state[head + 1], state[head + 4], state[head + 5] = clock + time_step, state[0], state[m]
        state[head + 6] = math.sqrt(size)
    if integers[5] == 0:
        return max(retainer, 0.0), max(seat, 0.0)
    return retainer, seat


@njit(**KERNEL)
def forces_at(parameters, integers, states, overlaps, work, displacements, velocities, ends, pulls):
    """Forces on retainer and seat (n, 2) and accelerations without mass damping (n, m) of positions and
    velocities (n, 2 m) whose overlaps (n, p) are known; ``work`` is a state.
    """
    m, p, pairs = integers[0], integers[1], integers[6]
    pull = _scratch_place(work, m, p, pairs) + 3 * ((m + LINE - 1) // LINE * LINE)
    head, oldest, blocks = 2 * m, 3 * m + HEAD, 4 * m + HEAD + 2 * pairs
    due = blocks + (p + LINE - 1) // LINE
    work[head + 2] = math.inf
    for n in range(states.shape[0]):
        for i in range(2 * m):
            work[i] = states[n, i]
        for i in range(m):
            work[oldest + i] = work[m + i]
        # nothing was moved from outside, and open points are not due
        work[head + 4], work[head + 5] = work[0], work[m]
        for c in range(p):
            work[due + c] = 0.0 if overlaps[n, c] > 0.0 else math.inf
        for block in range((p + LINE - 1) // LINE):
            work[blocks + block] = 0.0
        ends[n, 0], ends[n, 1] = advance_reduced(
            parameters, integers, work, displacements[n], velocities[n], -1.0
        )
        for i in range(m):
            pulls[n, i] = work[pull + i]
