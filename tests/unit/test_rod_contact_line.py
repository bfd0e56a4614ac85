"""Contact line: gaps against a dense closest-point search on the true wire axis, and the reach of
the line to the wire tips.
"""

from __future__ import annotations

import numpy as np
import pytest

from twins.rod_cases import small_spring, uniform_spring
from twins.rod_energy import spline
from valvetrain.cosserat.contact_line import true_distance
from valvetrain.cosserat.mesh import mesh_spring
from valvetrain.cosserat.static import RodStatics
from valvetrain.parameters.winding import EndCoil


def nearest(points: np.ndarray, curve: np.ndarray) -> np.ndarray:
    """Distance of points (n, 3) from a densely sampled curve (m, 3) made of straight pieces."""
    start, along = curve[:-1], np.diff(curve, axis=0)
    best = np.full(len(points), np.inf)
    for k, point in enumerate(points):
        share = np.clip(np.sum((point - start) * along, axis=1) / np.sum(along**2, axis=1), 0, 1)
        best[k] = np.min(np.linalg.norm(point - start - share[:, None] * along, axis=1))
    return best


def test_true_distance_is_the_closest_point_one_turn_below():
    spring = small_spring()
    coil = np.linspace(1.1, 3.1, 23)
    dense = spring.centreline(np.linspace(0.0, 3.2, 40001))
    points = spring.centreline(coil)
    below = [
        nearest(points[k : k + 1], spring.centreline(np.linspace(u - 1.3, u - 0.7, 8001)))[0]
        for k, u in enumerate(coil)
    ]
    assert len(dense) and np.abs(true_distance(spring.centreline, coil) - below).max() < 1e-9


@pytest.mark.parametrize("per_coil", [9, 12, 24, 37])
def test_free_gap_is_that_of_the_true_wire(per_coil):
    """Whatever the mesh: axis distance of the free coils less the wire diameter, although the
    spline rounds the pitch law off.
    """
    spring = small_spring()
    mesh = mesh_spring(spring, per_coil)
    gaps = RodStatics(mesh).gaps(mesh.position)
    step = mesh.coil_number[1] - mesh.coil_number[0]
    for group, place in enumerate(mesh.contact.upper_place):
        points = mesh.contact.points[group]
        coil = mesh.coil_number[points] + place * step
        inside = (coil > 1.05) & (coil < 3.15)
        true = true_distance(spring.centreline, coil)
        wire = (spring.wire_diameter.value(coil) + spring.wire_diameter.value(coil - 1)) / 2
        expected = np.maximum(true - wire, 0.0)
        assert np.abs(gaps[group, points] - expected)[inside].max() < 1e-9


@pytest.mark.parametrize("per_coil", [12, 24])
def test_deformed_gap_against_a_dense_search(per_coil):
    """Coils shifted sideways and squeezed.

    The one Newton step is within 1 um of the closest point of the spline (0.2 % of the overlap
    scale).
    """
    spring = uniform_spring(pitch=5e-3, coils=4.0)
    mesh = mesh_spring(spring, per_coil)
    position = mesh.position.copy()
    u = mesh.coil_number
    position[:, 2] *= 0.85
    position[:, 0] += 4e-4 * np.sin(2 * np.pi * u / 4)
    position[:, 1] += 3e-4 * np.cos(2 * np.pi * u / 3)
    gaps = RodStatics(mesh).gaps(position)
    fine = np.linspace(0.6, mesh.vertices - 1.6, 200 * mesh.vertices)
    curve = spline(position, fine)
    for group, place in enumerate(mesh.contact.upper_place):
        index = np.flatnonzero(mesh.contact.points[group])[1:]
        points = spline(position, index + place)
        expected = [
            nearest(
                points[k : k + 1],
                curve[np.abs(fine - (i + place - mesh.contact.offset)) < per_coil / 4],
            )[0]
            for k, i in enumerate(index)
        ]
        found = gaps[group, index] + mesh.contact.distance[group, index]
        assert np.abs(found - expected).max() < 1e-6


@pytest.mark.parametrize("held", [0.0, 0.6, 0.78])
@pytest.mark.parametrize("per_coil", [11, 24, 36])
def test_contact_line_covers_the_wire_on_every_mesh(held, per_coil):
    """All wire from one turn above the lower tip to the upper tip has a partner: length in contact
    does not depend on the mesh.
    """
    spring = uniform_spring(coils=5.0).replace(
        lower_end=EndCoil("closed", held, 0.5), upper_end=EndCoil("closed", held, 0.5)
    )
    mesh = mesh_spring(spring, per_coil)
    expected = spring.integrate_along_wire(between=(1.0, 5.0))
    assert mesh.contact.length.sum() == pytest.approx(expected, rel=1e-9)
    assert np.all(mesh.contact.length >= 0)
