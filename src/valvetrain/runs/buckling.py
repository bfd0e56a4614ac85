"""Buckling of a compressed spring, and its leaning on a guide, found on a path of equilibria of the
rod.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import brentq

from valvetrain.cosserat.rates import axial_rate
from valvetrain.cosserat.stability import PLACE_TOLERANCE, last_before, negative_modes
from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.static import Equilibrium, compress
from valvetrain.solution.static import Buckling, Leaning
from valvetrain.solution.status import Status
from valvetrain.springs.finite_element import FiniteElementRod

#: A spring has buckled where its rate has fallen to this share of its rate as wound. Beyond an
#: opened pitchfork a tenth is left, and two thirds of that fall are done at the critical point of
#: the perfect column.
RATE_SHARE = 0.5
#: The rate is the mean over this share of the free length: single contact points of the end coils
#: make the tangent jump.
WINDOW_SHARE = 0.01


def find_buckling(rod: FiniteElementRod, path: Sequence[Equilibrium]) -> Buckling | None:
    """Where the rod first buckles on a ``path`` of rising compression from the free state; None
    where it does not.
    """
    if len(path) < 2:
        return None
    states = [one.state for one in path]
    losses = (_lost_rate(rod, path), _lost_sign(rod, states))
    found = [compression for compression in losses if compression is not None]
    if not found:
        return None
    compression = float(min(found))
    return Buckling(
        compression, rod.definition.free_length - compression, _force(rod, states, compression)
    )


def _lost_sign(rod: FiniteElementRod, states: Sequence[RodState]) -> float | None:
    """Compression (m) at which the tangent stops being positive definite; None where it is so at
    the end of the path.
    """

    def stable(state: RodState) -> bool:
        return negative_modes(rod.statics, state) == 0

    if stable(states[-1]):
        return None
    above, below = len(states) - 1, 0
    while above - below > 1:
        middle = (above + below) // 2
        above, below = (above, middle) if stable(states[middle]) else (middle, below)
    return last_before(rod.statics, states[below], states[above].compression, stable).compression


def _lost_rate(rod: FiniteElementRod, path: Sequence[Equilibrium]) -> float | None:
    """Compression (m) at which the mean rate falls through a share of that as wound; None where it
    does not.
    """
    half, states = 0.5 * WINDOW_SHARE * rod.definition.free_length, [one.state for one in path]
    compression, force = (
        np.array([one.compression for one in states]),
        np.array([one.retainer_force for one in path]),
    )
    enough = RATE_SHARE * axial_rate(rod.statics, states[0]) * 2 * half
    middle = compression[(compression >= half) & (compression <= compression[-1] - half)]
    low = np.flatnonzero(
        np.interp(middle + half, compression, force) - np.interp(middle - half, compression, force)
        <= enough
    )
    if not len(low):
        return None

    def excess(centre: float) -> float:
        return _force(rod, states, centre + half) - _force(rod, states, centre - half) - enough

    # The path's straight lines may be off by an interval where the force bends.
    after, before = int(low[0]), max(int(low[0]) - 1, 0)
    while before > 0 and excess(middle[before]) <= 0.0:
        after, before = before, before - 1
    while excess(middle[after]) > 0.0:
        before, after = after, after + 1
        if after == len(middle):
            return None
    # A very slender spring has lost its rate at the first mean over the window.
    if excess(middle[before]) <= 0.0:
        return float(middle[before])
    return float(brentq(excess, middle[before], middle[after], xtol=PLACE_TOLERANCE))


def _force(rod: FiniteElementRod, states: Sequence[RodState], compression: float) -> float:
    """Force (N) at a compression (m) from the next state of the path below."""
    below = states[0]
    for state in states[1:]:
        below = state if state.compression <= compression else below
    if below.compression == compression:
        return rod.statics.solve(below, compression).retainer_force
    return compress(rod.statics, [compression], below)[-1].retainer_force


def find_leaning(rod: FiniteElementRod, path: Sequence[Equilibrium]) -> Leaning | None:
    """Where the wire first touches its guide on a ``path`` of rising compression, and its force on
    it at the end.
    """
    walls = rod.mesh.guide
    if walls is None:
        return None

    def clear(state: RodState) -> bool:
        return walls.least_gap(state.position) > 0.0

    first = next((index for index, one in enumerate(path) if not clear(one.state)), None)
    if first is None:
        return None
    before = path[max(first - 1, 0)].state
    touch = last_before(rod.statics, before, path[first].state.compression, clear)
    force = walls.pressed(path[-1].state.position, rod.mesh.node_length)
    return Leaning(float(touch.compression), float(force))


def path_status(
    rod: FiniteElementRod, buckling: Buckling | None, leaning: Leaning | None
) -> Status | None:
    """Status of a static curve that passes a ``buckling`` or ends ``leaning`` on a guide; None for
    any other.

    A spring in a guide that bows until it leans on it has not failed.
    """
    if buckling is None and leaning is None:
        return None
    name = f"spring '{rod.definition.name}'"
    buckles = (
        "" if buckling is None else f" buckles at {buckling.compression * 1e3:.4g} mm compression"
    )
    if leaning is not None:
        bows = f"{buckles} and" if buckles else ""
        touch = f" leans on its guide from {leaning.compression * 1e3:.4g} mm, in the end with {leaning.force:.4g} N in all"
        return Status("completed", name + bows + touch)
    assert buckling is not None
    if rod.guide is not None:
        return Status("completed", f"{name}{buckles} and does not yet touch its guide")
    state = f"{buckling.height * 1e3:.4g} mm high, {buckling.force:.4g} N"
    message = f"{name}{buckles} ({state}); beyond this compression the spring is bent sideways"
    remedy = "compress it less, guide it in a bore or on a rod, or make it shorter or wider"
    return Status("buckled", message, 0.0, state, remedy)
