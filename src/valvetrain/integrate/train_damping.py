"""Damping impulses of one step, of all interactions together; the reason is in ``train_kernel``."""

from __future__ import annotations

from valvetrain.compiled import njit
from valvetrain.mechanism.gaps import PART


@njit(**PART)
def _mean_share(now, z):
    """Share theta of the velocity after the step in the one that a damper of z = h c W acts on;
    ``now``: its share at t_n (1/2 of even steps), where light dampers act; heavy ones act on what
    is left at the end.
    """
    return (6.0 * now + z) / (6.0 + z)


@njit(**PART)
def meet_neighbours(index, neighbour):
    """Fill ``neighbour`` (n,): for each interaction the first that shares a coordinate with it, itself
    where none before it does.
    """
    for k in range(index.shape[0]):
        neighbour[k] = k
        for other in range(k - 1, -1, -1):
            for slot in range(4):
                for its in range(4):
                    if index[k, slot] >= 0 and index[k, slot] == index[other, its]:
                        neighbour[k] = other


@njit(**PART)
def _damped_rows(index, scratch, step, now, v):
    """Collect the damped interactions: their places, velocities per impulse, right-hand sides,
    diagonals and the first row that each can be coupled with.

    ``bend`` leads the rates, which were found with the gradients of t_n, to the middles of the
    steps on either side. A damper that was met since the last step acts for its share of the kick,
    which lasts from the middle of one step to the middle of the next.
    """
    gaps, gradients, old, dense = scratch.gaps, scratch.gradients, scratch.old, scratch.dense
    count, onwards = 0, (1.0 - now) / now
    for k in range(index.shape[0]):
        scratch.place[k] = count
        if gaps[k, 3] <= 0.0:
            continue
        if scratch.share[k] == 0.0:
            scratch.share[k] = (
                2.0 * now * gaps[k, 0] / (gaps[k, 0] - scratch.before[k, 0]) + 1.0 - now
            )
        drag = step * scratch.share[k] * gaps[k, 3]
        before, after, mobility = gaps[k, 1], gaps[k, 1], 0.0
        for i in range(v.shape[0]):
            dense[count, i] = 0.0
        for slot in range(4):
            i = index[k, slot]
            if i >= 0:
                gradient = gradients[k, slot]
                before += gradient * old[i]
                after += gradient * v[i]
                dense[count, i] = gradient * scratch.guides[i, 3]
                mobility += gradient * dense[count, i]
        # theta = upper / lower, see _mean_share
        upper, lower = 6.0 * now + drag * mobility, 6.0 + drag * mobility
        share = 1.0 / (drag * upper)
        scratch.diagonal[count] = lower * share
        scratch.right[count] = (
            after
            + onwards * scratch.bend[k]
            + (lower - upper) * share * drag * (before - scratch.bend[k])
        )
        scratch.rows[count] = k
        scratch.lowest[count] = scratch.place[scratch.neighbour[k]]
        count += 1
    return count


@njit(**PART)
def _rate_of(k, row, index, scratch):
    """Rate (m/s) of interaction ``k`` per impulse of the damped one of ``row``."""
    rate = 0.0
    for slot in range(4):
        if index[k, slot] >= 0:
            rate += scratch.gradients[k, slot] * scratch.dense[row, index[k, slot]]
    return rate


@njit(**PART)
def _solve(count, index, scratch):
    """Impulses of all interactions that are not held at their bound: L D L^T in contact space, row by
    row within the envelope, since a contact meets only those that share a body with it.
    """
    rows, held, matrix, impulse, lowest, row = (
        scratch.rows, scratch.held, scratch.matrix, scratch.impulse, scratch.lowest, scratch.row,
    )  # fmt: skip
    bound = 0
    for a in range(count):
        bound += held[a]
    for a in range(count):
        if held[a] == 1:
            for b in range(lowest[a], a):
                matrix[a, b] = 0.0
            matrix[a, a] = 1.0
            continue
        k, first = rows[a], lowest[a]
        value, pivot = scratch.right[a], scratch.diagonal[a] + _rate_of(k, a, index, scratch)
        for b in range(count if bound > 0 else 0):
            if held[b] == 1:
                value -= _rate_of(k, b, index, scratch) * impulse[b]
        for b in range(first, a):
            row[b] = _rate_of(k, b, index, scratch) if held[b] == 0 else 0.0
            for c in range(max(first, lowest[b]), b):
                row[b] -= row[c] * matrix[b, c]
            matrix[a, b] = row[b] * matrix[b, b]
            pivot -= row[b] * matrix[a, b]
            if held[b] == 0:
                value -= matrix[a, b] * impulse[b]
        matrix[a, a], impulse[a] = 1.0 / pivot, value
    for a in range(count - 1, -1, -1):
        if held[a] == 1:
            continue
        impulse[a] *= matrix[a, a]
        for c in range(a + 1, count):
            if lowest[c] <= a and held[c] == 0:
                impulse[a] -= matrix[c, a] * impulse[c]


@njit(**PART)
def _exchange(count, index, laws, scratch, step, single):
    """Hold the contacts that would pull, at no force, and free the held ones whose damper would
    press; returns how many changed.

    ``single``: only the last of them (Murty's rule, which ends for any positive definite matrix,
    where changing all might go in circles).
    """
    gaps, rows, held, impulse = scratch.gaps, scratch.rows, scratch.held, scratch.impulse
    changed = 0
    for back in range(count):
        a = count - 1 - back
        k = rows[a]
        least = -gaps[k, 2] * step
        if laws[k] < 0 or (single and changed > 0):
            continue
        if held[a] == 0:
            if impulse[a] < least:
                held[a], impulse[a], changed = 1, least, changed + 1
        else:
            rate = scratch.right[a]
            for b in range(count):
                rate -= _rate_of(k, b, index, scratch) * impulse[b]
            if rate > scratch.diagonal[a] * impulse[a]:
                held[a], changed = 0, changed + 1
    return changed


@njit(**PART)
def damp(index, laws, scratch, step, now, v):
    """Damping impulses of all interactions together; adds the mean damping forces to ``gaps[:,
    2]``; returns how many there are.

    ``now``: share of the velocity after the step in that of t_n. A contact carries no force rather
    than pull: which ones are held so is found together with the impulses (a linear
    complementarity).
    """
    gaps, rows, held, impulse = scratch.gaps, scratch.rows, scratch.held, scratch.impulse
    count = _damped_rows(index, scratch, step, now, v)
    for a in range(count):
        held[a] = 0
    for trial in range(8 * count):
        _solve(count, index, scratch)
        if _exchange(count, index, laws, scratch, step, 4 * count < trial) == 0:
            break
    per_step = 1.0 / step
    for a in range(count):
        k = rows[a]
        for slot in range(4):
            i = index[k, slot]
            if i >= 0:
                v[i] -= impulse[a] * scratch.dense[a, i]
        force = gaps[k, 2] + impulse[a] * per_step
        # a contact at its bound carries nothing, not the rounding of the difference
        gaps[k, 2] = force if laws[k] < 0 or (held[a] == 0 and force > 0.0) else 0.0
    return count


@njit(**PART)
def guide(body, scratch, step, now, v):
    """Slow ``v`` in the guides, and fill ``guides``: the mass that an impulse of this step moves,
    the guide's impulse per rate, its theta and one over that mass.

    The guide acts on (1 - theta) v_before + theta v_after, so that it is solved together with the
    impulses that follow: slowed after them instead, a valve drifted through its stiff contacts.
    Friction takes its direction at the mean velocity.
    """
    guides, old = scratch.guides, scratch.old
    for i in range(v.shape[0]):
        mass = body[i, 0]
        guides[i, 0] = mass
        if body[i, 2] > 0.0 or body[i, 3] > 0.0:
            drag = step * (
                body[i, 2] + body[i, 3] / max(abs((1.0 - now) * old[i] + now * v[i]), body[i, 4])
            )
            theta = _mean_share(now, drag / mass)
            guides[i, 0], guides[i, 1], guides[i, 2] = mass + theta * drag, drag, theta
            guides[i, 3] = 1.0 / guides[i, 0]
            v[i] = (mass * v[i] - (1.0 - theta) * drag * old[i]) * guides[i, 3]


@njit(**PART)
def losses(index, body, scratch, v, count):
    """Energy (J) lost in the damping impulses of the contacts and in the guides."""
    gaps, gradients, old, rows, impulse, guides = (
        scratch.gaps, scratch.gradients, scratch.old, scratch.rows, scratch.impulse, scratch.guides,
    )  # fmt: skip
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
            lost += (
                guides[i, 1]
                * ((1.0 - guides[i, 2]) * old[i] + guides[i, 2] * v[i])
                * 0.5
                * (old[i] + v[i])
            )
    return lost
