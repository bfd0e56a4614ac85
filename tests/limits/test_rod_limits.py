"""Limits of the rod: slender close-coiled helix, slow motion, small motion."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

from twins.rod_cases import STEEL, uniform_spring
from valvetrain.cosserat.buffer import RodDynamics, inertia_of
from valvetrain.cosserat.mesh import mesh_spring
from valvetrain.cosserat.section import shear_factor
from valvetrain.cosserat.state import free_state
from valvetrain.cosserat.static import RodStatics, compress
from valvetrain.cosserat.transient import simulate
from valvetrain.parameters.curves import Constant


def rate_error(index: float, lead: float) -> float:
    """Rate of the uncorrected rod over G d^4 / (8 D^3 n), less one."""
    wire, turns = 1e-3, 8.0
    diameter = index * wire
    spring = uniform_spring(wire, diameter, 1.02 * wire, turns)
    # A lead angle below that of touching coils is no spring, but it is a rod.
    object.__setattr__(spring, "pitch", Constant(np.pi * diameter * np.tan(lead)))
    mesh = mesh_spring(spring, 48, curvature_correction=False, contact=False)
    travel = 1e-4 * diameter
    rate = compress(RodStatics(mesh), [travel])[-1].retainer_force / travel
    return rate / (STEEL.shear_modulus * wire**4 / (8 * diameter**3 * turns)) - 1


def test_rate_tends_to_the_close_coiled_formula_with_the_square_of_the_index():
    """Coils nearly touching (lead angle 1.05 / (pi c)), so that every correction falls with 1 /
    c^2.
    """
    errors = np.array(
        [rate_error(index, np.arctan(1.05 / (np.pi * index))) for index in (15.0, 30.0, 60.0)]
    )
    assert np.all(np.abs(np.log2(errors[:-1] / errors[1:]) - 2) < 0.25)
    assert abs(errors[-1]) < 1.5e-4


def test_rate_of_a_flat_ring_differs_from_the_formula_by_its_direct_shear():
    """Lead angle far below the index' own: what is left is 1 / (2 kappa c^2) of direct shear."""
    for index in (15.0, 30.0):
        shear = 1 / (1 + 1 / (2 * shear_factor(STEEL) * index**2)) - 1
        assert rate_error(index, 1e-4) == pytest.approx(shear, rel=0.02)


def test_usual_spring_against_shooting_on_the_rods_equations():
    """Wire 3.8, D 22, pitch 7 mm, five turns clamped: 0.990041 and 0.984626 of the formula at 0.1
    and 7 mm (DOP853, 1e-11).
    """
    formula = STEEL.shear_modulus * 3.8e-3**4 / (8 * 22e-3**3 * 5)
    mesh = mesh_spring(
        uniform_spring(3.8e-3, 22e-3, 7e-3, 5.0), 96, curvature_correction=False, contact=False
    )
    for travel, expected in ((1e-4, 0.990041), (7e-3, 0.984626)):
        assert compress(RodStatics(mesh), [travel])[
            -1
        ].retainer_force / travel / formula == pytest.approx(expected, abs=2e-5)


def test_slow_motion_tends_to_statics_with_the_square_of_the_speed():
    """Seat force of a damped run less the static force at the same retainer displacement."""
    mesh = mesh_spring(uniform_spring(coils=3.0), 9, contact=False)
    statics = RodStatics(mesh)
    start = compress(statics, [1e-3])[-1].state
    gaps = []
    for duration in (0.02, 0.04):
        motion = lambda t, d=duration: 1e-3 + 2e-3 * np.sin(np.pi * np.clip(t / d, 0, 1)) ** 4
        run = simulate(mesh, start, motion, duration / 40, 40, RodDynamics(mass_damping=300.0))
        static = np.array(
            [compress(statics, [x], start=start)[-1].seat_force for x in run.displacement]
        )
        gaps.append(np.abs(run.seat_force - static).max())
    # Mass damping leaves a force proportional to the speed, inertia one to its square.
    assert gaps[0] < 2.0
    assert 1.8 < gaps[0] / gaps[1] < 4.5


def test_small_motion_is_the_sum_of_the_rods_modes():
    """Impulse of 10 nm against modal superposition on the tangent, all modes of a small mesh,
    integrated apart.
    """
    mesh = mesh_spring(uniform_spring(coils=1.5), 8, contact=False)
    statics = RodStatics(mesh)
    tangent, free = statics.tangent(free_state(mesh)).toarray(), statics.free
    scale = 1 / np.sqrt(inertia_of(mesh)[free])
    squares, modes = eigh(scale[:, None] * tangent[np.ix_(free, free)] * scale)
    drive = np.zeros(len(free))
    drive[6 * mesh.last + 2 :: 6] = -1.0  # the retainer moves down
    load = modes.T @ (scale * -(tangent @ drive)[free])
    reaction = (tangent[2::6][: mesh.first + 1].sum(axis=0)[free] * scale) @ modes
    direct = float((tangent @ drive)[2::6][: mesh.first + 1].sum())

    def push(t):
        return 1e-8 * np.sin(np.pi * np.clip(np.asarray(t) / 2e-4, 0, 1)) ** 4

    count = len(squares)
    times = np.linspace(0, 4e-4, 81)
    found = solve_ivp(
        lambda t, y: np.concatenate([y[count:], load * push(t) - squares * y[:count]]),
        (0, times[-1]),
        np.zeros(2 * count),
        method="DOP853",
        t_eval=times,
        rtol=1e-9,
        atol=1e-18,
    )
    expected = reaction @ found.y[:count] + direct * push(times)
    run = simulate(mesh, free_state(mesh), push, 5e-6, 80, RodDynamics(), 2e-8)
    assert np.abs(run.seat_force - expected).max() < 5e-3 * np.abs(expected).max()
