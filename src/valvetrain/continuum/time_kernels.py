"""The time step of a solid wire: explicit leapfrog with the masses of section deformation scaled.

Order within a step: forces of the bricks -> section centres -> contact -> records -> accelerations
-> velocities and positions. Positions live at whole steps, velocities at half steps. The rigid part
of each section's motion keeps its true mass; what is left, the deformation of the section, whose
high frequencies limit the step, has (1 + scaling) times the mass (as in olovsson2005).
"""

from __future__ import annotations

import numpy as np

from valvetrain.compiled import njit
from valvetrain.continuum.brick_kernels import OPTIONS, SIGNS, brick_energies, brick_forces
from valvetrain.continuum.contact_kernels import (
    LOST,
    STORED,
    coil_forces,
    follow_feet,
    plane_forces,
    section_centres,
    spread_push,
)
from valvetrain.continuum.friction_kernels import (
    rub_coils,
    rub_planes,
    section_spins,
    spread_couple,
)

#: Stride of the rows of scratch per station, a constant so that loops vectorise, and those rows.
STRIDE = 4104
SECTION_ROWS = 18
_S = np.uint64(STRIDE)
(_M, _CX, _CY, _CZ, _FX, _FY, _FZ, _XX, _YY, _ZZ, _XY, _XZ, _YZ, _TX, _TY, _TZ) = (
    np.uint64(row * STRIDE) for row in range(16)
)
#: Numbers that continue from call to call: work of the retainer (J), heat of damping and of contact (J),
#: step of the last energy, power lost then (W), fastest centre (m/s).
WORK, DAMPING_HEAT, CONTACT_HEAT, LAST_ENERGY, LAST_POWER, FASTEST = range(6)
#: Columns of the energies of a sample (J); ``SCALED`` is kinetic energy of the masses added.
KINETIC, ELASTIC, HOURGLASS, BRANCH, CONTACT, WORK_DONE, HEAT, SCALED = range(8)
#: Force (N) beyond which a run has diverged.
LOST_FORCE = 1e7


@njit(**OPTIONS)
def accelerate(x, force, mass, work, nodes, stations, first, last, scaling):
    """Replace the forces (N) at stations ``first`` to ``last - 1`` by accelerations (m/s2)."""
    row, two = np.uint64(stations), np.uint64(2)
    begin, end = np.uint64(first), np.uint64(last)
    for part in range(16):
        base = np.uint64(part) * _S
        for s in range(begin, end):
            work[base + s] = 0.0
    for n in range(np.uint64(nodes)):
        m, p = n * row, np.uint64(3) * n * row
        for s in range(begin, end):
            own = mass[m + s]
            work[_M + s] += own
            work[_CX + s] += own * x[p + s]
            work[_CY + s] += own * x[p + row + s]
            work[_CZ + s] += own * x[p + two * row + s]
        for s in range(begin, end):
            work[_FX + s] += force[p + s]
            work[_FY + s] += force[p + row + s]
            work[_FZ + s] += force[p + two * row + s]
    for s in range(begin, end):
        share = 1.0 / work[_M + s]
        work[_CX + s] *= share
        work[_CY + s] *= share
        work[_CZ + s] *= share
        work[_FX + s] *= share
        work[_FY + s] *= share
        work[_FZ + s] *= share
    for n in range(np.uint64(nodes)):
        m, p = n * row, np.uint64(3) * n * row
        for s in range(begin, end):
            own = mass[m + s]
            rx = x[p + s] - work[_CX + s]
            ry = x[p + row + s] - work[_CY + s]
            rz = x[p + two * row + s] - work[_CZ + s]
            work[_XX + s] += own * (ry * ry + rz * rz)
            work[_YY + s] += own * (rx * rx + rz * rz)
            work[_ZZ + s] += own * (rx * rx + ry * ry)
            work[_XY + s] -= own * rx * ry
            work[_XZ + s] -= own * rx * rz
            work[_YZ + s] -= own * ry * rz
            fx, fy, fz = force[p + s], force[p + row + s], force[p + two * row + s]
            work[_TX + s] += ry * fz - rz * fy
            work[_TY + s] += rz * fx - rx * fz
            work[_TZ + s] += rx * fy - ry * fx
    for s in range(begin, end):
        xx, yy, zz = work[_XX + s], work[_YY + s], work[_ZZ + s]
        xy, xz, yz = work[_XY + s], work[_XZ + s], work[_YZ + s]
        tx, ty, tz = work[_TX + s], work[_TY + s], work[_TZ + s]
        k0, k1, k2 = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
        share = 1.0 / (xx * k0 + xy * k1 + xz * k2)
        k3, k4, k5 = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
        work[_TX + s] = share * (k0 * tx + k1 * ty + k2 * tz)
        work[_TY + s] = share * (k1 * tx + k3 * ty + k4 * tz)
        work[_TZ + s] = share * (k2 * tx + k4 * ty + k5 * tz)
    left = 1.0 / (1.0 + scaling)
    rigid = 1.0 - left
    for n in range(np.uint64(nodes)):
        m, p = n * row, np.uint64(3) * n * row
        for s in range(begin, end):
            ry, rz = x[p + row + s] - work[_CY + s], x[p + two * row + s] - work[_CZ + s]
            whole = work[_FX + s] + work[_TY + s] * rz - work[_TZ + s] * ry
            force[p + s] = rigid * whole + left * force[p + s] / mass[m + s]
        p += row
        for s in range(begin, end):
            rx, rz = x[p - row + s] - work[_CX + s], x[p + row + s] - work[_CZ + s]
            whole = work[_FY + s] + work[_TZ + s] * rx - work[_TX + s] * rz
            force[p + s] = rigid * whole + left * force[p + s] / mass[m + s]
        p += row
        for s in range(begin, end):
            rx, ry = x[p - two * row + s] - work[_CX + s], x[p - row + s] - work[_CY + s]
            whole = work[_FZ + s] + work[_TX + s] * ry - work[_TY + s] * rx
            force[p + s] = rigid * whole + left * force[p + s] / mass[m + s]


@njit(inline="always")
def damped_step(step, mass_damping):
    """Factors of velocity and acceleration in a step with mass damping, centred."""
    half = 0.5 * step * mass_damping
    return (1.0 - half) / (1.0 + half), step / (1.0 + half)


@njit(**OPTIONS)
def kinetic_energy(x, v, acceleration, momentum, mass, work, nodes, stations, first, last, motion):
    """Kinetic energy (J) at the time of the positions, from the velocities half a step before and
    after, and what the scaled masses add to it; ``momentum`` is scratch.
    """
    row, total = np.uint64(stations), 0.0
    keep, gain = damped_step(motion.step, motion.mass_damping)
    begin, end = np.uint64(first), np.uint64(last)
    for n in range(np.uint64(nodes)):
        m = n * row
        for axis in range(np.uint64(3)):
            p = (np.uint64(3) * n + axis) * row
            for s in range(begin, end):
                mean = 0.5 * (v[p + s] + keep * v[p + s] + gain * acceleration[p + s])
                momentum[p + s] = mass[m + s] * mean
                total += 0.5 * mass[m + s] * mean * mean
    # with infinite scaling the rigid part of the motion is left
    accelerate(x, momentum, mass, work, nodes, stations, first, last, np.inf)
    rigid = 0.0
    for n in range(np.uint64(nodes)):
        m = n * row
        for axis in range(np.uint64(3)):
            p = (np.uint64(3) * n + axis) * row
            for s in range(begin, end):
                rigid += 0.5 * mass[m + s] * momentum[p + s] * momentum[p + s]
    return total, motion.scaling * (total - rigid)


@njit(**OPTIONS)
def advance_velocities(x, v, acceleration, nodes, stations, first, last, keep, gain, step):
    """Kick and drift the free nodes."""
    row = np.uint64(stations)
    for n in range(np.uint64(3 * nodes)):
        p = n * row
        for s in range(np.uint64(first), np.uint64(last)):
            v[p + s] = keep * v[p + s] + gain * acceleration[p + s]
        for s in range(np.uint64(first), np.uint64(last)):
            x[p + s] += step * v[p + s]


@njit(**OPTIONS)
def move_retainer(x, v, nodes, stations, last, rate, step):
    """Carry the bonded turns along with the retainer, at its velocity (m/s)."""
    for n in range(nodes):
        for s in range((3 * n + 2) * stations + last, (3 * n + 3) * stations):
            v[s] = rate
            x[s] += step * rate


@njit(**OPTIONS)
def axial_sum(force, nodes, stations, first, last):
    """Sum of the axial forces of all nodes at stations ``first`` to ``last - 1``."""
    total = 0.0
    for n in range(nodes):
        for s in range((3 * n + 2) * stations + first, (3 * n + 2) * stations + last):
            total += force[s]
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def integrate_solid(begin, end, travel, motion, parts, points, planes, clock, records):
    """Steps ``begin`` to ``end - 1`` of a solid wire under the ``travel`` (m) of the retainer from the
    free state at steps begin - 1, begin, ...

    Records at every sample and between them; returns the step it stopped at, before ``end`` where
    the run diverged.
    """
    x, v, force, mass, weights = parts.x, parts.v, parts.force, parts.mass, parts.weights
    centre, rate, push = parts.centre, parts.rate, parts.push
    stations, first, last = parts.stations, parts.first, parts.last
    nodes, step = len(weights), motion.step
    keep, gain = damped_step(step, motion.mass_damping)
    row, carried = motion.law_numbers.ctypes.data, records.carried
    totals, energy = np.zeros(2), np.zeros(4)
    sample_steps = clock.substeps * clock.dense
    for n in range(begin, end):
        place = n - begin + 1
        force[:] = 0.0
        brick_forces(
            x, force, parts.constants, parts.branch, parts.scratch, parts.corners, SIGNS, parts.shape,
            motion.lame, motion.damper,
        )  # fmt: skip
        section_centres(x, weights, stations, centre)
        section_centres(v, weights, stations, rate)
        if n % clock.search == 0:
            follow_feet(centre, stations, points, clock.margin, 2)
        push[:] = 0.0
        totals[:] = 0.0
        coil_forces(
            centre, rate, push, stations, points, motion.law, row, motion.damping_time, totals
        )
        lower, upper = plane_forces(
            centre, push, stations, planes, travel[place], motion.law, row, totals
        )
        rubbing = motion.coil_friction > 0.0 or motion.seat_friction > 0.0
        if rubbing:
            spin, couple = parts.spin, parts.couple
            couple[:] = 0.0
            section_spins(x, v, weights, stations, centre, rate, parts.inverse, spin)
            rub_coils(
                centre,
                rate,
                spin,
                push,
                couple,
                stations,
                points,
                motion.coil_friction,
                step,
                totals,
            )
            rub_planes(
                rate, spin, push, couple, stations, planes, motion.seat_friction, step, totals
            )
        axial = 2 * stations
        seat = lower - axial_sum(force, nodes, stations, first, first + 1)
        retainer = upper + axial_sum(force, nodes, stations, last, last + 1)
        for s in range(first + 1):
            seat -= push[axial + s]
        for s in range(last, stations):
            retainer += push[axial + s]
        carried[CONTACT_HEAT] += totals[LOST] * step
        carried[WORK] += retainer * 0.5 * (travel[place + 1] - travel[place - 1])

        sample = n // sample_steps
        if seat > records.extremes[sample, 0]:
            records.extremes[sample, 0], records.extremes[sample, 1] = seat, n * step
        if seat < records.extremes[sample, 2]:
            records.extremes[sample, 2], records.extremes[sample, 3] = seat, n * step
        if retainer > records.extremes[sample, 4]:
            records.extremes[sample, 4], records.extremes[sample, 5] = retainer, n * step
        if retainer < records.extremes[sample, 6]:
            records.extremes[sample, 6], records.extremes[sample, 7] = retainer, n * step
        if n % clock.substeps == 0:
            dense = n // clock.substeps
            records.ends[dense, 0], records.ends[dense, 1] = retainer, seat
        for p in range(points.pressed.shape[1]):
            pressed = points.pressed[0, p]
            records.impulse[p] += pressed * step
            records.peak[p] = max(records.peak[p], pressed)
        if sample >= clock.discard:
            since = n - clock.discard * sample_steps
            if since % clock.pair_steps == 0:
                records.pairs[since // clock.pair_steps] = points.pressed
        spread_push(push, weights, stations, force)
        if rubbing:
            spread_couple(x, couple, parts.inverse, weights, stations, centre, force)
        accelerate(x, force, mass, parts.section, nodes, stations, first + 1, last, motion.scaling)
        if n % sample_steps == 0 or n - carried[LAST_ENERGY] >= clock.energy_steps:
            brick_energies(
                x, parts.constants, parts.branch, parts.scratch, parts.corners, parts.shape,
                motion.lame, motion.damper, energy,
            )  # fmt: skip
            kinetic, added = kinetic_energy(
                x, v, force, parts.momentum, mass, parts.section, nodes, stations, first + 1, last, motion
            )  # fmt: skip
            passed = 0.5 * step * (n - carried[LAST_ENERGY])
            lost = energy[3] / motion.branch_time + 2.0 * motion.mass_damping * (kinetic + added)
            carried[DAMPING_HEAT] += passed * (carried[LAST_POWER] + lost)
            carried[LAST_POWER], carried[LAST_ENERGY] = lost, n
            heat = carried[DAMPING_HEAT] + carried[CONTACT_HEAT]
            if n % sample_steps == 0:
                found = records.energy[sample]
                found[KINETIC], found[ELASTIC], found[HOURGLASS] = kinetic, energy[0], energy[1]
                found[BRANCH], found[CONTACT] = energy[2], totals[STORED]
                found[SCALED] = added
                # the work of this step's second half is not done yet
                half = retainer * 0.5 * (travel[place + 1] - travel[place])
                found[WORK_DONE], found[HEAT] = carried[WORK] - half, heat
        if n % sample_steps == 0:
            since_last = sample_steps * step
            for p in range(points.pressed.shape[1]):
                records.contact[sample, 0, p] = records.impulse[p] / since_last
                records.contact[sample, 1, p] = records.peak[p]
                records.impulse[p], records.peak[p] = 0.0, 0.0
            if sample >= clock.discard:
                records.position[sample - clock.discard] = x
                records.centre_rate[sample - clock.discard] = rate
                records.point_peak[sample - clock.discard] = points.peak
                records.plane_peak[sample - clock.discard] = planes.peak
            points.peak[:] = 0.0
            planes.peak[:] = 0.0
            fastest = 0.0
            for s in range(len(rate)):
                fastest = max(fastest, abs(rate[s]))
            carried[FASTEST] = max(carried[FASTEST], fastest)
        if not (abs(seat) < LOST_FORCE and abs(retainer) < LOST_FORCE):
            return n
        advance_velocities(x, v, force, nodes, stations, first + 1, last, keep, gain, step)
        move_retainer(
            x, v, nodes, stations, last, -(travel[place + 1] - travel[place]) / step, step
        )
    return end
