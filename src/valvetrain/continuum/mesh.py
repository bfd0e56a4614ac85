"""The solid mesh of a spring: plain arrays with named sets, independent of any solver."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from valvetrain.arrays import Array, Ints
from valvetrain.continuum.section import SectionMesh, disc_section, ground_section
from valvetrain.errors import InputError
from valvetrain.parameters.spring import SpringDefinition

Integers = Ints


@dataclass(frozen=True)
class FaceSet:
    """Outer faces of the wire: element numbers (from 0) and their coil number; every face is side 4
    of its element.
    """

    elements: Integers
    coil: Array

    def between(self, first: float, last: float) -> FaceSet:
        """The faces whose middle is at first <= coil number < last."""
        inside = (self.coil >= first) & (self.coil < last)
        return FaceSet(self.elements[inside], self.coil[inside])


@dataclass(frozen=True)
class SolidMesh:
    """Hexahedra of a swept wire.

    ``coordinates`` (n, 3) in m; ``elements`` (m, 20 or 8) numbered from 0; ``coil`` (n,) coil
    number of each node;
    ``section`` (n, 2) its place in the unit disc (x outward, y up); ``lower`` and ``upper`` faces
    of the wire that can
    meet a neighbouring coil; ``node_sets``: ``seat`` and ``retainer`` (bonded to the seats) and
    whatever a caller adds.
    """

    coordinates: Array
    elements: Integers
    coil: Array
    section: Array
    lower: FaceSet
    upper: FaceSet
    node_sets: Mapping[str, Integers] = field(default_factory=dict)

    @property
    def quadratic(self) -> bool:
        """True for twenty-node elements, whose edges follow the wire."""
        return bool(self.elements.shape[1] == 20)

    @property
    def unknowns(self) -> int:
        """Displacement components of nodes that are not bonded."""
        bonded = set(self.node_sets["seat"]) | set(self.node_sets["retainer"])
        return 3 * (len(self.coordinates) - len(bonded))

    def fibre(self, x: float, y: float) -> Integers:
        """Nodes along the wire nearest to section place (x, y), ordered by coil number; (-1, 0) is
        the inner fibre.
        """
        distance = np.hypot(self.section[:, 0] - x, self.section[:, 1] - y)
        nodes = np.flatnonzero(distance < distance.min() + 1e-6)
        return nodes[np.argsort(self.coil[nodes])]


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


def jacobian_determinants(coordinates: Array, elements: Ints, points: Array) -> Array:
    """Determinants (elements, points) of the map from the reference cube; positive everywhere in a
    usable mesh.
    """
    gradients = shape_gradients(points, elements.shape[1])
    jacobians = np.einsum("pna,enb->epab", gradients, coordinates[elements])
    found: Array = np.linalg.det(jacobians)
    return found


def volume(coordinates: Array, elements: Ints) -> float:
    """Volume (m3 for coordinates in m) of all elements by 3 x 3 x 3 Gauss points."""
    points, weights = gauss_points(3)
    return float(np.sum(jacobian_determinants(coordinates, elements, points) @ weights))


EndTreatment = Literal["sections", "bonded", "ground"]
ELEMENT_TYPES = {"C3D20R": 20, "C3D20": 20, "C3D8I": 8, "C3D8": 8, "C3D8R": 8}

#: Turns over which the refinement towards a clamp fades.
END_REFINEMENT_LENGTH = 0.08


@dataclass(frozen=True)
class MeshOptions:
    """Mesh of the wire.

    ``elements_per_coil`` along the wire; ``core`` x ``core`` cells and ``rings`` rings over the
    section;
    ``element_type`` of CalculiX; ``end_refinement`` shortens elements at the clamps by this factor.
    ``ends``: ``sections`` meshes only the free wire and clamps its two end sections; ``bonded``
    meshes the whole wire and
    bonds every node of the inactive turns to its seat; ``ground`` cuts the end turns flat at the
    seat planes and bonds the
    cut faces over the inactive turns (the wire above a bonded face stays elastic).
    """

    elements_per_coil: int = 24
    core: int = 2
    rings: int = 1
    element_type: str = "C3D20R"
    end_refinement: float = 1.0
    ends: EndTreatment = "sections"

    def __post_init__(self) -> None:
        if self.element_type not in ELEMENT_TYPES:
            raise InputError(
                f"solid element '{self.element_type}' is not supported; use one of {', '.join(ELEMENT_TYPES)}"
            )
        if self.elements_per_coil < 4:
            raise InputError(
                f"{self.elements_per_coil} elements per coil cannot follow a helix; give at least 4"
            )
        if self.end_refinement < 1:
            raise InputError(
                f"end_refinement {self.end_refinement} would coarsen the ends; give 1 or more"
            )
        if self.ends not in ("sections", "bonded", "ground"):
            raise InputError(
                f"end treatment '{self.ends}' is unknown; use sections, bonded or ground"
            )

    @property
    def quadratic(self) -> bool:
        """True for twenty-node elements, whose edges follow the wire."""
        return ELEMENT_TYPES[self.element_type] == 20


def layer_coils(spring: SpringDefinition, options: MeshOptions) -> Array:
    """Coil numbers of the element boundaries along the wire, increasing; always holds both ends of
    the free wire.
    """
    first, last = spring.free_coils
    free = _graded(first, last, options)
    if options.ends == "sections":
        return free
    below = _even(0.0, first, options.elements_per_coil)
    above = _even(last, spring.total_coils, options.elements_per_coil)
    return np.concatenate([below[:-1], free, above[1:]])


def _even(first: float, last: float, per_coil: int) -> Array:
    if last - first < 1e-9:
        return np.array([first])
    return np.linspace(first, last, max(1, round((last - first) * per_coil)) + 1)


def _graded(first: float, last: float, options: MeshOptions) -> Array:
    """Boundaries from first to last with a density that rises towards both ends."""
    fine = np.linspace(first, last, 20001)
    rise = options.end_refinement - 1
    density = options.elements_per_coil * (
        1
        + rise
        * (
            np.exp(-(fine - first) / END_REFINEMENT_LENGTH)
            + np.exp(-(last - fine) / END_REFINEMENT_LENGTH)
        )
    )
    count = np.concatenate(([0.0], np.cumsum(np.diff(fine) * (density[1:] + density[:-1]) / 2)))
    number = max(2, round(float(count[-1])))
    layers = np.interp(np.linspace(0, count[-1], number + 1), count, fine)
    layers[0], layers[-1] = first, last
    return layers


#: Faces within this angle of the top or bottom of the section can meet a neighbouring coil.
CONTACT_ZONE = np.radians(70.0)


def section_frames(spring: SpringDefinition, coil: Array) -> tuple[Array, Array]:
    """Outward and upward section axes (n, 3) at right angles to the wire axis at coil numbers
    ``coil``.
    """
    angle = 2 * np.pi * coil
    hand = 1.0 if spring.hand == "right" else -1.0
    radius, growth = spring.mean_diameter.value(coil) / 2, spring.mean_diameter.derivative(coil) / 2
    radial = np.stack([np.cos(angle), hand * np.sin(angle), np.zeros_like(angle)], axis=-1)
    around = np.stack([-np.sin(angle), hand * np.cos(angle), np.zeros_like(angle)], axis=-1)
    tangent = radial * growth[:, None] + around * (2 * np.pi * radius)[:, None]
    tangent[:, 2] = spring.pitch.value(coil)
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    outward = radial - tangent * np.sum(radial * tangent, axis=-1, keepdims=True)
    outward /= np.linalg.norm(outward, axis=-1, keepdims=True)
    upward = hand * np.cross(outward, tangent)
    return outward, upward


def sweep_spring(spring: SpringDefinition, options: MeshOptions | None = None) -> SolidMesh:
    """Mesh of the wire of ``spring``. Raises :class:`InputError` for options that make no mesh."""
    options = options or MeshOptions()
    section = disc_section(options.core, options.rings, options.quadratic)
    layers = layer_coils(spring, options)
    stations = np.sort(np.concatenate([layers, (layers[1:] + layers[:-1]) / 2]))
    outward, upward = section_frames(spring, stations)
    centre, radius = spring.centreline(stations), spring.wire_diameter.value(stations) / 2
    place = np.repeat(section.nodes[None], len(stations), axis=0)
    if options.ends == "ground":
        place = np.stack(
            [
                ground_section(spring, u, up[2], section)
                for u, up in zip(stations, upward, strict=True)
            ]
        )
    scaled = place * radius[:, None, None]
    grid = centre[:, None] + scaled[..., :1] * outward[:, None] + scaled[..., 1:] * upward[:, None]
    elements = connect_sections(section, len(layers) - 1, reverse=spring.hand == "right")
    if not options.quadratic:
        elements = elements[:, :8]
    return _finish(spring, options, section, layers, stations, grid, elements)


def connect_sections(section: SectionMesh, spans: int, reverse: bool) -> Integers:
    """Twenty-node elements, span after span; nodes are numbered station * section nodes + section
    node.
    """
    count = len(section.nodes)
    corners, middles = section.quads[:, :4], section.quads[:, 4:]
    # x (outward) cross y (up) runs against a right-handed wire, so there the bottom face is the
    # farther one.
    bottom, top = (2, 0) if reverse else (0, 2)
    blocks = []
    for span in range(spans):
        base, middle, lid = ((2 * span + step) * count for step in (bottom, 1, top))
        blocks.append(
            np.hstack(
                [corners + base, corners + lid, middles + base, middles + lid, corners + middle]
            )
        )
    return np.vstack(blocks)


def _finish(
    spring: SpringDefinition,
    options: MeshOptions,
    section: SectionMesh,
    layers: Array,
    stations: Array,
    grid: Array,
    elements: Integers,
) -> SolidMesh:
    used = np.unique(elements)
    number = np.full(grid.shape[0] * grid.shape[1], -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    coil = np.repeat(stations, len(section.nodes))[used]
    place = np.tile(section.nodes, (len(stations), 1))[used]
    middle = (layers[1:] + layers[:-1]) / 2
    lower, upper = (_contact_faces(section, middle, side) for side in (-1.0, 1.0))
    coordinates = grid.reshape(-1, 3)[used]
    sets = _bonded(spring, options, coordinates, coil)
    return SolidMesh(coordinates, number[elements], coil, place, lower, upper, sets)


def _contact_faces(section: SectionMesh, middle: Array, side: float) -> FaceSet:
    turned = np.abs(np.angle(np.exp(1j * (section.rim_angles - side * np.pi / 2))))
    quads = section.rim_quads[turned <= CONTACT_ZONE]
    elements = (np.arange(len(middle))[:, None] * len(section.quads) + quads[None]).ravel()
    return FaceSet(elements, np.repeat(middle, len(quads)))


def _bonded(
    spring: SpringDefinition, options: MeshOptions, coordinates: Array, coil: Array
) -> dict[str, Integers]:
    first, last = spring.free_coils
    low, high = coil <= first + 1e-9, coil >= last - 1e-9
    if options.ends == "ground":
        slack = 1e-6 * float(spring.wire_diameter.value(0.0))
        low = (coil <= max(first, 0.0) + 1e-9) & (
            coordinates[:, 2] <= spring.lower_seat_height + slack
        )
        high = (coil >= last - 1e-9) & (coordinates[:, 2] >= spring.upper_seat_height - slack)
    return {"seat": np.flatnonzero(low), "retainer": np.flatnonzero(high)}
