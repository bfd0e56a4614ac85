"""Every point in which a rod can touch itself or its seats: overlap, and how it changes with the
positions of the vertices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.arrays import Array
from valvetrain.cosserat.contact_line import span_weights
from valvetrain.cosserat.mesh import RodMesh
from valvetrain.cosserat.state import RodState


@dataclass(frozen=True, eq=False)
class ContactPoints:
    """Points (p,) of a rod of ``mesh``: those between coils by ``group`` and ``vertex``, ascending
    along the wire, then the free vertices over the lower seat (``lower``) and below the retainer
    (``upper``).

    Points whose two sides are held by one end are left out: they never move against each other.
    """

    mesh: RodMesh
    group: NDArray[np.int64]
    vertex: NDArray[np.int64]
    lower: NDArray[np.int64]
    upper: NDArray[np.int64]

    @classmethod
    def of(cls, mesh: RodMesh) -> ContactPoints:
        """All points of a mesh."""
        group, vertex = np.nonzero(mesh.contact.points)
        order = np.lexsort((group, vertex))
        group, vertex = group[order], vertex[order]
        partner = vertex - mesh.contact.offset
        below = (vertex + 1 <= mesh.first) & (partner + 1 <= mesh.first)
        above = (vertex - 1 >= mesh.last) & (partner - 1 >= mesh.last)
        moves = ~(below | above)
        index = np.arange(mesh.vertices)
        free = (index > mesh.first) & (index < mesh.last)
        return cls(
            mesh,
            group[moves],
            vertex[moves],
            np.flatnonzero(np.isfinite(mesh.lower_seat_limit) & free),
            np.flatnonzero(np.isfinite(mesh.upper_seat_limit) & free),
        )

    @property
    def count(self) -> int:
        """Number of points."""
        return len(self.vertex) + len(self.lower) + len(self.upper)

    @property
    def length(self) -> Array:
        """Length of wire (p,) in m that each point represents."""
        nodes = self.mesh.node_length
        coils = self.mesh.contact.length[self.group, self.vertex]
        return np.concatenate((coils, nodes[self.lower], nodes[self.upper]))

    def overlaps(self, state: RodState) -> tuple[Array, Array]:
        """Overlap (p,) in m, negative where open, and its gradient (p, nv, 3) by the positions."""
        mesh, x, line = self.mesh, state.position, self.mesh.contact
        coils, rows = len(self.vertex), np.arange(len(self.vertex))
        gradient = np.zeros((self.count, mesh.vertices, 3))
        upper, below = self.vertex, self.vertex - line.offset
        start = line.lower_place[self.group]
        before, centre, after = x[below - 1], x[below], x[below + 1]
        slope = (after - before) / 2 + start[:, None] * (after - 2 * centre + before)
        here = [w[:, None] for w in span_weights(line.upper_place[self.group])]
        there = [w[:, None] for w in span_weights(start)]
        gap = sum(
            w * x[upper + k - 1] - v * x[below + k - 1]
            for k, (w, v) in enumerate(zip(here, there, strict=True))
        )
        shift = np.sum(gap * slope, axis=1) / np.sum(slope * slope, axis=1)
        bent = after - 2 * centre + before
        gap = gap - shift[:, None] * slope - 0.5 * shift[:, None] ** 2 * bent
        distance = np.linalg.norm(gap, axis=1)
        normal = gap / distance[:, None]
        foot = [w[:, None] for w in span_weights(start + shift)]
        for k in range(3):
            np.add.at(gradient, (rows, upper + k - 1), -here[k] * normal)
            np.add.at(gradient, (rows, below + k - 1), foot[k] * normal)
        low = coils + np.arange(len(self.lower))
        high = coils + len(self.lower) + np.arange(len(self.upper))
        gradient[low, self.lower, 2], gradient[high, self.upper, 2] = -1.0, 1.0
        limit = mesh.upper_seat_limit[self.upper] - state.compression
        return np.concatenate(
            (
                line.distance[self.group, upper] - distance,
                mesh.lower_seat_limit[self.lower] - x[self.lower, 2],
                x[self.upper, 2] - limit,
            )
        ), gradient
