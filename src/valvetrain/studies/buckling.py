"""Buckling on the static path of the finite-element rod: whether, where, and the sentence on it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from valvetrain.cosserat.stability import RATE_SHARE, buckling_between, free_rate, last_before, stability
from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.static import Equilibrium, compress
from valvetrain.solution.static import Buckling, Leaning
from valvetrain.solution.status import Status
from valvetrain.springs.finite_element import FiniteElementRod

#: Even parts into which an interval of low mean rate between two standing states is cut to look for the buckled one.
PARTS = 8


def find_buckling(rod: FiniteElementRod, path: Sequence[Equilibrium]) -> Buckling | None:
    """First place on a ``path`` of rising compression, from the free state, at which the rod buckles; None where it stands.

    The path says whether; the place is bisected, so that it moves with no step of the path.
    """
    if len(path) < 2:
        return None
    rate = free_rate(rod.statics)

    def stands(index: int) -> bool:
        return path[index].state.compression == 0.0 or stability(rod.statics, path[index].state).holds(rate)

    compressions = np.array([one.state.compression for one in path])
    low = np.flatnonzero(np.diff([one.retainer_force for one in path]) < RATE_SHARE * rate * np.diff(compressions))
    above = int(low[0]) + 1 if len(low) else len(path) - 1
    if stands(above):
        return _between(rod, path[above - 1], path[above], rate) if len(low) and stands(above - 1) else None
    below = 0
    while above - below > 1:
        middle = (above + below) // 2
        above, below = (above, middle) if stands(middle) else (middle, below)
    return _told(rod, path[below], float(compressions[above]))


def _between(rod: FiniteElementRod, lower: Equilibrium, upper: Equilibrium, rate: float) -> Buckling | None:
    """A buckled stretch between two states that stand, as where the coils of a bowed spring meet again."""
    for target in np.linspace(lower.state.compression, upper.state.compression, PARTS + 1)[1:-1]:
        found = compress(rod.statics, [float(target)], lower.state)[-1]
        if not found.converged:
            return None
        if not stability(rod.statics, found.state).holds(rate):
            return _told(rod, lower, float(target))
        lower = found
    return None


def _told(rod: FiniteElementRod, standing: Equilibrium, buckled_compression: float) -> Buckling:
    state = buckling_between(rod.statics, standing.state, buckled_compression)
    force = rod.statics.solve(state, state.compression).retainer_force
    compression = float(state.compression)
    return Buckling(compression, rod.definition.free_length - compression, force)


def find_leaning(rod: FiniteElementRod, path: Sequence[Equilibrium]) -> Leaning | None:
    """Where the wire first touches its guide on a ``path`` of rising compression, and how hard it leans on it in the end."""
    walls = rod.mesh.guide
    if walls is None:
        return None

    def clear(state: RodState) -> bool:
        return walls.least_gap(state.position) > 0.0

    met = next((place for place, one in enumerate(path) if not clear(one.state)), None)
    if met is None:
        return None
    touch = last_before(rod.statics, path[max(met - 1, 0)].state, path[met].state.compression, clear)
    return Leaning(float(touch.compression), float(walls.pressed(path[-1].state.position, rod.mesh.node_length)))


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
