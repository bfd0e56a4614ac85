"""The one compiled loop of a whole train: explicit leapfrog, all damping of a step solved together.

Order of operations in a step (written down once, here): kinematics -> gaps -> memories of the laws
-> laws -> springs -> kick -> damping impulses -> friction -> log of transitions -> record -> drift.
Positions and memories live at t_n, velocities at t_(n-1/2); the spring kernels share the step. A
memory with a differential equation is brought from t_(n-1) to t_n by its exact solution for a
penetration that changed evenly, which is of second order in the step; after the last step it is
brought to the last positions.

Damping never limits the step: its impulses J solve J_k = h c_k ((1 - theta_k) rate_before + theta_k
rate_after) for all interactions at once, theta = (3 + z)/(6 + z) with z = h c W, the exponentially
fitted mean (1/2 for light, 1 for heavy damping). Solved one after the other instead, heavy contact
damping pumped energy into chains of contacts.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types

from valvetrain.compiled import njit
from valvetrain.contact.kernels import (
    ELASTIC_LINK,
    FLORES,
    IMPACT_RATE,
    LANKARANI_NIKRAVESH,
    MAXWELL_LINK,
    OWN_LAW,
    SLOWEST,
    WIDTH,
    damped_force,
    elastic_force,
    maxwell_force,
    update_impact,
)
from valvetrain.contact.own_law import call_law
from valvetrain.integrate.spring_slot import SPRING_FUNCTION, compiled_once, write_contacts
from valvetrain.integrate.train_damping import damp, guide, losses, meet_neighbours
from valvetrain.integrate.train_friction import friction_loss, rub
from valvetrain.integrate.train_impacts import finest_step, meets_damper, parts_of
from valvetrain.integrate.train_log import (
    close_stretch,
    in_window,
    nose_share,
    note_body,
    note_contact,
    note_crossing,
    note_loads,
)
from valvetrain.integrate.train_tuples import PEAK_PENETRATION, Motion, Records, Scratch, Slot
from valvetrain.mechanism.gaps import OPTIONS, PART, penetration_and_gradient, table_value
from valvetrain.system.train_system import TrainArrays

f8, i8 = types.float64, types.int64
_vector, _integers = types.Array(f8, 1, "C"), types.Array(i8, 1, "C")
_matrix, _integer_matrix, _cube = (
    types.Array(f8, 2, "C"),
    types.Array(i8, 2, "C"),
    types.Array(f8, 3, "C"),
)


_TRAIN = types.NamedTuple(
    (
        _integers, _integer_matrix, _integers, _integers, _matrix, _matrix, _integers, _matrix, _cube, _matrix, _cube, i8, i8,
    ),
    TrainArrays,
)  # fmt: skip
_SLOT = types.NamedTuple((_vector, _integers, _vector, _integer_matrix), Slot)
_MOTION = types.NamedTuple(
    (_vector, _vector, _vector, _integers, _vector, _integers, _vector), Motion
)
_RECORDS = types.NamedUniTuple(_matrix, 13, Records)
_SIGNATURE = i8(SPRING_FUNCTION, SPRING_FUNCTION, _TRAIN, _SLOT, _SLOT, _MOTION, _RECORDS)


@njit(**PART)
def law_force_and_damping(law, parameters, impact_rate, pen, rate):
    """Rate-free force (N) and damping coefficient (N s/m) of a contact at this penetration
    (positive).
    """
    elastic = elastic_force(law, parameters, pen)  # taken once: its power costs the most
    still = damped_force(law, parameters, impact_rate, pen, 0.0, elastic)
    closing = max(abs(rate), 1e-9)
    pressed = damped_force(law, parameters, impact_rate, pen, closing, elastic)
    return still, max((pressed - still) / closing, 0.0)


@njit(**PART)
def _remember(k, train, motion, pen, rate, elapsed, scratch):
    """Bring the memory of a Maxwell link or a law of its own over ``elapsed`` (s; 0: it is up to
    date).

    Fills rate-free force (N) and damping coefficient (N s/m) in ``scratch.gaps``; adds what a
    damper took (J) to the totals.
    """
    law, first, parameters, memory, gaps = (
        train.laws[k],
        train.memory_of[k],
        train.law_parameters,
        motion.law_state,
        scratch.gaps,
    )
    if law == MAXWELL_LINK:
        old, damper = memory[first], parameters[k, 2]
        memory[first] = maxwell_force(
            parameters[k, 1], damper, old, pen - scratch.before[k, 0], elapsed
        )
        mean = 0.5 * (old + memory[first])
        motion.totals[2] += elapsed * mean * mean / damper
        gaps[k, 2], gaps[k, 3] = parameters[k, 0] * pen + memory[first], 0.0
    else:
        call_law(
            motion.law_addresses[law - OWN_LAW],
            parameters.ctypes.data + 8 * WIDTH * k,
            memory.ctypes.data + 8 * first,
            train.memory_of[k + 1] - first,
            pen,
            scratch.before[k, 0],
            rate,
            elapsed,
            gaps.ctypes.data + 8 * (4 * k + 2),
        )


@njit(**PART)
def _gap(k, train, q, v, cam_angle, cam_speed, gradients):
    """Penetration (m), its rate by the cam alone and its rate (m/s)."""
    pen, per_angle = penetration_and_gradient(
        k,
        train.kinds,
        train.coordinate_of,
        train.geometry,
        train.tables,
        train.table_of,
        q,
        cam_angle,
        gradients,
    )
    driven = per_angle * cam_speed
    rate = driven
    for slot in range(4):
        if train.coordinate_of[k, slot] >= 0:
            rate += gradients[k, slot] * v[train.coordinate_of[k, slot]]
    return pen, driven, rate


@njit(**PART)
def gaps_and_laws(train, motion, cam_angle, cam_speed, elapsed, scratch, extremes):
    """Fill ``scratch.gaps``: penetration, gap rate of the cam alone, rate-free force, damping
    coefficient.
    """
    law_parameters, gaps, law_state = train.law_parameters, scratch.gaps, motion.law_state
    per_elapsed = 1.0 / elapsed if elapsed > 0.0 else 0.0
    for k in range(train.laws.shape[0]):
        law = train.laws[k]
        pen, driven, rate = _gap(
            k, train, motion.q, motion.v, cam_angle, cam_speed, scratch.gradients
        )
        gaps[k, 0], gaps[k, 1], gaps[k, 2], gaps[k, 3] = pen, driven, 0.0, 0.0
        scratch.rate[k] = rate
        if elapsed > 0.0:
            scratch.bend[k] = rate - (pen - scratch.before[k, 0]) * per_elapsed
        if 0 <= law < OWN_LAW:
            impact_rate = 0.0
            if law == LANKARANI_NIKRAVESH or law == FLORES:
                update_impact(law_state, train.memory_of[k], law_parameters[k, SLOWEST], pen, rate)
                impact_rate = law_state[train.memory_of[k] + IMPACT_RATE]
            if pen > 0.0:
                gaps[k, 2], gaps[k, 3] = law_force_and_damping(
                    law, law_parameters[k], impact_rate, pen, rate
                )
        elif law == ELASTIC_LINK:
            gaps[k, 2], gaps[k, 3] = law_parameters[k, 0] * pen, law_parameters[k, 1]
        else:
            _remember(k, train, motion, pen, rate, elapsed, scratch)
        scratch.share[k] = 1.0
        if (
            law >= 0
            and pen > 0.0
            and scratch.before[k, 0] <= 0.0
            and meets_damper(k, train, motion, scratch, pen, rate)
        ):
            scratch.share[k] = 0.0  # to be found with the step that follows
        extremes[k, PEAK_PENETRATION] = max(extremes[k, PEAK_PENETRATION], pen)


@njit(**PART)
def _kick(index, body, gaps, gradients, guides, step, v):
    """Velocity change by constant and rate-free forces."""
    for i in range(v.shape[0]):
        v[i] += step * body[i, 1] * guides[i, 4]
    for k in range(index.shape[0]):
        if gaps[k, 2] != 0.0:
            impulse = step * gaps[k, 2]
            for slot in range(4):
                i = index[k, slot]
                if i >= 0:
                    v[i] -= impulse * gradients[k, slot] * guides[i, 4]


@njit(**PART)
def _accelerations(index, scratch, step, v):
    """Fill ``scratch.accelerations`` (m/s2, rad/s2) with those that the forces give at t_n.

    A damper met since the last step acts for 0.5 to 1.5 of the kick (its ``share``); its force over
    all of the kick, which the record has too, is the one that accelerates.
    """
    for i in range(v.shape[0]):
        scratch.accelerations[i] = (v[i] - scratch.old[i]) / step
    for k in range(index.shape[0]):
        if scratch.share[k] != 1.0:
            missing = scratch.gaps[k, 2] / scratch.share[k] - scratch.gaps[k, 2]
            for slot in range(4):
                i = index[k, slot]
                if i >= 0:
                    scratch.accelerations[i] -= (
                        missing * scratch.gradients[k, slot] * scratch.guides[i, 3]
                    )


@njit(**PART)
def _account(laws, body, motion, scratch, records, first, cam_angle, step, now):
    """Add the work of cam and constant forces to the totals and note every contact; returns cam
    power (W) and largest speed.
    """
    power, work, bound, gaps, rubbing = 0.0, 0.0, 0.0, scratch.gaps, scratch.rubbing
    v, old = motion.v, scratch.old
    inside = in_window(cam_angle, motion.clock[9], motion.clock[10])
    nose = nose_share(cam_angle, motion.clock[1], first, motion.clock)
    for k in range(laws.shape[0]):
        power += gaps[k, 2] * gaps[k, 1]
        if rubbing[k, 0] != 0.0:
            power += rubbing[k, 0] / step * rubbing[k, 1]
        note_contact(
            k,
            gaps[k, 0],
            gaps[k, 2] / scratch.share[k],
            laws[k] >= 0,
            first,
            inside,
            nose,
            cam_angle,
            motion,
            scratch,
            records,
        )
    for i in range(v.shape[0]):
        work += body[i, 1] * 0.5 * (old[i] + v[i])
        bound = max(bound, abs(v[i]))
        note_body(
            i, motion.q[i], old[i], v[i], now, scratch.accelerations[i], cam_angle, records.bodies
        )
    motion.totals[0] += step * power
    motion.totals[1] += step * work
    return power, bound


@njit(**PART)
def _pass_on(v, scratch, first):
    """Store the penetrations for the next step, as :func:`_account` does among all else; returns the
    largest speed.
    """
    bound = 0.0
    for k in range(scratch.before.shape[0]):
        if not first:
            scratch.before[k, 1] = scratch.before[k, 0]
            scratch.before[k, 0] = scratch.gaps[k, 0]
    for i in range(v.shape[0]):
        bound = max(bound, abs(v[i]))
    return bound


@njit(**PART)
def _record(row, records, q, v, now, cam_angle, power, scratch, clock):
    count, motion, gaps, share = q.shape[0], records.motion, scratch.gaps, scratch.share
    for i in range(count):
        motion[row, i] = q[i]
        motion[row, count + i] = (1.0 - now) * scratch.old[i] + now * v[i]
        motion[row, 2 * count + i] = scratch.accelerations[i]
    motion[row, 3 * count], motion[row, 3 * count + 1] = cam_angle, power
    for k in range(gaps.shape[0]):
        records.force[row, k], records.gap[row, k] = gaps[k, 2] / share[k], -gaps[k, 0]
    for j in range(4):
        records.spring[row, j] = clock[4 + j]


@njit(**PART)
def _begin(train, motion, scratch):
    """Penetrations at the start and, by their rates, one step before it; masses and neighbours."""
    meet_neighbours(train.coordinate_of, scratch.neighbour)
    for i in range(motion.q.shape[0]):
        scratch.guides[i, 3] = scratch.guides[i, 4] = 1.0 / train.body[i, 0]
    for k in range(train.laws.shape[0]):
        pen, _, rate = _gap(
            k, train, motion.q, motion.v, motion.clock[0], motion.clock[1], scratch.gradients
        )
        scratch.before[k, 0], scratch.before[k, 1] = pen, pen - motion.clock[11] * rate
        scratch.latest[k] = -1


@njit(**PART)
def _finish(train, motion, scratch, log):
    """Bring memories and the log of transitions to the positions after the last drift."""
    clock = motion.clock
    for k in range(train.laws.shape[0]):
        pen, _, rate = _gap(k, train, motion.q, motion.v, clock[0], clock[1], scratch.gradients)
        if train.laws[k] == MAXWELL_LINK or train.laws[k] >= OWN_LAW:
            _remember(k, train, motion, pen, rate, clock[11], scratch)
        if train.laws[k] >= 0 and (pen > 0.0) != (scratch.before[k, 0] > 0.0):
            note_crossing(k, pen, clock[0], motion, scratch, log)
        close_stretch(k, -1, pen > 0.0, scratch, log)


@njit(**OPTIONS)
def _integrate(spring_a, spring_b, train, slot_a, slot_b, motion, records, scratch):
    """The loop itself; see :func:`advance_train`. Compiled without reference counting, which would
    cost more than the physics.
    """
    q, v, clock, counters, totals, old, gaps = (
        motion.q,
        motion.v,
        motion.clock,
        motion.counters,
        motion.totals,
        scratch.old,
        scratch.gaps,
    )
    index, laws, body, retainer, gas_coordinate = (
        train.coordinate_of,
        train.laws,
        train.body,
        train.retainer,
        train.gas_coordinate,
    )
    step, every, exchange, bound, sample, elapsed = clock[3], counters[1], counters[3], 0.0, 0, 0.0
    watched, next_watch, noted = (
        0,
        0 if records.pressed_a.shape[0] > 0 else -1,
        records.loads.shape[0] > 0,
    )
    n, left, part, change = -1, 0, step, 0.0
    _begin(train, motion, scratch)
    while True:
        whole = left == 0
        if whole:
            n += 1
            if n == counters[0]:
                break
        recording = whole and n % every == 0 and sample < records.motion.shape[0]
        cam_angle, cam_speed = clock[0], clock[1]
        for i in range(q.shape[0]):
            old[i] = v[i]
        if recording:
            for i in range(records.spring_a.shape[1]):
                records.spring_a[sample, i] = slot_a.state[i]
            for i in range(records.spring_b.shape[1]):
                records.spring_b[sample, i] = slot_b.state[i]
        gaps_and_laws(train, motion, cam_angle, cam_speed, elapsed, scratch, records.extremes)
        ahead = step if whole else left * part
        if counters[5] > 0:
            finest = finest_step(train, motion, scratch, ahead, elapsed)
            if whole or finest < 0.9 * part:
                left = parts_of(ahead, finest)
                part = ahead / left
        elif whole:
            left = 1
        kick = 0.5 * (clock[11] + part)
        now = 0.5 * clock[11] / kick
        if whole:
            change = clock[4] + clock[6]
            if exchange <= 0:
                clock[4], clock[5] = spring_a(
                    slot_a.parameters, slot_a.integers, slot_a.state, q[retainer], v[retainer], step
                )
                clock[6], clock[7] = spring_b(
                    slot_b.parameters, slot_b.integers, slot_b.state, q[retainer], v[retainer], step
                )
            elif (
                n % exchange == 0
            ):  # the force found now is stored; the spring module then integrates the velocity it was given
                for sub in range(exchange):
                    forces_a = spring_a(
                        slot_a.parameters,
                        slot_a.integers,
                        slot_a.state,
                        clock[8],
                        old[retainer],
                        step,
                    )
                    forces_b = spring_b(
                        slot_b.parameters,
                        slot_b.integers,
                        slot_b.state,
                        clock[8],
                        old[retainer],
                        step,
                    )
                    if sub == 0:
                        clock[4], clock[5] = forces_a
                        clock[6], clock[7] = forces_b
                    clock[8] += step * old[retainer]
            change = clock[4] + clock[6] - change if n > 0 else 0.0
        if whole and n == next_watch:
            write_contacts(slot_a.state, slot_a.watched, records.pressed_a[watched])
            write_contacts(slot_b.state, slot_b.watched, records.pressed_b[watched])
            watched, next_watch = watched + 1, n + counters[4]
        pull = (
            clock[4] + clock[6] + (1.0 - ahead / step) * change
        )  # inside a step the springs' force continues as it came
        _kick(index, body, gaps, scratch.gradients, scratch.guides, kick, v)
        v[retainer] -= kick * pull * scratch.guides[retainer, 4]
        pressed = 0.0
        if gas_coordinate >= 0:
            pressed, _, _ = table_value(train.gas, 0, cam_angle)
            v[gas_coordinate] += kick * pressed / body[gas_coordinate, 0]
        guide(body, scratch, kick, now, v)
        damped = damp(index, laws, scratch, kick, now, v)
        rub(train, q, cam_angle, cam_speed, kick, v, scratch)
        if noted:
            rubbed = friction_loss(index, v, scratch)
            totals[2] += rubbed + losses(index, body, scratch, v, damped)
            totals[4] += rubbed
            _accelerations(index, scratch, kick, v)
            power, bound = _account(
                laws, body, motion, scratch, records, whole and n == 0, cam_angle, kick, now
            )
            note_loads(power, cam_angle, cam_speed, clock, records.loads)
            if whole:
                for j in range(4):
                    records.ends[n // counters[6], j] += clock[4 + j]
            if gas_coordinate >= 0:
                totals[1] += kick * pressed * 0.5 * (old[gas_coordinate] + v[gas_coordinate])
            totals[3] += kick * pull * 0.5 * (old[retainer] + v[retainer])
            if recording:
                _record(
                    sample,
                    records,
                    q,
                    v,
                    now,
                    cam_angle,
                    power,
                    scratch,
                    clock,
                )
                sample += 1
        else:
            bound = _pass_on(v, scratch, whole and n == 0)
        for i in range(q.shape[0]):
            q[i] += part * v[i]
        clock[0] = cam_angle + part * (cam_speed + 0.5 * part * clock[2])
        clock[1] = cam_speed + part * clock[2]
        clock[12], clock[11], elapsed, left = clock[11], part, part, left - 1
        if not bound < 1e4:
            return n
    _finish(train, motion, scratch, records.transitions)
    return counters[0]


@njit(forceinline=True, error_model="numpy")
def scratch_of(n, count, states):
    """Empty working memory for n interactions, ``count`` coordinates and ``states`` numbers that
    the laws remember.
    """
    return Scratch(
        np.zeros(count),
        np.zeros((n, 4)),
        np.zeros((n, 4)),
        np.zeros((n, 2)),
        np.zeros((n, 2)),
        np.zeros((n, n)),
        np.zeros((n, count)),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n, dtype=np.int64),
        np.zeros(n, dtype=np.int64),
        np.zeros(n, dtype=np.int64),
        np.zeros(n, dtype=np.int64),
        np.zeros(n, dtype=np.int64),
        np.zeros((n, 2)),
        np.zeros((n, 4)),
        np.zeros(n, dtype=np.int64),
        np.zeros((count, 5)),
        np.zeros(n),
        np.zeros(n),
        np.zeros((n, 4)),
        np.zeros(states),
        np.ones(n),
        np.zeros(count),
    )


@njit(cache=True, error_model="numpy")
def advance_train(spring_a, spring_b, train, slot_a, slot_b, motion, records):
    """Advance ``motion`` by ``motion.counters[0]`` steps in place; returns the steps done (fewer
    when the motion left all bounds).

    ``spring_a``, ``spring_b``: kernels of ``springs.contract``; the arrays of all that moves come
    as ``TrainArrays`` and as the named tuples of ``train_tuples``. Compiled once for all trains,
    see :func:`ready_train_kernel`.
    """
    scratch = scratch_of(train.kinds.shape[0], motion.q.shape[0], motion.law_state.shape[0])
    return _integrate(spring_a, spring_b, train, slot_a, slot_b, motion, records, scratch)


def ready_train_kernel() -> Any:
    """:func:`advance_train` compiled for spring kernels as first-class functions."""
    return compiled_once(advance_train, _SIGNATURE)
