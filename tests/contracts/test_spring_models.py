"""One battery for every spring model: what the spring contract promises."""

from __future__ import annotations

from dataclasses import fields
from functools import cache

import numpy as np
import pytest
from numba import njit, types

from spring_parts import (
    CLOSED_ENDS,
    LINEAR_RATE,
    MODELS,
    PRECOMPRESSION,
    build_models,
    drive,
    raised_cosine,
)
from valvetrain.cosserat.layout import row
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.registry import places
from valvetrain.runs.statics import rod_statics
from valvetrain.springs.contract import (
    SpringModel,
    SpringOutputs,
    outputs_at,
)
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.spec import spring_model

NAMES = list(MODELS)
#: The published modal form scales its modes' force with k(x) and keeps their frequencies: where
#: k(x) is no constant its forces at the
#: retainer are no gradient of any energy, and work is not stored exactly. Its straight line, where
#: they are, is tested for both.
EXACT_ENERGY = [name for name in NAMES if name != "modal-varied-curved"]
#: Words of the spring models that ship and run in time in every system.
MOVING = [
    word
    for word, place in places("springs").items()
    if place.startswith("valvetrain.")
    and not (spring_model(word).no_motion or spring_model(word).alone)
]


WIRE = InstalledSpring(wire=CLOSED_ENDS, precompression=PRECOMPRESSION).with_options(
    "finite-element", elements_per_coil=8
)
CARD = InstalledSpring(card=SpringCard(rate=30e3, preload=250.0, mass=0.04))


@cache
def statics():
    return rod_statics(spring_model("finite-element").build(WIRE), 12e-3, steps=6, modes=12)


@pytest.mark.parametrize("word", MOVING)
def test_every_word_of_the_registry_is_in_this_battery(word):
    for spring in (WIRE, CARD):
        if not spring_model(word).why_not(spring):
            model = spring_model(word).build(spring, statics())
            assert isinstance(model, SpringModel)
            assert type(model) in {type(member) for member in MODELS.values()}


def disturbed(model, displacement: float, seed: int = 1) -> np.ndarray:
    """A state away from equilibrium, contacts open and closed, at rest."""
    if isinstance(model, FiniteElementRod):
        return swinging(model, displacement, seed)
    state = model.initial_state(displacement)
    rng = np.random.default_rng(seed)
    state[: model.unknowns] += 2e-4 * rng.standard_normal(model.unknowns)
    return state


def swinging(model: FiniteElementRod, displacement: float, seed: int) -> np.ndarray:
    """The rod caught in motion and stopped (its frames allow no random disturbance)."""
    time_step = usable_step(model)
    motion, velocity = raised_cosine(2 * displacement, 4e-3, time_step)
    count = int(np.argmin(np.abs(motion[: len(motion) // 2] - displacement))) + 1
    state = model.with_time_step(time_step).initial_state(0.0)
    drive(
        model.with_time_step(time_step),
        state,
        motion[:count],
        (1 + 0.1 * seed) * velocity[:count],
        time_step,
    )
    drive(
        model.with_time_step(time_step),
        state,
        np.full(40 * seed, displacement),
        np.zeros(40 * seed),
        time_step,
    )
    for name in ("VX", "VY", "VZ", "W1", "W2", "W3"):
        row(state, name, model.mesh.vertices)[:] = 0.0
    return state


def usable_step(model) -> float:
    return min(1e-5, 0.9 * model.stable_time_step())


@pytest.mark.parametrize("name", NAMES)
def test_is_a_spring_model(name):
    model = MODELS[name]
    assert isinstance(model, SpringModel)
    assert model.parameters().dtype == np.float64 and model.parameters().flags.c_contiguous
    assert model.integers().dtype == np.int64
    assert len(model.initial_state(0.0)) >= 2 * model.unknowns
    assert model.retainer_mass() >= 0 and model.stable_time_step() > 0


@pytest.mark.parametrize("name", NAMES)
def test_kernel_gives_the_forces_of_the_class_and_zero_step_keeps_the_state(name):
    model = MODELS[name]
    state = disturbed(model, 1e-3)
    if not isinstance(model, FiniteElementRod):
        state[model.unknowns : 2 * model.unknowns] = 0.3 * np.random.default_rng(2).standard_normal(
            model.unknowns
        )
    before = state.copy()
    forces = model.kernel(model.parameters(), model.integers(), state, 1e-3, 0.4, 0.0)
    expected = model.force(before, 1e-3, 0.4)
    assert forces == pytest.approx(tuple(expected), rel=1e-10, abs=1e-9)
    if isinstance(model, FiniteElementRod):
        # Its positions hold the retainer's own vertices, which a call places; asked again it
        # answers the same.
        assert model.kernel(
            model.parameters(), model.integers(), state, 1e-3, 0.4, 0.0
        ) == pytest.approx(forces, rel=1e-9)
    else:
        assert np.array_equal(state[: 2 * model.unknowns], before[: 2 * model.unknowns])
    shown = model.outputs(before, 1e-3, 0.4)
    assert (shown.retainer_force, shown.seat_force) == pytest.approx(tuple(expected), rel=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_outputs_of_many_instants_are_those_of_each(name):
    """Contract: what loops over all samples read is what the model answers at one."""
    model, draws = MODELS[name], np.random.default_rng(3)
    places, speeds = np.array([0.0, 1e-3, 4e-3]), np.array([0.0, 0.4, -0.7])
    states = np.array([disturbed(model, float(place)) for place in places])
    moved = slice(model.unknowns, 2 * model.unknowns)
    if not isinstance(model, FiniteElementRod):
        states[:, moved] = 0.3 * draws.standard_normal((3, model.unknowns))
    together = outputs_at(model, states.copy(), places, speeds)
    for shown, state, place, speed in zip(together, states, places, speeds, strict=True):
        alone = model.outputs(state, float(place), float(speed))
        for field in fields(SpringOutputs):
            one, other = (getattr(found, field.name) for found in (shown, alone))
            if isinstance(one, dict):
                assert one.keys() == other.keys()
            else:
                np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("displacement", [0.0, 4e-3])
def test_a_spring_at_rest_presses_seat_and_retainer_alike(name, displacement):
    """Action and reaction; and more where it is compressed further."""
    model = MODELS[name]
    forces = model.force(model.initial_state(displacement), displacement)
    assert forces.seat == pytest.approx(forces.retainer, rel=1e-4) and forces.seat > 100.0
    assert (
        displacement == 0.0 or forces.seat > model.force(model.initial_state(0.0), 0.0).seat + 20.0
    )


@pytest.mark.parametrize("name", NAMES)
def test_tangent_equals_finite_difference(name):
    model, step = MODELS[name], 1e-9
    for seed in (1, 2, 3):
        state = disturbed(model, 2e-3, seed)
        up, down = (model.force(state, 2e-3 + sign * step).retainer for sign in (1, -1))
        assert model.tangent(state, 2e-3) == pytest.approx((up - down) / (2 * step), rel=1e-5)


@pytest.mark.parametrize("name", EXACT_ENERGY)
def test_force_is_the_energy_gradient(name):
    model, step = MODELS[name], 1e-7
    for seed in (1, 2, 3):
        state = disturbed(model, 2e-3, seed)
        up, down = (model.energy(state, 2e-3 + sign * step).potential for sign in (1, -1))
        force = model.force(state, 2e-3).retainer
        assert force == pytest.approx((up - down) / (2 * step), rel=1e-5, abs=1e-3)


def test_the_curved_modal_spring_gains_little_energy_from_its_changing_stiffness():
    """What the published form costs: work and energy gained and lost part by some per cent of the
    turnover, not more.
    """
    model, time_step = MODELS["modal-varied-curved"], 5e-6
    displacement, velocity = raised_cosine(9e-3, 5e-3, time_step, rest=3e-3)
    state = model.initial_state(0.0)
    forces = drive(model, state, displacement, velocity, time_step)
    pieces = (forces[1:, 0] + forces[:-1, 0]) / 2 * np.diff(displacement)
    end, start = (
        model.energy(state, 0.0, 0.0, time_step),
        model.energy(model.initial_state(0.0), 0.0),
    )
    gap = abs(end.total - start.total + end.dissipated - float(pieces.sum())) / float(
        np.abs(pieces).sum()
    )
    assert 1e-3 < gap < 0.05


@pytest.mark.parametrize("name", NAMES)
def test_inner_forces_are_the_energy_gradient(name):
    """One kick of the kernel from rest must point down the potential: m dv = -dE/dq dt, checked by
    the work it does.
    """
    model = MODELS[name]
    if model.unknowns == 0 or isinstance(model, FiniteElementRod):
        pytest.skip("no unknowns, or frames that cannot be shifted freely")
    state, step = disturbed(model, 2e-3), 1e-9
    parameters, integers = model.parameters(), model.integers()
    kicked = state.copy()
    model.kernel(parameters, integers, kicked, 2e-3, 0.0, step)
    move = kicked[: model.unknowns] - state[: model.unknowns]
    scale = 1e-7 / np.max(np.abs(move))
    potentials = []
    for sign in (1, -1):
        shifted = state.copy()
        shifted[: model.unknowns] += sign * scale * move
        potentials.append(model.energy(shifted, 2e-3).potential)
    downhill = -(potentials[0] - potentials[1]) / (2 * scale)
    # From rest the kick's kinetic energy is half of force times displacement.
    assert 2 * model.energy(kicked, 2e-3).kinetic == pytest.approx(downhill, rel=1e-3)


@pytest.mark.parametrize("name", NAMES)
def test_static_state_stays_and_its_force_is_the_slope_of_its_energy(name):
    model = MODELS[name]
    for displacement in (0.0, 3e-3, 8e-3):
        state = model.initial_state(displacement)
        force = model.force(state, displacement)
        # Newton of the finite-element rod stops at a residual of some 1e-4 N.
        tolerance = 3e-6 if isinstance(model, FiniteElementRod) else 1e-8
        assert force.seat == pytest.approx(force.retainer, rel=tolerance)
        step = 2e-6
        energies = [
            model.energy(model.initial_state(displacement + s), displacement + s).potential
            for s in (step, -step)
        ]
        assert force.retainer == pytest.approx((energies[0] - energies[1]) / (2 * step), rel=2e-4)
        if name in LINEAR_RATE:
            assert force.retainer == pytest.approx(
                250.0 + LINEAR_RATE[name] * displacement, rel=1e-9
            )
        rest = np.full(200, displacement)
        step = usable_step(model)
        forces = drive(
            model.with_time_step(step) if isinstance(model, FiniteElementRod) else model,
            state,
            rest,
            np.zeros(200),
            step,
        )
        assert np.allclose(forces, force.retainer, rtol=10 * tolerance)


@pytest.mark.parametrize("name", NAMES)
def test_slow_motion_follows_the_static_curve(name):
    model, lift = MODELS[name], 4e-3
    time_step = usable_step(model)
    model = model.with_time_step(time_step)
    displacement, velocity = raised_cosine(lift, 0.2, time_step)
    half = len(displacement) // 2
    forces = drive(model, model.initial_state(0.0), displacement[:half], velocity[:half], time_step)
    static = model.force(
        model.initial_state(displacement[half - 1]), displacement[half - 1]
    ).retainer
    if name == "nested-rubbing":
        # What is left is friction: at most mu N at either end.
        assert np.all(np.abs(forces[-1] - static) < 0.12 * 60.0)
    else:
        assert forces[-1] == pytest.approx(np.full(2, static), rel=3e-3)


@pytest.mark.parametrize("name", EXACT_ENERGY)
@pytest.mark.parametrize(
    ("lift", "duration"), [(4e-3, 8e-3), (9e-3, 5e-3)], ids=["gentle", "clashing"]
)
def test_energy_balance(name, lift, duration):
    """Work of the retainer = energy gained + dissipated, over an event and the surge after it."""
    model = MODELS[name]
    # A fine step of the motion, and a quarter of the model's own limit; a wave rod keeps its grid,
    # or its limit would follow.
    time_step = min(1e-5, 0.25 * model.stable_time_step())
    if isinstance(model, FiniteElementRod):
        model = model.with_time_step(time_step)
    displacement, velocity = raised_cosine(lift, duration, time_step, rest=3e-3)
    state = model.initial_state(0.0)
    start = model.energy(state, 0.0)
    forces = drive(model, state, displacement, velocity, time_step)
    work = float(np.sum((forces[1:, 0] + forces[:-1, 0]) / 2 * np.diff(displacement)))
    end = model.energy(state, 0.0, 0.0, time_step)
    turnover = float(np.sum(np.abs((forces[1:, 0] + forces[:-1, 0]) / 2 * np.diff(displacement))))
    assert end.total - start.total + end.dissipated == pytest.approx(work, abs=1e-3 * turnover)
    assert end.dissipated >= -1e-12
    if name in (
        "chain-damped",
        "rod-damped",
        "modal-damped",
        "modal-varied-damped",
        "reduced-rod-damped",
        "nested-rubbing",
    ):
        assert end.dissipated > 1e-4 * turnover
    if name in ("wave-rod", "modal-uniform", "modal-varied", "chain-card", "chain-no-clash"):
        assert end.dissipated == 0.0


def test_clash_happens_in_the_clashing_event_and_costs_energy():
    """The battery's contact cases do touch: otherwise its balances would prove nothing."""
    for name in ("chain", "chain-7-per-coil", "wave-rod-clash", "nested", "reduced-rod"):
        model = MODELS[name]
        time_step = 0.5 * model.stable_time_step()
        displacement, velocity = raised_cosine(9e-3, 5e-3, time_step, rest=3e-3)
        state = model.initial_state(0.0)
        drive(model, state, displacement, velocity, time_step)
        assert model.energy(state, 0.0).dissipated > 1e-6


@cache
def built_again():
    return build_models()


@pytest.mark.parametrize("name", NAMES)
def test_is_deterministic(name):
    traces = []
    for models in (MODELS, built_again()):
        model = models[name]
        time_step = usable_step(model)
        displacement, velocity = raised_cosine(6e-3, 4e-3, time_step)
        traces.append(drive(model, model.initial_state(0.0), displacement, velocity, time_step))
    assert np.array_equal(*traces)


@pytest.mark.parametrize("name", NAMES)
def test_with_time_step_is_stable_at_that_step(name):
    time_step = (
        4e-6 if MODELS[name].stable_time_step() > 4e-6 else 0.9 * MODELS[name].stable_time_step()
    )
    model = MODELS[name].with_time_step(time_step)
    assert model.stable_time_step() >= time_step * (1 - 1e-9)
    displacement, velocity = raised_cosine(9e-3, 6e-3, time_step, rest=30e-3)
    forces = drive(model, model.initial_state(0.0), displacement, velocity, time_step)
    assert np.all(np.abs(forces) < 5e3)
    static = model.force(model.initial_state(0.0), 0.0).retainer
    assert abs(np.mean(forces[-1000:, 1]) - static) < 0.2 * static


_FIRST_CLASS = types.FunctionType(
    types.UniTuple(types.float64, 2)(
        types.Array(types.float64, 1, "C"),
        types.Array(types.int64, 1, "C"),
        types.Array(types.float64, 1, "C"),
        types.float64,
        types.float64,
        types.float64,
    )
)


@pytest.mark.parametrize(
    "name",
    [
        "massless",
        "massless-table",
        "chain",
        "wave-rod",
        "modal-uniform",
        "modal-varied-curved",
        "nested-rubbing",
    ],
)
def test_kernel_fits_a_loop_compiled_once_for_all_models(name):
    model = MODELS[name]

    @njit(
        types.UniTuple(types.float64, 2)(
            _FIRST_CLASS,
            types.Array(types.float64, 1, "C"),
            types.Array(types.int64, 1, "C"),
            types.Array(types.float64, 1, "C"),
        )
    )
    def call(kernel, parameters, integers, state):
        return kernel(parameters, integers, state, 1e-3, 0.0, 0.0)

    state = model.initial_state(0.0)
    direct = model.kernel(model.parameters(), model.integers(), state.copy(), 1e-3, 0.0, 0.0)
    assert call(model.kernel, model.parameters(), model.integers(), state) == direct
