"""Kinetic energy of the rod against that of its wire: closed forms of a round bar in translation
and in turning about each own axis.
"""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from twins.rod_cases import STEEL, uniform_spring
from valvetrain.cosserat.layout import row
from valvetrain.cosserat.mesh import mesh_spring
from valvetrain.springs.finite_element_channels import _kinetic
from valvetrain.springs.finite_element_model import RodModel

WIRE, DIAMETER, PITCH, COILS = 4e-3, 24e-3, 7.5e-3, 6.0
SPRING = uniform_spring(WIRE, DIAMETER, PITCH, COILS)
LENGTH = COILS * math.hypot(math.pi * DIAMETER, PITCH)
MASS = STEEL.density * math.pi / 4 * WIRE**2 * LENGTH
#: A round bar: m d^2 / 16 about a diameter, twice that about its own axis.
ACROSS, ALONG = MASS * WIRE**2 / 16, MASS * WIRE**2 / 8


def test_the_wire_weighs_and_turns_as_a_round_bar():
    mesh = mesh_spring(SPRING, 24)
    assert float(mesh.node_mass[mesh.first : mesh.last + 1].sum()) == pytest.approx(MASS, rel=1e-6)
    assert mesh.edge_inertia.sum(axis=0) == pytest.approx([ACROSS, ACROSS, ALONG], rel=1e-6)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_turning_about_each_axis_carries_its_energy(axis):
    model, rate = RodModel(SPRING, 5e-3, seats="clamps"), 30.0
    mesh, inertia = model.mesh, (ACROSS, ACROSS, ALONG)[axis]
    state = model.initial_state(0.0)
    assert model.energy(state, 0.0).kinetic == 0.0
    row(state, f"W{axis + 1}", mesh.vertices + 1)[:] = rate
    assert model.energy(state, 0.0).kinetic == pytest.approx(0.5 * inertia * rate**2, rel=1e-6)
    spin = np.zeros((2, mesh.vertices + 1, 3))
    spin[1, :, axis] = rate
    still = SimpleNamespace(spin=spin, velocity=np.zeros((2, mesh.vertices, 3)))
    assert _kinetic(mesh, still) == pytest.approx([0.0, 0.5 * inertia * rate**2], rel=1e-6)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_moving_along_each_axis_carries_the_mass_between_the_ends(axis):
    """The vertices at the ends are held by seat and retainer: half an element each is not the
    wire's own motion.
    """
    model, speed = RodModel(SPRING, 5e-3, seats="clamps"), 3.0
    mesh, moving = model.mesh, MASS * (1 - 1 / (24 * COILS))
    state = model.initial_state(0.0)
    row(state, "VXVYVZ"[2 * axis : 2 * axis + 2], mesh.vertices)[:] = speed
    assert model.energy(state, 0.0).kinetic == pytest.approx(0.5 * moving * speed**2, rel=1e-6)
    velocity = np.zeros((1, mesh.vertices, 3))
    velocity[0, :, axis] = speed
    run = SimpleNamespace(spin=np.zeros((1, mesh.vertices + 1, 3)), velocity=velocity)
    assert _kinetic(mesh, run) == pytest.approx([0.5 * moving * speed**2], rel=1e-6)


def test_the_force_at_a_bonded_end_is_the_slope_of_the_stored_energy():
    """Virtual work: only the bonded end moves, the wire between stays where it is."""
    model, step = RodModel(SPRING, 5e-3, seats="clamps"), 1e-7
    state = model.initial_state(0.0)
    low, high = (model.energy(state, moved).elastic for moved in (-step, step))
    assert (high - low) / (2 * step) == pytest.approx(model.force(state, 0.0).retainer, rel=1e-6)
