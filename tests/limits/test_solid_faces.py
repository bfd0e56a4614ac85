"""Contact of the faces of bricks: forces are the slope of their energy and in balance, a round surface
stands over its flat faces, gaps are those of the true surfaces.
"""

from __future__ import annotations

import numpy as np
import pytest
from validation.hertz import bouncing_ring, outside, pressed_section, swept
from validation.pressed_faces import FaceContact, Plane, end_faces, side_faces
from validation.springs import STEEL

#: A flat block of 3 x 2 x 2 bricks.
EDGE = np.array([3e-3, 2e-3, 2e-3])


def block(begin: float, cells: tuple[int, int]):
    """A block from ``begin`` (m) up, and its quadrilaterals."""
    x, y = (np.linspace(0.0, edge, count + 1) for edge, count in zip(EDGE[:2], cells, strict=True))
    number = np.arange(len(x) * len(y)).reshape(len(x), -1)
    corners = (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    grid = np.zeros((3, number.size, 3))
    grid[:, :, 0], grid[:, :, 1] = (part.ravel() for part in np.meshgrid(x, y, indexing="ij"))
    grid[:, :, 2] = begin + np.linspace(0.0, EDGE[2], 3)[:, None]
    quads = np.stack(corners, axis=-1).reshape(-1, 4)
    return swept(grid, quads, STEEL), quads


@pytest.fixture(scope="module")
def pressed() -> tuple[FaceContact, np.ndarray]:
    """Two shaken blocks with different meshes, one 20 um in the other."""
    lower, own = block(0.0, (3, 2))
    upper, other = block(EDGE[2] - 20e-6, (4, 3))
    position = np.concatenate([lower.position.ravel(), upper.position.ravel()])
    position += 1e-7 * np.random.default_rng(5).standard_normal(position.size)
    top = end_faces(other, 3, 0, reverse=True).shifted(lower.position.size)
    return FaceContact(top, end_faces(own, 3, 2), 1e13, order=3), position


def test_forces_are_the_slope_of_their_energy(pressed):
    """Property: the forces do the work that the energy loses, but for what the faces turn and stretch by
    (their tilt here is some 1e-4)."""
    contact, position = pressed
    rises = np.zeros(position.size)
    rises[contact.faces.corners[:, :, 2]] = 1e-9
    before, after = (contact.pressed(position + side * rises).energy for side in (-1, 1))
    force = contact.pressed(position).force
    assert before > 0 and -force @ rises == pytest.approx((after - before) / 2, rel=2e-4)


def test_two_bodies_push_one_another_equally(pressed):
    """Property: no resultant, and no moment but of the gap times the tilt, 1e-6 of the force times the
    edge."""
    contact, position = pressed
    found = contact.pressed(position)
    corners = [np.unique(one.corners.reshape(-1, 3), axis=0) for one in (contact.faces, contact.other)]  # fmt: skip
    places = np.concatenate(corners)
    force, at = found.force[places], position[places]
    size = float(found.pressure @ found.area)
    assert size == pytest.approx(1e13 * 20e-6 * EDGE[0] * EDGE[1], rel=0.02)
    assert np.abs(force.sum(axis=0)).max() < 1e-12 * size
    assert np.abs(np.cross(at, force).sum(axis=0)).max() < 1e-6 * size * EDGE[0]


def test_a_round_surface_stands_over_its_flat_faces():
    """Closed form: points of the faces of a ring with eight sides, each 0.73 times the radius across, lie
    on the circle of the ring within 6 um of 2 mm, 0.15 mm without the sag."""
    radius, sides = 2e-3, 8
    angle = 2 * np.pi * np.arange(sides) / sides
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    grid = np.zeros((2, 2 * sides, 3))
    grid[:, :, :2], grid[1, :, 2] = radius * np.concatenate([circle / 2, circle]), 1e-3
    place, further = np.arange(sides), (np.arange(sides) + 1) % sides
    quads = np.stack([place, sides + place, sides + further, further], axis=1)
    body, edges = swept(grid, quads, STEEL), np.stack([sides + place, sides + further], axis=1)
    width = 2 * radius * np.sin(np.pi / sides)
    sag = np.tile([0.0, width**2 / (8 * radius)], (sides, 1))
    plane = Plane(np.array([0.0, 0.0, 1.0]), -1.0)
    for height, within in ((sag, 6e-6), (0 * sag, 0.16e-3)):
        places = FaceContact(outside(body, edges, height), plane, 1.0, 4).pressed(body.position.ravel()).place  # fmt: skip
        off = np.abs(np.hypot(places[:, 0], places[:, 1]) - radius).max()
        assert within / 4 < off < within


def test_side_faces_look_outward_whichever_way_a_body_is_swept():
    """Contract: a swept body and its mirror image have outward faces."""
    for side in (1.0, -1.0):
        body, _ = block(0.0, (1, 1))
        grid = body.position.transpose(2, 0, 1) * (1, 1, side)
        mirrored = swept(np.ascontiguousarray(grid), np.array([[0, 2, 3, 1]]), STEEL)
        faces = outside(mirrored, np.array([[0, 2], [3, 1]]), np.zeros((2, 2)))
        _, normal, _ = faces.at(mirrored.position.ravel(), np.zeros((1, 1, 2)))
        middle = mirrored.position.ravel()[faces.corners].mean(axis=1)
        assert np.all(np.sum(normal[:, 0] * (middle - grid.mean(axis=(0, 1))), axis=1) > 0)


def test_points_beside_the_other_body_touch_nothing():
    """Contract: faces beyond the edge of the other body carry no pressure."""
    lower, own = block(0.0, (2, 2))
    upper, other = block(EDGE[2] - 1e-6, (2, 2))
    aside = upper.position + np.array([2 * EDGE[0], 0.0, 0.0])[None, :, None]
    position = np.concatenate([lower.position.ravel(), aside.ravel()])
    top = end_faces(other, 3, 0, reverse=True).shifted(lower.position.size)
    found = FaceContact(top, end_faces(own, 3, 2), 1e13).pressed(position)
    assert np.all(np.isinf(found.gap)) and not found.force.any() and found.tangent.nnz == 0


@pytest.mark.slow
def test_a_finer_section_comes_nearer_to_hertz():
    """Closed form: the force of a squeezed section by 8 and 16 bricks across is 1.9 and 0.3 % off the
    closed form."""
    errors = [pressed_section(4e-3, STEEL, 1e4, across=n).force / 1e4 - 1 for n in (8, 16)]
    assert 0 < errors[1] < 5e-3 < errors[0] < 0.02


def test_a_ring_bounces_harder_the_faster_it_falls():
    """Property: linear waves, so force grows with the velocity and the time does not."""
    slow, fast = (bouncing_ring(STEEL, 2e-3, 0.5e-3, 20e-3, v, 20) for v in (0.5, 1.0))
    assert fast.force == pytest.approx(2 * slow.force, rel=2e-3)
    assert fast.duration == pytest.approx(slow.duration, rel=2e-2)


def test_reversed_edges_look_inward():
    """Contract: the direction of the edges is what says where outside is."""
    body, _ = block(0.0, (1, 1))
    stations = body.position.shape[2]
    normals = []
    for edges in (np.array([[0, 2]]), np.array([[2, 0]])):
        faces = side_faces(edges, stations, reverse=body.reverse)
        normals.append(faces.at(body.position.ravel(), np.zeros((1, 1, 2)))[1])
    assert normals[0] == pytest.approx(-normals[1])
