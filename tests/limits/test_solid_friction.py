"""Friction of a solid wire: a roller that slides, sticks and runs down a slope, against closed forms; balance
of forces, moments and energy between coils."""

from __future__ import annotations

import numpy as np
import pytest
from validation.bars import MASS, NUMBERS, PRESS, STATIONS, STEP, Rolled

from solid_parts import helix
from valvetrain.continuum import contact_kernels as contact
from valvetrain.continuum import friction_kernels as friction
from valvetrain.continuum import time_kernels
from valvetrain.continuum.statics import SolidStatics
from valvetrain.continuum.transient import SolidDynamics, simulate_solid
from valvetrain.continuum.wire import SolidContactLaw, SolidMeshSize, SolidWire


def test_a_roller_slides_until_it_rolls():
    """Closed form: a bar thrown across itself at v slows by mu g and spins up until it rolls, after
    v / (mu g (1 + 1/k)), at v / (1 + k), k its inertia over m r^2; k / (1 + k) of its energy is heat."""
    bar, speed, coefficient = Rolled(), 1.0, 0.2
    bar.v.reshape(-1, 3, STATIONS)[:, 1] = speed
    k = bar.inertia
    time = speed / (coefficient * PRESS * (1 + 1 / k))
    half, _ = bar.run(round(time / 2 / STEP), coefficient)
    assert half == pytest.approx(speed - coefficient * PRESS * time / 2, rel=1e-2)
    across, rim = bar.run(round(time / STEP), coefficient)
    assert across == pytest.approx(speed / (1 + k), rel=1e-2)
    assert rim == pytest.approx(across, abs=0.01 * speed)
    energy = STATIONS * MASS * speed**2 / 2
    assert bar.heat == pytest.approx(energy * k / (1 + k), rel=1e-2)


@pytest.mark.parametrize("slope", [0.3, 1.2])
def test_a_roller_on_a_slope(slope):
    """Closed form: it rolls at g' / (1 + k) while the slope is below mu (1 + 1/k), without heat, and slides at
    g' - mu g beyond, g' along and g across the slope."""
    bar, coefficient = Rolled(), 0.2
    k, along = bar.inertia, slope * PRESS
    rolls = slope < coefficient * (1 + 1 / k)
    due = along / (1 + k) if rolls else along - coefficient * PRESS
    steps = 1000
    across, rim = bar.run(steps, coefficient, along)
    assert across == pytest.approx(due * steps * STEP, rel=0.02)
    energy = STATIONS * MASS * (across**2 + k * rim**2) / 2 + bar.heat + bar.stored
    done = STATIONS * MASS * along * across * steps * STEP / 2
    assert energy == pytest.approx(done, rel=0.02)
    assert (abs(bar.heat) < 1e-3 * done) if rolls else (bar.heat > 0.1 * done)


def test_friction_between_coils_leaves_all_momentum():
    """Closed form: with surfaces in motion on coils that press, points that slide carry mu N, forces and moments
    sum to zero, and friction takes power."""
    wire = SolidWire(helix(coils=3.0, pitch=4.0e-3), SolidMeshSize(16), SolidContactLaw(1e9))
    n, points = wire.stations, wire.contact_points.copy()
    x = wire.free_position * np.array([1.0, 1.0, 0.93])[None, :, None]
    x = np.ascontiguousarray(x).ravel()
    v = np.random.default_rng(5).standard_normal(x.size)
    centre, rate, push, spin, inverse, couple = (np.zeros(k * n) for k in (3, 3, 3, 3, 6, 3))
    contact.section_centres(x, wire.weights, n, centre)
    contact.section_centres(v, wire.weights, n, rate)
    contact.follow_feet(centre, n, points, 1.0, 20)
    contact.coil_forces(centre, rate, push, n, points, 0, NUMBERS.ctypes.data, 0.0, np.zeros(2))
    push[:] = 0.0
    friction.section_spins(x, v, wire.weights, n, centre, rate, inverse, spin)
    friction.rub_coils(centre, rate, spin, push, couple, n, points, 0.15, 1e-3, np.zeros(2))
    pressed = points.held[0].sum()
    assert pressed > 10.0
    rubbed = np.linalg.norm(points.held[1:], axis=0)
    assert np.all(rubbed <= 0.15 * points.held[0] * (1 + 1e-12))
    assert rubbed.sum() > 0.9 * 0.15 * pressed  # a point may stick
    force, moment = push.reshape(3, n), couple.reshape(3, n)
    whole = np.cross(centre.reshape(3, n).T, force.T).sum(axis=0) + moment.sum(axis=1)
    assert np.abs(force.sum(axis=1)).max() < 1e-12 * pressed
    assert np.abs(whole).max() < 1e-12 * pressed
    power = push @ rate + couple @ spin
    assert power < 0
    nodes = np.zeros(x.size)
    contact.spread_push(push, wire.weights, n, nodes)
    friction.spread_couple(x, couple, inverse, wire.weights, n, centre, nodes)
    assert nodes @ v == pytest.approx(power, rel=1e-9)


def test_energy_of_a_run_with_friction_closes():
    """Property: a spring of coils that lie close, driven until they rub: work of the retainer is stored or
    heat, and friction makes more of it heat."""
    lost = []
    for coefficient in (0.0, 0.3):
        law = SolidContactLaw(coil_friction=coefficient, seat_friction=coefficient)
        statics = SolidStatics(SolidWire(helix(coils=3.0, pitch=4.2e-3), SolidMeshSize(12), law))
        run = simulate_solid(
            statics, statics.start(), lambda t: 4e-4 * (1 - np.cos(6e3 * t)), 1e-5, 200, SolidDynamics(60.0)
        )  # fmt: skip
        assert run.completed and run.contact_peak.max() > 50.0
        work = float(np.ptp(run.energy[:, time_kernels.WORK_DONE]))
        assert np.abs(run.energy_gap).max() < 2e-3 * work
        lost.append(float(run.energy[-1, time_kernels.HEAT]) / work)
    assert lost[1] > 1.1 * lost[0]
