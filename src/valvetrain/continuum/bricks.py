"""Eight-node bricks of a swept body: mean gradient, hourglass stiffness and mass of each, laid out
for :mod:`valvetrain.continuum.brick_kernels`.

The stiffness of a brick in its undeformed shape is that of the element with incompatible modes
(QM6, taylor1976), which does not lock in bending. It splits exactly into V B:C:B
of the mean gradient and G^T K G of the hourglass vectors gamma (belytschko1984): so the
elements pass the patch test and bend as QM6 does, at the cost of one point.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from valvetrain.arrays import Array, Ints
from valvetrain.continuum import brick_kernels as kern
from valvetrain.continuum.mesh import NODE_COORDINATES, gauss_points, shape_gradients
from valvetrain.errors import InputError
from valvetrain.parameters.material import Material

Integers = Ints

#: Hourglass modes of the corners, in the order of :data:`brick_kernels.SIGNS`.
_MODES = np.stack(
    [np.prod(NODE_COORDINATES[:8][:, axes], axis=1) for axes in ([1, 2], [0, 2], [0, 1], [0, 1, 2])]
)
#: Step (m) of the difference quotients of the tangent.
TANGENT_STEP = 1e-9


class BrickConstants(NamedTuple):
    """``gradient`` (e, 8, 3) of the shape functions, mean over the volume; ``mode`` (e, 4, 3)
    hourglass sums of the corner coordinates; ``stiffness`` (e, 12, 12) of the hourglass amplitudes;
    ``volume`` (e,) and its share of each corner (e, 8), m3; ``misfit``: largest difference of the
    split from QM6, over the largest stiffness.
    """

    gradient: Array
    mode: Array
    stiffness: Array
    volume: Array
    share: Array
    misfit: float


def strain_matrix(gradient: Array) -> Array:
    """Strains xx yy zz xy yz zx (6, 3 n) of nodal displacements, from gradients (e, n, 3)."""
    count, nodes, _ = gradient.shape
    found = np.zeros((count, 6, nodes, 3))
    for axis, (one, two) in enumerate(((0, 1), (1, 2), (2, 0))):
        found[:, axis, :, axis] = gradient[..., axis]
        found[:, 3 + axis, :, one] = gradient[..., two]
        found[:, 3 + axis, :, two] = gradient[..., one]
    return found.reshape(count, 6, 3 * nodes)


def lame_constants(material: Material) -> tuple[float, float]:
    """Lame's first constant and the shear modulus (Pa)."""
    ratio = material.poisson_ratio
    first = material.youngs_modulus * ratio / ((1 + ratio) * (1 - 2 * ratio))
    return first, material.shear_modulus


def brick_constants(corners: Array, material: Material) -> BrickConstants:
    """The constants of bricks with ``corners`` (e, 8, 3) in m. Raises :class:`InputError` for a brick
    that is turned inside out.
    """
    first, shear = lame_constants(material)
    elastic = np.diag([2 * shear] * 3 + [shear] * 3)
    elastic[:3, :3] += first
    points, weights = gauss_points(2)
    local = shape_gradients(points, 8)
    shape = np.prod(1 + points[:, None, :] * NODE_COORDINATES[None, :8], axis=-1) / 8
    middle = np.einsum("na,enb->eab", shape_gradients(np.zeros((1, 3)), 8)[0], corners)
    middle_inverse, middle_determinant = np.linalg.inv(middle), np.linalg.det(middle)
    count = len(corners)
    compatible, mixed = np.zeros((count, 24, 24)), np.zeros((count, 24, 9))
    incompatible = np.zeros((count, 9, 9))
    volume, share, gradient = np.zeros(count), np.zeros((count, 8)), np.zeros((count, 8, 3))
    for point, weight in enumerate(weights):
        jacobian = np.einsum("na,enb->eab", local[point], corners)
        size = weight * np.linalg.det(jacobian)
        if not np.all(size > 0):
            raise InputError("a brick of the solid mesh is folded; use more elements per coil")
        here = np.einsum("eab,nb->ena", np.linalg.inv(jacobian), local[point])
        volume += size
        share += size[:, None] * shape[point]
        gradient += size[:, None, None] * here
        # The quadratic modes are differentiated with the Jacobian of the middle: the patch test.
        bubble = np.einsum("eab,nb->ena", middle_inverse, np.diag(-2 * points[point]))
        bubble *= (weight * middle_determinant / size)[:, None, None]
        own, more = strain_matrix(here), strain_matrix(bubble)
        scaled = size[:, None, None]
        compatible += scaled * (own.transpose(0, 2, 1) @ (elastic @ own))
        mixed += scaled * (own.transpose(0, 2, 1) @ (elastic @ more))
        incompatible += scaled * (more.transpose(0, 2, 1) @ (elastic @ more))
    gradient /= volume[:, None, None]
    whole = compatible - mixed @ np.linalg.solve(incompatible, mixed.transpose(0, 2, 1))
    mode = np.einsum("an,enj->eaj", _MODES, corners)
    vectors = (_MODES[None] - np.einsum("eaj,enj->ean", mode, gradient)) / 8
    basis = np.concatenate(
        [np.full((count, 1, 8), 1 / 8), gradient.transpose(0, 2, 1), vectors], axis=1
    )
    patterns = np.linalg.inv(basis)[:, :, 4:]
    by_node = whole.reshape(count, 8, 3, 8, 3)
    stiffness = np.einsum("ena,enimj,emc->eaicj", patterns, by_node, patterns, optimize=True)
    stiffness = stiffness.reshape(count, 12, 12)
    mean = strain_matrix(gradient)
    amplitudes = np.einsum("ean,ij->eainj", vectors, np.eye(3)).reshape(count, 12, 24)
    split = volume[:, None, None] * (mean.transpose(0, 2, 1) @ (elastic @ mean))
    split += amplitudes.transpose(0, 2, 1) @ stiffness @ amplitudes
    misfit = float(np.abs(split - whole).max() / np.abs(whole).max())
    return BrickConstants(gradient, mode, stiffness, volume, share, misfit)


@dataclass(frozen=True, eq=False)
class Bricks:
    """Bricks between neighbouring stations of a swept body, and the masses of its nodes.

    ``constants`` and ``corners``: arrays of the kernels; ``mass`` (nodes, stations) in kg of the
    bricks' nodes; ``stations`` in all, of which bricks fill ``first`` to ``last``; ``material``.
    """

    constants: Array
    corners: NDArray[np.uint64]
    mass: Array
    stations: int
    first: int
    last: int
    width: int
    misfit: float
    material: Material

    @property
    def nodes(self) -> int:
        """Nodes per section."""
        return len(self.mass)

    @property
    def spans(self) -> int:
        """Bricks along the body."""
        return self.last - self.first

    @property
    def count(self) -> int:
        """Bricks in all."""
        return len(self.corners) * self.spans

    @cached_property
    def shape(self) -> NDArray[np.uint64]:
        """Stride, quadrilaterals, spans and spans per block, for the kernels."""
        found = [self.stations, len(self.corners), self.spans, self.width]
        return np.array(found, dtype=np.uint64)

    @cached_property
    def lame(self) -> Array:
        """Lame's constants (Pa)."""
        return np.array(lame_constants(self.material))

    def branch_states(self) -> Array:
        """Zeros for the states of the Maxwell branch."""
        blocks = len(self.corners) * -(-self.spans // self.width)
        return np.zeros(blocks * kern.STRAINS * kern.LANES)

    def forces(self, position: Array) -> Array:
        """Internal forces (N) on the nodes, (nodes, 3, stations), at positions of that shape (m)."""
        force = np.zeros(position.size)
        kern.brick_forces(
            np.ascontiguousarray(position).ravel(),
            force,
            self.constants,
            np.zeros(1),
            np.zeros(kern.SCRATCH),
            self.corners,
            kern.SIGNS,
            self.shape,
            self.lame,
            np.zeros(4),
        )
        return force.reshape(position.shape)

    def energy(self, position: Array) -> float:
        """Elastic energy (J) at positions (nodes, 3, stations) in m."""
        found = np.zeros(4)
        kern.brick_energies(
            np.ascontiguousarray(position).ravel(),
            self.constants,
            np.zeros(1),
            np.zeros(kern.SCRATCH),
            self.corners,
            self.shape,
            self.lame,
            np.zeros(4),
            found,
        )
        return float(found[0])

    @cached_property
    def corner_unknowns(self) -> Integers:
        """Positions (quadrilaterals, spans, 24) of the corners' components in a flat position."""
        spans, axes = np.arange(self.spans), self.stations * np.arange(3)
        found = self.corners.astype(np.int64)[:, None, :, None] + axes[None, None, None]
        return (found + spans[None, :, None, None]).reshape(len(self.corners), self.spans, 24)

    def tangent(self, position: Array) -> tuple[Array, Integers]:
        """Element tangents (e, 24, 24) in N/m by central differences and the places (e, 24) of their
        unknowns in the flat position.

        Every brick is moved alone: the corners of a quadrilateral's bricks are laid out apart.
        """
        places, flat = self.corner_unknowns, np.ascontiguousarray(position).ravel()
        found = np.zeros((*places.shape, 24))
        apart = (np.arange(24, step=3, dtype=np.uint64) * np.uint64(self.spans))[None]
        shape = np.array([self.spans, 1, self.spans, self.width], dtype=np.uint64)
        block = len(self.constants) // len(self.corners)
        none, scratch = np.zeros(1), np.zeros(kern.SCRATCH)
        for quad in range(len(self.corners)):
            own = np.ascontiguousarray(flat[places[quad]].T)
            constants = self.constants[quad * block : (quad + 1) * block]
            for unknown in range(24):
                sides = np.zeros((2, own.size))
                for side, step in zip(sides, (TANGENT_STEP, -TANGENT_STEP), strict=True):
                    moved = own.copy()
                    moved[unknown] += step
                    kern.brick_forces(
                        moved.ravel(), side, constants, none, scratch, apart, kern.SIGNS, shape,
                        self.lame, np.zeros(4),
                    )  # fmt: skip
                change = (sides[1] - sides[0]).reshape(24, self.spans) / (2 * TANGENT_STEP)
                found[quad, :, :, unknown] = change.T
        return found.reshape(-1, 24, 24), places.reshape(-1, 24)


def sweep_bricks(
    grid: Array,
    quads: Integers,
    material: Material,
    *,
    reverse: bool = False,
    first: int = 0,
    last: int | None = None,
) -> Bricks:
    """Bricks between the stations ``first`` to ``last`` (all) of a ``grid`` (stations, nodes, 3) in m
    of sections divided into ``quads`` (q, 4).

    ``reverse``: the sections' normal (first corner to second, cross to fourth) runs against the
    stations. Nodes at stations without bricks have no mass. Raises :class:`InputError` for folded
    bricks.
    """
    stations, nodes, _ = grid.shape
    last = stations - 1 if last is None else last
    spans = last - first
    blocks = -(-spans // kern.LANES)
    width = -(-spans // blocks)
    constants = np.zeros((len(quads), blocks, kern.CONSTANT_ROWS, kern.LANES))
    mass, misfit = np.zeros((nodes, stations)), 0.0
    sides = (1, 0) if reverse else (0, 1)
    corners = np.zeros((len(quads), 8), dtype=np.uint64)
    span = np.arange(first, last)
    for number, quad in enumerate(quads):
        own = np.stack([grid[span + side, node] for side in sides for node in quad[:4]], axis=1)
        made = brick_constants(own, material)
        misfit = max(misfit, made.misfit)
        rows = np.concatenate(
            [part.reshape(spans, -1) for part in (made.gradient, made.mode, made.stiffness)]
            + [made.volume[:, None]],
            axis=1,
        )
        for block in range(blocks):
            part = rows[block * width : (block + 1) * width]
            constants[number, block, :, : len(part)] = part.T
        for corner, (side, node) in enumerate((s, n) for s in sides for n in quad[:4]):
            np.add.at(mass[node], span + side, material.density * made.share[:, corner])
            corners[number, corner] = 3 * node * stations + first + side
    return Bricks(constants.ravel(), corners, mass, stations, first, last, width, misfit, material)
