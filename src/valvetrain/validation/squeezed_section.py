"""A slice of wire of bricks in plane strain, squeezed between two opposite lines."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.linalg import spsolve

from valvetrain.coil_contact.line_contact import line_contact
from valvetrain.continuum.bricks import sweep_bricks
from valvetrain.parameters.material import Material

#: Radius of the arcs at which the mesh ends next to the two lines, over the half width of the contact.
END = 0.05


def squeezed_section(
    wire_diameter: float, material: Material, force_per_length: float, across: int = 24
) -> float:
    """Compression (m) of a disc under the pressure of Hertz on both sides (N/m), by ``across`` bricks from
    line to line of a mesh that is refined towards both lines.

    Bipolar coordinates: tanh maps a strip of squares onto the disc, its two ends onto the lines.
    """
    radius = wire_diameter / 2
    half_width = line_contact(wire_diameter, material, force_per_length).half_width
    reach = -np.log(END * half_width / wire_diameter)
    along = 2 * int(np.ceil(reach * across / np.pi))
    places = (
        np.linspace(-reach, reach, along + 1)[:, None]
        + 1j * np.linspace(-np.pi / 2, np.pi / 2, across + 1)[None]
    )
    disc = radius * np.tanh(places / 2)
    number = np.arange(disc.size).reshape(disc.shape)
    corners = (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    quads = np.stack(corners, axis=-1).reshape(-1, 4)
    nodes, thickness = np.stack([disc.real.ravel(), disc.imag.ravel()], axis=1), half_width
    grid = np.zeros((2, len(nodes), 3))
    grid[:, :, :2], grid[1, :, 2] = nodes, thickness
    bricks = sweep_bricks(grid, quads.astype(np.int64), material)
    elements, unknowns = bricks.tangent(np.ascontiguousarray(grid.transpose(1, 2, 0)))
    # both faces move alike and not along the wire
    face = np.full(grid.size, -1).reshape(len(nodes), 3, 2)
    face[:, :2] = np.arange(2 * len(nodes)).reshape(-1, 2)[:, :, None]
    place = face.ravel()[unknowns]
    rows, columns = np.broadcast_arrays(place[:, :, None], place[:, None, :])
    used = (rows >= 0) & (columns >= 0)
    size = 2 * len(nodes)
    stiffness = sparse.csr_matrix((elements[used], (rows[used], columns[used])), shape=(size, size))
    load = np.zeros((len(nodes), 2))
    for side, end in ((1, along), (-1, 0)):
        half = number[along // 2 :] if side > 0 else number[: along // 2 + 1]
        rim = np.unique(np.concatenate([half[:, 0], half[:, -1], number[end]]))
        rim = rim[np.argsort(nodes[rim, 1])]
        between = np.diff(_pressed(nodes[rim, 1] / half_width))
        share = np.zeros(len(rim))
        share[:-1] += between / 2
        share[1:] += between / 2
        load[rim, 0] -= side * force_per_length * thickness * share
    fixed = np.zeros((len(nodes), 2), dtype=bool)
    fixed[number[along // 2], 0] = True
    fixed[number[along // 2, across // 2], 1] = True
    free = ~fixed.ravel()
    moved = np.zeros(size)
    moved[free] = spsolve(stiffness[free][:, free].tocsc(), load.ravel()[free])
    return float(-2 * np.mean(moved.reshape(-1, 2)[number[along], 0]))


def _pressed(place: NDArray[np.float64]) -> NDArray[np.float64]:
    """Share of the pressure of Hertz that acts below a place, in half widths from the middle."""
    inside = np.clip(place, -1.0, 1.0)
    found: NDArray[np.float64] = 0.5 + (inside * np.sqrt(1 - inside**2) + np.arcsin(inside)) / np.pi
    return found
