"""Compiled contact laws: one function evaluates any law from its code and parameter row.

Row of ``WIDTH`` float64 per contact (SI)::

    0 STIFFNESS   N/m**exponent        4 DEPTH         m, penetration of full damping (IMPACT)
    1 EXPONENT    -                    5 SLOWEST       m/s, floor of the impact rate (restitution laws)
    2 DAMPING     law's own unit       6 IMPACT_RATE   m/s, MEMORY: greatest rate since first touch
    3 RESTITUTION -                    7 TOUCHING      MEMORY: 1 while touching, else 0

Slots 6 and 7 are the only memory of a contact; laws that need them (Lankarani-Nikravesh, Flores) want
:func:`update_impact` called once per step before :func:`contact_force`. A train copies the rows into its state.
In a free impact the greatest rate since first touch IS the approach velocity of the papers; in a lasting contact under
outer forces it keeps the damping factor bounded, where a fixed tiny approach velocity would cut the force off.
"""

from __future__ import annotations

import math

from numba import njit

WIDTH = 8
STIFFNESS, EXPONENT, DAMPING, RESTITUTION, DEPTH, SLOWEST, IMPACT_RATE, TOUCHING = range(WIDTH)

LINEAR, POWER, HUNT_CROSSLEY, LANKARANI_NIKRAVESH, FLORES, IMPACT, IMPACT_AS_PRINTED = range(7)


@njit(cache=True, inline="always")
def _power(depth, exponent):
    if exponent == 1.5:
        return depth * math.sqrt(depth)
    if exponent == 1.0:
        return depth
    return depth**exponent


@njit(cache=True)
def update_impact(parameters, penetration, penetration_rate):
    """Keep the memory slots of one contact row: first touch, then the greatest rate since."""
    if penetration <= 0.0:
        parameters[TOUCHING] = 0.0
        parameters[IMPACT_RATE] = 0.0
        return
    if parameters[TOUCHING] == 0.0:
        parameters[TOUCHING] = 1.0
        parameters[IMPACT_RATE] = parameters[SLOWEST]
    if abs(penetration_rate) > parameters[IMPACT_RATE]:
        parameters[IMPACT_RATE] = abs(penetration_rate)


@njit(cache=True)
def contact_force(code, parameters, penetration, penetration_rate):
    """Normal force (N, compressive positive, never adhesive) of law ``code`` at a penetration (m) and its rate (m/s)."""
    if penetration <= 0.0:
        return 0.0
    stiffness = parameters[STIFFNESS]
    if code == LINEAR:
        return max(0.0, stiffness * penetration + parameters[DAMPING] * penetration_rate)
    elastic = stiffness * _power(penetration, parameters[EXPONENT])
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
        rate = max(parameters[IMPACT_RATE], parameters[SLOWEST])
        restitution = parameters[RESTITUTION]
        if code == LANKARANI_NIKRAVESH:
            factor = 0.75 * (1.0 - restitution * restitution) / rate
        else:
            factor = 1.6 * (1.0 - restitution) / (restitution * rate)
    return max(0.0, elastic * (1.0 + factor * penetration_rate))


@njit(cache=True)
def coulomb_friction(coefficient, slip_rate, normal_force, sliding_velocity):
    """Friction force (N) against ``sliding_velocity`` (m/s): mu N tanh(v / slip_rate), within 0.1 % of mu N at v = 4 slip_rate."""
    return -coefficient * normal_force * math.tanh(sliding_velocity / slip_rate)
