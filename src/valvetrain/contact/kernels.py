"""Compiled laws: one function evaluates any contact law from its code, its parameter row and what
it remembers.

Row of ``WIDTH`` float64 per law (SI)::

    0 STIFFNESS   N/m**exponent        3 RESTITUTION -
    1 EXPONENT    -                    4 DEPTH       m, penetration of full damping (IMPACT)
    2 DAMPING     law's own unit       5 SLOWEST     m/s, floor of the impact rate (restitution
    laws)

Memory is separate from the parameters: a law declares its number of ``states`` and a train gives
it as many places of one flat array.
Lankarani-Nikravesh and Flores remember IMPACT_RATE (m/s, greatest rate since first touch) and
TOUCHING (1 while touching); they need
:func:`update_impact` once per step before :func:`contact_force`. In a free impact the greatest rate
since first touch IS the approach
velocity of the papers; in a lasting contact under outer forces it keeps the damping factor bounded,
where a fixed tiny approach
velocity would cut the force off. A Maxwell link remembers the force of its branch (N), see
:func:`maxwell_force`.
"""

from __future__ import annotations

import math
from typing import Any

from valvetrain.compiled import njit

#: Nothing is allocated here; counting references to the rows passed in costs the time loop of a
#: train some percent.
OPTIONS: dict[str, Any] = {
    "cache": True,
    "_nrt": False,
    "forceinline": True,
    "error_model": "numpy",
}

WIDTH = 8
STIFFNESS, EXPONENT, DAMPING, RESTITUTION, DEPTH, SLOWEST = range(6)
IMPACT_RATE, TOUCHING = range(2)

LINEAR, POWER, HUNT_CROSSLEY, LANKARANI_NIKRAVESH, FLORES, IMPACT, IMPACT_AS_PRINTED = range(7)

ELASTIC_LINK, MAXWELL_LINK = -1, -2
"""Codes below zero: links, which pull as well as they push."""

OWN_LAW = 100
"""Code of a law that brings its own compiled ``kernel`` (``contact.law.OwnLaw``)."""


@njit(**OPTIONS)
def _power(depth, exponent):
    if exponent == 1.5:
        return depth * math.sqrt(depth)
    if exponent == 1.0:
        return depth
    return depth**exponent


@njit(**OPTIONS)
def update_impact(memory, place, slowest, penetration, penetration_rate):
    """Store the two numbers from ``place`` on in ``memory``: first touch, then the greatest rate
    since (at least ``slowest``, m/s).
    """
    if penetration <= 0.0:
        memory[place + TOUCHING] = 0.0
        memory[place + IMPACT_RATE] = 0.0
        return
    if memory[place + TOUCHING] == 0.0:
        memory[place + TOUCHING] = 1.0
        memory[place + IMPACT_RATE] = slowest
    if abs(penetration_rate) > memory[place + IMPACT_RATE]:
        memory[place + IMPACT_RATE] = abs(penetration_rate)


@njit(**OPTIONS)
def maxwell_force(branch_stiffness, branch_damping, force, stretched, elapsed):
    """Force (N) of a spring and a damper in series after ``elapsed`` (s) in which the pair was
    stretched evenly by ``stretched`` (m).

    Exact for that stretching: f' = k x' - f k / c. ``force`` (N): before it.
    """
    if elapsed <= 0.0:
        return force
    share = elapsed * branch_stiffness / branch_damping
    return force * math.exp(-share) - branch_stiffness * stretched * math.expm1(-share) / share


@njit(**OPTIONS)
def contact_force(code, parameters, impact_rate, penetration, penetration_rate):
    """Normal force (N, compressive positive, never adhesive) of law ``code`` at a penetration (m)
    and its rate (m/s).

    ``impact_rate`` (m/s): what the restitution laws remember; ignored by all others.
    """
    if penetration <= 0.0:
        return 0.0
    elastic = elastic_force(code, parameters, penetration)
    return damped_force(code, parameters, impact_rate, penetration, penetration_rate, elastic)


@njit(**OPTIONS)
def elastic_force(code, parameters, penetration):
    """Force (N) of law ``code`` at a penetration (m, positive) that does not change."""
    if code == LINEAR:
        return parameters[STIFFNESS] * penetration
    return parameters[STIFFNESS] * _power(penetration, parameters[EXPONENT])


@njit(**OPTIONS)
def damped_force(code, parameters, impact_rate, penetration, penetration_rate, elastic):
    """:func:`contact_force` at a positive penetration whose :func:`elastic_force` is known."""
    if code == LINEAR:
        return max(0.0, elastic + parameters[DAMPING] * penetration_rate)
    if code == POWER:
        return elastic
    if code >= IMPACT:
        share = min(penetration / parameters[DEPTH], 1.0)
        damping = parameters[DAMPING] * share * share * (3.0 - 2.0 * share)
        if code == IMPACT:
            return max(0.0, elastic + damping * penetration_rate)
        return elastic + damping
    if code == HUNT_CROSSLEY:
        factor = parameters[DAMPING]
    else:
        rate = max(impact_rate, parameters[SLOWEST])
        restitution = parameters[RESTITUTION]
        if code == LANKARANI_NIKRAVESH:
            factor = 0.75 * (1.0 - restitution * restitution) / rate
        else:
            factor = 1.6 * (1.0 - restitution) / (restitution * rate)
    return max(0.0, elastic * (1.0 + factor * penetration_rate))
