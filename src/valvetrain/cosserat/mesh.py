"""The rod's discrete wire: positions at vertices, material frames on edges, true arc lengths
throughout.

Vertex ``i`` is between edge ``i`` and edge ``i + 1``. The wire is elastic between vertices
``first`` and ``last``;
edges ``first`` and ``last + 1`` hold the clamp frames. Vertices outside belong to the fixed ends
(contact only).
Staggered grid after Lang, Linn and Arnold (2011), with the arc length in place of the chord.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Protocol

import numpy as np

from valvetrain.arrays import Array
from valvetrain.cosserat import quaternion as quat
from valvetrain.cosserat.contact_line import ContactLine, no_contact, pair_coils
from valvetrain.cosserat.guide import GuideWalls
from valvetrain.cosserat.section import Section, round_section
from valvetrain.errors import InputError
from valvetrain.parameters.spring import SpringDefinition

#: Most vertices the compiled kernels can hold (the row stride of their state buffer).
MAXIMUM_VERTICES = 1536


@dataclass(frozen=True)
class RodMesh:
    """Flat description of a rod in its stress-free state; nv vertices, ne = nv + 1 edge slots, SI
    units.

    ``stretch_stiffness`` (ne, 3) = kappa G A, kappa G A, E A; ``bend_stiffness`` (nv, 3) = E I, E
    I, G J per length of
    the dual cell; ``rest_stretch`` (ne, 3) and ``rest_bend`` (nv, 3) are the strains of the free
    wire.
    """

    coil_number: Array
    first: int
    last: int
    position: Array
    frame: Array
    edge_length: Array
    node_length: Array
    stretch_stiffness: Array
    bend_stiffness: Array
    rest_stretch: Array
    rest_bend: Array
    node_mass: Array
    edge_inertia: Array
    wire_diameter: Array
    contact: ContactLine
    lower_seat_limit: Array
    upper_seat_limit: Array
    guide: GuideWalls | None = None

    @property
    def vertices(self) -> int:
        """Number of vertices, the fixed ones included."""
        return len(self.position)

    @property
    def elements(self) -> int:
        """Number of elastic elements (edges)."""
        return self.last - self.first


class WireCurve(Protocol):
    """A smooth wire over a ``parameter`` (n,): input of :func:`mesh_curve`; lengths in m."""

    def position(self, parameter: Array) -> Array:
        """Points (n, 3) of the wire axis."""
        ...

    def directors(self, parameter: Array) -> tuple[Array, Array, Array]:
        """Three unit vectors (n, 3), right-handed, the last along the wire."""
        ...

    def line_speed(self, parameter: Array) -> Array:
        """Arc length per unit of the parameter (n,)."""
        ...

    def section(self, parameter: Array, curvature_correction: bool) -> tuple[Section, Array]:
        """Section stiffness and wire diameter (n,)."""
        ...


@lru_cache(maxsize=16)
def mesh_spring(
    definition: SpringDefinition,
    elements_per_coil: int = 24,
    *,
    curvature_correction: bool = True,
    contact: bool = True,
) -> RodMesh:
    """Mesh the free wire of a spring uniformly over the coil number, fixed ends continued on the
    same grid to just past the tips.

    Raises :class:`InputError` for fewer than 6 elements per coil or more vertices than the kernels
    hold.
    """
    if elements_per_coil != int(elements_per_coil):
        raise InputError(
            f"elements_per_coil is {elements_per_coil:g}; give a whole number, 24 is typical"
        )
    if elements_per_coil < 6:
        raise InputError(
            f"{elements_per_coil} elements per coil do not describe a coil; use 8 or more"
        )
    lower, upper = definition.free_coils
    elements = max(4, round(elements_per_coil * (upper - lower)))
    step = (upper - lower) / elements
    # The grid runs past both wire tips, so that the contact line reaches them on every mesh.
    below, above = (
        int(np.ceil(held / step - 1e-9)) + 1 for held in (lower, definition.total_coils - upper)
    )
    coil = np.asarray(lower + step * np.arange(-below, elements + above + 1), dtype=np.float64)
    if len(coil) + 2 > MAXIMUM_VERTICES:
        raise InputError(
            f"{len(coil)} vertices exceed the {MAXIMUM_VERTICES} that the rod holds; use fewer elements per coil"
        )
    mesh = mesh_curve(
        _WireCurve(definition),
        coil,
        below,
        below + elements,
        curvature_correction=curvature_correction,
    )
    lower_limit, upper_limit = _seat_limits(definition, mesh)
    line = no_contact(mesh.vertices)
    if contact:
        length = definition.line_speed(coil)
        line = pair_coils(
            coil,
            mesh.position,
            mesh.wire_diameter,
            length,
            definition.total_coils,
            definition.centreline,
        )
    return replace(mesh, contact=line, lower_seat_limit=lower_limit, upper_seat_limit=upper_limit)


@dataclass(frozen=True)
class _WireCurve:
    """Position, directors, arc length and section along the wire of a spring definition."""

    definition: SpringDefinition

    def position(self, coil: Array) -> Array:
        return self.definition.centreline(coil)

    def directors(self, coil: Array) -> tuple[Array, Array, Array]:
        spring, angle = self.definition, 2 * np.pi * coil
        sign = 1.0 if spring.hand == "right" else -1.0
        radius, growth = (
            spring.mean_diameter.value(coil) / 2,
            spring.mean_diameter.derivative(coil) / 2,
        )
        radial = np.stack([np.cos(angle), sign * np.sin(angle), np.zeros_like(angle)], axis=-1)
        around = (
            2
            * np.pi
            * np.stack([-np.sin(angle), sign * np.cos(angle), np.zeros_like(angle)], axis=-1)
        )
        tangent = radius[:, None] * around + growth[:, None] * radial
        tangent[:, 2] = spring.pitch.value(coil)
        tangent /= np.linalg.norm(tangent, axis=1)[:, None]
        outward = radial - np.sum(radial * tangent, axis=1)[:, None] * tangent
        outward /= np.linalg.norm(outward, axis=1)[:, None]
        return outward, np.cross(tangent, outward), tangent

    def line_speed(self, coil: Array) -> Array:
        return self.definition.line_speed(coil)

    def section(self, coil: Array, curvature_correction: bool) -> tuple[Section, Array]:
        wire = self.definition.wire_diameter.value(coil)
        index = self.definition.mean_diameter.value(coil) / wire if curvature_correction else None
        return round_section(wire, self.definition.material, index), wire


def mesh_curve(
    curve: WireCurve, parameter: Array, first: int, last: int, *, curvature_correction: bool = False
) -> RodMesh:
    """Mesh any smooth wire: ``curve`` answers position, directors, line_speed and section at
    ``parameter`` (nv,).
    """
    vertices = len(parameter)
    step = parameter[1] - parameter[0]
    middle = np.concatenate(([parameter[0] - step / 2], parameter + step / 2))
    middle[first], middle[last + 1] = parameter[first], parameter[last]
    frame = quat.from_directors(*curve.directors(middle))
    frame[:first], frame[last + 2 :] = frame[first], frame[last + 1]
    position = curve.position(parameter)

    edge_length, node_length = np.zeros(vertices + 1), np.zeros(vertices)
    edge_length[1:-1] = _arc_length(curve, parameter[:-1], parameter[1:])
    before, after = (
        _arc_length(curve, parameter - step / 2, parameter),
        _arc_length(curve, parameter, parameter + step / 2),
    )
    node_length[:] = before + after
    node_length[first], node_length[last] = after[first], before[last]

    edges, wire = (
        curve.section(middle, curvature_correction)[0],
        curve.section(parameter, curvature_correction),
    )
    nodes, wire_diameter = wire
    stretch, bend, mass, inertia = _stiffness_arrays(
        edges, nodes, edge_length, node_length, first, last
    )
    # In-plane bending is weakened by cos^2 of half the angle per element in the measure 2 vec(q);
    # undo it.
    scalar, vector = quat.relative_vector(frame[:-1], frame[1:])
    bend[:, 1] /= np.where(scalar > 0.1, scalar, 1.0) ** 2
    rest_stretch = np.zeros((vertices + 1, 3))
    chord = np.diff(position, axis=0) / edge_length[1:-1, None]
    rest_stretch[1:-1] = np.einsum("nji,nj->ni", quat.to_matrix(frame[1:-1]), chord)
    return RodMesh(
        coil_number=parameter,
        first=first,
        last=last,
        position=position,
        frame=frame,
        edge_length=edge_length,
        node_length=node_length,
        stretch_stiffness=stretch,
        bend_stiffness=bend,
        rest_stretch=rest_stretch,
        rest_bend=2 * vector,
        node_mass=mass,
        edge_inertia=inertia,
        wire_diameter=wire_diameter,
        contact=no_contact(vertices),
        lower_seat_limit=np.full(vertices, -np.inf),
        upper_seat_limit=np.full(vertices, np.inf),
    )


def _stiffness_arrays(
    edges: Section, nodes: Section, edge_length: Array, node_length: Array, first: int, last: int
) -> tuple[Array, Array, Array, Array]:
    vertices = len(node_length)
    stretch = np.stack([edges.shear, edges.shear, edges.tension], axis=1)
    bend = np.stack([nodes.bending, nodes.bending, nodes.torsion], axis=1) / node_length[:, None]
    inertia = (
        np.stack([edges.bending_inertia, edges.bending_inertia, edges.torsion_inertia], axis=1)
        * edge_length[:, None]
    )
    outside_edge = (np.arange(vertices + 1) <= first) | (np.arange(vertices + 1) > last)
    outside_node = (np.arange(vertices) < first) | (np.arange(vertices) > last)
    stretch[outside_edge], inertia[outside_edge], bend[outside_node] = 0.0, 0.0, 0.0
    return stretch, bend, nodes.mass * node_length, inertia


def _arc_length(curve: WireCurve, start: Array, end: Array) -> Array:
    nodes, weights = np.polynomial.legendre.leggauss(3)
    points = start[:, None] + (end - start)[:, None] * (nodes + 1) / 2
    speed = curve.line_speed(points.ravel()).reshape(points.shape)
    return (end - start) / 2 * (speed @ weights)


def _seat_limits(definition: SpringDefinition, mesh: RodMesh) -> tuple[Array, Array]:
    """Lowest and highest height of the wire axis that the seat planes allow, never below the free
    state.

    Seats meet the coils next to the ends, and all that telescope; others rest on their neighbour
    before they reach the seat. The coils
    next to an open end, which is fixed at its tip alone, touch no plane.
    """
    height, radius = mesh.position[:, 2], mesh.wire_diameter / 2
    lower, upper = np.full(mesh.vertices, -np.inf), np.full(mesh.vertices, np.inf)
    index, near = np.arange(mesh.vertices), 1.5
    bottom = (index > mesh.first) & (mesh.coil_number < definition.free_coils[0] + near)
    top = (index < mesh.last) & (mesh.coil_number > definition.free_coils[1] - near)
    bottom &= definition.lower_end.kind != "open"
    top &= definition.upper_end.kind != "open"
    bottom |= (index > mesh.first) & (index < mesh.last) & definition.telescopes(mesh.coil_number)
    top |= (
        (index > mesh.first) & (index < mesh.last) & definition.telescopes(mesh.coil_number + 1.0)
    )
    lower[bottom] = np.minimum(definition.lower_seat_height + radius, height)[bottom]
    upper[top] = np.maximum(definition.upper_seat_height - radius, height)[top]
    return lower, upper
