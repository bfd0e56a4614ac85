"""Buckling on the static path of the finite-element rod: whether, where, and the sentence on it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from valvetrain.cosserat.stability import RATE_SHARE, last_before, stability
from valvetrain.cosserat.state import RodState
from valvetrain.solution.static import Buckling, Leaning
from valvetrain.solution.status import Status
from valvetrain.springs.finite_element import FiniteElementRod

Array = NDArray[np.float64]


def find_buckling(rod: FiniteElementRod, path: Sequence[RodState], rates: Array) -> Buckling | None:
    """First place on a ``path`` of equilibria from the free state, of these ``rates`` (N/m), at which it buckles; None where it stands.

    The path says whether; the place is bisected, so that it moves with no step of the path.
    """
    if len(path) < 2:
        return None
    statics, rate = rod.statics, float(rates[0])
    low = np.flatnonzero(rates <= RATE_SHARE * rate)
    above, below = int(low[0]) if len(low) else len(path) - 1, 0
    if stability(statics, path[above]).holds(rate):
        return None
    while above - below > 1:
        middle = (above + below) // 2
        above, below = (above, middle) if stability(statics, path[middle]).holds(rate) else (middle, below)
    state = last_before(statics, path[below], path[above].compression, lambda one: stability(statics, one).holds(rate))
    compression, force = float(state.compression), statics.solve(state, state.compression).retainer_force
    return Buckling(compression, rod.definition.free_length - compression, force)


def find_leaning(rod: FiniteElementRod, path: Sequence[RodState]) -> Leaning | None:
    """Where the wire first touches its guide on a ``path`` of rising compression, and how hard it leans on it in the end."""
    walls = rod.mesh.guide
    if walls is None:
        return None

    def clear(state: RodState) -> bool:
        return walls.least_gap(state.position) > 0.0

    met = next((place for place, one in enumerate(path) if not clear(one)), None)
    if met is None:
        return None
    touch = last_before(rod.statics, path[max(met - 1, 0)], path[met].compression, clear)
    return Leaning(float(touch.compression), float(walls.pressed(path[-1].position, rod.mesh.node_length)))


def path_status(rod: FiniteElementRod, buckling: Buckling | None, leaning: Leaning | None) -> Status | None:
    """What a static curve ends with that passes a ``buckling`` or ends ``leaning`` on a guide; None for any other.

    A spring in a guide that bows until it leans on it has not failed.
    """
    if buckling is None and leaning is None:
        return None
    name = f"spring '{rod.definition.name}'"
    if leaning is not None:
        bows = "" if buckling is None else f" buckles at {buckling.compression * 1e3:.4g} mm compression and"
        touch = f" leans on its guide from {leaning.compression * 1e3:.4g} mm, in the end with {leaning.force:.4g} N in all"
        return Status("completed", name + bows + touch)
    assert buckling is not None
    place = f"{buckling.height * 1e3:.4g} mm high, {buckling.force:.4g} N"
    words = f"{name} buckles at {buckling.compression * 1e3:.4g} mm compression ({place}); what lies beyond is a spring bent sideways"
    if rod.guide is not None:
        return Status("completed", f"{name} buckles at {buckling.compression * 1e3:.4g} mm compression and does not yet touch its guide")
    return Status("buckled", words, 0.0, place, "compress it less, guide it in a bore or on a rod, or make it shorter or wider")
