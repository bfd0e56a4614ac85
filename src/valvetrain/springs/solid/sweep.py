"""Sweeps the meshed section along the wire axis of a spring definition."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from valvetrain.parameters.spring import SpringDefinition
from valvetrain.springs.solid.grinding import ground_section
from valvetrain.springs.solid.layout import MeshOptions, layer_coils
from valvetrain.springs.solid.mesh import FaceSet, SolidMesh
from valvetrain.springs.solid.section import SectionMesh, disc_section

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

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
