"""The state of a spring carried over to the same spring at another time step, whose grid may be
another.
"""

from __future__ import annotations

import numpy as np

from valvetrain.springs.contract import Array, SpringModel
from valvetrain.springs.nested import NestedSprings


def carried_state(
    state: Array,
    spring: SpringModel,
    other: SpringModel,
    retainer_displacement: float,
    retainer_velocity: float,
) -> Array:
    """The ``state`` of ``spring`` as a state of ``other``, the same spring by ``with_time_step``
    for another step.

    Where both have the same unknowns it is copied, bookkeeping included. Else (a rod whose cells
    follow the step) the departure from rest
    at ``retainer_displacement`` (m) and the velocities, zero at the seat and ``retainer_velocity``
    (m/s) above, are interpolated
    along evenly spaced unknowns; bookkeeping starts anew.
    """
    if isinstance(spring, NestedSprings) and isinstance(other, NestedSprings):
        pairs = zip(spring.split(state), spring.members, other.members, strict=True)
        return other.joined(
            [
                carried_state(part, one, new, retainer_displacement, retainer_velocity)
                for part, one, new in pairs
            ]
        )
    if spring.unknowns == other.unknowns:
        return state.copy()
    n, m = spring.unknowns, other.unknowns
    found = np.asarray(other.initial_state(retainer_displacement), dtype=float).copy()
    departure = state[:n] - np.asarray(spring.initial_state(retainer_displacement))[:n]
    found[:m] += _on_grid(np.concatenate(([0.0], departure, [0.0])), m)
    found[m : 2 * m] = _on_grid(np.concatenate(([0.0], state[n : 2 * n], [retainer_velocity])), m)
    return found


def _on_grid(values: Array, count: int) -> Array:
    """``values`` on an even grid, ends included, at the ``count`` inner places of another."""
    return np.interp(
        np.arange(1, count + 1) / (count + 1), np.linspace(0.0, 1.0, len(values)), values
    )
