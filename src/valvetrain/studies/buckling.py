"""Buckling on the static path of the finite-element rod: whether, where, and the sentence on it.

A wound wire is never quite straight, so its path bends away before the critical point and no
eigenvalue need pass zero: of a pitchfork
that an imperfection opens only the fall of the rate is left. Both are looked for, and the place is
found beside the path's own points.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from valvetrain.cosserat.rates import axial_rate
from valvetrain.cosserat.stability import PLACE_TOLERANCE, last_before, negative_modes
from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.static import Equilibrium, compress
from valvetrain.solution.static import Buckling, Leaning
from valvetrain.solution.status import Status
from valvetrain.springs.finite_element import FiniteElementRod

Array = NDArray[np.float64]

#: A spring has buckled where its rate is this share of its rate as wound. Beyond an opened
#: pitchfork a tenth of the rate is left, and two
#: thirds of that fall are done at the critical point of the perfect column (decision 0049).
RATE_SHARE = 0.5
#: The rate is the mean over this share of the free length: single points of contact of the end
#: coils that open make the tangent jump.
WINDOW_SHARE = 0.01


def find_buckling(rod: FiniteElementRod, path: Sequence[Equilibrium]) -> Buckling | None:
    """First place on a ``path`` of rising compression, from the free state on, at which the rod
    buckles; None where it stands.
    """
    if len(path) < 2:
        return None
    states = [one.state for one in path]
    places = [
        place for place in (_lost_rate(rod, path), _lost_sign(rod, states)) if place is not None
    ]
    if not places:
        return None
    compression = float(min(places))
    return Buckling(
        compression, rod.definition.free_length - compression, _force(rod, states, compression)
    )


def _lost_sign(rod: FiniteElementRod, states: Sequence[RodState]) -> float | None:
    """Compression (m) from which the tangent at the end of the path has lost a sign, None where it
    has not.
    """

    def stands(state: RodState) -> bool:
        return negative_modes(rod.statics, state) == 0

    if stands(states[-1]):
        return None
    above, below = len(states) - 1, 0
    while above - below > 1:
        middle = (above + below) // 2
        above, below = (above, middle) if stands(states[middle]) else (middle, below)
    return last_before(rod.statics, states[below], states[above].compression, stands).compression


def _lost_rate(rod: FiniteElementRod, path: Sequence[Equilibrium]) -> float | None:
    """Compression (m) at which the mean rate falls through a share of that as wound, None where it
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

    def excess(place: float) -> float:
        return _force(rod, states, place + half) - _force(rod, states, place - half) - enough

    # The path's straight lines may be off by an interval where the force bends.
    place, before = int(low[0]), max(int(low[0]) - 1, 0)
    while before > 0 and excess(middle[before]) <= 0.0:
        place, before = before, before - 1
    while excess(middle[place]) > 0.0:
        before, place = place, place + 1
        if place == len(middle):
            return None
    if (
        excess(middle[before]) <= 0.0
    ):  # a very slender spring has lost its rate where the first mean over the window stands
        return float(middle[before])
    return float(brentq(excess, middle[before], middle[place], xtol=PLACE_TOLERANCE))


def _force(rod: FiniteElementRod, states: Sequence[RodState], compression: float) -> float:
    """Force (N) at a compression (m) from the next state of the path below."""
    below = max(
        place
        for place, state in enumerate(states)
        if state.compression <= compression or place == 0
    )
    if states[below].compression == compression:
        return rod.statics.solve(states[below], compression).retainer_force
    return compress(rod.statics, [compression], states[below])[-1].retainer_force


def find_leaning(rod: FiniteElementRod, path: Sequence[Equilibrium]) -> Leaning | None:
    """Where the wire first touches its guide on a ``path`` of rising compression, and how hard it
    leans on it in the end.
    """
    walls = rod.mesh.guide
    if walls is None:
        return None

    def clear(state: RodState) -> bool:
        return walls.least_gap(state.position) > 0.0

    met = next((place for place, one in enumerate(path) if not clear(one.state)), None)
    if met is None:
        return None
    touch = last_before(
        rod.statics, path[max(met - 1, 0)].state, path[met].state.compression, clear
    )
    return Leaning(
        float(touch.compression),
        float(walls.pressed(path[-1].state.position, rod.mesh.node_length)),
    )


def path_status(
    rod: FiniteElementRod, buckling: Buckling | None, leaning: Leaning | None
) -> Status | None:
    """What a static curve ends with that passes a ``buckling`` or ends ``leaning`` on a guide; None
    for any other.

    A spring in a guide that bows until it leans on it has not failed.
    """
    if buckling is None and leaning is None:
        return None
    name = f"spring '{rod.definition.name}'"
    if leaning is not None:
        bows = (
            ""
            if buckling is None
            else f" buckles at {buckling.compression * 1e3:.4g} mm compression and"
        )
        touch = f" leans on its guide from {leaning.compression * 1e3:.4g} mm, in the end with {leaning.force:.4g} N in all"
        return Status("completed", name + bows + touch)
    assert buckling is not None
    place = f"{buckling.height * 1e3:.4g} mm high, {buckling.force:.4g} N"
    words = f"{name} buckles at {buckling.compression * 1e3:.4g} mm compression ({place}); what lies beyond is a spring bent sideways"
    if rod.guide is not None:
        return Status(
            "completed",
            f"{name} buckles at {buckling.compression * 1e3:.4g} mm compression and does not yet touch its guide",
        )
    return Status(
        "buckled",
        words,
        0.0,
        place,
        "compress it less, guide it in a bore or on a rod, or make it shorter or wider",
    )
