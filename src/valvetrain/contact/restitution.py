"""Rebound theory of the laws F = K d**n (1 + q d'): one equation for all of them.

From m v dv/dd = -K d**n (1 + q v): the integral of v / (1 + q v) dv vanishes between approach v and
rebound -e v, so
q v (1 + e) = ln((1 + q v) / (1 - e q v)), free of mass, stiffness and exponent (Hunt and Crossley
1975 give its small-q limit).
"""

from __future__ import annotations

import math

from valvetrain.errors import InputError


def rebound(damping_number: float) -> float:
    """Restitution e for the damping number q v (dimensionless, >= 0) by bisection to 1e-14.

    Raises :class:`InputError` for a negative number.
    """
    if not damping_number >= 0:
        raise InputError(f"damping number is {damping_number}; give zero or a positive number")
    if damping_number == 0:
        return 1.0
    low, high = 0.0, min(1.0, 1.0 / damping_number)
    while high - low > 1e-14:
        middle = (low + high) / 2
        # log1p keeps the tiny difference of the small-damping limit.
        excess = (
            math.log1p(damping_number)
            - math.log1p(-middle * damping_number)
            - damping_number * (1 + middle)
        )
        low, high = (middle, high) if excess < 0 else (low, middle)
    return (low + high) / 2


def damping_number(restitution: float) -> float:
    """Damping number q v that gives ``restitution`` (0 < e <= 1): the inverse of :func:`rebound`."""
    if not 0 < restitution <= 1:
        raise InputError(f"restitution is {restitution}; it must be above 0 and at most 1")
    low, high = 0.0, 1.0 / restitution
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if rebound(middle) > restitution else (low, middle)
    return (low + high) / 2
