"""Compiled log of what the integrator saw of each contact: openings and closings within the step,
largest gaps, extreme forces.
"""

from __future__ import annotations

import math

from valvetrain.compiled import njit
from valvetrain.integrate.train_tuples import (
    ANGLE,
    CLOSES,
    HIGHEST,
    HIGHEST_ANGLE,
    LOWEST,
    LOWEST_ANGLE,
    MAX_FORCE,
    MAX_GAP,
    MAX_GAP_ANGLE,
    MIN_FORCE,
    MIN_FORCE_ANGLE,
    NOSE_FORCE,
    OPEN_FORCE,
    PEAK_ACCELERATION,
    PEAK_ACCELERATION_ANGLE,
    PEAK_FORCE,
    PEAK_FORCE_ANGLE,
    PEAK_PLACE,
    PEAK_SPEED,
    PEAK_SPEED_ANGLE,
    PLACE,
    RATE,
)
from valvetrain.mechanism.gaps import PART

TURN = 2.0 * math.pi
PER_TURN = 1.0 / TURN


@njit(**PART)
def crossing(earlier, before, now, ratio):
    """Where in the last step, 0 to 1, a penetration passed zero, and its rate there per step;
    ``ratio``: the step before over the last.

    A parabola through the last three steps: no force of the step of a touch has moved the last of
    them, so that the rate of a closing is that of the free motion, to second order in the step.
    """
    bend = (earlier - before + ratio * (now - before)) / (ratio * (1.0 + ratio))
    slope = now - before - bend
    root = math.sqrt(max(slope * slope - 4.0 * bend * before, 0.0))
    rate = root if now > 0.0 else -root
    below = slope + rate
    share = -2.0 * before / below if below != 0.0 else 0.0
    return min(max(share, 0.0), 1.0), rate


@njit(**PART)
def note_crossing(k, pen, cam_angle, motion, scratch, log):
    """Write a row: contact ``k`` opened or closed since the step before (cam angle and clock: now)."""
    row, step = motion.counters[2], motion.clock[11]
    share, rate = crossing(scratch.before[k, 1], scratch.before[k, 0], pen, motion.clock[12] / step)
    since = (1.0 - share) * step
    motion.counters[2] += 1
    if row >= log.shape[0]:
        row = -1
    angle = cam_angle - since * (motion.clock[1] - 0.5 * since * motion.clock[2])
    if row >= 0:
        log[row, PLACE], log[row, CLOSES], log[row, ANGLE], log[row, RATE] = (
            k,
            1.0 if pen > 0.0 else 0.0,
            angle,
            rate / step,
        )
    close_stretch(k, row, pen <= 0.0, scratch, log)
    scratch.latest[k] = row
    scratch.track[k, 0], scratch.track[k, 1], scratch.track[k, 2] = 0.0, angle, 0.0


@njit(**PART)
def close_stretch(k, row, touching, scratch, log):
    """Give the rows at both ends of the stretch since the last transition its largest force, or its
    largest gap.
    """
    for place in (scratch.latest[k], row):
        if place >= 0:
            if touching:
                log[place, MAX_FORCE] = scratch.track[k, 2]
            else:
                log[place, MAX_GAP], log[place, MAX_GAP_ANGLE] = (
                    scratch.track[k, 0],
                    scratch.track[k, 1],
                )


@njit(**PART)
def note_contact(
    k, pen, force, unilateral, first, inside, nose, cam_angle, motion, scratch, records
):
    """Note interaction ``k`` after a step: extreme forces (``inside``: in the window of the least),
    transition, largest gap and force.

    ``nose``: share of the last step at which the cam passed its nose, negative where it did not.
    """
    extremes, before, track = records.extremes, scratch.before, scratch.track
    if abs(force) > extremes[k, PEAK_FORCE]:
        extremes[k, PEAK_FORCE], extremes[k, PEAK_FORCE_ANGLE] = abs(force), cam_angle
    if inside:
        if force < extremes[k, MIN_FORCE]:
            extremes[k, MIN_FORCE], extremes[k, MIN_FORCE_ANGLE] = force, cam_angle
        extremes[k, OPEN_FORCE] = max(extremes[k, OPEN_FORCE], force)
    if nose >= 0.0:
        extremes[k, NOSE_FORCE] = track[k, 3] + nose * (force - track[k, 3])
    track[k, 3] = force
    if unilateral:
        if (pen > 0.0) != (before[k, 0] > 0.0):
            note_crossing(k, pen, cam_angle, motion, scratch, records.transitions)
        if pen > 0.0:
            if force > track[k, 2]:
                track[k, 2] = force
        elif -pen > track[k, 0]:
            track[k, 0], track[k, 1] = -pen, cam_angle
    if not first:
        before[k, 1] = before[k, 0]
        before[k, 0] = pen


@njit(**PART)
def note_load(row, value, cam_angle, loads):
    """Note one of the loads of this step: its largest and least value and their positions."""
    if value > loads[row, HIGHEST]:
        loads[row, HIGHEST], loads[row, HIGHEST_ANGLE] = value, cam_angle
    if value < loads[row, LOWEST]:
        loads[row, LOWEST], loads[row, LOWEST_ANGLE] = value, cam_angle


@njit(**PART)
def note_loads(power, cam_angle, cam_speed, clock, loads):
    """Note the end forces of the springs and the torque of the cam after a step."""
    for row in range(4):
        note_load(row, clock[4 + row], cam_angle, loads)
    note_load(4, clock[4] + clock[6], cam_angle, loads)
    note_load(5, clock[5] + clock[7], cam_angle, loads)
    note_load(6, power / cam_speed, cam_angle, loads)


@njit(**PART)
def note_body(i, place, before, after, now, acceleration, cam_angle, bodies):
    """Note coordinate ``i`` after a kick that took its velocity from ``before`` to ``after``,
    ``now`` of it done at ``cam_angle``, where its ``acceleration`` is that of the forces.
    """
    speed, size = abs((1.0 - now) * before + now * after), abs(acceleration)
    bodies[i, PEAK_PLACE] = max(bodies[i, PEAK_PLACE], place)
    if speed > bodies[i, PEAK_SPEED]:
        bodies[i, PEAK_SPEED], bodies[i, PEAK_SPEED_ANGLE] = speed, cam_angle
    if size > bodies[i, PEAK_ACCELERATION]:
        bodies[i, PEAK_ACCELERATION], bodies[i, PEAK_ACCELERATION_ANGLE] = size, cam_angle


@njit(**PART)
def nose_share(cam_angle, cam_speed, first, clock):
    """Share of the last step at which the cam passed its nose; negative where it did not."""
    away = cam_angle - clock[14]
    away -= TURN * math.floor(away * PER_TURN)
    last = clock[11] * cam_speed
    if away >= last:
        return -1.0
    return 1.0 if first else 1.0 - away / last


@njit(**PART)
def in_window(cam_angle, begin, width):
    """Whether a cam angle is in the window (rad) that may pass the end of the turn."""
    away = cam_angle - begin
    return away - TURN * math.floor(away * PER_TURN) <= width
