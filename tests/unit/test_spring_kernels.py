"""Each spring kernel against a plain NumPy twin that steps whole matrices."""

from __future__ import annotations

import numpy as np
import pytest

from spring_parts import CLOSED_ENDS, MODELS, PRECOMPRESSION, SLIM, UNIFORM, drive, raised_cosine
from spring_shapes import beehive, cylindrical
from valvetrain.errors import InputError
from valvetrain.parameters.curves import Constant
from valvetrain.parameters.winding import OPEN_END
from valvetrain.springs.chain_layout import axial_clearance, chain_from_definition
from valvetrain.springs.chain_statics import (
    contact_depths,
    contact_rows,
    element_matrix,
    solve_static,
    static_curve,
)
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.springs.massless import MasslessSpring, massless_table
from valvetrain.springs.modal_uniform import ModalUniform
from valvetrain.springs.modal_varied import ModalVaried
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.nested import NestedSprings, RadialRubbing
from valvetrain.springs.wave_rod import WaveRod


def chain_twin(model: MultiMassSpring, state, displacement, velocity, time_step):
    """The chain stepped by dense matrices; returns forces (steps, 2), the final positions and the
    energy lost.

    Contacts lose by the rates before and after each kick, half of their impulse at either; the
    impulse of one that opens counts no more.
    """
    layout, n = model.layout, model.unknowns
    elements, rows = element_matrix(layout), contact_rows(layout)
    q, v = state[:n].copy(), state[n : 2 * n].copy()
    half = np.exp(-model.mass_damping * time_step / 2)
    forces, lost, impulse = np.empty((len(displacement), 2)), 0.0, np.zeros(len(rows))
    for k, (x, speed) in enumerate(zip(displacement, velocity, strict=True)):
        nodes = np.concatenate(([0.0], q, [model.precompression + x]))
        rates = np.concatenate(([0.0], v, [speed]))
        before = rows @ rates
        depth = contact_depths(layout, nodes)
        closed, stiffness = depth > 0, layout.contacts.stiffness
        net = -elements @ nodes - (stiffness * np.maximum(depth, 0)) @ rows
        rates[1:-1] = half * v + time_step / 2 * net[1:-1] / layout.masses
        damping = (
            stiffness * np.maximum(-depth, model.contact_damping_time * (rows @ rates)) * closed
        )
        pull = -model.stiffness_damping * elements @ rates
        lost -= time_step * rates @ pull + time_step**2 / 2 * np.sum(
            pull[1:-1] ** 2 / layout.masses
        )
        lost += before @ (impulse + time_step * damping) / 2
        impulse = time_step * damping
        net = net + pull - damping @ rows
        forces[k] = -net[-1], net[0]
        kicked = half * v + time_step * net[1:-1] / layout.masses
        lost += (1 - half**2) / 2 * layout.masses @ (v**2 + kicked**2)
        v = half * kicked
        q = q + time_step * v
    return forces, q, lost


@pytest.mark.parametrize(
    "name",
    ["chain", "chain-damped", "chain-7-per-coil", "chain-no-clash", "chain-card", "chain-one-mass"],
)
def test_chain_kernel_equals_its_twin(name):
    model = MODELS[name]
    time_step = min(1e-5, 0.8 * model.stable_time_step())
    displacement, velocity = raised_cosine(9e-3, 3e-3, time_step)
    state = model.initial_state(0.0)
    expected, position, lost = chain_twin(model, state, displacement, velocity, time_step)
    forces = drive(model, state, displacement, velocity, time_step)
    assert np.allclose(forces, expected, rtol=1e-7, atol=1e-5)
    assert np.allclose(state[: model.unknowns], position, atol=1e-10)
    assert state[2 * model.unknowns] == pytest.approx(lost, rel=1e-6, abs=1e-12)
    assert (lost > 0) == (name not in ("chain-no-clash", "chain-card", "chain-one-mass"))


def test_rod_with_clash_is_the_chain_of_its_layout():
    model = MODELS["wave-rod-clash"]
    time_step = 0.9 * model.stable_time_step()
    displacement, velocity = raised_cosine(9e-3, 3e-3, time_step)
    state = model.initial_state(0.0)
    expected, *_ = chain_twin(model.chain, state, displacement, velocity, time_step)
    assert np.allclose(
        drive(model, state, displacement, velocity, time_step), expected, rtol=1e-7, atol=1e-5
    )


@pytest.mark.parametrize("cells", [3, 4, 57])
def test_rod_kernel_equals_its_twin(cells):
    model = WaveRod(UNIFORM, cells, friction=40.0)
    time_step = 0.97 * model.stable_time_step()
    displacement, velocity = raised_cosine(6e-3, 4e-3, time_step)
    state = model.initial_state(0.0)
    forces = drive(model, state, displacement, velocity, time_step)
    q, v, half = np.zeros(cells - 1), np.zeros(cells - 1), np.exp(-40.0 * time_step)
    for k, x in enumerate(displacement):
        nodes = np.concatenate(([0.0], q, [x]))
        expected = 250.0 + model.cell_stiffness * (x - q[-1]), 250.0 + model.cell_stiffness * q[0]
        assert forces[k] == pytest.approx(expected, rel=1e-9)
        v = half * (
            half * v + time_step * model.cell_stiffness / model.cell_mass * np.diff(nodes, 2)
        )
        q = q + time_step * v


def test_modal_kernel_equals_direct_integration():
    """Same motion through the undamped-in-x equation q'' + 2 z w q' + w**2 q = -c x'' by an
    independent solver.
    """
    from scipy.integrate import solve_ivp

    model, lift, duration = ModalUniform(UNIFORM, 3, damping_ratio=0.03), 6e-3, 5e-3
    time_step = 1e-6
    displacement, velocity = raised_cosine(lift, duration, time_step)
    forces = drive(model, model.initial_state(0.0), displacement, velocity, time_step)

    def acceleration(t):
        s, c = np.sin(np.pi * t / duration), np.cos(np.pi * t / duration)
        return 4 * lift * (np.pi / duration) ** 2 * (3 * s**2 * c**2 - s**4)

    omega = model.circular_frequencies

    def rate(t, y):
        return np.concatenate(
            (y[3:], -model.shares * acceleration(t) - 2 * 0.03 * omega * y[3:] - omega**2 * y[:3])
        )

    times = np.arange(len(displacement))[::200] * time_step
    run = solve_ivp(rate, (0, times[-1]), np.zeros(6), t_eval=times, rtol=1e-10, atol=1e-13)
    pull = run.y[:3] + 2 * 0.03 / omega[:, None] * run.y[3:]
    seat = 250.0 + UNIFORM.rate * (displacement[::200] + np.pi * (model.numbers @ pull))
    assert np.allclose(forces[::200, 1], seat, atol=1e-3 * np.ptp(seat))


def test_chain_impulse_is_the_change_of_momentum():
    model = MODELS["chain"]
    time_step = 0.8 * model.stable_time_step()
    displacement, velocity = raised_cosine(9e-3, 5e-3, time_step)
    state = model.initial_state(0.0)
    forces = drive(model, state, displacement, velocity, time_step)
    momentum = model.layout.masses @ state[model.unknowns : 2 * model.unknowns]
    assert time_step * np.sum(forces[:, 0] - forces[:, 1]) == pytest.approx(momentum, rel=1e-8)


def test_nested_without_rubbing_is_the_sum_of_its_members():
    model = MODELS["nested"]
    time_step = 0.5 * model.stable_time_step()
    displacement, velocity = raised_cosine(8e-3, 4e-3, time_step)
    together = drive(model, model.initial_state(0.0), displacement, velocity, time_step)
    apart = sum(
        drive(member, member.initial_state(0.0), displacement, velocity, time_step)
        for member in model.members
    )
    assert np.allclose(together, apart, rtol=1e-12)
    assert model.retainer_mass() == pytest.approx(
        sum(member.retainer_mass() for member in model.members)
    )


def rubbed(normal_force: float) -> tuple[NestedSprings, np.ndarray, float]:
    """Two rods after a violent event and 30 ms of surge: model, state and energy left above the
    static one.
    """
    model = NestedSprings(
        WaveRod(UNIFORM, 60), WaveRod(SLIM, 80), RadialRubbing(0.15, normal_force)
    )
    time_step = 0.9 * model.stable_time_step()
    displacement, velocity = raised_cosine(8e-3, 5e-3, time_step, rest=30e-3)
    state = model.initial_state(0.0)
    start = model.energy(state, 0.0).total
    drive(model, state, displacement, velocity, time_step)
    return model, state, model.energy(state, 0.0, 0.0, time_step).total - start


def test_light_rubbing_damps_the_surge_and_a_tight_fit_locks_the_springs():
    free, light, tight = (rubbed(force) for force in (0.0, 20.0, 1e7))
    assert free[0].energy(free[1], 0.0).dissipated == 0.0
    assert light[0].energy(light[1], 0.0).dissipated > 0.1 * free[2]
    assert light[2] < 0.8 * free[2]
    # Locked: the sections that rub (every one of them listed once) move together.
    model, state, _ = tight
    pairs, _ = model._pairs
    velocity = state[model.unknowns :]
    outer, inner = velocity[pairs[:, 0]], velocity[model.outer.unknowns + pairs[:, 1]]
    assert np.max(np.abs(outer)) > 0.5
    assert np.allclose(outer, inner, atol=1e-9)


def test_gaps_are_those_of_the_wire():
    """Uniform open spring: every neighbour is pitch less wire away, so the chain goes solid after
    that travel per turn.
    """
    spring = cylindrical(3.8e-3, 22e-3, 7e-3, 6.0, ends="open")
    layout = chain_from_definition(spring, 72, 1e10)
    pairs = (layout.contacts.upper_coil >= 1) & (layout.contacts.upper_coil < 6)
    inside = pairs & (layout.contacts.gap > 0)
    assert np.allclose(layout.contacts.gap[inside], 3.2e-3)
    before, after = static_curve(layout, np.array([0.98, 1.02]) * 6 * 3.2e-3)[1]
    assert before == pytest.approx(layout.rate)
    # solid but for the first and last turn, which still twist and bend between clamp and contact
    assert after > 20 * before


def test_conical_coils_nest_when_one_slips_inside_the_next():
    cone = beehive(
        3e-3, 40e-3, 12e-3, 1.0, Constant(5e-3), 5.0, lower_end=OPEN_END, upper_end=OPEN_END
    )
    assert np.all(np.isinf(axial_clearance(cone, np.array([3.0, 4.0]))))
    steep = beehive(
        3e-3, 24e-3, 16e-3, 1.0, Constant(5e-3), 5.0, lower_end=OPEN_END, upper_end=OPEN_END
    )
    shift = 0.5 * (16e-3 - 24e-3) / 4
    assert axial_clearance(steep, np.array([3.5]))[0] == pytest.approx(
        5e-3 - np.sqrt(3e-3**2 - shift**2)
    )


def test_statics_of_a_clashing_chain_balances_every_node():
    model = MultiMassSpring.from_definition(CLOSED_ENDS, PRECOMPRESSION)
    for compression in (0.0, 5e-3, 15e-3, 17e-3, 20e-3):
        nodes = solve_static(model.layout, compression)
        depth = np.maximum(contact_depths(model.layout, nodes), 0)
        net = element_matrix(model.layout) @ nodes + (
            model.layout.contacts.stiffness * depth
        ) @ contact_rows(model.layout)
        assert np.max(np.abs(net[1:-1])) < 1e-6 * max(1.0, abs(net[-1]))
    forces, rates = static_curve(model.layout, np.linspace(0, 16e-3, 30))
    assert np.all(np.diff(forces) > 0) and rates[-1] > 1.1 * rates[0]


def test_massless_table_follows_the_wire_and_closes_coils():
    table = massless_table(CLOSED_ENDS, PRECOMPRESSION, 9e-3, points=81)
    chain = MultiMassSpring.from_definition(CLOSED_ENDS, PRECOMPRESSION, masses_per_coil=24)
    for x in (0.0, 2.05e-3, 6.3e-3):
        assert table.force(table.initial_state(x), x).retainer == pytest.approx(
            chain.force(chain.initial_state(x), x).retainer, rel=1e-4
        )
    assert table.tangent(table.initial_state(8e-3), 8e-3) > 1.05 * table.tangent(
        table.initial_state(-5e-3), -5e-3
    )


@pytest.mark.parametrize(
    "name",
    ["chain", "chain-no-clash", "wave-rod", "wave-rod-clash", "modal-uniform", "finite-element"],
)
def test_sections_move_from_the_seat_to_the_retainer(name):
    """Static state: no motion at the seat, all of it at the retainer, against z; nothing moves at
    the installed state.
    """
    model = MODELS[name]
    rest = model.outputs(model.initial_state(0.0), 0.0)
    assert np.allclose(rest.axial_displacement, 0.0, atol=1e-12)
    shown = model.outputs(model.initial_state(4e-3), 4e-3)
    assert shown.axial_displacement[0] == pytest.approx(0.0, abs=1e-12)
    assert shown.axial_displacement[-1] == pytest.approx(-4e-3)
    assert np.all(np.diff(shown.coil_number) > 0)
    assert np.all(np.diff(shown.axial_displacement[:: max(1, len(shown.coil_number) // 8)]) <= 1e-6)
    assert len(shown.coil_gap) == len(shown.upper_coil) == len(shown.coil_contact_force)
    assert np.all((shown.coil_contact_force > 0) <= (shown.coil_gap < 1e-12))


BAD = [
    (lambda: MasslessSpring(1e4, 1.0, 0.05, 1.5), "effective_mass_fraction"),
    (lambda: MultiMassSpring.from_definition(CLOSED_ENDS, -7e-3), "compression"),
    (lambda: MultiMassSpring.from_card(3e4, 250.0, 0.0), "mass"),
    (lambda: EquivalentSpring(3e4, 250.0, 0.0), "mass"),
    (lambda: WaveRod(UNIFORM, 2), "cells"),
    (lambda: WaveRod(UNIFORM).with_time_step(0.0), "time step"),
    (lambda: ModalUniform(UNIFORM, 0), "modes"),
    (lambda: ModalUniform(UNIFORM, 2, (600.0,)), "frequencies"),
    (lambda: ModalUniform(UNIFORM, 30, stiffness_damping=1e-4), "critical"),
    (lambda: ModalVaried((600.0,), 0.01, (0.0, 8e-3), (0.0, 4e2), 7e-3).solve(lambda a: 5e-3 + 0 * a, 200.0), "extend the curve"),
    (lambda: NestedSprings(MODELS["massless"], MODELS["wave-rod"], RadialRubbing(0.1, 10.0)), "sections"),
]  # fmt: skip


@pytest.mark.parametrize(("build", "word"), BAD)
def test_impossible_springs_are_refused_with_the_reason(build, word):
    with pytest.raises(InputError, match=word):
        build()
