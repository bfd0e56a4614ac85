"""Forces and moments through the sections of a solid wire, from the nodal forces of its bricks."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from valvetrain.continuum import brick_kernels as kern
from valvetrain.continuum.wire import SolidWire

Array = NDArray[np.float64]


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
