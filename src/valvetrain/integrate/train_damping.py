"""Damping impulses of one step, of all interactions together; why so is told in ``train_kernel``."""

from __future__ import annotations

import math

from numba import njit

from valvetrain.mechanism.gaps import OPTIONS


@njit(forceinline=True, **OPTIONS)
def _damped_rows(index, body, scratch, step, v):
    """Collect the damped interactions: their places, gradients over the root of mass, right-hand sides and diagonals."""
    gaps, gradients, old, dense = scratch.gaps, scratch.gradients, scratch.old, scratch.dense
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
        scratch.diagonal[count] = 1.0 / (step * gaps[k, 3] * theta)
        scratch.right[count] = after + (1.0 - theta) / theta * before
        scratch.rows[count] = k
        count += 1
    return count


@njit(forceinline=True, **OPTIONS)
def _solve(count, scratch):
    """Impulses of all interactions that are not held at their bound: Cholesky in contact space (at most n by n)."""
    held, dense, right, diagonal, matrix, impulse = (
        scratch.held, scratch.dense, scratch.right, scratch.diagonal, scratch.matrix, scratch.impulse,
    )  # fmt: skip
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
def damp(index, laws, body, scratch, step, v):
    """Damping impulses of all interactions together; adds the mean damping forces to ``gaps[:, 2]``; returns how many there are.

    A contact whose total force would pull is kept at zero force and the others are solved again.
    """
    gaps, gradients, rows, held, impulse = scratch.gaps, scratch.gradients, scratch.rows, scratch.held, scratch.impulse
    count = _damped_rows(index, body, scratch, step, v)
    for a in range(count):
        held[a] = 0
    for _ in range(count):
        _solve(count, scratch)
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
def losses(index, body, scratch, step, v, count):
    """Energy (J) lost in the damping impulses of the contacts, then in the guides, which slow ``v`` here."""
    gaps, gradients, old, rows, impulse = scratch.gaps, scratch.gradients, scratch.old, scratch.rows, scratch.impulse
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
