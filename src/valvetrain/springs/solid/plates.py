"""Rigid seat planes: one bonded block at either end that the end coils beyond their inactive turns
can touch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.parameters.spring import SpringDefinition

Array = NDArray[np.float64]

#: Free turns next to a fixed end that can reach the seat plane.
SEAT_REACH = 0.9


@dataclass(frozen=True)
class SeatPlate:
    """A rigid block: ``name`` of its surface, node set it moves with, corners (8, 3) in m, the side
    that faces the wire.

    ``first`` and ``last``: coil numbers of the free wire that can touch it.
    """

    name: str
    node_set: str
    corners: Array
    side: str
    first: float
    last: float


def seat_plates(spring: SpringDefinition, ground: bool) -> tuple[SeatPlate, SeatPlate]:
    """Blocks under and over ``spring`` whose inner faces are the seat planes, widened to hold the
    spring.

    ``ground``: the mesh has flat ground faces. A round wire would start inside the plane over the
    ground turns, so it
    meets the plane only beyond them.
    """
    first, last = spring.free_coils
    if not ground:
        first = max(first, spring.lower_end.ground_coils)
        last = min(last, spring.total_coils - spring.upper_end.ground_coils)
    half = 0.75 * float(np.max(spring.outer_diameter(np.linspace(0, spring.total_coils, 257))))
    thick = float(spring.wire_diameter.value(0.0))
    low, high = spring.lower_seat_height, spring.upper_seat_height
    return (
        SeatPlate(
            "SEATPLANE",
            "SEAT",
            _block(half, low - thick, low),
            "S2",
            first,
            min(first + SEAT_REACH, last),
        ),
        SeatPlate(
            "RETAINERPLANE",
            "RETAINER",
            _block(half, high, high + thick),
            "S1",
            max(last - SEAT_REACH, first),
            last,
        ),
    )


def _block(half: float, bottom: float, top: float) -> Array:
    square = [(-half, -half), (half, -half), (half, half), (-half, half)]
    return np.array([(x, y, z) for z in (bottom, top) for x, y in square])
