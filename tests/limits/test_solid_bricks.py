"""Bricks of the solid model against closed forms of elasticity: patch, rotation, bars, waves."""

from __future__ import annotations

import numpy as np
import pytest
from validation.bars import (
    STEEL,
    area_moments,
    bar,
    disc,
    frequencies,
    reactions,
    thin_quarter,
)

from valvetrain.continuum.bricks import sweep_bricks
from valvetrain.errors import InputError

RADIUS, LENGTH = 2e-3, 40e-3
YOUNG, SHEAR, DENSITY = STEEL.youngs_modulus, STEEL.shear_modulus, STEEL.density


def distorted(seed: int) -> tuple:
    """A short bar whose inner nodes stand anywhere within a tenth of a brick."""
    nodes, quads = disc()
    rng = np.random.default_rng(seed)
    grid = np.zeros((5, len(nodes), 3))
    grid[:, :, :2], grid[:, :, 2] = RADIUS * nodes, np.linspace(0, 4 * RADIUS, 5)[:, None]
    grid[1:-1] += 0.1 * RADIUS * rng.uniform(-1, 1, grid[1:-1].shape)
    return sweep_bricks(grid, quads, STEEL), np.ascontiguousarray(grid.transpose(1, 2, 0))


def turned(angle: float) -> np.ndarray:
    axis = np.array([0.6, -0.48, 0.64])
    cross = np.cross(np.eye(3), axis)
    return (
        np.cos(angle) * np.eye(3)
        - np.sin(angle) * cross
        + (1 - np.cos(angle)) * np.outer(axis, axis)
    )


@pytest.mark.parametrize("seed", [1, 2])
def test_patch_of_distorted_bricks(seed):
    """Closed form: under any homogeneous deformation the inner nodes are in balance and the energy is
    that of the St Venant-Kirchhoff solid."""
    bricks, free = distorted(seed)
    gradient = np.eye(3) + 0.05 * np.random.default_rng(seed).standard_normal((3, 3))
    moved = np.einsum("ij,njs->nis", gradient, free)
    strain = (gradient.T @ gradient - np.eye(3)) / 2
    lame, shear = bricks.lame
    density = lame / 2 * np.trace(strain) ** 2 + shear * np.sum(strain**2)
    force = bricks.forces(moved)
    rim = np.hypot(*disc()[0].T) > 0.99
    assert np.abs(force[~rim][:, :, 1:-1]).max() < 1e-9 * np.abs(force).max()
    assert bricks.energy(moved) == pytest.approx(density * bricks.mass.sum() / DENSITY, rel=1e-10)
    assert bricks.misfit < 1e-12


@pytest.mark.parametrize("angle", [0.3, 1.5, 3.0])
def test_rotation_costs_no_energy(angle):
    """Closed form: a rigid motion strains nothing, however large."""
    bricks, free = distorted(3)
    moved = (
        np.einsum("ij,njs->nis", turned(angle), free) + np.array([1.0, 2.0, 3.0])[:, None] * 1e-2
    )
    stretched = bricks.energy(free * 1.001)
    assert bricks.energy(moved) < 1e-15 * stretched / 1e-6
    assert np.abs(bricks.forces(moved)).max() < 1e-6


def test_forces_are_the_slope_of_the_energy():
    """Property: the internal force is minus the derivative of the energy, in any state."""
    bricks, free = distorted(4)
    rng = np.random.default_rng(5)
    state = free * (1 + 0.02 * rng.standard_normal(free.shape))
    step = 1e-9 * rng.standard_normal(free.shape)
    slope = (bricks.energy(state + step) - bricks.energy(state - step)) / 2
    assert -np.sum(bricks.forces(state) * step) == pytest.approx(slope, rel=1e-6)


def test_tangent_is_the_slope_of_the_forces():
    """Property: element tangents, summed, change the forces as a small motion does."""
    bricks, free = distorted(6)
    rng = np.random.default_rng(7)
    state, step = (
        free * (1 + 0.01 * rng.standard_normal(free.shape)),
        1e-9 * rng.standard_normal(free.shape),
    )
    elements, places = bricks.tangent(state)
    found = np.zeros(free.size)
    np.add.at(found, places, np.einsum("eij,ej->ei", elements, step.ravel()[places]))
    change = (bricks.forces(state + step) - bricks.forces(state - step)) / 2
    assert found == pytest.approx(-change.ravel(), abs=1e-5 * np.abs(change).max())


def test_pull_bend_and_twist_of_a_straight_bar():
    """Closed form: L/EA of the length that a second bar is longer, 12 EI/L^3 with shear (Cowper's
    factor) and GJ/L, with area and second moment of the meshed section. The clamps, which keep their
    sections plane and round, stiffen bending by 1 to 2 % at ten diameters."""
    one, nodes = 1e-6, RADIUS * disc(4, 2)[0]
    moment, area = area_moments(4, 2)
    inertia, section = moment * np.pi * RADIUS**4 / 4, area * np.pi * RADIUS**2
    pull, push, twist = np.zeros((3, len(nodes), 3))
    pull[:, 2], push[:, 0] = one, one
    twist[:, :2] = one / RADIUS * np.stack([-nodes[:, 1], nodes[:, 0]], axis=1)
    bricks, free = bar(LENGTH, RADIUS, 40, core=4, rings=2)
    longer = bar(2 * LENGTH, RADIUS, 80, core=4, rings=2)
    soft = [one / reactions(*which, pull)[:, 2].sum() for which in ((bricks, free), longer)]
    assert soft[1] - soft[0] == pytest.approx(LENGTH / (YOUNG * section), rel=1e-4)
    ratio = STEEL.poisson_ratio
    factor = 6 * (1 + ratio) / (7 + 6 * ratio)
    bent = LENGTH**3 / (12 * YOUNG * inertia) + LENGTH / (factor * SHEAR * section)
    assert reactions(bricks, free, push)[:, 0].sum() == pytest.approx(one / bent, rel=0.02)
    force = reactions(bricks, free, twist)
    torque = np.sum(nodes[:, 0] * force[:, 1] - nodes[:, 1] * force[:, 0])
    assert torque == pytest.approx(SHEAR * 2 * inertia / LENGTH * one / RADIUS, rel=0.001)


@pytest.mark.parametrize(("per_turn", "within"), [(96, 0.045), (192, 0.025)])
def test_bending_of_a_curved_bar(per_turn, within):
    """Closed form: a quarter ring, clamped, its end pushed along the clamp's tangent without turning:
    thin-ring energy of bending, stretch and shear. Slices that taper are too stiff by the square of
    their length over the wire's radius, the clamps add 1 %; slices of springs are as long as here with
    96 to a turn."""
    radius = 24 * RADIUS
    bricks, free = bar(radius * np.pi / 2, RADIUS, per_turn // 4, core=4, rings=2, arc=np.pi / 2)
    moment, area = area_moments(4, 2)
    inertia, section = moment * np.pi * RADIUS**4 / 4, area * np.pi * RADIUS**2
    due = 1e-6 * thin_quarter(radius, inertia, section)
    moved = np.zeros((bricks.nodes, 3))
    moved[:, 2] = 1e-6
    found = reactions(bricks, free, moved)[:, 2].sum()
    assert found == pytest.approx(due, rel=within)


def test_longitudinal_waves_run_at_the_speed_of_the_bar():
    """Closed form: a bar with one end fixed rings at (2 n - 1) c / (4 L), c = sqrt(E/rho), less
    Love's correction for its lateral inertia."""
    bricks, free = bar(LENGTH, RADIUS, 40)
    fixed = np.zeros(free.shape, dtype=bool)
    fixed[:, 2, 0] = True
    centre = int(np.argmin(np.hypot(*disc()[0].T)))
    fixed[centre, :2] = True  # the axis stays straight: longitudinal and torsional motion are left
    fixed[int(np.argmax(disc()[0][:, 0])), 1] = True
    found = frequencies(bricks, free, fixed, 3)
    order = np.array([1, 3, 5])
    wave = order * np.pi / (2 * LENGTH)
    slow = 1 / np.sqrt(1 + (STEEL.poisson_ratio * wave * RADIUS) ** 2 / 2)
    expected = wave * np.sqrt(YOUNG / DENSITY) * slow / (2 * np.pi)
    assert found == pytest.approx(expected, rel=0.003)


def test_bricks_converge_with_the_square_of_their_size():
    """Order: the lateral stiffness of a curved bar differs from finer meshes' by theta^2."""

    def force(spans: int) -> float:
        bricks, free = bar(16 * RADIUS, RADIUS, spans, arc=np.pi / 2)
        moved = np.zeros((bricks.nodes, 3))
        moved[:, 0] = 1e-6
        return float(reactions(bricks, free, moved)[:, 0].sum())

    coarse, middle, fine = force(6), force(12), force(24)
    assert (coarse - middle) / (middle - fine) == pytest.approx(4.0, abs=0.6)


def test_a_folded_brick_is_refused():
    """Contract: a section turned over makes no mesh."""
    nodes, quads = disc()
    grid = np.zeros((2, len(nodes), 3))
    grid[:, :, :2], grid[1, :, 2] = RADIUS * nodes, -1e-3
    with pytest.raises(InputError, match="folded"):
        sweep_bricks(grid, quads, STEEL)
