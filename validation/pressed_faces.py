"""Contact of the outer faces of bricks with a plane or with the faces of another body: a pressure at
Gauss points of each face, proportional to how deep they are in the other.

Faces are flat between nodes on a round surface: ``sag`` is the height of that surface over
the middle of a face, and counts as part of it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Places of the four corners of a face, anticlockwise seen from outside.
_CORNERS = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=float)
#: Faces nearest to a point that are tried, Newton steps of its foot, and how far beyond its edges a
#: face reaches (of half its width).
NEAREST, FOOT_STEPS, REACH = 4, 4, 1e-3


@dataclass(frozen=True, eq=False)
class Faces:
    """``corners`` (f, 4, 3): places of the coordinates of each face's corners in a flat position,
    anticlockwise seen from outside; ``sag`` (f, 2) in m of the true surface along its first and its
    second edge.
    """

    corners: Integers
    sag: Array

    def at(self, position: Array, local: Array) -> tuple[Array, Array, Array]:
        """Points (f, g, 3) in m at ``local`` (f or 1, g, 2) places in [-1, 1]; outward normals (f, g, 3)
        whose length is the area (m2) per unit of local area; weights of the corners (f, g, 4).
        """
        own = position[self.corners]
        reach = 1 + local[..., None, :] * _CORNERS
        shape = reach[..., 0] * reach[..., 1] / 4
        first = np.broadcast_to(_CORNERS[:, 0] * reach[..., 1] / 4, shape.shape)
        second = np.broadcast_to(_CORNERS[:, 1] * reach[..., 0] / 4, shape.shape)
        point, one, two = (np.einsum("fga,fak->fgk", _all(part, own), own) for part in (shape, first, second))  # fmt: skip
        return point, np.cross(one, two), _all(shape, own)

    def rise(self, local: Array) -> Array:
        """Height (m) of the true surface over the faces at ``local`` (f or 1, g, 2)."""
        found: Array = np.einsum("fgk,fk->fg", _all(1 - local**2, self.sag), self.sag)
        return found

    def shifted(self, places: int) -> Faces:
        """The faces of a body whose flat position begins at ``places`` of a longer one."""
        return replace(self, corners=self.corners + places)


def _all(part: Array, faces: Array) -> Array:
    """``part`` (f or 1, ...) for every face."""
    found: Array = np.broadcast_to(part, (len(faces), *part.shape[1:]))
    return found


def side_faces(
    edges: Integers, stations: int, *, reverse: bool = False, sag: Array | None = None
) -> Faces:
    """Faces between neighbouring stations over ``edges`` (e, 2) of section nodes, anticlockwise round
    the section; ``reverse`` as in :func:`~valvetrain.continuum.bricks.sweep_bricks`. ``sag`` (e, 2)
    in m along the wire and across it.
    """
    span = np.arange(stations - 1)
    one, two = (3 * edges[:, side, None] * stations + span for side in (0, 1))
    order = (one, one + 1, two + 1, two) if reverse else (one, two, two + 1, one + 1)
    corners = np.stack(order, axis=-1).reshape(-1, 4)
    across = np.zeros((len(edges), 2)) if sag is None else sag
    across = across if reverse else across[:, ::-1]
    places = corners[..., None] + stations * np.arange(3)
    return Faces(places, np.repeat(across, stations - 1, axis=0))


class Plane(NamedTuple):
    """A rigid plane with the outward unit ``normal`` (3,) through the ``level`` (m) along it."""

    normal: Array
    level: float


class Pressed(NamedTuple):
    """Of every Gauss point (n,): ``pressure`` (Pa), ``gap`` (m, negative where it presses), ``area``
    (m2), ``place`` (n, 3) in m and ``normal`` (n, 3) of the other body; ``force`` (N) on all
    unknowns, stored ``energy`` (J) and ``tangent`` (N/m) of the pressed points.
    """

    pressure: Array
    gap: Array
    area: Array
    place: Array
    normal: Array
    force: Array
    energy: float
    tangent: sparse.csr_matrix


@dataclass(frozen=True, eq=False)
class FaceContact:
    """``faces`` pressed on ``other`` with ``stiffness`` (Pa per m of depth), ``order`` x ``order`` Gauss
    points a face. The faces' own body is the finer one.
    """

    faces: Faces
    other: Faces | Plane
    stiffness: float
    order: int = 2

    def pressed(self, position: Array) -> Pressed:
        """The contact at a flat position (m) of all bodies."""
        place, weight = np.polynomial.legendre.leggauss(self.order)
        local = np.stack(np.meshgrid(place, place, indexing="ij"), axis=-1).reshape(1, -1, 2)
        area_weight = np.outer(weight, weight).ravel()
        point, outward, shape = self.faces.at(position, local)
        size = np.linalg.norm(outward, axis=-1)
        area = (size * area_weight).ravel()
        # the true surface is outside the face
        risen = point + (self.faces.rise(local) / size)[..., None] * outward
        risen, shape = risen.reshape(-1, 3), shape.reshape(-1, 4)
        corners = np.repeat(self.faces.corners, local.shape[1], axis=0)
        if isinstance(self.other, Plane):
            normal = np.broadcast_to(self.other.normal, risen.shape)
            gap = risen @ self.other.normal - self.other.level
            below = np.zeros((len(gap), 0)), np.zeros((len(gap), 0, 3), dtype=np.int64)
        else:
            gap, normal, below = _feet(self.other, position, risen)
        return _response(self.stiffness, gap, area, risen, normal, (shape, corners), below, len(position))  # fmt: skip


def _response(
    stiffness: float,
    gap: Array,
    area: Array,
    place: Array,
    normal: Array,
    own: tuple[Array, Integers],
    below: tuple[Array, Integers],
    size: int,
) -> Pressed:
    depth = np.maximum(-gap, 0.0)
    pressure, on = stiffness * depth, depth > 0
    weight = np.concatenate([own[0], -below[0]], axis=1)[on]
    width = 3 * weight.shape[1]
    rate = (weight[..., None] * normal[on][:, None]).reshape(-1, width)
    where = np.concatenate([own[1], below[1]], axis=1)[on].reshape(-1, width)
    force = np.zeros(size)
    np.add.at(force, where, (pressure * area)[on, None] * rate)
    values = (stiffness * area[on])[:, None, None] * rate[:, :, None] * rate[:, None, :]
    rows, columns = np.broadcast_arrays(where[:, :, None], where[:, None, :])
    tangent = sparse.csr_matrix((values.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size))  # fmt: skip
    energy = 0.5 * stiffness * float(np.sum(area * depth**2))
    return Pressed(pressure, gap, area, place, normal, force, energy, tangent)


def _feet(
    faces: Faces, position: Array, point: Array
) -> tuple[Array, Array, tuple[Array, Integers]]:
    """Gap (n,) of points from the nearest of ``faces`` (infinite outside all of them), normals (n, 3), and
    the corners' weights (n, 4) and places (n, 4, 3).
    """
    middle = position[faces.corners].mean(axis=1)
    near = cKDTree(middle).query(point, k=min(NEAREST, len(middle)))[1].reshape(len(point), -1)
    found = np.full(len(point), np.inf)
    normal, shape = np.zeros((len(point), 3)), np.zeros((len(point), 4))
    chosen = np.zeros(len(point), dtype=np.int64)
    for candidate in near.T:
        few = Faces(faces.corners[candidate], faces.sag[candidate])
        local = np.zeros((len(point), 1, 2))
        own = position[few.corners]
        for _ in range(FOOT_STEPS):
            here, _, weights = few.at(position, local)
            apart = point - here[:, 0]
            reach = 1 + local[:, 0, None, :] * _CORNERS
            slopes = np.stack([_CORNERS[:, 0] * reach[..., 1], _CORNERS[:, 1] * reach[..., 0]], axis=1) / 4  # fmt: skip
            tangents = np.einsum("nia,nak->nik", slopes, own)
            square = np.einsum("nik,njk->nij", tangents, tangents)
            step = np.linalg.solve(square, np.einsum("nik,nk->ni", tangents, apart)[..., None])
            local = np.clip(local + step[:, None, :, 0], -3.0, 3.0)
        here, outward, weights = few.at(position, local)
        outward = outward[:, 0] / np.linalg.norm(outward[:, 0], axis=1, keepdims=True)
        gap = np.sum((point - here[:, 0]) * outward, axis=1) - few.rise(local)[:, 0]
        over = np.all(np.abs(local[:, 0]) <= 1 + REACH, axis=1)
        better = over & (np.abs(gap) < np.abs(found))
        found[better], chosen[better] = gap[better], candidate[better]
        normal[better], shape[better] = outward[better], weights[better, 0]
    return found, normal, (shape, faces.corners[chosen])


def end_faces(quads: Integers, stations: int, station: int, *, reverse: bool = False) -> Faces:
    """The faces of section ``quads`` (q, 4) at one ``station``; ``reverse`` where their first edge crossed
    with the second points into the body.
    """
    corners = 3 * (quads[:, ::-1] if reverse else quads) * stations + station
    return Faces(corners[..., None] + stations * np.arange(3), np.zeros((len(quads), 2)))
