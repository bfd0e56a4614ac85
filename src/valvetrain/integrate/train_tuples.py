"""The few named tuples that the compiled loop of a train takes in addition to ``TrainArrays``.

Shapes: n interactions, N coordinates, S samples.
"""

from __future__ import annotations

from typing import NamedTuple

from valvetrain.arrays import Array, Ints

Integers = Ints

TRANSITIONS = 512
"""Rows of the log of contact transitions in one cycle; what does not fit is counted."""

(
    PEAK_FORCE,
    PEAK_FORCE_ANGLE,
    PEAK_PENETRATION,
    MIN_FORCE,
    MIN_FORCE_ANGLE,
    OPEN_FORCE,
    NOSE_FORCE,
) = range(7)
"""Columns of ``Records.extremes``."""

HIGHEST, HIGHEST_ANGLE, LOWEST, LOWEST_ANGLE = range(4)
"""Columns of ``Records.loads``."""

LOADS = (
    "first_retainer",
    "first_seat",
    "second_retainer",
    "second_seat",
    "retainer",
    "seat",
    "torque",
)
"""Rows of ``Records.loads``: end forces of each spring and of both, and the torque of the cam."""

PEAK_PLACE, PEAK_SPEED, PEAK_SPEED_ANGLE, PEAK_ACCELERATION, PEAK_ACCELERATION_ANGLE = range(5)
"""Columns of ``Records.bodies``."""

PLACE, CLOSES, ANGLE, RATE, MAX_GAP, MAX_GAP_ANGLE, MAX_FORCE = range(7)
"""Columns of ``Records.transitions``."""


class Slot(NamedTuple):
    """The arrays of one spring kernel; ``watched`` (r, 2): stretches of the state, first entry and
    length, that hold its coil contacts.
    """

    parameters: Array
    integers: Integers
    state: Array
    watched: Integers


class Motion(NamedTuple):
    """What the loop changes in place.

    ``q``, ``v`` (N,); ``law_state``: memory of all laws; ``law_addresses``: of the kernels of the
    train's own laws. ``clock`` (15,): cam angle, cam speed, cam acceleration, step, four spring end
    forces, displacement of a partitioned spring, begin and width (rad) of the window of least
    forces, the last part of a step and the one before it, least force (N) of an impact that is
    resolved, cam angle (rad) of the nose. ``counters`` (7,): steps, record every, transitions
    found, exchange interval (0: all advance together), steps per row of coil contacts, parts of the
    rise of an impact (0: steps are never divided), steps per row of ``ends``. ``totals`` (5,): work of the cam, of constant and
    gas forces, dissipated, work on the springs (J), and the share of contact friction in what was
    dissipated.
    """

    q: Array
    v: Array
    law_state: Array
    law_addresses: Integers
    clock: Array
    counters: Integers
    totals: Array


class Records(NamedTuple):
    """What the loop writes down.

    ``motion`` (S, 3 N + 2): q, v, a, cam angle, cam power. ``force``, ``gap`` (S, n). ``spring``
    (S, 4): end forces. ``spring_a``, ``spring_b`` (S, entries): heads of the spring states.
    ``extremes`` (n, 7) over every step: peak force and its cam angle, peak penetration, least force
    in the window and its cam angle, largest force in the window, force at the nose. ``loads`` (7,
    4), ``bodies`` (N, 5) over every step: see their columns; speeds and accelerations of either
    sign. ``ends`` (bins, 4): sums of the end
    forces over the steps of a bin. ``transitions`` (:data:`TRANSITIONS`, 7): interaction, 1 for a closing and 0 for an
    opening, cam angle, rate of the penetration, largest gap of the open side and its cam angle,
    largest force of the closed side. ``pressed_a``, ``pressed_b`` (rows, entries): the coil
    contacts of each spring; no rows: they are not recorded. Without rows of ``loads`` nothing is
    written down at all, and no totals are stored.
    """

    motion: Array
    force: Array
    gap: Array
    spring: Array
    spring_a: Array
    spring_b: Array
    extremes: Array
    loads: Array
    ends: Array
    bodies: Array
    transitions: Array
    pressed_a: Array
    pressed_b: Array


class Scratch(NamedTuple):
    """Working memory of the loop.

    ``old`` (N,): velocities before the step. ``gaps`` (n, 4): penetration, gap rate of the cam
    alone, rate-free force that becomes the whole force, damping coefficient. ``gradients`` (n, 4)
    per coordinate slot, ``slides`` (n, 2) of the first two; ``rubbing`` (n, 2): friction impulse,
    sliding of the cam. ``matrix`` to ``neighbour``: the damping solve. ``before`` (n, 2): penetrations
    one and two steps ago. ``track`` (n, 4): largest gap, its cam angle and largest force since the
    last transition, force of the step before; ``latest`` (n,): its row, -1 for none. ``guides`` (N,
    5): see ``train_damping.guide``, and last one over the mass of the body alone. ``rate``, ``bend`` (n,): rate of the penetration before the
    step, and by how much it exceeds the change of the penetration. ``impacts`` (n, 4): see
    ``train_impacts.finest_step``; ``trial``: copy of the memory of all laws. ``share`` (n,): part of
    the kick in which a contact's damper acts, 1 but in the step of its touch. ``accelerations``
    (N,): of the forces at the step, see ``train_kernel``.
    """

    old: Array
    gaps: Array
    gradients: Array
    slides: Array
    rubbing: Array
    matrix: Array
    dense: Array
    right: Array
    diagonal: Array
    impulse: Array
    row: Array
    rows: Integers
    held: Integers
    lowest: Integers
    place: Integers
    neighbour: Integers
    before: Array
    track: Array
    latest: Integers
    guides: Array
    bend: Array
    rate: Array
    impacts: Array
    trial: Array
    share: Array
    accelerations: Array
