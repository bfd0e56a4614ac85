"""The wire followed from section to section: turns, radii and heights along it, and its hand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.measurements.spring_scan.sections import Sections

Array = NDArray[np.float64]
#: Distance, in wire diameters, up to which sections of neighbouring half planes belong together, and by how much it grows a missing one.
NEAR, GROWTH, FARTHEST = 0.3, 0.02, 0.45
#: Turns without a section after which the wire is taken to end, and turns behind that tell where it goes on.
GAP, BEHIND = 0.45, 0.25
#: Fewest turns of a wire that is a spring.
FEWEST_TURNS = 2.0


@dataclass(frozen=True, eq=False)
class Trace:
    """Sections along the wire: ``turn`` (k,) unwound and rising with the height, ``radius`` and ``height``; ``hand`` 1 right, -1 left."""

    turn: Array
    radius: Array
    height: Array
    hand: int
    wire_radius: float


def follow(sections: Sections, wedges: int) -> Trace:
    """The wire through ``sections`` that stand in ``wedges`` half planes.

    Raises :class:`InputError` where they are no wire of :data:`FEWEST_TURNS` turns.
    """
    plane = np.column_stack([sections.radius, sections.height])
    wedge = np.round(sections.turn * wedges - 0.5).astype(int)
    members = [np.flatnonzero(wedge == one) for one in range(wedges)]
    after = _links(plane, members, 2 * NEAR * sections.wire_radius)
    chain = max(_chains(after), key=len)
    if len(chain) < 8:
        raise InputError("the sections of the wire do not join to a helix; give the scan of one spring, cleaned of its holder")
    steps = np.arange(len(chain))
    slope = float(np.polyfit(steps, plane[chain, 1], 1)[0])
    hand = 1 if slope > 0 else -1
    if hand < 0:
        chain = chain[::-1]
    known = {hand * int(wedge[chain[0]]) + step: chain[step] for step in range(len(chain))}
    used = set(chain)
    for direction in (1, -1):
        _extend(known, used, plane, members, hand, direction, sections.wire_radius)
    places = np.array(sorted(known))
    index = np.array([known[place] for place in places])
    turn = (places + 0.5 * hand) / wedges
    if turn[-1] - turn[0] < FEWEST_TURNS:
        raise InputError(
            f"the wire could be followed over {turn[-1] - turn[0]:.2g} turns only; give more points, less noise or a cloud cleaned of all "
            "but one spring"
        )
    return Trace(turn, plane[index, 0], plane[index, 1], hand, sections.wire_radius)


def _links(plane: Array, members: list[NDArray[np.intp]], reach: float) -> dict[int, int]:
    """Section -> the one in the next half plane, where each is the nearest of the other."""
    found: dict[int, int] = {}
    for here, there in zip(members, members[1:] + members[:1], strict=True):
        if not len(here) or not len(there):
            continue
        apart = np.linalg.norm(plane[here][:, None] - plane[there][None], axis=2)
        forward, back = np.argmin(apart, axis=1), np.argmin(apart, axis=0)
        for k, to in enumerate(forward):
            if back[to] == k and apart[k, to] < reach:
                found[int(here[k])] = int(there[to])
    return found


def _chains(after: dict[int, int]) -> list[list[int]]:
    """Runs of linked sections, each in the order of its links."""
    chains = []
    for first in sorted(set(after) - set(after.values())) or sorted(after)[:1]:
        chain = [first]
        while chain[-1] in after and after[chain[-1]] != first:
            chain.append(after[chain[-1]])
        chains.append(chain)
    return chains or [[]]


def _extend(
    known: dict[int, int], used: set[int], plane: Array, members: list[NDArray[np.intp]], hand: int, direction: int, wire: float
) -> None:
    """Go on from the end of what is known, half plane by half plane, where the wire before it points to."""
    wedges = len(members)
    place = max(known) if direction > 0 else min(known)
    missing = 0
    while missing <= GAP * wedges:
        place += direction
        last = max(known) if direction > 0 else min(known)
        behind = [one for one in range(last, last - direction * int(BEHIND * wedges), -direction) if one in known]
        ahead = np.polyval(_line(behind, plane[[known[one] for one in behind], 0]), place - last), _rise(behind, known, plane, place - last)
        reach = 2 * wire * min(NEAR + GROWTH * missing, FARTHEST)
        nearest, best = -1, reach
        for one in members[(hand * place) % wedges]:
            apart = float(np.hypot(*(plane[one] - ahead)))
            if one not in used and apart < best:
                nearest, best = int(one), apart
        if nearest < 0:
            missing += 1
            continue
        known[place] = nearest
        used.add(nearest)
        missing = 0


def _line(behind: list[int], values: Array) -> Array:
    return np.polyfit(np.array(behind) - behind[0], values, 1) if len(behind) > 3 else np.array([values[0]])


def _rise(behind: list[int], known: dict[int, int], plane: Array, away: int) -> float:
    """Height ahead: the wire never runs back."""
    values = plane[[known[one] for one in behind], 1]
    line = _line(behind, values)
    slope = max(float(line[0]), 0.0) if len(line) > 1 else 0.0
    return float(line[-1] + slope * away)
