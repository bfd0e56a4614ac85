"""From nodes of the solid mesh to the wire axis: positions over the coil number and gaps between
coils.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from validation.calculix.deck import SolidContact
from valvetrain.continuum.mesh import SolidMesh
from valvetrain.parameters.spring import SpringDefinition

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


def axis_points(mesh: SolidMesh) -> tuple[Array, Integers, Array]:
    """Coil numbers (points,) of the wire axis, the point that each node of set ``axis`` belongs to,
    free positions (points, 3).

    A section without a middle node is represented by the mean of the nodes around its middle.
    """
    nodes = mesh.node_sets["axis"]
    coil, index = np.unique(np.round(mesh.coil[nodes], 9), return_inverse=True)
    count = np.bincount(index)
    mean = np.stack(
        [np.bincount(index, mesh.coordinates[nodes, k]) / count for k in range(3)], axis=-1
    )
    return coil, index, mean


def averaged(table: Array, mesh: SolidMesh, index: Integers, points: int) -> Array:
    """Mean vector (points, 3) per axis point of a printed node table with rows (node, x, y, z)."""
    order = np.argsort(table[:, 0])
    axis_rows = np.searchsorted(table[order, 0], mesh.node_sets["axis"] + 1)
    values = table[order][axis_rows, 1:4]
    count = np.bincount(index, minlength=points)
    return np.stack(
        [np.bincount(index, values[:, k], minlength=points) / count for k in range(3)], axis=-1
    )


def coil_gaps(
    spring: SpringDefinition,
    coil: Array,
    positions: Array,
    pairs: Array,
    contact: SolidContact | None,
) -> Array:
    """Smallest gap (state, pair) in m over the wire of each pair between the wire and the turn
    below it.
    """
    from scipy.interpolate import CubicSpline

    gaps = np.zeros((len(positions), len(pairs)))
    if contact is None or not len(pairs):
        return gaps
    half, around = contact.wire_per_pair / 2, np.linspace(-0.1, 0.1, 81)
    for state, position in enumerate(positions):
        axis = CubicSpline(coil, position)
        for number, middle in enumerate(pairs):
            upper = np.linspace(middle - half, middle + half, 33)
            below = np.clip(upper[:, None] - 1 + around, coil[0], coil[-1])
            distance = np.linalg.norm(axis(upper)[:, None] - axis(below), axis=-1)
            wire = (
                spring.wire_diameter.value(upper)[:, None] + spring.wire_diameter.value(below)
            ) / 2
            gaps[state, number] = float(np.min(distance - wire))
    return gaps


def estimated_rate(spring: SpringDefinition) -> float:
    """Rate (N/m) of the free wire by elementary theory, 1/k = integral of 64 R^3 / (G d^4) over the
    turns.
    """
    first, last = spring.free_coils
    coil = np.linspace(first, last, 4001)
    compliance = (
        8
        * spring.mean_diameter.value(coil) ** 3
        / (spring.material.shear_modulus * spring.wire_diameter.value(coil) ** 4)
    )
    return float(1 / np.trapezoid(compliance, coil))
