"""What no rod may depend on: place and direction in space, hand of the helix, numbering of the
wire, units, and size of a small load.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from twins.rod_cases import random_state, small_mesh, small_spring
from valvetrain.cosserat import quaternion as quat
from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.cosserat.mesh import mesh_spring
from valvetrain.cosserat.modes import natural_modes
from valvetrain.cosserat.state import RodState, free_state
from valvetrain.cosserat.static import RodStatics, compress
from valvetrain.cosserat.transient import simulate
from valvetrain.parameters.curves import PiecewiseLinear
from valvetrain.parameters.material import Material

EXAMPLES = settings(max_examples=20, deadline=None)


@EXAMPLES
@given(
    axis=st.tuples(*[st.floats(-3, 3)] * 3),
    shift=st.tuples(*[st.floats(-0.5, 0.5)] * 3),
    seed=st.integers(0, 50),
)
def test_energy_and_forces_turn_with_the_wire(axis, shift, seed):
    mesh = small_mesh(9)
    statics, state = RodStatics(mesh), random_state(mesh, seed)
    turn = quat.from_rotation_vector(np.array([axis]))
    matrix = quat.to_matrix(turn)[0]
    moved = RodState(
        state.position @ matrix.T + shift,
        quat.multiply(np.repeat(turn, len(state.frame), axis=0), state.frame),
    )
    energy, residual, *_ = statics.assemble(state, False)
    energy_moved, residual_moved, *_ = statics.assemble(moved, False)
    assert energy_moved == pytest.approx(energy, rel=1e-9)
    force, force_moved = residual.reshape(-1, 6), residual_moved.reshape(-1, 6)
    scale = np.abs(force).max()
    assert np.abs(force_moved[:, :3] - force[:, :3] @ matrix.T).max() < 1e-7 * scale
    assert np.abs(force_moved[:, 3:] - force[:, 3:]).max() < 1e-7 * scale


def test_left_and_right_hand_are_mirror_images():
    results = []
    for hand in ("right", "left"):
        statics = RodStatics(mesh_spring(small_spring(hand=hand), 12))
        result = compress(statics, [2.5e-3])[-1]
        assert np.count_nonzero(statics.gaps(result.state.position) < 0) > 0
        results.append(
            (
                result.retainer_force,
                natural_modes(statics, result.state, 8).natural_frequency,
                result.state.position,
            )
        )
    assert results[0][0] == pytest.approx(results[1][0], rel=1e-7)
    assert np.allclose(results[0][1], results[1][1], rtol=1e-6)
    assert np.abs(results[0][2] * [1, -1, 1] - results[1][2]).max() < 1e-9


def turned_over(spring):
    """The same wire with its coils counted from the other end."""
    total = spring.total_coils

    def flip(curve: PiecewiseLinear) -> PiecewiseLinear:
        return PiecewiseLinear(
            tuple(total - u for u in reversed(curve.coils)), tuple(reversed(curve.values))
        )

    return replace(
        spring,
        wire_diameter=flip(spring.wire_diameter),
        mean_diameter=flip(spring.mean_diameter),
        pitch=flip(spring.pitch),
        lower_end=spring.upper_end,
        upper_end=spring.lower_end,
    )


def test_counting_the_wire_from_the_other_end_changes_nothing():
    """Contact points sit on the upper wire, so they move when the wire is turned over: 0.02 % of
    the force, 0.15 % of a contact mode.
    """
    results = []
    for spring in (small_spring(), turned_over(small_spring())):
        statics = RodStatics(mesh_spring(spring, 20))
        result = compress(statics, [1.5e-3])[-1]
        assert np.count_nonzero(statics.gaps(result.state.position) < 0) > 0
        results.append(
            (result.retainer_force, natural_modes(statics, result.state, 6).natural_frequency)
        )
    assert results[0][0] == pytest.approx(results[1][0], rel=5e-4)
    assert np.allclose(results[0][1], results[1][1], rtol=3e-3)
    free = [
        RodStatics(mesh_spring(spring, 20, contact=False))
        for spring in (small_spring(), turned_over(small_spring()))
    ]
    forces = [compress(statics, [1.5e-3])[-1].retainer_force for statics in free]
    assert forces[0] == pytest.approx(
        forces[1], abs=65 * 1e-5
    )  # 65 vertices, each in balance to 1e-5 N


@EXAMPLES
@given(length=st.floats(0.2, 5.0), stiffness=st.floats(0.2, 5.0), density=st.floats(0.2, 5.0))
def test_units_scale_as_they_must(length, stiffness, density):
    """Lengths s, moduli e, density r: forces e s^2, frequencies sqrt(e / r) / s, at a compression s
    times as large.
    """
    base = small_spring()
    steel = base.material
    scaled = replace(
        base,
        wire_diameter=grown(base.wire_diameter, length),
        mean_diameter=grown(base.mean_diameter, length),
        pitch=grown(base.pitch, length),
        material=Material(
            "scaled",
            stiffness * steel.youngs_modulus,
            stiffness * steel.shear_modulus,
            density * steel.density,
        ),
    )
    one, other = (
        RodStatics(mesh_spring(base, 9), 2e9),
        RodStatics(mesh_spring(scaled, 9), 2e9 * stiffness),
    )
    first, second = compress(one, [1e-3])[-1], compress(other, [1e-3 * length])[-1]
    assert second.retainer_force == pytest.approx(
        first.retainer_force * stiffness * length**2, rel=1e-5
    )
    frequency = natural_modes(one, first.state, 4).natural_frequency
    assert np.allclose(
        natural_modes(other, second.state, 4).natural_frequency,
        frequency * np.sqrt(stiffness / density) / length,
        rtol=1e-4,
    )


def grown(curve: PiecewiseLinear, factor: float) -> PiecewiseLinear:
    return PiecewiseLinear(curve.coils, tuple(factor * value for value in curve.values))


def test_small_loads_superpose():
    statics = RodStatics(mesh_spring(small_spring(), 12, contact=False))
    tangent = natural_modes(statics, free_state(statics.mesh), 2).axial_stiffness
    for travel in (1e-7, 2e-7, -3e-7):
        assert compress(statics, [travel])[-1].retainer_force == pytest.approx(
            tangent * travel, rel=1e-3
        )


def test_small_motions_superpose():
    """Force of two small motions together is the sum of their forces."""
    mesh = mesh_spring(small_spring(2.4), 9, contact=False)
    pushes = [
        lambda t, s=start: 2e-8 * np.sin(np.pi * np.clip((t - s) / 2e-4, 0, 1)) ** 4
        for start in (0.0, 1e-4)
    ]
    runs = [
        simulate(
            mesh, free_state(mesh), motion, 5e-6, 100, RodDynamics(stiffness_damping=4e-6)
        ).seat_force
        for motion in pushes
    ]
    both = simulate(
        mesh,
        free_state(mesh),
        lambda t: pushes[0](t) + pushes[1](t),
        5e-6,
        100,
        RodDynamics(stiffness_damping=4e-6),
    ).seat_force
    assert np.abs(both - runs[0] - runs[1]).max() < 1e-4 * np.abs(both).max()
