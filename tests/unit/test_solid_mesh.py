"""The solid mesh against the wire it is made of: volume, orientation, sets, ground faces."""

from __future__ import annotations

import numpy as np
import pytest
from validation.calculix.jobs import jacobian_quality

from spring_shapes import conical, cylindrical
from valvetrain.continuum import mesh as hexahedra
from valvetrain.continuum.mesh import MeshOptions, sweep_spring
from valvetrain.errors import InputError
from valvetrain.parameters.curves import Constant
from valvetrain.parameters.material import OTEVA_90_SC
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import OPEN_END, EndCoil


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
