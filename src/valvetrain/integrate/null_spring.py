"""The spring of an empty slot: no force, no state."""

from __future__ import annotations

from valvetrain.compiled import njit


@njit(cache=True)
def no_spring(parameters, integers, state, retainer_displacement, retainer_velocity, time_step):
    """Zero force at both ends (N)."""
    return 0.0, 0.0
