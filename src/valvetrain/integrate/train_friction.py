"""Friction in the contacts of a train: one implicit impulse per sliding contact, after the normal
impulses of the step are known.

The sliding velocity s after the step solves s + h W mu N tanh(s / v0) = s_free, W the tangential
mobility: exact where it slides, and dissipative at any step where it sticks (regularised Coulomb
law of ``contact.friction``).
"""

from __future__ import annotations

import math

from valvetrain.compiled import njit
from valvetrain.mechanism.gaps import PART
from valvetrain.mechanism.sliding import SLIDING_SLOTS, sliding_gradient


@njit(**PART)
def slowed(free, most, width):
    """Root s of s + most tanh(s / width) = free. Newton from below on a concave function never
    overshoots.
    """
    aim = abs(free)
    s = max(aim - most, 0.0)
    for _ in range(50):
        pull = math.tanh(s / width)
        move = (aim - s - most * pull) / (1.0 + most / width * (1.0 - pull * pull))
        s += move
        if move <= 1e-14 * aim:
            break
    return s if free > 0.0 else -s


@njit(**PART)
def rub(train, q, cam_angle, cam_speed, step, v, scratch):
    """Friction impulses of all contacts that slide; changes ``v`` and fills ``rubbing`` (n, 2):
    impulse (N s), sliding of the cam (m/s).
    """
    index, friction, gaps, slides, rubbing = (
        train.coordinate_of,
        train.friction,
        scratch.gaps,
        scratch.slides,
        scratch.rubbing,
    )
    for k in range(index.shape[0]):
        rubbing[k, 0], rubbing[k, 1] = 0.0, 0.0
        if friction[k, 0] <= 0.0 or gaps[k, 2] <= 0.0:
            continue
        driven = cam_speed * sliding_gradient(
            k,
            train.kinds,
            index,
            train.geometry,
            train.tables,
            train.table_of,
            q,
            cam_angle,
            slides,
        )
        free, mobility = driven, 0.0
        for slot in range(SLIDING_SLOTS):
            i = index[k, slot]
            if i >= 0:
                free += slides[k, slot] * v[i]
                mobility += slides[k, slot] * slides[k, slot] * scratch.guides[i, 3]
        limit = step * friction[k, 0] * gaps[k, 2]
        after = slowed(free, limit * mobility, friction[k, 1])
        impulse = limit * math.tanh(after / friction[k, 1])
        for slot in range(SLIDING_SLOTS):
            i = index[k, slot]
            if i >= 0:
                v[i] -= impulse * slides[k, slot] * scratch.guides[i, 3]
        rubbing[k, 0], rubbing[k, 1] = impulse, driven


@njit(**PART)
def friction_loss(index, v, scratch):
    """Energy (J) that friction takes in the step: impulses times the mean sliding velocity."""
    lost, old, slides, rubbing = 0.0, scratch.old, scratch.slides, scratch.rubbing
    for k in range(index.shape[0]):
        if rubbing[k, 0] != 0.0:
            rate = rubbing[k, 1]
            for slot in range(SLIDING_SLOTS):
                if index[k, slot] >= 0:
                    rate += 0.5 * slides[k, slot] * (old[index[k, slot]] + v[index[k, slot]])
            lost += rubbing[k, 0] * rate
    return lost
