"""Bodies of bricks pressed and struck together by their faces: wires across and along one another, a
ring on a plane, blocks, bars. What comes out is set against Hertz and the closed forms of impact.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from validation.pressed_faces import (
    FaceContact,
    Faces,
    Plane,
    Pressed,
    end_faces,
    side_faces,
)
from valvetrain.coil_contact.line_contact import line_contact
from valvetrain.continuum.bricks import Bricks, sweep_bricks
from valvetrain.continuum.section import disc_section
from valvetrain.parameters.material import Material

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Radius of the arcs at which the mesh of a section ends next to the two lines, over the half width.
END = 0.01
#: Depth to which contact gives way, over the approach of the bodies.
GIVE = 1 / 500
#: Of crossed wires: even bricks reach so far along and below the surface, and the mesh so far (half
#: widths); growth between.
EVEN, FAR, GROWTH = (1.2, 0.4), 8.0, 1.4


class Body(NamedTuple):
    """Bricks, their ``position`` (nodes, 3, stations) in m, whether they are ``reverse``."""

    bricks: Bricks
    position: Array
    reverse: bool

    @property
    def mass(self) -> Array:
        """Mass (kg) of every unknown of the flat position."""
        return np.repeat(self.bricks.mass[:, None, :], 3, axis=1).ravel()

    def stiffness(self) -> sparse.csr_matrix:
        """Stiffness (N/m) of the undeformed body."""
        elements, places = self.bricks.tangent(self.position)
        rows, columns = np.broadcast_arrays(places[:, :, None], places[:, None, :])
        entries = (elements.ravel(), (rows.ravel(), columns.ravel()))
        return sparse.csr_matrix(entries, shape=(self.position.size, self.position.size))


def swept(grid: Array, quads: Integers, material: Material) -> Body:
    """A body over the sections ``grid`` (stations, nodes, 3) in m, whichever way these turn."""
    first, second, fourth = (grid[0, quads[0, corner]] for corner in (0, 1, 3))
    along = np.cross(second - first, fourth - first) @ (grid[1] - grid[0]).mean(axis=0)
    bricks = sweep_bricks(grid, quads, material, reverse=bool(along < 0))
    return Body(bricks, np.ascontiguousarray(grid.transpose(1, 2, 0)), bool(along < 0))


def settle(
    stiffness: sparse.csr_matrix,
    contacts: Sequence[FaceContact],
    position: Array,
    start: Array,
    free: NDArray[np.bool_],
    motion: sparse.csr_matrix,
) -> tuple[Array, list[Pressed]]:
    """Equilibrium of linear bodies in contact: unknowns u from ``start`` of which ``free`` ones are solved for,
    the flat ``position`` (m) moved by ``motion`` u; and the contacts.
    """
    moved, inside = start.copy(), np.flatnonzero(free)
    for _ in range(30):
        pressed = [one.pressed(position + motion @ moved) for one in contacts]
        force = motion.T @ np.sum([one.force for one in pressed], axis=0)
        left = (force - stiffness @ moved)[inside]
        if np.abs(left).max() < 1e-8 * np.abs(force).max():
            return moved, pressed
        pushed = sum((one.tangent for one in pressed[1:]), pressed[0].tangent)
        whole = (stiffness + motion.T @ pushed @ motion).tocsr()[inside][:, inside]
        factor = splu(whole.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
        moved[inside] += factor.solve(left)
    raise ArithmeticError("bodies in contact find no equilibrium")


class PressedSection(NamedTuple):
    """``force`` per length (N/m) of a round section between two planes that come nearer by
    ``approach`` (m); ``half_width`` (m) of the contact and ``pressure`` (Pa) in its middle.
    """

    force: float
    approach: float
    half_width: float
    pressure: float


def pressed_section(
    wire_diameter: float,
    material: Material,
    force_per_length: float,
    ring_radius: float = np.inf,
    across: int = 16,
) -> PressedSection:
    """A wire, straight in plane strain or a ring, pressed between two planes by as much as
    ``force_per_length`` (N/m) needs by closed form; ``across`` bricks between the planes' lines.

    Bipolar coordinates: tanh maps a strip of squares onto the disc, its two ends onto the lines.
    """
    radius, due = wire_diameter / 2, line_contact(wire_diameter, material, force_per_length)
    reach = -np.log(END * due.half_width / wire_diameter)
    along = 2 * int(np.ceil(reach * across / np.pi))
    places = (
        np.linspace(-reach, reach, along + 1)[:, None]
        + 1j * np.linspace(-np.pi / 2, np.pi / 2, across + 1)[None]
    )
    disc = radius * np.tanh(places / 2)
    up, out = disc.real.ravel(), disc.imag.ravel()
    number = np.arange(disc.size).reshape(disc.shape)
    thickness, count = due.half_width, disc.size
    turn = np.array([-0.5, 0.5]) * (thickness / ring_radius)
    grid = np.zeros((2, count, 3))
    grid[:, :, 2] = up
    if np.isinf(ring_radius):
        grid[:, :, 0], grid[1, :, 1] = out, thickness
    else:
        grid[:, :, 0] = (ring_radius + out) * np.cos(turn)[:, None] - ring_radius
        grid[:, :, 1] = (ring_radius + out) * np.sin(turn)[:, None]
    body = swept(grid, _quads(number), material)
    # both faces move alike, outwards and up
    rows = np.concatenate([6 * np.arange(count) + one for one in (0, 1, 2, 3, 4, 5)])
    columns = np.concatenate([2 * np.arange(count) + one for one in (0, 0, 0, 0, 1, 1)])
    values = np.repeat([*np.cos(turn), *np.sin(turn), 1.0, 1.0], count)
    motion = sparse.csr_matrix((values, (rows, columns)), shape=(6 * count, 2 * count))
    left, right = number[:, 0], number[:, -1]
    edges = np.stack([np.append(left[1:], right[:-1]), np.append(left[:-1], right[1:])], axis=1)
    width = np.hypot(*(part[edges[:, 1]] - part[edges[:, 0]] for part in (up, out)))
    sag = np.stack([np.zeros(len(width)), width**2 / (8 * radius)], axis=1)
    faces = outside(body, edges, sag)
    stiffness = 2 * force_per_length / (np.pi * due.half_width) / (GIVE * due.approach)
    level = due.approach / 2 - radius
    planes = [Plane(np.array([0.0, 0.0, z]), level) for z in (1.0, -1.0)]
    contacts = [FaceContact(faces, plane, stiffness) for plane in planes]
    free = np.ones(2 * count, dtype=bool)
    middle = number[along // 2, across // 2]
    free[2 * middle + 1] = False
    free[2 * middle] = not np.isinf(ring_radius)
    linear = (motion.T @ body.stiffness() @ motion).tocsr()
    at_rest = np.zeros(2 * count)
    _, (below, _) = settle(linear, contacts, body.position.ravel(), at_rest, free, motion)
    carried, place = below.pressure * below.area, below.place[:, 0]
    force = float(carried.sum()) / thickness
    return PressedSection(
        force,
        due.approach,
        # the second moment of Hertz's pressure is a quarter of the square
        2 * float(np.sqrt(np.average(place**2, weights=carried))),
        _middle(below, np.abs(place), line_contact(wire_diameter, material, force).half_width),
    )


class PressedWires(NamedTuple):
    """``force`` (N) of two wires pressed together at right angles, ``approach`` (m) of what is far from
    their contact, ``pressure`` (Pa) in its middle.
    """

    force: float
    approach: float
    pressure: float


def crossed_wires(
    wire_diameter: float, material: Material, half_width: float, per: int = 5
) -> PressedWires:
    """A quarter of two wires across each other, moved as far as a contact of ``half_width`` (m) needs by
    Hertz; ``per`` bricks in the half width.

    The mesh ends :data:`FAR` half widths away, where a point force on a half space moves it.
    """
    radius = wire_diameter / 2
    shear, ratio = material.shear_modulus, material.poisson_ratio
    approach, modulus = half_width**2 / radius, shear / (1 - ratio)  # E* of two bodies
    force = 4 / 3 * modulus * half_width**3 / radius
    fine, far = half_width / per, FAR * half_width
    aside, below = (_graded(fine, even * half_width, far) for even in EVEN)
    number = np.arange(len(aside) * len(below)).reshape(len(aside), -1)
    across, deep = (part.ravel() for part in np.meshgrid(aside, below, indexing="ij"))
    height = np.sqrt(radius**2 - across**2) - radius - deep
    edges = np.stack([number[:-1, 0], number[1:, 0]], axis=1)
    width = np.hypot(*(part[edges[:, 1]] - part[edges[:, 0]] for part in (across, height)))
    sag = np.stack([np.zeros(len(width)), width**2 / (8 * radius)], axis=1)
    bodies, faces, start, held = [], [], [], []
    for axis, other, side in ((0, 1, 1.0), (1, 0, -1.0)):
        grid = np.zeros((len(aside), len(across), 3))
        grid[:, :, axis], grid[:, :, other] = aside[:, None], across
        grid[:, :, 2] = side * height
        end = np.zeros(grid.shape[:2], dtype=bool)
        end[-1] = end[:, number[-1]] = end[:, number[:, -1]] = True
        place = grid[end] * (1, 1, -side)
        own, fixed = np.zeros(grid.shape), np.repeat(end[:, :, None], 3, axis=2)
        own[:, :, 2] = side * approach / 4
        own[end] = _point_force(place, force, shear, ratio) * (1, 1, -side)
        own[end, 2] += side * approach / 2
        fixed[0, :, axis] = fixed[:, number[0], other] = True
        own[0, :, axis] = own[:, number[0], other] = 0.0
        bodies.append(swept(grid, _quads(number), material))
        faces.append(outside(bodies[-1], edges, sag))
        start.append(own)
        held.append(fixed)
    deepest = 2 * modulus * half_width / (np.pi * radius)
    found = _together(bodies, faces, deepest / (GIVE * approach), start, held)
    pushed = found.force[: bodies[0].position.size].reshape(bodies[0].position.shape)
    return PressedWires(
        -4 * float(pushed[:, 2].sum()),
        approach,
        _middle(found, np.hypot(found.place[:, 0], found.place[:, 1]), half_width),
    )


def pressed_blocks(material: Material, cells: tuple[int, int], order: int) -> float:
    """Largest deviation from its mean of the pressure between two blocks with ``cells`` along an edge,
    pressed together evenly: the patch test of contact.
    """
    edge, moved = 10e-3, 1e-7
    bodies, faces, held, start = [], [], [], []
    for count, begin in zip(cells, (0.0, edge), strict=True):
        along, touching = np.linspace(0.0, edge, count + 1), 0 if begin else 3
        number = np.arange((count + 1) ** 2).reshape(count + 1, -1)
        grid = np.zeros((4, number.size, 3))
        for axis, part in enumerate(np.meshgrid(along, along, indexing="ij")):
            grid[:, :, axis] = part.ravel()
        grid[:, :, 2] = begin + np.linspace(0.0, edge, 4)[:, None]
        fixed, own = grid == 0, np.zeros(grid.shape)
        fixed[:, :, 2] = False
        fixed[3 - touching, :, 2] = True
        own[:, :, 2] = -moved if begin else 0.0
        bodies.append(swept(grid, _quads(number), material))
        faces.append(end_faces(_quads(number), 4, touching, reverse=not touching))
        held.append(fixed)
        start.append(own)
    stiffness = 20 * material.youngs_modulus / edge
    pressure = _together(bodies, faces, stiffness, start, held, order)
    mean = np.average(pressure.pressure, weights=pressure.area)
    return float(np.abs(pressure.pressure / mean - 1).max())


def _together(
    bodies: Sequence[Body],
    faces: Sequence[Faces],
    stiffness: float,
    start: Sequence[Array],
    held: Sequence[NDArray[np.bool_]],
    order: int = 2,
) -> Pressed:
    """Contact of the faces of the second of two bodies with those of the first, each moved from ``start`` with
    the unknowns ``held``, both (stations, nodes, 3), at rest.
    """
    contact = FaceContact(faces[1].shifted(bodies[0].position.size), faces[0], stiffness, order)
    position = np.concatenate([one.position.ravel() for one in bodies])
    moved, fixed = (
        np.concatenate([one.transpose(1, 2, 0).ravel() for one in part]) for part in (start, held)
    )
    linear = sparse.block_diag([one.stiffness() for one in bodies]).tocsr()
    whole = sparse.eye(position.size, format="csr")
    return settle(linear, [contact], position, moved, ~fixed, whole)[1][0]


class Impact(NamedTuple):
    """``force`` (N): mean over the middle six tenths of the time that bodies touch by closed form;
    ``duration`` (s) for which more than half of it acts; ``velocity`` (m/s) of the last body after it.
    """

    force: float
    duration: float
    velocity: float


def colliding_bars(
    material: Material, length: float, radius: float, velocity: float, spans: int = 32
) -> Impact:
    """A round bar that flies into an equal one at rest; both of 12 bricks a slice."""
    disc = disc_section(2, 1, quadratic=False)
    used, quads = np.unique(disc.quads[:, :4], return_inverse=True)
    quads = quads.reshape(-1, 4)
    bodies, faces = [], []
    for begin, touching in ((-length, spans), (0.0, 0)):
        grid = np.zeros((spans + 1, len(used), 3))
        grid[:, :, :2] = radius * disc.nodes[used]
        grid[:, :, 2] = begin + np.linspace(0.0, length, spans + 1)[:, None]
        bodies.append(swept(grid, quads, material))
        faces.append(end_faces(quads, spans + 1, touching, reverse=not touching))
    faces[1] = faces[1].shifted(bodies[0].position.size)
    contact = FaceContact(faces[1], faces[0], material.youngs_modulus * spans / length)
    return _impact(bodies, contact, (velocity, 0.0), length, radius / 4)


def bouncing_ring(
    material: Material, radius: float, wall: float, height: float, velocity: float, spans: int = 60
) -> Impact:
    """A thin ring that falls on a plane with its flat side."""
    around = 24
    angle, place = 2 * np.pi * np.arange(around) / around, np.arange(around)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    grid = np.zeros((spans + 1, 2 * around, 3))
    grid[:, :, :2] = np.concatenate([(radius - wall / 2) * circle, (radius + wall / 2) * circle])
    grid[:, :, 2] = np.linspace(0.0, height, spans + 1)[:, None]
    further = (place + 1) % around
    quads = np.stack([place, around + place, around + further, further], axis=1)
    faces = end_faces(quads, spans + 1, 0, reverse=True)
    plane = Plane(np.array([0.0, 0.0, 1.0]), 0.0)
    contact = FaceContact(faces, plane, 2 * material.youngs_modulus * spans / height)
    return _impact([swept(grid, quads, material)], contact, (-velocity,), height, wall)


def _impact(
    bodies: Sequence[Body],
    contact: FaceContact,
    velocities: Sequence[float],
    length: float,
    smallest: float,
) -> Impact:
    """Leapfrog over one and a half times the way of a wave along the ``length`` (m) and back."""
    material, count = bodies[0].bricks.material, len(bodies)
    speed = np.sqrt(material.youngs_modulus / material.density)
    passing, step = 2 * length / speed, 0.25 * smallest / speed
    ends = np.cumsum([0, *(one.position.size for one in bodies)])
    x = np.concatenate([one.position.ravel() for one in bodies])
    mass = np.concatenate([one.mass for one in bodies])
    v, forces = np.zeros(x.size), []
    for begin, one, given in zip(ends, bodies, velocities, strict=False):
        v[begin : begin + one.position.size].reshape(one.position.shape)[:, 2] = given
    for _ in range(int(1.5 * passing / step)):
        found = contact.pressed(x)
        push = found.force
        for begin, end, one in zip(ends, ends[1:], bodies, strict=False):
            push[begin:end] += one.bricks.forces(x[begin:end].reshape(one.position.shape)).ravel()
        v += step * push / mass
        x += step * v
        forces.append(float(found.pressure @ found.area))
    force, time = np.array(forces), step * np.arange(len(forces))
    middle = force[(time > 0.2 * passing) & (time < 0.8 * passing)].mean()
    shape = bodies[-1].position.shape
    own, moving = (part[ends[count - 1] :].reshape(shape)[:, 2] for part in (mass, v))
    after = float(np.sum(own * moving) / own.sum())
    return Impact(float(middle), step * int(np.sum(force > middle / 2)), after)


def outside(body: Body, edges: Integers, sag: Array) -> Faces:
    """Side faces of a body over ``edges`` that run so that they are outside a section which is not
    reverse, else the other way round.
    """
    return side_faces(edges, body.position.shape[2], reverse=body.reverse, sag=sag)


def _quads(number: Integers) -> Integers:
    """Quadrilaterals (q, 4) of a grid of node numbers."""
    corners = (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    return np.stack(corners, axis=-1).reshape(-1, 4)


def _graded(fine: float, even: float, far: float) -> Array:
    """Places from 0 to ``far`` (m), evenly ``fine`` to ``even``, then growing."""
    count = round(even / fine)
    grown = fine * np.cumsum(GROWTH ** np.arange(1, 40))
    needed = int(np.searchsorted(grown, far - fine * count)) + 1
    grown = grown[:needed]
    # even growth to the exact end
    grown = grown + (far - fine * count - grown[-1]) * (grown / grown[-1]) ** 2
    return np.concatenate([fine * np.arange(count + 1), fine * count + grown])


def _point_force(place: Array, force: float, shear: float, ratio: float) -> Array:
    """Displacement (n, 3) of a half space at ``place`` (n, 3: two along its surface, depth) under a point
    force into it (johnson1985, section 3.2); the last along the force.
    """
    far = np.linalg.norm(place, axis=1)
    depth, scale = np.maximum(place[:, 2], 0.0), force / (4 * np.pi * shear)
    aside = scale * (depth / far**3 - (1 - 2 * ratio) / (far * (far + depth)))
    down = scale * (depth**2 / far**3 + 2 * (1 - ratio) / far)
    return np.stack([aside * place[:, 0], aside * place[:, 1], down], axis=1)


def _middle(found: Pressed, distance: Array, half_width: float) -> float:
    """Pressure (Pa) in the middle of a contact by its points from a tenth to eight tenths of the half
    width, each of the share there by Hertz: single points scatter.
    """
    share = 1 - (distance / half_width) ** 2
    used = (share > 0.36) & (share < 0.99) & (found.pressure > 0)
    return float(np.average(found.pressure[used] / np.sqrt(share[used]), weights=found.area[used]))
