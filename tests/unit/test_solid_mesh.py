"""The solid mesh against the wire it is made of: volume, orientation, sets, ground faces."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from validation.calculix.deck import seat_plates
from validation.calculix.jobs import jacobian_quality

from valvetrain.continuum import mesh as hexahedra
from valvetrain.continuum.mesh import MeshOptions, layer_coils, sweep_spring
from valvetrain.continuum.section import disc_section
from valvetrain.errors import InputError
from valvetrain.parameters.constructors import conical, cylindrical
from valvetrain.parameters.curves import Constant
from valvetrain.parameters.material import OTEVA_90_SC
from valvetrain.parameters.spring import OPEN_END, EndCoil, SpringDefinition


@pytest.fixture
def uniform() -> SpringDefinition:
    return SpringDefinition(
        wire_diameter=Constant(3.8e-3),
        mean_diameter=Constant(22e-3),
        pitch=Constant(7e-3),
        total_coils=3.0,
        material=OTEVA_90_SC,
        lower_end=OPEN_END,
        upper_end=OPEN_END,
    )


def wire_volume(spring: SpringDefinition) -> float:
    return np.pi / 4 * spring.integrate_along_wire(spring.wire_diameter, 2)


@pytest.mark.parametrize("nodes", [8, 20])
def test_shape_gradients_reproduce_linear_fields(nodes):
    points = np.random.default_rng(1).uniform(-1, 1, (7, 3))
    gradients = hexahedra.shape_gradients(points, nodes)
    assert np.allclose(gradients.sum(axis=1), 0, atol=1e-14)
    field = hexahedra.NODE_COORDINATES[:nodes]
    assert np.allclose(np.einsum("pna,nb->pab", gradients, field), np.eye(3), atol=1e-14)


def test_twenty_node_gradients_reproduce_a_quadratic_field():
    x = hexahedra.NODE_COORDINATES
    values = x[:, 0] ** 2 + x[:, 1] * x[:, 2]
    points = np.random.default_rng(2).uniform(-1, 1, (5, 3))
    gradient = np.einsum("pna,n->pa", hexahedra.shape_gradients(points), values)
    assert np.allclose(
        gradient, np.stack([2 * points[:, 0], points[:, 2], points[:, 1]], axis=-1), atol=1e-13
    )


@pytest.mark.parametrize(("core", "rings"), [(1, 1), (2, 1), (3, 2)])
def test_section_nodes_are_the_disc(core, rings):
    section = disc_section(core, rings)
    assert len(section.quads) == core**2 + 4 * core * rings
    assert len(np.unique(section.quads)) == len(section.nodes)
    rim = section.nodes[section.quads[section.rim_quads][:, [1, 2, 5]]]
    # Enlarged a little so that the area inside the arcs is exactly that of the disc.
    assert np.ptp(np.hypot(rim[..., 0], rim[..., 1])) < 1e-12
    assert 1 <= np.hypot(*rim[0, 0]) < 1.01


def volume_of(mesh) -> float:
    return hexahedra.volume(mesh.coordinates, mesh.elements)


@pytest.mark.parametrize("hand", ["right", "left"])
@pytest.mark.parametrize("kind", ["C3D20R", "C3D8I"])
def test_mesh_volume_is_the_wire_volume_and_elements_are_upright(uniform, hand, kind):
    mesh = sweep_spring(uniform.replace(hand=hand), MeshOptions(24, 2, 1, kind))
    assert jacobian_quality(mesh) > 0.2
    # Chords of 15 degrees lose 1.1 % of the arc; curved elements lose only 3e-4.
    tolerance = 5e-4 if kind == "C3D20R" else 0.013
    assert volume_of(mesh) == pytest.approx(wire_volume(uniform), rel=tolerance)


def test_volume_converges_with_fourth_order(uniform):
    # Second order along the wire times second order across: elements without middles of faces.
    errors = [
        abs(
            volume_of(sweep_spring(uniform, MeshOptions(12 * n, 2 * n, n))) / wire_volume(uniform)
            - 1
        )
        for n in (1, 2)
    ]
    assert 3.5 < np.log2(errors[0] / errors[1]) < 4.5


def test_end_sections_are_bonded_and_stand_across_the_wire(uniform):
    mesh = sweep_spring(uniform)
    for name, coil in (("seat", 0.0), ("retainer", 3.0)):
        nodes = mesh.node_sets[name]
        assert np.allclose(mesh.coil[nodes], coil)
        away = mesh.coordinates[nodes] - uniform.centreline(coil)
        tangent = uniform.centreline(coil + 1e-6) - uniform.centreline(coil - 1e-6)
        assert np.max(np.abs(away @ tangent / np.linalg.norm(tangent))) < 1e-9
        assert np.max(np.linalg.norm(away, axis=-1)) == pytest.approx(1.9e-3, rel=1e-2)


def test_held_turns_move_with_their_seats():
    spring = cylindrical(3.8e-3, 22e-3, 7e-3, 6.0)
    mesh = sweep_spring(spring, MeshOptions(12, 1, 1, ends="bonded"))
    assert volume_of(mesh) == pytest.approx(spring.mass / spring.material.density, rel=5e-3)
    assert mesh.coil.min() == 0 and mesh.coil.max() == 6
    assert set(mesh.node_sets["seat"]) == set(np.flatnonzero(mesh.coil <= 0.75 + 1e-9))
    assert set(mesh.node_sets["retainer"]) == set(np.flatnonzero(mesh.coil >= 5.25 - 1e-9))


def test_ground_ends_are_flat_and_lose_the_ground_off_volume():
    spring = cylindrical(3.8e-3, 22e-3, 7e-3, 6.0)
    mesh = sweep_spring(spring, MeshOptions(48, 4, 1, ends="ground"))
    assert jacobian_quality(mesh) > 0
    assert mesh.coordinates[:, 2].min() >= spring.lower_seat_height - 1e-5
    assert mesh.coordinates[:, 2].max() <= spring.upper_seat_height + 1e-5
    assert np.allclose(
        mesh.coordinates[mesh.node_sets["seat"], 2], spring.lower_seat_height, atol=1e-8
    )
    # Circular segment below the seat plane, integrated along the wire.
    coil = np.linspace(0, 0.75, 4001)
    level = np.clip((spring.axial_position(coil) - spring.lower_seat_height) / 1.9e-3, -1, 1)
    segment = 1.9e-3**2 * (np.arccos(level) - level * np.sqrt(1 - level**2))
    lost = 2 * np.trapezoid(segment * spring.line_speed(coil), coil)
    # The straight edges of the cut sections lose a little more than the flat itself.
    assert wire_volume(spring) - volume_of(mesh) == pytest.approx(lost, rel=0.05)


def test_too_much_grinding_is_refused():
    spring = cylindrical(
        3.8e-3, 22e-3, 7e-3, 6.0, lower_end=EndCoil(inactive_coils=0.75, ground_coils=1.0)
    )
    with pytest.raises(InputError, match="grinding leaves less"):
        sweep_spring(spring, MeshOptions(12, 1, 1, ends="ground"))


def test_layers_refine_towards_the_clamps(uniform):
    layers = layer_coils(uniform, MeshOptions(24, 2, 1, end_refinement=3.0))
    steps = np.diff(layers)
    assert layers[0] == 0 and layers[-1] == 3
    assert steps[0] == pytest.approx(steps[-1], rel=1e-6)
    assert steps[0] < 0.45 * steps[len(steps) // 2]


def test_contact_faces_look_down_and_up(uniform):
    mesh = sweep_spring(uniform, MeshOptions(12, 2, 1))
    for faces, sign in ((mesh.lower, -1), (mesh.upper, 1)):
        # Side 4 of a hexahedron: corners 2, 6, 7, 3.
        corners = mesh.coordinates[mesh.elements[faces.elements][:, [1, 5, 6, 2]]]
        normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        outward = corners.mean(axis=1) - uniform.centreline(faces.coil)
        assert np.all(np.abs(np.einsum("na,na->n", normal, outward)) > 0)
        assert np.all(sign * outward[:, 2] > 0.3 * np.linalg.norm(outward, axis=-1))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"element_type": "C3D10"}, "not supported"),
        ({"elements_per_coil": 2}, "at least 4"),
        ({"end_refinement": 0.5}, "1 or more"),
        ({"ends": "welded"}, "unknown"),
        ({"core": 0}, "at least 1"),
    ],
)
def test_impossible_meshes_are_refused(uniform, changes, words):
    with pytest.raises(InputError, match=words):
        sweep_spring(uniform, MeshOptions(**changes))


def test_tapered_wire_paths_mesh_too():
    spring = conical(3e-3, 26e-3, 18e-3, 6e-3, 6.0)
    mesh = sweep_spring(spring, MeshOptions(24, 2, 1, ends="bonded"))
    assert jacobian_quality(mesh) > 0.2
    assert volume_of(mesh) == pytest.approx(wire_volume(spring), rel=1e-3)


@pytest.mark.parametrize(
    ("free", "grinding", "ground", "reach"),
    [
        ((0.0, 6.0), (0.0, 0.0), False, (0.0, 0.9, 5.1, 6.0)),
        ((0.5, 5.75), (0.25, 0.75), True, (0.5, 1.4, 4.85, 5.75)),
        ((0.5, 5.75), (0.25, 0.75), False, (0.5, 1.4, 4.35, 5.25)),
        ((0.25, 5.75), (1.0, 0.1), False, (1.0, 1.9, 4.85, 5.75)),
        ((2.9, 3.3), (2.0, 1.0), True, (2.9, 3.3, 2.9, 3.3)),
    ],
)
def test_seat_plates_are_blocks_under_and_over_the_wire(free, grinding, ground, reach):
    """A cone of 4 mm wire, 30 mm over its widest coil: blocks of three quarters of that to each
    side, one wire thick (mm).
    """
    cone = SimpleNamespace(
        free_coils=free,
        total_coils=6.0,
        wire_diameter=Constant(4e-3),
        outer_diameter=lambda coil: 30e-3 - 1e-3 * coil,
        lower_end=SimpleNamespace(ground_coils=grinding[0]),
        upper_end=SimpleNamespace(ground_coils=grinding[1]),
        lower_seat_height=-1e-3,
        upper_seat_height=37e-3,
    )
    lower, upper = seat_plates(cone, ground)
    for plate, told, heights in (
        (lower, ("SEATPLANE", "SEAT", "S2"), (-5, -1)),
        (upper, ("RETAINERPLANE", "RETAINER", "S1"), (37, 41)),
    ):
        assert (plate.name, plate.node_set, plate.side) == told
        square = [(-22.5, -22.5), (22.5, -22.5), (22.5, 22.5), (-22.5, 22.5)]
        assert 1e3 * plate.corners == pytest.approx(
            np.array([(*corner, height) for height in heights for corner in square])
        )
    assert (lower.first, lower.last, upper.first, upper.last) == pytest.approx(reach)
