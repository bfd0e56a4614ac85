"""Impacts of a train's contacts: when one is due, how long its force rises, and the step that
resolves it.

A contact that a body meets at the rate r stops it in a time of the size tau: F(r tau, r) W tau = r,
F its law and W the mobility of the two bodies. For a linear contact tau is 1 / omega; for a damper
that takes the impact it is far shorter than any period of the train.
"""

from __future__ import annotations

import math

from valvetrain.compiled import njit
from valvetrain.contact.kernels import OWN_LAW, WIDTH, contact_force
from valvetrain.contact.own_law import call_law
from valvetrain.mechanism.gaps import PART

MAX_PARTS = 64
"""Most parts of one step."""
LASTS = 8.0
"""Times tau for which a contact that stays closed is taken in short steps; a free mass leaves an
elastic contact after 3.
"""
AHEAD = 1.25
"""Times the step over which a closing is looked for: the gap may close faster than its rate shows."""
OCTAVES, HALVINGS = 12.0, 8


@njit(**PART)
def _force(k, train, motion, scratch, pen, rate, since):
    """Force (N) of contact ``k`` at a penetration (m, positive), ``since`` (s) after a touch at
    ``rate`` (m/s); a law of its own gets a copy of its memory.
    """
    law = train.laws[k]
    if law < OWN_LAW:
        return contact_force(law, train.law_parameters[k], rate, pen, rate)
    first, end = train.memory_of[k], train.memory_of[k + 1]
    for i in range(first, end):
        scratch.trial[i] = motion.law_state[i]
    call_law(
        motion.law_addresses[law - OWN_LAW],
        train.law_parameters.ctypes.data + 8 * WIDTH * k,
        scratch.trial.ctypes.data + 8 * first,
        end - first,
        pen,
        0.0,
        rate,
        since,
        scratch.impacts.ctypes.data + 8 * (4 * k + 2),
    )
    return scratch.impacts[k, 2] + scratch.impacts[k, 3] * rate


@njit(**PART)
def meets_damper(k, train, motion, scratch, pen, rate):
    """Whether a contact that closed since the last step presses with a damper from the touch on, as
    no law with a smooth force does.
    """
    damper = scratch.gaps[k, 3] * rate
    return damper > 0.0 and _force(k, train, motion, scratch, 1e-6 * pen, rate, 0.0) > 0.5 * damper


@njit(**PART)
def _rise(k, train, motion, scratch, rate, longest, least):
    """Time tau (s) of an impact at ``rate`` (m/s), by halving its logarithm; ``longest`` where it is
    that or longer, or the force below ``least`` (N).
    """
    mobility = 0.0
    for slot in range(4):
        i = train.coordinate_of[k, slot]
        if i >= 0:
            mobility += scratch.gradients[k, slot] * scratch.gradients[k, slot] / train.body[i, 0]
    if mobility == 0.0 or rate <= least * mobility * longest * 2.0**-OCTAVES:
        return longest
    if _force(k, train, motion, scratch, rate * longest, rate, longest) * mobility * longest < rate:
        return longest
    share, half = 0.0, 0.5 * OCTAVES
    for _ in range(HALVINGS):
        tau = longest * 2.0 ** (share - half)
        if _force(k, train, motion, scratch, rate * tau, rate, tau) * mobility * tau > rate:
            share -= half
        half *= 0.5
    tau = longest * 2.0**share
    return tau if rate > least * mobility * tau else longest


@njit(**PART)
def finest_step(train, motion, scratch, ahead, passed):
    """Step (s) that takes ``counters[5]`` parts of the rise of every impact that lasts or is due
    within ``ahead`` (s).

    ``passed`` (s): since the last call. ``impacts`` (n, 4) holds per contact the step of its impact (0:
    none) and how long that still lasts.
    """
    parts, impacts, laws, finest = motion.counters[5], scratch.impacts, train.laws, math.inf
    for k in range(laws.shape[0]):
        if laws[k] < 0:
            continue
        pen, rate = scratch.gaps[k, 0], scratch.rate[k]
        impacts[k, 1] -= passed
        if pen <= 0.0:
            begins = rate > 0.0 and pen + AHEAD * ahead * rate > 0.0
            impacts[k, 0] *= 1.0 if begins else 0.0
        else:
            begins = rate > 0.0 and scratch.before[k, 0] <= 0.0 and impacts[k, 0] == 0.0
            if impacts[k, 1] <= 0.0:
                impacts[k, 0] = 0.0
        if begins:
            longest = parts * motion.clock[3]
            tau = _rise(k, train, motion, scratch, rate, longest, motion.clock[13])
            if tau < longest:
                impacts[k, 0], impacts[k, 1] = tau / parts, LASTS * tau + ahead
            else:
                impacts[k, 0] = 0.0
        if impacts[k, 0] > 0.0:
            finest = min(finest, impacts[k, 0])
    return finest


@njit(**PART)
def parts_of(length, finest):
    """In how many equal parts a stretch (s) is taken so that none is longer than ``finest`` (s)."""
    if length <= finest:
        return 1
    return int(min(math.ceil(length / finest), MAX_PARTS))
