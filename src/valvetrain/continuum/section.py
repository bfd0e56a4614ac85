"""O-grid of quadrilaterals over the unit disc: a bulged square core inside rings, eight nodes per
quadrilateral.

Section coordinates: x points away from the spring axis, y up along the spring; the wire surface is
the unit circle.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array, Flags, Ints
from valvetrain.errors import InputError
from valvetrain.parameters.spring import SpringDefinition

#: Radius of the core's corners as a share of the wire radius, and how far its sides bulge (0
#: square, 1 circle).
CORE_RADIUS = 0.62
CORE_BULGE = 0.55


@dataclass(frozen=True)
class SectionMesh:
    """Quadrilaterals over the unit disc.

    ``nodes`` (n, 2) just outside the circle where its arcs would lose area; ``quads`` (q, 8)
    counter-clockwise corners then edge middles; ``corner`` (n,) True at corners;
    ``rim_quads`` the quads whose edge from corner 2 to corner 3 is on the circle.
    """

    nodes: Array
    quads: Ints
    corner: Flags
    rim_quads: Ints

    @property
    def rim_angles(self) -> Array:
        """Angle (rad, 0 outside, pi/2 on top) of the rim edge's middle of every rim quad."""
        x, y = self.nodes[self.quads[self.rim_quads, 5]].T
        found: Array = np.arctan2(y, x)
        return found

    def nearest(self, x: float, y: float) -> int:
        """Number of the node nearest to (x, y)."""
        return int(np.argmin(np.hypot(self.nodes[:, 0] - x, self.nodes[:, 1] - y)))


def disc_section(core: int = 2, rings: int = 1, quadratic: bool = True) -> SectionMesh:
    """O-grid with ``core`` x ``core`` quads inside ``rings`` rings of 4 ``core`` quads, of the area
    of the unit disc.

    ``quadratic``: whether the sides of the quads are curved. Raises :class:`InputError` below one core cell or ring.
    """
    if core < 1 or rings < 1:
        raise InputError(
            f"a wire section of {core} core cells and {rings} rings is no mesh; give at least 1 of each"
        )
    book = _NodeBook()
    quads = [_numbered(book, _core_map, i, j, core, core) for i in range(core) for j in range(core)]
    around = 4 * core

    def ring_map(radial: float, turn: float) -> tuple[float, float]:
        inner, outer = _core_rim(4 * turn), np.array([np.cos(_angle(turn)), np.sin(_angle(turn))])
        point = (1 - radial) * np.asarray(inner) + radial * outer
        return float(point[0]), float(point[1])

    first_ring = len(quads)
    quads += [
        _numbered(book, ring_map, i, j, rings, around) for i in range(rings) for j in range(around)
    ]
    connectivity = np.array(quads, dtype=np.int64)
    nodes = np.array(book.points)
    # Arcs through three points enclose less than the circle; equal area keeps mass and stiffness of
    # a coarse section.
    nodes *= np.sqrt(np.pi / _area(nodes, connectivity, quadratic))
    corner = np.zeros(len(nodes), dtype=bool)
    corner[connectivity[:, :4]] = True
    rim = first_ring + (rings - 1) * around + np.arange(around)
    return SectionMesh(nodes, connectivity, corner, rim)


class _NodeBook:
    """Numbers points, giving coincident ones the same number."""

    def __init__(self) -> None:
        self.points: list[tuple[float, float]] = []
        self._numbers: dict[tuple[int, int], int] = {}

    def number(self, point: tuple[float, float]) -> int:
        key = (round(point[0] * 1e9), round(point[1] * 1e9))
        for shifted in ((key[0] + i, key[1] + j) for i in (0, -1, 1) for j in (0, -1, 1)):
            if shifted in self._numbers:
                return self._numbers[shifted]
        self._numbers[key] = len(self.points)
        self.points.append(point)
        return self._numbers[key]


#: Corners then middles of a quad in its own unit square.
_QUAD_STATIONS = ((0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0), (1, 0.5), (0.5, 1), (0, 0.5))


def _numbered(
    book: _NodeBook,
    patch: Callable[[float, float], tuple[float, float]],
    i: int,
    j: int,
    across: int,
    along: int,
) -> list[int]:
    return [book.number(patch((i + a) / across, (j + b) / along)) for a, b in _QUAD_STATIONS]


def _core_map(across: float, along: float) -> tuple[float, float]:
    s, t = 2 * across - 1, 2 * along - 1
    straight = np.array([s, t]) / np.sqrt(2)
    round_one = np.array([s * np.sqrt(1 - t * t / 2), t * np.sqrt(1 - s * s / 2)])
    point = CORE_RADIUS * ((1 - CORE_BULGE) * straight + CORE_BULGE * round_one)
    return float(point[0]), float(point[1])


def _core_rim(side_position: float) -> tuple[float, float]:
    """Point of the core's rim; ``side_position`` runs 0..4 counter-clockwise from the lower right
    corner.
    """
    side, step = int(side_position) % 4, side_position % 1.0
    return _core_map(*((1.0, step), (1 - step, 1.0), (0.0, 1 - step), (step, 0.0))[side])


def _area(nodes: Array, quads: Ints, quadratic: bool) -> float:
    """Area inside all sides by Green's theorem; Simpson's rule is exact for a side through three
    points.
    """
    total = 0.0
    for edge in range(4):
        first, last = nodes[quads[:, edge]], nodes[quads[:, (edge + 1) % 4]]
        middle = nodes[quads[:, 4 + edge]] if quadratic else (first + last) / 2
        start, end, chord = (
            4 * middle - 3 * first - last,
            first + 3 * last - 4 * middle,
            last - first,
        )
        for point, slope, weight in (
            (first, start, 1 / 6),
            (middle, chord, 4 / 6),
            (last, end, 1 / 6),
        ):
            total += (
                weight * float(np.sum(point[:, 0] * slope[:, 1] - point[:, 1] * slope[:, 0])) / 2
            )
    return total


def _angle(turn: float) -> float:
    return 2 * np.pi * turn - np.pi / 4


#: Least thickness of the wire left by grinding, as a share of its diameter.
MIN_THICKNESS = 0.1


def ground_section(
    spring: SpringDefinition, coil: float, upright: float, section: SectionMesh
) -> Array:
    """Nodes (n, 2) of ``section`` at ``coil`` with everything beyond the seat planes moved inside.

    ``upright`` is the z component of the section's upward axis (cosine of the helix angle).
    """
    radius, height = float(spring.wire_diameter.value(coil)) / 2, float(spring.axial_position(coil))
    low = (spring.lower_seat_height - height) / (radius * upright)
    high = (spring.upper_seat_height - height) / (radius * upright)
    if coil <= spring.lower_end.ground_coils and low > -1:
        return _cut_below(section, section.nodes, _checked(low, coil, spring))
    if coil >= spring.total_coils - spring.upper_end.ground_coils and high < 1:
        return _cut_below(section, section.nodes * (1, -1), _checked(-high, coil, spring)) * (1, -1)
    return section.nodes


def _checked(level: float, coil: float, spring: SpringDefinition) -> float:
    if level > 1 - 2 * MIN_THICKNESS:
        raise InputError(
            f"at coil {coil:.2f} of spring '{spring.name}' grinding leaves less than {MIN_THICKNESS:.0%} of the wire; "
            "grind fewer turns or use fixed ends"
        )
    return level


def _cut_below(section: SectionMesh, nodes: Array, level: float) -> Array:
    """Disc nodes mapped onto the part of the disc above y = level, ray by ray from the middle of
    that part.
    """
    rim = float(np.max(np.hypot(*nodes.T)))
    level, middle = level / rim, (1 + level / rim) / 2
    angle, share = np.arctan2(nodes[:, 1], nodes[:, 0]), np.hypot(nodes[:, 0], nodes[:, 1]) / rim
    across, up = np.cos(angle), np.sin(angle)
    to_circle = -middle * up + np.sqrt(np.maximum((middle * up) ** 2 + 1 - middle**2, 0.0))
    with np.errstate(divide="ignore"):
        to_plane = np.where(up < 0, (level - middle) / np.minimum(up, -1e-300), np.inf)
    reach = share * np.minimum(to_circle, to_plane)
    mapped = rim * np.stack([reach * across, middle + reach * up], axis=-1)
    return _straightened(section, mapped, to_circle <= to_plane)


def _straightened(section: SectionMesh, mapped: Array, round_side: Flags) -> Array:
    """Edge middles put between their corners, except on edges of the uncut circle: a middle next to
    a kink folds an element.
    """
    rim = np.zeros(len(mapped), dtype=bool)
    rim[section.quads[section.rim_quads][:, [1, 2, 5]]] = True
    straight = mapped.copy()
    for edge in range(4):
        first, last, middle = (
            section.quads[:, edge],
            section.quads[:, (edge + 1) % 4],
            section.quads[:, 4 + edge],
        )
        keep = rim[middle] & round_side[first] & round_side[last] & round_side[middle]
        straight[middle] = np.where(
            keep[:, None], mapped[middle], (mapped[first] + mapped[last]) / 2
        )
    return straight
