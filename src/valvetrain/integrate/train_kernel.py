"""The one compiled loop of a whole train: explicit leapfrog, all damping of a step solved together.

Order of operations in a step (written down once, here): kinematics -> gaps -> laws -> springs -> kick -> damping
impulses -> friction -> record -> drift. Positions live at t_n, velocities at t_(n-1/2); the spring kernels share the step.

Damping never limits the step: its impulses J solve J_k = h c_k ((1 - theta_k) rate_before + theta_k rate_after) for all
interactions at once, theta = (3 + z)/(6 + z) with z = h c W, the exponentially fitted mean (1/2 for light, 1 for heavy damping).
Solved one after the other instead, heavy contact damping pumped energy into chains of contacts.
"""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
from numba import njit, types
from numba.core.errors import NumbaExperimentalFeatureWarning

from valvetrain.contact.kernels import FLORES, LANKARANI_NIKRAVESH, contact_force, update_impact
from valvetrain.integrate.train_friction import friction_loss, rub
from valvetrain.mechanism.gaps import OPTIONS, penetration_and_gradient, table_value

# Spring kernels enter as first-class functions; numba calls that experimental each time it compiles the loop.
warnings.filterwarnings("ignore", category=NumbaExperimentalFeatureWarning)

BILATERAL = -1
"""Law code of an elastic link; contact laws count from zero."""

f8, i8 = types.float64, types.int64
_vector, _integers = types.Array(f8, 1, "C"), types.Array(i8, 1, "C")
_matrix, _integer_matrix, _cube = types.Array(f8, 2, "C"), types.Array(i8, 2, "C"), types.Array(f8, 3, "C")
SPRING_SIGNATURE = types.UniTuple(f8, 2)(_vector, _integers, _vector, f8, f8, f8)
SPRING_FUNCTION = types.FunctionType(SPRING_SIGNATURE)


@njit(forceinline=True, **OPTIONS)
def law_force_and_damping(law, parameters, pen, rate):
    """Rate-free force (N) and damping coefficient (N s/m) of a contact at this penetration (positive)."""
    still = contact_force(law, parameters, pen, 0.0)
    closing = max(abs(rate), 1e-9)
    return still, max((contact_force(law, parameters, pen, closing) - still) / closing, 0.0)


_SIGNATURE = i8(
    SPRING_FUNCTION, SPRING_FUNCTION, _integers, _integer_matrix, _integers, _integers, _matrix, _matrix, _matrix, _cube, _matrix,
    _cube, i8, i8, _vector, _integers, _vector, _vector, _integers, _vector, _vector, _vector,
    _vector, _integers, _vector, _matrix, _matrix, _matrix, _matrix, _matrix, _matrix,
)  # fmt: skip


@njit(forceinline=True, **OPTIONS)
def _gaps_and_laws(kinds, index, table_of, laws, geometry, law_parameters, tables, q, v, cam_angle, cam_speed, gaps, gradients, totals):
    """Fill ``gaps`` (n, 4): penetration, gap rate of the cam alone, rate-free force, damping coefficient."""
    interactions = kinds.shape[0]
    for k in range(interactions):
        pen, per_angle = penetration_and_gradient(k, kinds, index, geometry, tables, table_of, q, cam_angle, gradients)
        driven = per_angle * cam_speed
        rate = driven
        for slot in range(4):
            if index[k, slot] >= 0:
                rate += gradients[k, slot] * v[index[k, slot]]
        gaps[k, 0], gaps[k, 1] = pen, driven
        if laws[k] == LANKARANI_NIKRAVESH or laws[k] == FLORES:
            update_impact(law_parameters[k], pen, rate)
        if laws[k] == BILATERAL:
            gaps[k, 2], gaps[k, 3] = law_parameters[k, 0] * pen, law_parameters[k, 1]
        elif pen > 0.0:
            gaps[k, 2], gaps[k, 3] = law_force_and_damping(laws[k], law_parameters[k], pen, rate)
        else:
            gaps[k, 2], gaps[k, 3] = 0.0, 0.0
        totals[4 + interactions + k] = max(totals[4 + interactions + k], pen)


@njit(forceinline=True, **OPTIONS)
def _kick(index, body, gaps, gradients, step, v):
    """Velocity change by constant and rate-free forces."""
    for i in range(v.shape[0]):
        v[i] += step * body[i, 1] / body[i, 0]
    for k in range(index.shape[0]):
        if gaps[k, 2] != 0.0:
            for slot in range(4):
                if index[k, slot] >= 0:
                    v[index[k, slot]] -= step * gaps[k, 2] * gradients[k, slot] / body[index[k, slot], 0]


@njit(forceinline=True, **OPTIONS)
def _damped_rows(index, body, gaps, gradients, step, v, old, rows, dense, right, diagonal):
    """Collect the damped interactions: their places, gradients over the root of mass, right-hand sides and diagonals."""
    count = 0
    for k in range(index.shape[0]):
        if gaps[k, 3] <= 0.0:
            continue
        before, after, mobility = gaps[k, 1], gaps[k, 1], 0.0
        for i in range(v.shape[0]):
            dense[count, i] = 0.0
        for slot in range(4):
            i = index[k, slot]
            if i >= 0:
                before += gradients[k, slot] * old[i]
                after += gradients[k, slot] * v[i]
                dense[count, i] = gradients[k, slot] / math.sqrt(body[i, 0])
                mobility += dense[count, i] * dense[count, i]
        z = step * gaps[k, 3] * mobility
        theta = (3.0 + z) / (6.0 + z)
        diagonal[count] = 1.0 / (step * gaps[k, 3] * theta)
        right[count] = after + (1.0 - theta) / theta * before
        rows[count] = k
        count += 1
    return count


@njit(forceinline=True, **OPTIONS)
def _solve(count, held, dense, right, diagonal, matrix, impulse):
    """Impulses of all interactions that are not held at their bound: Cholesky in contact space (at most n by n)."""
    for a in range(count):
        for b in range(a + 1):
            value = 0.0
            if held[a] == 0 and held[b] == 0:
                for i in range(dense.shape[1]):
                    value += dense[a, i] * dense[b, i]
            matrix[a, b] = value
        matrix[a, a] += diagonal[a] if held[a] == 0 else 1.0
        if held[a] == 0:
            impulse[a] = right[a]
            for b in range(count):
                if held[b] == 1:
                    for i in range(dense.shape[1]):
                        impulse[a] -= dense[a, i] * dense[b, i] * impulse[b]
    for a in range(count):
        for b in range(a + 1):
            value = matrix[a, b]
            for c in range(b):
                value -= matrix[a, c] * matrix[b, c]
            matrix[a, b] = 1.0 / math.sqrt(value) if a == b else value * matrix[b, b]  # reciprocal diagonal
        for c in range(a):
            impulse[a] -= matrix[a, c] * impulse[c]
        impulse[a] *= matrix[a, a]
    for a in range(count - 1, -1, -1):
        for c in range(a + 1, count):
            impulse[a] -= matrix[c, a] * impulse[c]
        impulse[a] *= matrix[a, a]


@njit(forceinline=True, **OPTIONS)
def _damp(index, laws, body, gaps, gradients, step, v, old, rows, held, dense, right, diagonal, matrix, impulse):
    """Damping impulses of all interactions together; adds the mean damping forces to ``gaps[:, 2]``; returns how many there are.

    A contact whose total force would pull is held at zero force and the others are solved again.
    """
    count = _damped_rows(index, body, gaps, gradients, step, v, old, rows, dense, right, diagonal)
    for a in range(count):
        held[a] = 0
    for _ in range(count):
        _solve(count, held, dense, right, diagonal, matrix, impulse)
        pulling = 0
        for a in range(count):
            k = rows[a]
            if held[a] == 0 and laws[k] >= 0 and impulse[a] < -gaps[k, 2] * step:
                held[a], impulse[a], pulling = 1, -gaps[k, 2] * step, 1
        if pulling == 0:
            break
    for a in range(count):
        k = rows[a]
        for slot in range(4):
            i = index[k, slot]
            if i >= 0:
                v[i] -= impulse[a] * gradients[k, slot] / body[i, 0]
        force = gaps[k, 2] + impulse[a] / step
        # a contact at its bound carries nothing, not the rounding of the difference
        gaps[k, 2] = force if laws[k] < 0 or (held[a] == 0 and force > 0.0) else 0.0
    return count


@njit(forceinline=True, **OPTIONS)
def _losses(index, body, gaps, gradients, step, v, old, rows, count, impulse):
    """Energy (J) lost in the damping impulses of the contacts, then in the guides, which slow ``v`` here."""
    lost = 0.0
    for a in range(count):
        k = rows[a]
        rate = gaps[k, 1]
        for slot in range(4):
            if index[k, slot] >= 0:
                rate += 0.5 * gradients[k, slot] * (old[index[k, slot]] + v[index[k, slot]])
        lost += impulse[a] * rate
    for i in range(v.shape[0]):
        if body[i, 2] > 0.0 or body[i, 3] > 0.0:
            z = step * (body[i, 2] + body[i, 3] / max(abs(v[i]), body[i, 4])) / body[i, 0]
            after = v[i] / (1.0 + z + 0.5 * z * z)
            lost += 0.5 * body[i, 0] * (v[i] * v[i] - after * after)
            v[i] = after
    return lost


@njit(forceinline=True, **OPTIONS)
def _account(body, gaps, rubbing, step, v, old, totals):
    """Add the work of cam and constant forces and the peak forces to ``totals``; returns cam power (W) and largest speed."""
    power, work, bound, interactions = 0.0, 0.0, 0.0, gaps.shape[0]
    for k in range(interactions):
        power += gaps[k, 2] * gaps[k, 1] + rubbing[k, 0] / step * rubbing[k, 1]
        totals[4 + k] = max(totals[4 + k], abs(gaps[k, 2]))
    for i in range(v.shape[0]):
        work += body[i, 1] * 0.5 * (old[i] + v[i])
        bound = max(bound, abs(v[i]))
    totals[0] += step * power
    totals[1] += step * work
    return power, bound


@njit(forceinline=True, **OPTIONS)
def _record(row, motion, force, gap, spring, q, v, old, step, cam_angle, power, gaps, clock):
    count = q.shape[0]
    for i in range(count):
        motion[row, i] = q[i]
        motion[row, count + i] = 0.5 * (old[i] + v[i])
        motion[row, 2 * count + i] = (v[i] - old[i]) / step
    motion[row, 3 * count], motion[row, 3 * count + 1] = cam_angle, power
    for k in range(gaps.shape[0]):
        force[row, k], gap[row, k] = gaps[k, 2], -gaps[k, 0]
    for j in range(4):
        spring[row, j] = clock[4 + j]


@njit(**OPTIONS)
def _march(
    spring_a, spring_b, kinds, index, table_of, laws, geometry, law_parameters, friction, tables, body,
    gas, gas_coordinate, retainer, parameters_a, integers_a, state_a, parameters_b, integers_b, state_b, q, v,
    clock, counters, totals, record_motion, record_force, record_gap, record_spring, record_state_a, record_state_b,
    old, gaps, gradients, slides, rubbing, matrix, dense, right, diagonal, impulse, rows, held,
):  # fmt: skip
    """The loop itself; see :func:`advance_train`. Compiled without reference counting, which would cost more than the physics."""
    step, every, exchange, bound, sample = clock[3], counters[1], counters[3], 0.0, 0
    for n in range(counters[0]):
        recording = n % every == 0 and sample < record_motion.shape[0]
        cam_angle, cam_speed = clock[0], clock[1]
        for i in range(q.shape[0]):
            old[i] = v[i]
        if recording:
            for i in range(record_state_a.shape[1]):
                record_state_a[sample, i] = state_a[i]
            for i in range(record_state_b.shape[1]):
                record_state_b[sample, i] = state_b[i]
        _gaps_and_laws(kinds, index, table_of, laws, geometry, law_parameters, tables, q, v, cam_angle, cam_speed, gaps, gradients, totals)
        if exchange <= 0:
            clock[4], clock[5] = spring_a(parameters_a, integers_a, state_a, q[retainer], v[retainer], step)
            clock[6], clock[7] = spring_b(parameters_b, integers_b, state_b, q[retainer], v[retainer], step)
        elif n % exchange == 0:  # the force found now is held; the spring module then integrates the velocity it was handed
            for sub in range(exchange):
                forces_a = spring_a(parameters_a, integers_a, state_a, clock[8], old[retainer], step)
                forces_b = spring_b(parameters_b, integers_b, state_b, clock[8], old[retainer], step)
                if sub == 0:
                    clock[4], clock[5] = forces_a
                    clock[6], clock[7] = forces_b
                clock[8] += step * old[retainer]
        _kick(index, body, gaps, gradients, step, v)
        v[retainer] -= step * (clock[4] + clock[6]) / body[retainer, 0]
        pressed = 0.0
        if gas_coordinate >= 0:
            pressed, _, _ = table_value(gas, 0, cam_angle)
            v[gas_coordinate] += step * pressed / body[gas_coordinate, 0]
        damped = _damp(index, laws, body, gaps, gradients, step, v, old, rows, held, dense, right, diagonal, matrix, impulse)
        rub(kinds, index, table_of, friction, geometry, tables, q, cam_angle, cam_speed, body, gaps, step, v, slides, rubbing)
        rubbed = friction_loss(index, old, v, slides, rubbing)
        totals[2] += rubbed + _losses(index, body, gaps, gradients, step, v, old, rows, damped, impulse)
        totals[4 + 2 * kinds.shape[0]] += rubbed
        power, bound = _account(body, gaps, rubbing, step, v, old, totals)
        if gas_coordinate >= 0:
            totals[1] += step * pressed * 0.5 * (old[gas_coordinate] + v[gas_coordinate])
        totals[3] += step * (clock[4] + clock[6]) * 0.5 * (old[retainer] + v[retainer])
        if recording:
            _record(
                sample, record_motion, record_force, record_gap, record_spring, q, v, old, step, cam_angle, power, gaps, clock
            )  # fmt: skip
            sample += 1
        for i in range(q.shape[0]):
            q[i] += step * v[i]
        clock[0] = cam_angle + step * (cam_speed + 0.5 * step * clock[2])
        clock[1] = cam_speed + step * clock[2]
        if not bound < 1e4:
            return n
    return counters[0]


@njit(cache=True, error_model="numpy")
def advance_train(
    spring_a, spring_b, kinds, index, table_of, laws, geometry, law_parameters, friction, tables, body,
    gas, gas_coordinate, retainer, parameters_a, integers_a, state_a, parameters_b, integers_b, state_b, q, v,
    clock, counters, totals, record_motion, record_force, record_gap, record_spring, record_state_a, record_state_b,
):  # fmt: skip
    """Advance ``counters[0]`` steps in place; returns the steps done (fewer when the motion left all bounds).

    ``clock`` (9,): cam angle, cam speed, cam acceleration, step, four spring end forces, displacement of a partitioned spring.
    ``counters`` (4,): steps, record every, unused, exchange interval (0: all advance together). ``body`` (N, 5): mass, constant force,
    guide damping, friction, friction velocity. ``friction`` (n, 2): coefficient and slip rate (m/s) per contact. ``totals`` (5 + 2 n):
    work of the cam, of constant and gas forces, dissipated, work on the springs, then peak force and peak penetration per interaction,
    and the share of contact friction in what was dissipated. Records: ``motion`` (S, 3 N + 2) q, v, a, cam angle, cam power; ``force``
    and ``gap`` (S, n); ``spring`` (S, 4); spring states (S, unknowns...).
    """
    n, count = kinds.shape[0], q.shape[0]
    return _march(
        spring_a, spring_b, kinds, index, table_of, laws, geometry, law_parameters, friction, tables, body,
        gas, gas_coordinate, retainer, parameters_a, integers_a, state_a, parameters_b, integers_b, state_b, q, v,
        clock, counters, totals, record_motion, record_force, record_gap, record_spring, record_state_a, record_state_b,
        np.zeros(count), np.zeros((n, 4)), np.zeros((n, 4)), np.zeros((n, 4)), np.zeros((n, 2)), np.zeros((n, n)), np.zeros((n, count)),
        np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64),
    )  # fmt: skip


def ready_train_kernel() -> Any:
    """:func:`advance_train` compiled (or read from its cache) for spring kernels as first-class functions, and for nothing else."""
    if not advance_train.signatures:
        advance_train.compile(_SIGNATURE)
        advance_train.disable_compile()
    return advance_train
