"""Compiled steps of the massless springs (no unknowns, so nothing is advanced)."""

from __future__ import annotations

from valvetrain.compiled import njit


@njit(cache=True)
def advance_linear(
    parameters, integers, state, retainer_displacement, retainer_velocity, time_step
):
    """``parameters`` = preload (N), rate (N/m), displacement (m) below which the spring is loose."""
    force = parameters[0] + parameters[1] * max(retainer_displacement, parameters[2])
    return force, force


@njit(cache=True)
def advance_table(parameters, integers, state, retainer_displacement, retainer_velocity, time_step):
    """``parameters`` = displacements (m) then forces (N); ``integers`` = number of points, whether
    it pulls. By bisection.
    """
    points = integers[0]
    low, high = 0, points - 1
    while high - low > 1:
        middle = (low + high) // 2
        if parameters[middle] <= retainer_displacement:
            low = middle
        else:
            high = middle
    slope = (parameters[points + low + 1] - parameters[points + low]) / (
        parameters[low + 1] - parameters[low]
    )
    force = parameters[points + low] + slope * (retainer_displacement - parameters[low])
    if integers[1] == 0:
        force = max(force, 0.0)
    return force, force
