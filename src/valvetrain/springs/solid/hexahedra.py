"""The 20-node hexahedron: shape functions, Jacobians and volume, to judge a mesh before it is sent
to a solver.

Node order of Abaqus and CalculiX: corners of the bottom face 1-4, of the top face 5-8, middles of
the bottom edges
9-12, of the top edges 13-16, of the upright edges 17-20.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Local coordinates of the 20 nodes; the first eight are the corners.
NODE_COORDINATES = np.array(
    [
        (-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1),
        (0, -1, -1), (1, 0, -1), (0, 1, -1), (-1, 0, -1), (0, -1, 1), (1, 0, 1), (0, 1, 1), (-1, 0, 1),
        (-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0),
    ],
    dtype=float,
)  # fmt: skip


def shape_gradients(points: Array, nodes: int = 20) -> Array:
    """Derivatives of the shape functions by the local coordinates at ``points`` (p, 3): shape (p,
    nodes, 3), nodes 20 or 8.
    """
    own = NODE_COORDINATES[:nodes]
    reach = 1.0 + points[:, None, :] * own[None]
    gradients = np.empty((len(points), nodes, 3))
    for axis in range(3):
        one, two = (axis + 1) % 3, (axis + 2) % 3
        along, pair = points[:, None, axis], reach[..., one] * reach[..., two]
        corner = own[None, :, axis] * pair / 8
        if nodes == 20:
            total = np.sum(points[:, None, :] * own[None], axis=-1)
            corner = own[None, :, axis] * pair * (total - 2 + reach[..., axis]) / 8
        gradients[..., axis] = corner
        if nodes == 20:
            gradients[:, 8:, axis] = _edge_gradient(
                points, own[8:], reach[:, 8:], axis, one, two, along
            )
    return gradients


def _edge_gradient(
    points: Array, own: Array, reach: Array, axis: int, one: int, two: int, along: Array
) -> Array:
    """Derivative along ``axis`` of the edge functions (1 - a^2)(1 + b b_i)(1 + c c_i) / 4."""
    middle = own[:, axis] == 0
    one_middle, two_middle = own[:, one] == 0, own[:, two] == 0
    first = np.where(one_middle, 1 - points[:, None, one] ** 2, reach[..., one])
    second = np.where(two_middle, 1 - points[:, None, two] ** 2, reach[..., two])
    return np.where(middle, -2 * along, own[None, :, axis]) * first * second / 4


def gauss_points(order: int = 3) -> tuple[Array, Array]:
    """Tensor Gauss rule on the reference cube: points (order**3, 3) and weights."""
    node, weight = np.polynomial.legendre.leggauss(order)
    grid = np.stack(np.meshgrid(node, node, node, indexing="ij"), axis=-1).reshape(-1, 3)
    weights = np.einsum("i,j,k->ijk", weight, weight, weight).ravel()
    return grid, weights


def jacobian_determinants(coordinates: Array, elements: NDArray[np.int64], points: Array) -> Array:
    """Determinants (elements, points) of the map from the reference cube; positive everywhere in a
    usable mesh.
    """
    gradients = shape_gradients(points, elements.shape[1])
    jacobians = np.einsum("pna,enb->epab", gradients, coordinates[elements])
    found: Array = np.linalg.det(jacobians)
    return found


def volume(coordinates: Array, elements: NDArray[np.int64]) -> float:
    """Volume (m3 for coordinates in m) of all elements by 3 x 3 x 3 Gauss points."""
    points, weights = gauss_points(3)
    return float(np.sum(jacobian_determinants(coordinates, elements, points) @ weights))
