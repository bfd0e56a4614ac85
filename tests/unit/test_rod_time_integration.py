"""Time integration of the rod: against an independent integrator, bit for bit again, and the end of
a run that diverges.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from twins import rod_energy as twin
from twins.rod_cases import small_spring, uniform_spring
from valvetrain.cosserat.buffer import RodDynamics, stable_time_step
from valvetrain.cosserat.mesh import RodMesh, mesh_spring
from valvetrain.cosserat.static import RodStatics, compress
from valvetrain.cosserat.transient import RodTransient, simulate
from valvetrain.errors import InputError
from valvetrain.parameters.spring import SpringDefinition


def bump(time: np.ndarray, height: float, start: float, length: float) -> np.ndarray:
    """A C3 bump of ``height`` (m)."""
    phase = np.clip((np.asarray(time) - start) / length, 0, 1)
    return height * np.sin(np.pi * phase) ** 4


def reference(mesh: RodMesh, dynamics: RodDynamics, start, motion, times: np.ndarray) -> np.ndarray:
    """Seat force (N) of the same semi-discrete equations by an adaptive Runge-Kutta method; twins
    give the forces.
    """
    first, last, nv = mesh.first, mesh.last, mesh.vertices
    free, edges = slice(first + 1, last), slice(first + 1, last + 1)
    mass, inertia = mesh.node_mass[free, None], mesh.edge_inertia[edges]
    shapes = [
        (last - first - 1, 3),
        (last - first, 4),
        (last - first - 1, 3),
        (last - first, 3),
        (nv, 3),
    ]
    cuts = np.cumsum([a * b for a, b in shapes])

    def unpack(t, y):
        parts = [
            part.reshape(shape) for part, shape in zip(np.split(y, cuts[:-1]), shapes, strict=True)
        ]
        x, q = start.position.copy(), start.frame.copy()
        x[free], q[edges] = parts[0], parts[1] / np.linalg.norm(parts[1], axis=1)[:, None]
        x[last:, 2] -= motion(t) - start.compression
        return x, q, *parts[2:]

    def forces(t, y):
        x, q, v, w, low = unpack(t, y)
        out = twin.stretch(
            first, last, x, q, mesh.edge_length, mesh.stretch_stiffness, mesh.rest_stretch
        )[1]
        out += twin.bend(first, last, q, mesh.bend_stiffness, mesh.rest_bend)[1]
        relative = twin.product(twin.conjugate(q[:-1]), q[1:])
        strain = 2 * relative[:, 1:] - mesh.rest_bend
        # Viscous branch: the same torques with the moment of the strain less its low pass.
        extra = mesh.rest_bend + low
        extra_stiffness = dynamics.branch_stiffness * mesh.bend_stiffness
        out += twin.bend(first, last, q, extra_stiffness, extra)[1]
        line = mesh.contact
        out += twin.contact(
            x,
            line.offset,
            line.upper_place,
            line.lower_place,
            line.distance,
            line.length,
            dynamics.contact_stiffness,
        )[1]
        return out, strain, v, w, low, q

    def rate(t, y):
        out, strain, v, w, low, q = forces(t, y)
        acceleration = -out[free, :3] / mass - dynamics.mass_damping * v
        spin = (
            -out[first:last, 3:] - np.cross(w, inertia * w)
        ) / inertia - dynamics.mass_damping * w
        turn = 0.5 * twin.product(q[edges], np.concatenate([np.zeros((len(w), 1)), w], axis=1))
        return np.concatenate(
            [
                v.ravel(),
                turn.ravel(),
                acceleration.ravel(),
                spin.ravel(),
                ((strain - low) / dynamics.relaxation_time).ravel(),
            ]
        )

    strain0 = (
        2 * twin.product(twin.conjugate(start.frame[:-1]), start.frame[1:])[:, 1:] - mesh.rest_bend
    )
    begin = [
        start.position[free],
        start.frame[edges],
        np.zeros(shapes[2]),
        np.zeros(shapes[3]),
        strain0,
    ]
    found = solve_ivp(
        rate,
        (0, times[-1]),
        np.concatenate([p.ravel() for p in begin]),
        method="DOP853",
        t_eval=times,
        rtol=1e-7,
        atol=1e-9,
    )
    return np.array(
        [forces(t, y)[0][: first + 1, 2].sum() for t, y in zip(found.t, found.y.T, strict=True)]
    )


def prepared(spring: SpringDefinition, per_coil: int, compression: float, dynamics: RodDynamics):
    mesh = mesh_spring(spring, per_coil)
    return mesh, compress(RodStatics(mesh, dynamics.contact_stiffness), [compression])[-1].state


@pytest.mark.parametrize("clash", [False, pytest.param(True, marks=pytest.mark.long)])
@pytest.mark.slow
def test_march_against_an_independent_integrator(clash):
    """Same equations, other method: both damping kinds, large motion, and a clash at low contact
    stiffness.
    """
    dynamics = RodDynamics(
        mass_damping=200.0, stiffness_damping=4e-6, contact_stiffness=1e9, contact_damping_time=0.0
    )
    spring = small_spring(2.4, pitch=6e-3) if clash else uniform_spring(coils=1.6, pitch=6e-3)
    mesh, state = prepared(spring, 8, 1e-4, dynamics)
    height = 2.5e-3 if clash else 1e-3
    times = np.linspace(0, 2.4e-4, 49)
    motion = lambda t: 1e-4 + bump(t, height, 0.0, 2.4e-4)
    expected = reference(mesh, dynamics, state, motion, times)
    errors = []
    for step in (2e-7, 1e-7):
        run = simulate(mesh, state, motion, times[1], 48, dynamics, step)
        if clash:
            assert run.contact_peak.max() > 10
        errors.append(np.abs(run.seat_force - expected).max() / np.ptp(expected))
    assert errors[1] < 1e-3
    # With a clash the series of the contact kernel leaves a part that no time step removes.
    assert clash or errors[0] / errors[1] > 3.0


def clashing(step: float | None = None, samples: int = 60) -> RodTransient:
    dynamics = RodDynamics(stiffness_damping=8e-6)
    mesh, state = prepared(small_spring(), 16, 1e-3, dynamics)
    return simulate(
        mesh, state, lambda t: 1e-3 + bump(t, 2e-3, 0, 1.2e-3), 2e-5, samples, dynamics, step
    )


def test_the_same_run_gives_the_same_bits():
    one, two = clashing(), clashing()
    assert one.completed and one.contact_peak.max() > 1
    for name in (
        "seat_force",
        "retainer_force",
        "dense_seat_force",
        "position",
        "frame",
        "contact_force",
        "energy_dissipated",
    ):
        assert np.array_equal(getattr(one, name), getattr(two, name), equal_nan=True), name


def test_a_run_that_diverges_ends_with_what_it_computed():
    run = clashing(step=2e-6)
    assert not run.completed
    assert run.steps_done < run.steps
    assert 0 < len(run.time) < 61
    assert len(run.seat_force) == len(run.time) == len(run.position)


def test_a_time_step_that_is_not_positive_is_refused():
    with pytest.raises(InputError, match="time step"):
        clashing(step=0.0)


def test_the_stable_step_is_stable_and_not_wasteful():
    """Without damping the energy stays; at 1.15 times the limit (the safety taken off) the run
    diverges.
    """
    dynamics = RodDynamics(contact_stiffness=2e9)
    mesh = mesh_spring(uniform_spring(coils=3.0), 12, contact=False)
    state = compress(RodStatics(mesh), [2e-3])[-1].state
    limit = stable_time_step(mesh, dynamics)
    motion = lambda t: 2e-3 + bump(t, 1e-3, 0, 2e-4)
    calm = simulate(mesh, state, motion, 1e-5, 400, dynamics, limit)
    assert calm.completed and np.ptp(calm.seat_force[200:]) < 1.2 * np.ptp(calm.seat_force[:200])
    wild = simulate(
        mesh,
        state,
        motion,
        1.15 * limit / dynamics.step_safety,
        400,
        dynamics,
        1.15 * limit / dynamics.step_safety,
    )
    assert not wild.completed
