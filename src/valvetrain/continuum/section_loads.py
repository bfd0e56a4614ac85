"""Forces and moments through the sections of a solid wire, from the nodal forces of its bricks, and the
stress on its surface from their strains.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sparse

from valvetrain.arrays import Array
from valvetrain.continuum import brick_kernels as kern
from valvetrain.continuum.mesh import NODE_COORDINATES, shape_gradients
from valvetrain.continuum.wire import SolidWire


class SectionLoads(NamedTuple):
    """What the wire beyond a section does to it, in the middle of every span (spans, 3): ``force``
    (N) and ``moment`` (N m) along the outward normal, the binormal and the tangent of the wire;
    ``coil`` number of the middles.
    """

    force: Array
    moment: Array
    coil: Array


def section_loads(wire: SolidWire, position: Array) -> SectionLoads:
    """Loads at positions (nodes, 3, stations) in m: elastic, without the Maxwell branch.

    The bricks of a span pass on what they exert on the nodes of its upper section; axes are those of
    the rod, the tangent from centre to centre, the normal through the outer rim.
    """
    bricks, (first, last) = wire.bricks, wire.ends
    quads, spans = len(bricks.corners), last - first
    places, flat = bricks.corner_unknowns, np.ascontiguousarray(position).ravel()
    block = len(bricks.constants) // quads
    apart = (np.arange(24, step=3, dtype=np.uint64) * np.uint64(spans))[None]
    shape = np.array([spans, 1, spans, bricks.width], dtype=np.uint64)
    centre = wire.centres(position)
    lower, upper = centre[:, first:last].T, centre[:, first + 1 : last + 1].T
    middle = (lower + upper) / 2
    sides = (0, 4) if wire.spring.hand == "right" else (4, 8)
    force, moment = np.zeros((spans, 3)), np.zeros((spans, 3))
    scratch, none = np.zeros(kern.SCRATCH), np.zeros(1)
    for quad in range(quads):
        own = np.ascontiguousarray(flat[places[quad]].T)
        found = np.zeros(own.size)
        kern.brick_forces(
            own.ravel(), found, bricks.constants[quad * block : (quad + 1) * block], none, scratch,
            apart, kern.SIGNS, shape, bricks.lame, np.zeros(4),
        )  # fmt: skip
        corner = own.reshape(8, 3, spans)[slice(*sides)].transpose(0, 2, 1)
        push = found.reshape(8, 3, spans)[slice(*sides)].transpose(0, 2, 1)
        force -= push.sum(axis=0)
        moment -= np.cross(corner - middle, push).sum(axis=0)
    axes = _section_axes(wire, position, lower, upper)
    return SectionLoads(
        np.einsum("skj,sj->sk", axes, force),
        np.einsum("skj,sj->sk", axes, moment),
        (wire.coil[first:last] + wire.coil[first + 1 : last + 1]) / 2,
    )


def _section_axes(wire: SolidWire, position: Array, lower: Array, upper: Array) -> Array:
    """Outward normal, binormal and tangent (spans, 3 axes, 3)."""
    first, last = wire.ends
    x, y = wire.section_nodes.T
    outer, inner = np.argmax(x - np.abs(y)), np.argmin(x + np.abs(y))
    across = (position[outer] - position[inner]).T
    normal = across[first:last] + across[first + 1 : last + 1]
    tangent = upper - lower
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    normal -= tangent * np.sum(tangent * normal, axis=1, keepdims=True)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return np.stack([normal, np.cross(tangent, normal), tangent], axis=1)


class SurfaceStress:
    """Stress on the surface of the wire at the rim nodes of its sections, in the middle of every second
    span; Pa.

    ``coil`` (places,) numbers, span by span, and ``angle`` (fibres,) from the outward direction upward
    (rad) of the ``fibres`` of a span.
    """

    def __init__(self, wire: SolidWire) -> None:
        (first, last), section = wire.ends, wire.section_nodes
        turn, radius = np.arctan2(section[:, 1], section[:, 0]), np.hypot(*section.T)
        turn = np.mod(np.round(turn, 9), 2 * np.pi)
        rim = np.flatnonzero(radius > 1 - 1e-9)
        rim = rim[np.argsort(turn[rim])]
        bricks, free, span = wire.bricks, wire.grid, np.arange(first, last, 2)
        side = bricks.corners[0].astype(np.int64) % bricks.stations - first
        station = span[:, None] + side
        along = wire.centres(wire.free_position).T
        along = along[span + 1] - along[span]
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        rows, columns, entries = [], [], []
        for quad in bricks.corners.astype(np.int64) // (3 * bricks.stations):
            own = free[station, quad]
            for corner in np.flatnonzero(np.isin(quad[:4], rim)):
                # on the spoke from the node inward, at the wire's radius: flat sides project there
                inner = next(c % 4 for c in (corner - 1, corner + 1) if quad[c % 4] not in rim)
                far, near = radius[quad[corner]], radius[quad[inner]]
                share = (far - 1) / (far - near)
                at = (1 - share) * NODE_COORDINATES[corner] + share * NODE_COORDINATES[inner]
                local = shape_gradients(at[None] * (1.0, 1.0, 0.0), 8)[0]
                jacobian = np.einsum("na,snb->sab", local, own)
                slope = np.einsum("sab,nb->sna", np.linalg.inv(jacobian), local)
                spoke = free[span, quad[corner]] - free[span, quad[inner]]
                around = np.cross(along, spoke)
                around /= np.linalg.norm(around, axis=1, keepdims=True)
                place = np.arange(len(span)) * len(rim) + np.flatnonzero(rim == quad[corner])
                rows.append(np.repeat(place, 8))
                columns.append((quad * bricks.stations + station).ravel())
                entries.append(
                    [np.einsum("snk,sk->sn", slope, one).ravel() for one in (along, around)]
                )
        where = (np.concatenate(rows), np.concatenate(columns))
        count = np.bincount(where[0]) / 8  # bricks that share a node: their mean
        shape = (len(count), bricks.nodes * bricks.stations)
        self._along, self._around = (
            sparse.csr_matrix((values / count[where[0]], where), shape)
            for values in np.concatenate(entries, axis=1)
        )
        self._material, self.angle = wire.spring.material, turn[rim]
        self.coil = np.repeat((wire.coil[span] + wire.coil[span + 1]) / 2, len(rim))

    def parts(self, position: Array) -> tuple[Array, Array]:
        """Axial stress and shear stress about the axis (places,) at positions (nodes, 3, stations) in m:
        a free surface bears no other, so the former is E times the strain.
        """
        flat = position.transpose(0, 2, 1).reshape(-1, 3)
        along, around = self._along @ flat, self._around @ flat
        stretch, shear = (np.sum(along**2, axis=1) - 1) / 2, np.sum(along * around, axis=1)
        return self._material.youngs_modulus * stretch, self._material.shear_modulus * shear

    def equivalent(self, position: Array) -> Array:
        """Equivalent stress (places,) by von Mises."""
        axial, shear = self.parts(position)
        found: Array = np.sqrt(axial**2 + 3 * shear**2)
        return found
