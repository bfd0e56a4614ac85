"""Bars of bricks for the tests of solids, and their linear solution."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import eigsh, spsolve

from valvetrain.continuum.bricks import Bricks, sweep_bricks
from valvetrain.continuum.section import disc_section
from valvetrain.parameters.curves import Constant
from valvetrain.parameters.material import OTEVA_90_SC
from valvetrain.parameters.spring import OPEN_END, SpringDefinition

STEEL = OTEVA_90_SC


def disc(core: int = 2, rings: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, 2) and quadrilaterals (q, 4) of the unit disc."""
    section = disc_section(core, rings, quadratic=False)
    used, quads = np.unique(section.quads[:, :4], return_inverse=True)
    return section.nodes[used], quads.reshape(-1, 4)


def area_moments(core: int, rings: int) -> tuple[float, float]:
    """Second moments of the meshed unit section about one axis, over that of the disc, and its area
    over the disc's: what the polygon makes of the circle is known exactly.
    """
    nodes, quads = disc(core, rings)
    x, y = nodes[quads].transpose(2, 0, 1)
    x1, y1 = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
    cross = x * y1 - x1 * y
    moment = float(np.sum(cross * (y * y + y * y1 + y1 * y1))) / 12
    return moment / (np.pi / 4), float(np.sum(cross)) / 2 / np.pi


def bar(
    length: float, radius: float, spans: int, core: int = 2, rings: int = 1, arc: float = 0.0
) -> tuple[Bricks, np.ndarray]:
    """Bricks of a round bar along z, or bent to an ``arc`` (rad) in the x-z plane of that length, and
    their positions (nodes, 3, stations).
    """
    nodes, quads = disc(core, rings)
    along = np.linspace(0.0, length, spans + 1)
    grid = np.zeros((spans + 1, len(nodes), 3))
    grid[:, :, 1] = radius * nodes[:, 1]
    if arc:
        middle = length / arc
        angle = along / middle
        reach = middle - radius * nodes[None, :, 0]
        grid[:, :, 0] = middle - reach * np.cos(angle)[:, None]
        grid[:, :, 2] = reach * np.sin(angle)[:, None]
    else:
        grid[:, :, 0] = radius * nodes[:, 0]
        grid[:, :, 2] = along[:, None]
    bricks = sweep_bricks(grid, quads, STEEL)
    return bricks, np.ascontiguousarray(grid.transpose(1, 2, 0))


def stiffness(bricks: Bricks, position: np.ndarray) -> sparse.csr_matrix:
    """Stiffness (N/m) of all nodes."""
    elements, places = bricks.tangent(position)
    rows, columns = np.repeat(places, 24, axis=1).ravel(), np.tile(places, (1, 24)).ravel()
    size = position.size
    return sparse.csr_matrix((elements.ravel(), (rows, columns)), shape=(size, size))


def reactions(bricks: Bricks, position: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Forces (nodes, 3) in N that move the last section by ``moved`` (nodes, 3) in m, the first being
    fixed: linear.
    """
    whole = stiffness(bricks, position)
    number = np.arange(position.size).reshape(position.shape)
    free, end = number[:, :, 1:-1].ravel(), number[:, :, -1].ravel()
    given = np.zeros(position.size)
    given[end] = moved.ravel()
    given[free] = spsolve(whole[free][:, free].tocsc(), -(whole @ given)[free])
    return (whole @ given)[end].reshape(-1, 3)


def frequencies(bricks: Bricks, position: np.ndarray, fixed: np.ndarray, count: int) -> np.ndarray:
    """The lowest natural frequencies (Hz) with the unknowns in the mask ``fixed`` held."""
    free = np.flatnonzero(~fixed.ravel())
    mass = np.repeat(bricks.mass[:, None, :], 3, axis=1).ravel()[free]
    inner = stiffness(bricks, position)[free][:, free]
    scale = sparse.diags(1 / np.sqrt(mass))
    found = eigsh((scale @ inner @ scale).tocsc(), k=count, sigma=0.0, return_eigenvectors=False)
    return np.sort(np.sqrt(np.maximum(found, 0.0))) / (2 * np.pi)


def helix(
    mean_diameter: float = 22e-3, coils: float = 5.0, pitch: float = 7e-3
) -> SpringDefinition:
    """A uniform spring of 3.8 mm wire with clamped end sections."""
    return SpringDefinition(
        wire_diameter=Constant(3.8e-3),
        mean_diameter=Constant(mean_diameter),
        pitch=Constant(pitch),
        total_coils=coils,
        material=STEEL,
        lower_end=OPEN_END,
        upper_end=OPEN_END,
    )
