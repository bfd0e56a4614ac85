"""What a reduced rod shows along its wire: heights and section loads at the wire points, at rest and by
its coordinates. Loads are those of the rod to first order about rest, where it is exact.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from valvetrain.arrays import Array
from valvetrain.cosserat.condensed import CondensedRod, position_slots, rotation_slots
from valvetrain.cosserat.mesh import RodMesh
from valvetrain.cosserat.state import RodState, advance
from valvetrain.cosserat.static import RodStatics
from valvetrain.springs.finite_element_channels import (
    SECTION_LOADS,
    interpolation,
    section_interpolation,
    section_vectors,
    wire_points,
)

#: Largest displacement (m) of the differences that give slopes.
DIFFERENCE = 1e-7


class WireTables(NamedTuple):
    """Over f fine and c coarse lifts, n wire points: ``height`` (f, n) and ``load`` (f, 6, n) at rest,
    ``axial_shape`` (c, n, m) and ``load_shape`` (c, 6, n, m) by the coordinates. Loads are three
    moments (N m) and three forces (N) in the section's axes.
    """

    height: Array
    load: Array
    axial_shape: Array
    load_shape: Array


def wire_tables(
    bare: RodStatics,
    path: Sequence[RodState],
    lifts: Sequence[tuple[RodState, CondensedRod]],
    shapes: Sequence[Array],
    total_coils: float,
) -> WireTables:
    """Tables at :func:`wire_points` of a wire of ``total_coils``: ``path`` holds the fine, ``lifts`` the
    coarse equilibria with the condensed rod, ``shapes`` (n, m) displacements of its free vertices.
    """
    mesh = bare.mesh
    coil = wire_points(total_coils)
    at, on_wire = interpolation(mesh.coil_number, coil), section_interpolation(mesh, coil)
    axial = np.zeros((len(shapes), mesh.vertices, shapes[0].shape[1]))
    axial[:, mesh.first + 1 : mesh.last] = [shape[2::3] for shape in shapes]
    return WireTables(
        np.array([state.position[:, 2] for state in path]) @ at.T,
        _loads(mesh, path) @ on_wire.T,
        at @ axial,
        np.array(
            [
                _by_coordinates(bare, *lift, shape, on_wire)
                for lift, shape in zip(lifts, shapes, strict=True)
            ]
        ),
    )


def _loads(mesh: RodMesh, states: Sequence[RodState]) -> Array:
    """Moments and forces (states, 6, nv) on the vertices."""
    moment, force, _ = section_vectors(
        mesh,
        np.array([state.position for state in states]),
        np.array([state.frame for state in states]),
    )
    return np.concatenate((moment, force), axis=2).transpose(0, 2, 1)


def _by_coordinates(
    bare: RodStatics, state: RodState, wire: CondensedRod, shape: Array, on_wire: Array
) -> Array:
    change = np.zeros((6 * bare.mesh.vertices, shape.shape[1]))
    change[position_slots(bare.mesh)] = shape
    change[rotation_slots(bare)] = wire.turning @ shape
    size = DIFFERENCE / np.max(np.abs(shape), axis=0)
    ends = [
        _loads(
            bare.mesh, [advance(state, sign * one, state.compression) for one in (change * size).T]
        )
        for sign in (1, -1)
    ]
    slope = (ends[0] - ends[1]) / (2 * size[:, None, None]) @ on_wire.T
    return np.ascontiguousarray(slope.transpose(1, 2, 0))


def section_loads(loads: Array) -> Mapping[str, Array]:
    """Section loads (n,) by the names of their channels, from three moments and forces (6, n)."""
    bending, binormal, torsion, across, along, normal = loads
    values = (torsion, bending, binormal, normal, np.hypot(across, along))
    return dict(zip(SECTION_LOADS, values, strict=True))
