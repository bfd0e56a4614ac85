"""The solid mesh of a spring: plain arrays with named sets, independent of any solver."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from valvetrain.springs.solid import hexahedra

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class FaceSet:
    """Outer faces of the wire: element numbers (from 0) and their coil number; every face is side 4
    of its element.
    """

    elements: Integers
    coil: Array

    def between(self, first: float, last: float) -> FaceSet:
        """The faces whose middle lies at first <= coil number < last."""
        inside = (self.coil >= first) & (self.coil < last)
        return FaceSet(self.elements[inside], self.coil[inside])


@dataclass(frozen=True)
class SolidMesh:
    """Hexahedra of a swept wire.

    ``coordinates`` (n, 3) in m; ``elements`` (m, 20 or 8) numbered from 0; ``coil`` (n,) coil
    number of each node;
    ``section`` (n, 2) its place in the unit disc (x outward, y up); ``lower`` and ``upper`` faces
    of the wire that can
    meet a neighbouring coil; ``node_sets``: ``seat`` and ``retainer`` (bonded to the seats) and
    whatever a caller adds.
    """

    coordinates: Array
    elements: Integers
    coil: Array
    section: Array
    lower: FaceSet
    upper: FaceSet
    node_sets: Mapping[str, Integers] = field(default_factory=dict)

    @property
    def quadratic(self) -> bool:
        """True for twenty-node elements, whose edges follow the wire."""
        return bool(self.elements.shape[1] == 20)

    @property
    def unknowns(self) -> int:
        """Displacement components of nodes that are not bonded."""
        bonded = set(self.node_sets["seat"]) | set(self.node_sets["retainer"])
        return 3 * (len(self.coordinates) - len(bonded))

    @property
    def volume(self) -> float:
        """Volume of the mesh (m3)."""
        return hexahedra.volume(self.coordinates, self.elements)

    def jacobian_quality(self) -> float:
        """Smallest Jacobian determinant over its element's largest, at the corners and 3 x 3 x 3
        Gauss points; > 0 is usable.
        """
        points = np.vstack([hexahedra.gauss_points(3)[0], hexahedra.NODE_COORDINATES[:8]])
        determinants = hexahedra.jacobian_determinants(self.coordinates, self.elements, points)
        return float(np.min(determinants.min(axis=1) / np.abs(determinants).max(axis=1)))

    def fibre(self, x: float, y: float) -> Integers:
        """Nodes along the wire nearest to section place (x, y), ordered by coil number; (-1, 0) is
        the inner fibre.
        """
        distance = np.hypot(self.section[:, 0] - x, self.section[:, 1] - y)
        nodes = np.flatnonzero(distance < distance.min() + 1e-6)
        return nodes[np.argsort(self.coil[nodes])]
