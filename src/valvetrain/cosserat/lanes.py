"""Time integration of several rods side by side: variants in the lanes of the vector unit, entry j
of variant v at ``j * LANES + v``.

The passes are those of ``step_kernels`` with neighbours ``LANES`` apart; every loop runs over whole
vectors, whatever the
mesh and however short the stretch of wire in contact. Measured per core against one rod at a time:
see docs/performance.md.
"""

from __future__ import annotations

import numpy as np

from valvetrain.coil_contact.kernels import LINEAR, linear_contact, own_contact
from valvetrain.compiled import njit
from valvetrain.cosserat.layout import GROUP as _GROUP
from valvetrain.cosserat.layout import ROW
from valvetrain.cosserat.step_kernels import (
    bending_torques_of,
    contact_forces_of,
    copy_lower_wire,
    guide_contact,
    move_vertices_of,
    return_contact,
    section_forces_of,
    spread_contact_of,
    turn_edges_of,
)
from valvetrain.cosserat.time_stepping import (
    CONTACT_TIME,
    DECAY,
    DT,
    FIRST,
    GAIN_NEW,
    GAIN_OLD,
    GROUPS,
    GUIDED,
    KEEP,
    KICK,
    LAST,
    LAW,
    LOWER_END,
    OFFSET,
    OPTIONS,
    STRETCHES,
    UPPER_START,
    VERTICES,
    VISCOUS,
    WATCH_MARGIN,
    WATCH_STEPS,
    law_row,
)

X, Y, Z, VX, VY, VZ, FZ = (ROW[n] for n in ("X", "Y", "Z", "VX", "VY", "VZ", "FZ"))
CX, CY, CZ, GX, GY, GZ = (ROW[n] for n in ("CX", "CY", "CZ", "GX", "GY", "GZ"))
PX, PY, PZ, DH, KC = (ROW[n] for n in ("PX", "PY", "PZ", "DH", "KC"))
LOWER, UPPER, SEAT = (ROW[n] for n in ("LOWER", "UPPER", "SEAT"))
GROUP, ONE = _GROUP, np.uint64(1)

#: Variants side by side: two vector registers of 256 bits (four: 4 % slower on clash, 2 % faster
#: without).
LANES = 8
WIDTH = np.uint64(LANES)
#: Vertices per tile of the passes (9.1 -> 8.1 ns per element and step of a variant).
TILE = np.uint64(12)

section_forces, bending_torques = section_forces_of(WIDTH), bending_torques_of(WIDTH, 0)
turn_edges, move_vertices = turn_edges_of(WIDTH), move_vertices_of(WIDTH, 0)
# A batch stores no impulse, peak and loss per contact point.
contact_forces, contact_forces_second = (
    contact_forces_of(np.uint64(0), WIDTH, 0),
    contact_forces_of(_GROUP, WIDTH, 0),
)
own_forces, own_forces_second = (
    contact_forces_of(np.uint64(0), WIDTH, 0, own=True),
    contact_forces_of(_GROUP, WIDTH, 0, own=True),
)
spread_contact, spread_contact_second = (
    spread_contact_of(np.uint64(0), WIDTH),
    spread_contact_of(_GROUP, WIDTH),
)


@njit(**OPTIONS)
def near_in_any_lane(b, j, k, reach):
    """Whether the contact points of vertex j may close on vertex k within ``reach`` (m) in any
    variant.
    """
    for lane in range(WIDTH):
        p, q = j * WIDTH + lane, k * WIDTH + lane
        if b[KC + p] + b[KC + GROUP + p] > 0.0:
            dx, dy, dz = b[X + p] - b[X + q], b[Y + p] - b[Y + q], b[Z + p] - b[Z + q]
            sx = b[X + q + WIDTH] - b[X + q - WIDTH]
            sy = b[Y + q + WIDTH] - b[Y + q - WIDTH]
            sz = b[Z + q + WIDTH] - b[Z + q - WIDTH]
            along = dx * sx + dy * sy + dz * sz
            limit = 2.0 * max(b[DH + p], b[DH + GROUP + p]) + reach
            if (
                dx * dx + dy * dy + dz * dz - along * along / (sx * sx + sy * sy + sz * sz)
                < limit * limit
            ):
                return True
    return False


@njit(**OPTIONS)
def watch_lanes(b, integers, reach, stretches):
    """List the stretches of contact points (entries of the rows) that may close in any variant;
    returns their number.
    """
    vertices, offset = np.uint64(integers[VERTICES]), np.uint64(integers[OFFSET])
    for row in (PX, PY, PZ, PX + GROUP, PY + GROUP, PZ + GROUP):
        for j in range(np.uint64(0), (vertices + ONE) * WIDTH):
            b[row + j] = 0.0
    count, start, end, inside = 0, offset + ONE, offset + ONE, False
    for j in range(offset + ONE, vertices - ONE):
        if near_in_any_lane(b, j, j - offset, reach):
            if not inside:
                start, inside = max(j - ONE, offset + ONE), True
            end = min(j + ONE + ONE, vertices - ONE)
        elif inside and j > end + ONE and count < STRETCHES - 1:
            stretches[count, 0], stretches[count, 1] = start * WIDTH, end * WIDTH
            count, inside = count + 1, False
    if inside:
        stretches[count, 0], stretches[count, 1] = start * WIDTH, end * WIDTH
        count += 1
    return count


@njit(forceinline=True, **OPTIONS)
def contact_of_lanes(b, integers, numbers, places, stretches, count):
    """Contact forces of all watched stretches on the vertices (rows C) of all variants."""
    damping_time, dt, law, row_of_law = (
        numbers[CONTACT_TIME],
        numbers[DT],
        integers[LAW],
        law_row(numbers),
    )
    offset, end_of_rows = np.uint64(integers[OFFSET]) * WIDTH, np.uint64(integers[VERTICES]) * WIDTH
    for row in (CX, CY, CZ):
        for j in range(np.uint64(0), end_of_rows):
            b[row + j] = 0.0
    for n in range(count):
        start, end = np.uint64(stretches[n, 0]), np.uint64(stretches[n, 1])
        copy_lower_wire(b, start - WIDTH, end + WIDTH, offset)
        for row in (GX, GY, GZ):
            for j in range(start - WIDTH, end + WIDTH):
                b[row + j] = 0.0
        t, s = places[0, 0], places[0, 1]
        if law == LINEAR:
            contact_forces(b, start, end, t, s, damping_time, dt, law, row_of_law)
        else:
            own_forces(b, start, end, t, s, damping_time, dt, law, row_of_law)
        spread_contact(b, start - WIDTH, end + WIDTH, places[0, 0])
        if integers[GROUPS] > 1:
            t, s = places[1, 0], places[1, 1]
            if law == LINEAR:
                contact_forces_second(b, start, end, t, s, damping_time, dt, law, row_of_law)
            else:
                own_forces_second(b, start, end, t, s, damping_time, dt, law, row_of_law)
            spread_contact_second(b, start - WIDTH, end + WIDTH, places[1, 0])
        return_contact(b, start - WIDTH, end + WIDTH, offset)


@njit(**OPTIONS)
def seats_of_lanes(b, first, last, displacement, sign, forces, law, row):
    """Push the wire of vertices first .. last - 1 out of a seat plane (``sign`` 1 lower, -1 upper);
    adds to ``forces`` (lanes,).
    """
    for i in range(first, last):
        for lane in range(WIDTH):
            j = i * WIDTH + lane
            below, above = b[LOWER + j] - b[Z + j], b[Z + j] - (b[UPPER + j] - displacement)
            depth = below if sign > 0.0 else above
            depth = depth if depth > 0.0 else 0.0
            if law == LINEAR:
                _, push = linear_contact(law, row, b[SEAT + j], 0.0, depth, 0.0)
            else:
                _, push = own_contact(law, row, b[SEAT + j], 0.0, depth, 0.0)
            b[CZ + j] += sign * push
            forces[lane] += push


@njit(forceinline=True, **OPTIONS)
def outer_forces_of_lanes(
    b, integers, numbers, places, stretches, count, displacement, retainer, seat
):
    """Contact and seat forces at the present positions; fills their share of ``retainer`` and
    ``seat`` (lanes,), N.
    """
    first, last, vertices = (
        np.uint64(integers[FIRST]),
        np.uint64(integers[LAST]),
        np.uint64(integers[VERTICES]),
    )
    for lane in range(WIDTH):
        retainer[lane], seat[lane] = 0.0, 0.0
    contact_of_lanes(b, integers, numbers, places, stretches, count)
    start, law, row = np.uint64(0), integers[LAW], law_row(numbers)
    lower_end, upper_start = np.uint64(integers[LOWER_END]), np.uint64(integers[UPPER_START])
    seats_of_lanes(b, start, lower_end, displacement, 1.0, seat, law, row)
    seats_of_lanes(b, upper_start, vertices, displacement, -1.0, retainer, law, row)
    if integers[GUIDED] > 0:
        guide_contact(b, (first + ONE) * WIDTH, last * WIDTH)
    for i in range(np.uint64(0), first + ONE):
        for lane in range(WIDTH):
            seat[lane] -= b[CZ + i * WIDTH + lane]
    for i in range(last, vertices):
        for lane in range(WIDTH):
            retainer[lane] += b[CZ + i * WIDTH + lane]


@njit(forceinline=True, **OPTIONS)
def advance_lanes(b, integers, numbers):
    """Section forces at the present positions, then one step of all variants, tile by tile along
    the wire.

    All passes over one tile follow each other, so that its rows stay in the first cache. Edges turn
    up to the tile's end, vertices
    move up to one before: what the next tile reads is still of the old step.
    """
    first, last = np.uint64(integers[FIRST]), np.uint64(integers[LAST])
    dt, keep, kick = numbers[DT], numbers[KEEP], numbers[KICK]
    start = first
    while start <= last:
        end = min(start + TILE, last + ONE)
        turned, moved = (
            max(start, first + ONE),
            max(start - ONE, first + ONE) if start > first else first + ONE,
        )
        until = end - ONE if end <= last else last
        section_forces(b, turned * WIDTH, end * WIDTH)
        bending_torques(
            b,
            start * WIDTH,
            end * WIDTH,
            numbers[DECAY],
            numbers[GAIN_OLD],
            numbers[GAIN_NEW],
            numbers[VISCOUS],
        )
        turn_edges(b, turned * WIDTH, end * WIDTH, dt, keep, kick)
        move_vertices(b, moved * WIDTH, until * WIDTH, dt, keep, kick)
        start = end


@njit(**OPTIONS)
def place_retainers(b, integers, travel, velocity):
    """Lower the vertices fixed to the retainer by ``travel`` (m) and give them its closing
    velocity.
    """
    for j in range(np.uint64(integers[LAST]) * WIDTH, np.uint64(integers[VERTICES]) * WIDTH):
        b[Z + j] -= travel
        b[VZ + j] = -velocity


@njit(**OPTIONS)
def replace_diverged(b, integers, row_starts, step, reached):
    """Largest vertex speed (m/s) of all variants; one that diverged is noted in ``reached`` and
    gives its lane to a sound one.

    The numbers of a diverged lane would stay NaN for good; a copy of a sound lane keeps the vectors
    full of sane work.
    Returns infinity when no variant is left.
    """
    top, sound = 0.0, LANES
    for lane in range(LANES):
        square, whole = 0.0, True
        for i in range(np.uint64(0), np.uint64(integers[VERTICES])):
            j = i * WIDTH + np.uint64(lane)
            one = b[VX + j] ** 2 + b[VY + j] ** 2 + b[VZ + j] ** 2
            whole = whole and one < 1e12
            square = max(square, one)
        if whole:
            sound = lane
            top = max(top, square)
        else:
            reached[lane] = min(reached[lane], step)
    if sound == LANES:
        return np.inf
    for lane in range(LANES):
        if reached[lane] == step:
            for row in row_starts:
                for i in range(np.uint64(0), np.uint64(integers[VERTICES]) + ONE):
                    b[row + i * WIDTH + np.uint64(lane)] = b[row + i * WIDTH + np.uint64(sound)]
    return np.sqrt(top)


@njit(**OPTIONS)
def integrate_lanes(
    b, integers, numbers, places, displacement, clock, row_starts, stretches, forces, dense, reached
):
    """Integrate ``LANES`` rods over ``len(displacement) - 1`` steps of one prescribed retainer
    displacement (m).

    ``clock``: steps per record. Fills ``dense`` (records, 2, lanes) with retainer and seat force
    (N) and ``reached`` (lanes,)
    with the first step at which a variant was seen diverged (left as given otherwise). ``forces``
    (2, lanes) and
    ``stretches`` (STRETCHES, 2) are working space.
    """
    steps, count = len(displacement) - 1, 0
    for n in range(steps + 1):
        if n % WATCH_STEPS == 0:
            fastest = replace_diverged(b, integers, row_starts, n, reached)
            if fastest == np.inf:
                return
            count = watch_lanes(
                b,
                integers,
                2.0 * (fastest + 2.0) * WATCH_STEPS * numbers[DT] + WATCH_MARGIN,
                stretches,
            )
        outer_forces_of_lanes(
            b, integers, numbers, places, stretches, count, displacement[n], forces[0], forces[1]
        )
        advance_lanes(b, integers, numbers)
        if n % clock == 0:
            for lane in range(WIDTH):
                dense[n // clock, 0, lane] = (
                    forces[0, lane] - b[FZ + np.uint64(integers[LAST]) * WIDTH + lane]
                )
                dense[n // clock, 1, lane] = (
                    forces[1, lane] - b[FZ + (np.uint64(integers[FIRST]) + ONE) * WIDTH + lane]
                )
        if n < steps:
            travel = displacement[n + 1] - displacement[n]
            place_retainers(b, integers, travel, travel / numbers[DT])
