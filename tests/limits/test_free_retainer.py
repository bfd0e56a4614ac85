"""Limit evidence: a retainer that may turn, and one that moves with a mass, against the closed
forms of Love and of the uniform rod.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import valvetrain as vt
from spring_shapes import cylindrical
from valvetrain.cosserat.mesh import mesh_spring
from valvetrain.cosserat.rates import axial_rate, end_stiffness, retainer_loads
from valvetrain.cosserat.state import free_state
from valvetrain.cosserat.static import RodStatics, compress
from valvetrain.cosserat.turning import TurningStatics, rotation_of
from valvetrain.springs.finite_element import FiniteElementRod


class Helix:
    """Love's helix (Treatise, art. 271) of bending stiffness B and torsional C: slopes of force and
    torque, small displacements.
    """

    def __init__(self, wire, diameter, pitch, coils):
        self.spring = cylindrical(wire, diameter, pitch, coils, ends="open")
        material = self.spring.material
        self.bend = material.youngs_modulus * np.pi * wire**4 / 64
        self.twist = material.shear_modulus * np.pi * wire**4 / 32
        self.angle, self.radius = np.arctan(pitch / (np.pi * diameter)), diameter / 2
        self.length = coils * np.hypot(np.pi * diameter, pitch)

    @property
    def fixed_rate(self):
        sine, cosine = np.sin(self.angle), np.cos(self.angle)
        return (self.bend * sine**2 + self.twist * cosine**2) / (self.length * self.radius**2)

    @property
    def free_rate(self):
        sine, cosine = np.sin(self.angle), np.cos(self.angle)
        return 1 / (self.length * self.radius**2 * (cosine**2 / self.twist + sine**2 / self.bend))

    @property
    def torque_over_force(self):
        """Size of the torque that a retainer which does not turn takes, per axial force."""
        sine, cosine = np.sin(self.angle), np.cos(self.angle)
        return (
            self.radius
            * sine
            * cosine
            * (1 / self.twist - 1 / self.bend)
            / (sine**2 / self.twist + cosine**2 / self.bend)
        )

    @property
    def turn_per_travel(self):
        sine, cosine = np.sin(self.angle), np.cos(self.angle)
        return (
            self.free_rate
            * self.length
            * self.radius
            * sine
            * cosine
            * (1 / self.twist - 1 / self.bend)
        )


@pytest.mark.parametrize(("wire", "pitch", "coils"), [(1e-3, 60e-3, 12.0), (2e-3, 16e-3, 12.0)])
def test_rate_torque_and_rotation_of_loves_helix(wire, pitch, coils):
    """Two meshes to the limit: rates within 0.4 % (clamped ends and shear), torque and rotation
    within 1 %; a mesh of 24 is 6 % off.
    """
    helix, found = Helix(wire, 40e-3, pitch, coils), []
    for elements in (24, 48):
        statics = TurningStatics(
            mesh_spring(helix.spring, elements, curvature_correction=False, contact=False), 0.0
        )
        slopes = end_stiffness(statics, free_state(statics.mesh))
        free = axial_rate(statics, free_state(statics.mesh))
        found.append([slopes[0, 0], free, slopes[0, 1] / slopes[0, 0], slopes[0, 1] / slopes[1, 1]])
    fixed, free, torque, turn = (4 * np.array(found[1]) - np.array(found[0])) / 3
    assert fixed == pytest.approx(helix.fixed_rate, rel=4e-3) and free == pytest.approx(
        helix.free_rate, rel=4e-3
    )
    assert torque == pytest.approx(helix.torque_over_force, rel=0.01)
    assert turn == pytest.approx(helix.turn_per_travel, rel=0.01)
    assert free < fixed


def test_a_free_retainer_turns_until_no_torque_is_left_and_the_spring_is_softer():
    helix = Helix(1e-3, 40e-3, 60e-3, 6.0)
    mesh = mesh_spring(helix.spring, 16, curvature_correction=False, contact=False)
    held, turned = (compress(kind(mesh, 0.0), [6e-3])[-1] for kind in (RodStatics, TurningStatics))
    plane = mesh.position[mesh.last, 2] - 6e-3
    (_, fixed), (_, free) = (
        retainer_loads(RodStatics(mesh, 0.0), one.state, plane) for one in (held, turned)
    )
    assert turned.converged and abs(free[2]) < 1e-5 * abs(fixed[2])
    assert 0.98 * held.retainer_force < turned.retainer_force < held.retainer_force
    assert rotation_of(RodStatics(mesh, 0.0), turned.state) == pytest.approx(
        -6e-3 * helix.turn_per_travel, rel=0.2
    )


def test_rate_of_a_turning_retainer_is_the_slope_of_its_force():
    helix = Helix(2e-3, 24e-3, 12e-3, 5.0)
    statics = TurningStatics(mesh_spring(helix.spring, 16, contact=False), 0.0)
    here = compress(statics, [20e-3])[-1].state
    low, high = (
        compress(statics, [20e-3 + step], here)[-1].retainer_force for step in (-2e-5, 2e-5)
    )
    assert axial_rate(statics, here) == pytest.approx((high - low) / 4e-5, rel=1e-4)


def test_the_force_on_the_retainer_is_that_of_the_seat_turned_over():
    """Of a wire between clamps: forces of both ends are opposite, and their moments about one point
    balance.
    """
    helix = Helix(3e-3, 22e-3, 8e-3, 5.5)
    rod = FiniteElementRod(helix.spring, 8e-3, 16, seats="clamps")
    force, moment = retainer_loads(rod.statics, rod.installed.state, 0.0)
    _, residual, _, _ = rod.statics.assemble(rod.installed.state, with_tangent=False)
    unknowns, x = (
        residual.reshape(-1, 6)[: rod.mesh.first + 1],
        rod.installed.state.position[: rod.mesh.first + 1],
    )
    frames = rod.installed.state.frame[1 : rod.mesh.first + 2]
    from valvetrain.cosserat.quaternion import to_matrix

    seat = unknowns[:, :3].sum(axis=0)
    about = np.cross(x, unknowns[:, :3]).sum(axis=0) + np.einsum(
        "nij,nj->i", to_matrix(frames), unknowns[:, 3:]
    )
    np.testing.assert_allclose(force, seat, atol=1e-4)
    np.testing.assert_allclose(moment, about, atol=1e-5)
    point = rod.static_point(8e-3)
    assert point.force == pytest.approx(force[2]) and point.side_force == pytest.approx(
        np.hypot(*force[:2])
    )


@pytest.mark.parametrize("share", [0.0, 0.2, 1.0, 5.0, 50.0])
def test_modes_with_a_mass_on_the_retainer(share):
    """x tan x = m_spring / mass of the uniform rod, first mode, within what the helix adds (0.2 %
    free, less with a mass).
    """
    spring = cylindrical("2 mm", "24 mm", "6 mm", 10, ends="open")
    rod = FiniteElementRod(spring, 1e-3, 24, seats="clamps")
    rate, mass = rod.static_point(1e-3).stiffness, spring.mass
    root = (
        brentq(lambda x: x * np.tan(x) - 1 / share, 1e-6, np.pi / 2 - 1e-9) if share else np.pi / 2
    )
    found = rod.modes(12, share * mass)
    first = float(found.axial_frequencies[0])
    assert first == pytest.approx(root * np.sqrt(rate / mass) / (2 * np.pi), rel=2e-3)
    assert found.natural_frequency[0] == first
    if share >= 5:
        assert first == pytest.approx(
            np.sqrt(rate / (share * mass + mass / 3)) / (2 * np.pi), rel=1e-3
        )
    if share == 0.0:  # a quarter wave below the half wave between fixed ends
        assert rod.modes(12).axial_frequencies[0] / first == pytest.approx(2.0, rel=0.03)


def test_a_mass_below_zero_is_refused():
    rod = FiniteElementRod(cylindrical("2 mm", "24 mm", "6 mm", 4, ends="open"), 1e-3, 12)
    with pytest.raises(vt.InputError, match="an attached mass is zero or more"):
        rod.modes(4, -0.01)
