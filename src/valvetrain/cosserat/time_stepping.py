"""Time integration of the rod: one compiled loop over steps, with the contact watch list and the
records.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from valvetrain.coil_contact.kernels import LINEAR
from valvetrain.compiled import njit
from valvetrain.cosserat.coil_friction import rub_coils
from valvetrain.cosserat.end_coil_kernels import END, RATE, end_contacts, move_end_coils
from valvetrain.cosserat.layout import GROUP as _GROUP
from valvetrain.cosserat.layout import ROW
from valvetrain.cosserat.layout import STRIDE as _STRIDE
from valvetrain.cosserat.step_kernels import (
    bending_torques,
    contact_forces,
    contact_forces_second,
    copy_lower_wire,
    guide_contact,
    move_vertices,
    own_forces,
    own_forces_second,
    own_seat_contact,
    return_contact,
    seat_contact,
    section_forces,
    spread_contact,
    spread_contact_second,
    turn_edges,
)

X, Y, Z, VX, VY, VZ, FZ = (ROW[n] for n in ("X", "Y", "Z", "VX", "VY", "VZ", "FZ"))
CX, CY, CZ, GX, GY, GZ = (ROW[n] for n in ("CX", "CY", "CZ", "GX", "GY", "GZ"))
PX, PY, PZ, DH, KC, IMPULSE, PEAK, LOSS, STORED = (
    ROW[n] for n in ("PX", "PY", "PZ", "DH", "KC", "IMPULSE", "PEAK", "LOSS", "STORED")
)
GROUP, ONE, STRIDE = _GROUP, np.uint64(1), np.uint64(_STRIDE)

#: No fast maths here, so that a diverged run is seen; no reference counts either (see
#: step_kernels).
OPTIONS: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "_nrt": False}

#: Steps between two looks for coils that come near, and most separate stretches of wire watched at
#: once.
WATCH_STEPS, STRETCHES = 32, 12
#: Gap (m) beyond the travel until the next look at which wire is watched: the gap there is taken to
#: the chord, not the curve.
WATCH_MARGIN = 1e-4

# Places in the ``numbers`` and ``integers`` that travel with a buffer.
DT, KEEP, KICK, DECAY, GAIN_OLD, GAIN_NEW, VISCOUS, CONTACT_TIME, MASS_DAMPING, RELAXATION, FRICTION = range(11)  # fmt: skip
#: First of the numbers of the law of contact, the last of all ``numbers``.
LAW_NUMBERS = FRICTION + 1
FIRST, LAST, OFFSET, GROUPS, VERTICES, LOWER_END, UPPER_START, GUIDED, LAW, LIFTS = range(10)


@njit(**OPTIONS)
def clear_contact(b, vertices):
    """Zero all point forces and energies, so that points leaving the watch list leave nothing
    behind.
    """
    for row in (PX, PY, PZ, STORED, PX + GROUP, PY + GROUP, PZ + GROUP, STORED + GROUP):
        for j in range(np.uint64(0), vertices + ONE):
            b[row + j] = 0.0


@njit(**OPTIONS)
def watch_contacts(b, integers, reach, stretches):
    """List the stretches of contact points whose gap may close within ``reach`` (m); returns their
    number.

    The gap is measured at the vertices; contact points between two of them are covered by one
    vertex more at either end.
    Stretches keep two vertices between them: spreading reads one point beyond either end.
    """
    vertices, offset = np.uint64(integers[VERTICES]), np.uint64(integers[OFFSET])
    clear_contact(b, vertices)
    count, start, end, inside = 0, offset + ONE, offset + ONE, False
    for j in range(offset + ONE, vertices - ONE):
        k = j - offset
        near = False
        if b[KC + j] + b[KC + GROUP + j] > 0.0:
            dx, dy, dz = b[X + j] - b[X + k], b[Y + j] - b[Y + k], b[Z + j] - b[Z + k]
            sx, sy, sz = (
                b[X + k + ONE] - b[X + k - ONE],
                b[Y + k + ONE] - b[Y + k - ONE],
                b[Z + k + ONE] - b[Z + k - ONE],
            )
            along = dx * sx + dy * sy + dz * sz
            limit = 2.0 * max(b[DH + j], b[DH + GROUP + j]) + reach
            near = (
                dx * dx + dy * dy + dz * dz - along * along / (sx * sx + sy * sy + sz * sz)
                < limit * limit
            )
        if near:
            if not inside:
                start, inside = max(j - ONE, offset + ONE), True
            end = min(j + ONE + ONE, vertices - ONE)
        elif inside and j > end + ONE and count < STRETCHES - 1:
            stretches[count, 0], stretches[count, 1] = start, end
            count, inside = count + 1, False
    if inside:
        stretches[count, 0], stretches[count, 1] = start, end
        count += 1
    return count


@njit(forceinline=True, **OPTIONS)
def law_row(numbers):
    """Address of the numbers of the law of contact."""
    return numbers.ctypes.data + 8 * LAW_NUMBERS


@njit(forceinline=True, **OPTIONS)
def all_contact(b, integers, numbers, places, stretches, count, first, last):
    """Contact forces of all watched stretches on the vertices (rows C)."""
    offset, law, row = np.uint64(integers[OFFSET]), integers[LAW], law_row(numbers)
    damping_time, dt = numbers[CONTACT_TIME], numbers[DT]
    for j in range(first, last):
        b[CX + j] = 0.0
    for j in range(first, last):
        b[CY + j] = 0.0
    for j in range(first, last):
        b[CZ + j] = 0.0
    for n in range(count):
        start, end = np.uint64(stretches[n, 0]), np.uint64(stretches[n, 1])
        copy_lower_wire(b, start - ONE, end + ONE, offset)
        for j in range(start - ONE, end + ONE):
            b[GX + j] = 0.0
            b[GY + j] = 0.0
            b[GZ + j] = 0.0
        t, s = places[0, 0], places[0, 1]
        if law == LINEAR:
            contact_forces(b, start, end, t, s, damping_time, dt, law, row)
        else:
            own_forces(b, start, end, t, s, damping_time, dt, law, row)
        spread_contact(b, start - ONE, end + ONE, places[0, 0])
        if integers[GROUPS] > 1:
            t, s = places[1, 0], places[1, 1]
            if law == LINEAR:
                contact_forces_second(b, start, end, t, s, damping_time, dt, law, row)
            else:
                own_forces_second(b, start, end, t, s, damping_time, dt, law, row)
            spread_contact_second(b, start - ONE, end + ONE, places[1, 0])
        return_contact(b, start - ONE, end + ONE, offset)


@njit(**OPTIONS)
def fastest_vertex(b, first, last):
    """Largest speed (m/s) of any vertex; NaN passes through as infinity."""
    top = 0.0
    for i in range(first, last):
        square = b[VX + i] ** 2 + b[VY + i] ** 2 + b[VZ + i] ** 2
        if not square < 1e12:
            return np.inf
        top = max(top, square)
    return np.sqrt(top)


@njit(forceinline=True, **OPTIONS)
def forces_now(b, integers, numbers, places, stretches, count, displacement):
    """All forces at the present positions; returns (retainer force, seat force), N, compressive
    positive.
    """
    first, last, vertices = (
        np.uint64(integers[FIRST]),
        np.uint64(integers[LAST]),
        np.uint64(integers[VERTICES]),
    )
    start, law, row = np.uint64(0), integers[LAW], law_row(numbers)
    all_contact(b, integers, numbers, places, stretches, count, start, vertices)
    lower_end, upper_start = np.uint64(integers[LOWER_END]), np.uint64(integers[UPPER_START])
    if law == LINEAR:
        lower_down, _ = seat_contact(b, start, lower_end, displacement, law, row)
        _, upper_up = seat_contact(b, upper_start, vertices, displacement, law, row)
    else:
        lower_down, _ = own_seat_contact(b, start, lower_end, displacement, law, row)
        _, upper_up = own_seat_contact(b, upper_start, vertices, displacement, law, row)
    if integers[GUIDED] > 0:
        guide_contact(b, first + ONE, last)
    section_forces(b, first + ONE, last + ONE)
    if numbers[FRICTION] > 0.0:
        dt, offset, groups = numbers[DT], np.uint64(integers[OFFSET]), integers[GROUPS]
        rub_coils(b, numbers[FRICTION], dt, offset, groups, places, stretches, count)
    if integers[LIFTS] > 0:
        push, hold = end_contacts(b, first, last, displacement, numbers[CONTACT_TIME], law, row)
        return upper_up + push, lower_down + hold
    seat = lower_down - b[FZ + first + ONE]
    retainer = upper_up - b[FZ + last]
    for i in range(np.uint64(0), first + ONE):
        seat -= b[CZ + i]
    for i in range(last, vertices):
        retainer += b[CZ + i]
    return retainer, seat


@njit(forceinline=True, **OPTIONS)
def kick_and_drift(b, integers, numbers):
    """Advance all free unknowns by one step from the forces of ``forces_now``; returns the energy
    dissipated (J).
    """
    first, last = np.uint64(integers[FIRST]), np.uint64(integers[LAST])
    dt, keep, kick = numbers[DT], numbers[KEEP], numbers[KICK]
    branch = bending_torques(
        b, first, last + ONE, numbers[DECAY], numbers[GAIN_OLD], numbers[GAIN_NEW], numbers[VISCOUS]
    )
    turn_edges(b, first + ONE, last + ONE, dt, keep, kick)
    motion = move_vertices(b, first + ONE, last, dt, keep, kick)
    seats = 0.0
    if integers[LIFTS] > 0:
        seats = move_end_coils(b, first, last, np.uint64(integers[VERTICES]), dt)
    return seats + dt * (
        numbers[VISCOUS] / numbers[RELAXATION] * branch + 0.25 * numbers[MASS_DAMPING] * motion
    )


@njit(**OPTIONS)
def place_retainer(b, integers, travel, velocity):
    """Lower the vertices fixed to the retainer by ``travel`` (m) and give them its closing
    velocity; an end coil that lifts feels it by its contact.
    """
    if integers[LIFTS] > 0:
        b[END + RATE] = velocity
        return
    for i in range(np.uint64(integers[LAST]), np.uint64(integers[VERTICES])):
        b[Z + i] -= travel
        b[VZ + i] = -velocity


@njit(**OPTIONS)
def integrate_in_time(
    b,
    integers,
    numbers,
    places,
    displacement,
    clock,
    stretches,
    snapshots,
    contacts,
    dense,
    extremes,
    bins,
    pressed,
    finest,
    begin,
    end,
    carried,
):
    """Integrate the steps ``begin`` to ``end`` - 1 of prescribed retainer ``displacement`` (m, from
    the free state), whose first value is that of step ``begin``, a whole sample. ``carried`` (6,)
    takes running values from one call to the next; all zero at first.

    ``clock`` = (steps per dense record, dense records per sample, first sample stored, steps per
    record of coil pairs, steps per value of ``finest``); ``stretches``
    (STRETCHES, 2) is working space. Fills ``snapshots`` (samples stored, 13, nv + 1) with positions,
    frames, velocities and spins,
    ``contacts`` (samples, 3, groups, nv) with mean force, peak force and loss since the last
    sample, ``dense`` (records, 4) with
    retainer force, seat force, work done and dissipated energy, ``extremes`` (samples, 8) with the
    largest seat force of all steps from a
    sample up to the next, its step, the least and its step, and the same of the retainer force,
    ``pressed`` (records from the first
    sample stored, 2, pairs) with force and stored energy of the contact points of each pair, vertex i
    in pair ``bins[i]``, ``finest`` with seat forces from the first sample stored. Returns (steps
    done, largest vertex speed); a run that diverged stops early.
    """
    vertices, per_sample, dt = np.uint64(integers[VERTICES]), clock[0] * clock[1], numbers[DT]
    count, work, lost, before = int(carried[0]), carried[1], carried[2], carried[3]
    travel, fastest, row = carried[4], carried[5], begin // per_sample - 1
    seat_high, seat_low, high, low = 0.0, 0.0, 0.0, 0.0
    for n in range(begin, end):
        if n % WATCH_STEPS == 0:
            speed = fastest_vertex(b, np.uint64(0), vertices)
            fastest = max(fastest, speed)
            if speed == np.inf:
                return n, fastest
            reach = 2.0 * (speed + 2.0) * WATCH_STEPS * dt + WATCH_MARGIN
            count = watch_contacts(b, integers, reach, stretches)
        retainer, seat = forces_now(
            b, integers, numbers, places, stretches, count, displacement[n - begin]
        )
        if n > 0:
            work += 0.5 * (retainer + before) * travel
        before = retainer
        sample = n % per_sample == 0
        if sample:
            row, seat_high, seat_low, high, low = row + 1, -np.inf, np.inf, -np.inf, np.inf
        if seat > seat_high:
            seat_high, extremes[row, 0], extremes[row, 1] = seat, seat, n
        if seat < seat_low:
            seat_low, extremes[row, 2], extremes[row, 3] = seat, seat, n
        if retainer > high:
            high, extremes[row, 4], extremes[row, 5] = retainer, retainer, n
        if retainer < low:
            low, extremes[row, 6], extremes[row, 7] = retainer, retainer, n
        if n % clock[0] == 0:
            record = n // clock[0]
            dense[record, 0], dense[record, 1], dense[record, 2], dense[record, 3] = (
                retainer,
                seat,
                work,
                lost,
            )
        later = n - per_sample * clock[2]
        if later >= 0 and later % clock[3] == 0:
            take_pairs(b, integers, stretches, count, bins, pressed[later // clock[3]])
        if later >= 0 and later % clock[4] == 0:
            finest[later // clock[4]] = seat
        stored = row - clock[2]
        if sample and stored >= 0:
            take_snapshot(b, integers, snapshots[stored], 0.5)
        if sample:
            take_contacts(b, integers, contacts[row], dt * per_sample)
        lost += kick_and_drift(b, integers, numbers)
        if sample and stored >= 0:
            finish_snapshot(b, integers, snapshots[stored], 0.5)
        if n - begin < len(displacement) - 1:
            travel = displacement[n - begin + 1] - displacement[n - begin]
            place_retainer(b, integers, travel, travel / dt)
    carried[0], carried[1], carried[2], carried[3] = count, work, lost, before
    carried[4], carried[5] = travel, fastest
    return end, fastest


@njit(**OPTIONS)
def take_snapshot(b, integers, out, share):
    """Positions and frames at the step, and ``share`` of the velocities and spins of the half step
    before.
    """
    for r in range(13):
        factor = 1.0 if r < 7 else share
        for i in range(integers[VERTICES] + 1):
            out[r, i] = factor * b[X + np.uint64(r) * STRIDE + np.uint64(i)]


@njit(**OPTIONS)
def finish_snapshot(b, integers, out, share):
    """Add ``share`` of the velocities and spins of the half step after."""
    for r in range(7, 13):
        for i in range(integers[VERTICES] + 1):
            out[r, i] += share * b[X + np.uint64(r) * STRIDE + np.uint64(i)]


@njit(**OPTIONS)
def take_pairs(b, integers, stretches, count, bins, out):
    """Force and stored energy of the watched contact points of every pair, now."""
    for n in range(count):
        for i in range(int(stretches[n, 0]), int(stretches[n, 1])):
            pair = bins[i]
            if pair >= 0:
                for g in range(integers[GROUPS]):
                    j = GROUP * np.uint64(g) + np.uint64(i)
                    out[0, pair] += np.sqrt(b[PX + j] ** 2 + b[PY + j] ** 2 + b[PZ + j] ** 2)
                    out[1, pair] += b[STORED + j]


@njit(**OPTIONS)
def take_contacts(b, integers, out, interval):
    """Mean and peak force and energy loss of each contact point since the last sample; resets the
    counters.
    """
    for g in range(integers[GROUPS]):
        shift = GROUP * np.uint64(g)
        for i in range(integers[VERTICES]):
            j = np.uint64(i)
            out[0, g, i], out[1, g, i], out[2, g, i] = (
                b[IMPULSE + shift + j] / interval,
                b[PEAK + shift + j],
                b[LOSS + shift + j],
            )
            b[IMPULSE + shift + j] = b[PEAK + shift + j] = b[LOSS + shift + j] = 0.0
