"""Rows for whole trains: R, one run of 20 cycles against ``solve_ivp``, and W, a sweep of 200
speeds to steady state.

The right-hand side for ``solve_ivp`` is compiled from the same contact and gap kernels, so that
integrators are compared, not
languages; the same right-hand side as plain Python is timed beside it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

import valvetrain as vt
from benchmarks.own import Array, timed
from benchmarks.rows import Row
from valvetrain.integrate.train_kernel import gaps_and_laws, scratch_of
from valvetrain.integrate.train_record import CycleRecord, TrainOptions
from valvetrain.integrate.train_run import TrainRunner, runner
from valvetrain.integrate.train_tuples import Motion
from valvetrain.parameters.loading import load_case
from valvetrain.springs.contract import SpringModel
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.system.build import build
from valvetrain.system.train_rest import rest_of
from valvetrain.system.train_system import TrainSystem

CASE = "tdi-pushrod"


@njit(error_model="numpy")
def _slope(time_now, y, cam_speed, train, memory, chain, scratch, extremes, out):
    """Accelerations of train and spring chain; ``y`` = positions, then velocities, the chain's
    inner masses last.
    """
    index, body, retainer, room, gradients = (
        train.coordinate_of,
        train.body,
        train.retainer,
        scratch.gaps,
        scratch.gradients,
    )
    count, inner = body.shape[0], (chain.shape[0] - 1)
    total = count + inner
    q, v = y[:total], y[total:]
    angle = cam_speed * time_now
    motion = Motion(q, v, memory[0], memory[1], memory[2], memory[1], memory[2])
    gaps_and_laws(train, motion, angle, cam_speed, 0.0, scratch, extremes)
    for i in range(count):
        out[total + i] = body[i, 1]
    for k in range(index.shape[0]):
        rate = room[k, 1]
        for slot in range(4):
            if index[k, slot] >= 0:
                rate += gradients[k, slot] * v[index[k, slot]]
        force = room[k, 2] + room[k, 3] * rate
        for slot in range(4):
            if index[k, slot] >= 0:
                out[total + index[k, slot]] -= force * gradients[k, slot]
    # Chain rows: stiffness, inner mass, precompression, mass damping, stiffness damping.
    below, below_v = 0.0, 0.0
    for n in range(inner + 1):
        last = n == inner
        place, speed = (
            (chain[0, 2] + q[retainer], v[retainer]) if last else (q[count + n], v[count + n])
        )
        force = chain[n, 0] * (place - below + chain[0, 4] * (speed - below_v))
        if n > 0:
            out[total + count + n - 1] += force / chain[n - 1, 1]
        if last:
            out[total + retainer] -= force
        else:
            out[total + count + n] = -force / chain[n, 1] - chain[0, 3] * speed
        below, below_v = place, speed
    for i in range(count):
        out[total + i] /= body[i, 0]
    for i in range(total):
        out[i] = v[i]


def chain_of(spring: SpringModel) -> MultiMassSpring:
    """The spring as the chain of masses that these jobs run."""
    assert isinstance(spring, MultiMassSpring)
    return spring


def right_hand_side(
    system: TrainSystem, cam_speed: float, slope: Callable[..., None] = _slope
) -> tuple[Callable[[float, Array], Array], Array]:
    """f(t, y) of a train with one chain spring, and its state at rest."""
    arrays, spring = system.arrays, chain_of(system.springs[0])
    layout, count = spring.layout, len(system.masses)
    chain = np.zeros((len(layout.stiffness), 5))
    chain[:, 0], chain[:-1, 1] = layout.stiffness, layout.masses
    chain[0, 2:] = spring.precompression, spring.mass_damping, spring.stiffness_damping
    interactions, inner = len(arrays.kinds), len(layout.masses)
    states = arrays.memory_of[-1]
    scratch, extremes = scratch_of(interactions, count, states), np.zeros((interactions, 7))
    memory = np.zeros(states), np.zeros(0, dtype=np.int64), np.zeros(15)

    def function(time_now: float, y: Array) -> Array:
        out = np.empty(2 * (count + inner))
        slope(time_now, y, cam_speed, arrays, memory, chain, scratch, extremes, out)
        return out

    run = runner(system, cam_speed, TrainOptions())
    rest = run.initial_state()
    place = spring.precompression + rest.q[arrays.retainer]
    share = np.cumsum(1 / layout.stiffness)[:-1] / np.sum(1 / layout.stiffness)
    return function, np.concatenate([rest.q, place * share, np.zeros(count + inner)])


def measure() -> list[Row]:
    """R and W."""
    return [*one_run(), sweep()]


def one_run(cycles: int = 20, repeats: int = 3) -> list[Row]:
    """R: cam contact force of the last of 20 cycles, errors against a run with a step 30 times
    smaller.
    """
    case = load_case(CASE)
    system, cam_speed = build(case).members[0].system(), case.operation.engine_speeds[0] / 2
    assert isinstance(system, TrainSystem)
    rest = rest_of(system)

    def run(options: TrainOptions) -> tuple[TrainRunner, CycleRecord]:
        machine = runner(system, cam_speed, options, rest=rest)
        state = machine.initial_state()
        for _ in range(cycles):
            state, record = machine.cycle(state)
        return machine, record

    reference = run(TrainOptions(step_fraction=0.01))[1]
    retainer = system.arrays.retainer

    def error(displacement: Array) -> float:
        exact = reference.q[:, retainer]
        return float(np.sqrt(np.mean((displacement - exact) ** 2) / np.mean(exact**2)))

    title, masses = (
        f"R, whole train, {cycles} cycles",
        len(system.masses) + sum(len(chain_of(spring).layout.masses) for spring in system.springs),
    )
    rows, mine = [], []
    for fraction in (0.35, 0.05):
        wall, cpu, (machine, record) = timed(
            partial(run, TrainOptions(step_fraction=fraction)), repeats
        )
        mine.append((error(record.q[:, retainer]), cpu))
        rows.append(
            Row(
                title,
                "valvetrain",
                f"{masses} moving masses, {machine.steps} steps per cycle",
                wall,
                cpu,
                error=mine[-1][0],
            )
        )
    function, start = right_hand_side(system, cam_speed)
    period = 2 * np.pi / cam_speed
    at = period * (cycles - 1) + reference.cam_angle / cam_speed % period
    for method, tolerance in (("RK45", 1e-5), ("DOP853", 1e-7), ("LSODA", 1e-6)):
        function(0.0, start)
        begun = time.perf_counter(), time.process_time()
        found = solve_ivp(
            function,
            (0.0, cycles * period),
            start,
            method=method,
            rtol=tolerance,
            atol=1e-10,
            t_eval=np.sort(at),
        )
        wall, cpu = time.perf_counter() - begun[0], time.process_time() - begun[1]
        miss = error(found.y[retainer]) if found.success else float("nan")
        equal = [own for worse, own in mine if worse <= miss] or [mine[-1][1]]
        rows.append(
            Row(
                title,
                f"solve_ivp {method}",
                f"rtol {tolerance:g}, compiled right-hand side, {found.nfev} calls",
                wall,
                cpu,
                error=miss,
                ratio=cpu / min(equal),
            )
        )
    rows.append(_plain_python(system, cam_speed, title, mine, cycles))
    return rows


def _plain_python(
    system: TrainSystem, cam_speed: float, title: str, mine: list[tuple[float, float]], cycles: int
) -> Row:
    """The same with a right-hand side in plain Python, over a hundredth of a cycle and scaled up."""
    function, rest = right_hand_side(system, cam_speed, _slope.py_func)
    period, share = 2 * np.pi / cam_speed, 0.01
    begun = time.perf_counter(), time.process_time()
    found = solve_ivp(function, (0.0, share * period), rest, method="RK45", rtol=1e-5, atol=1e-10)
    wall, cpu = time.perf_counter() - begun[0], time.process_time() - begun[1]
    scale = cycles / share
    return Row(
        title,
        "solve_ivp RK45",
        f"plain Python right-hand side, {found.nfev} calls, scaled up",
        wall * scale,
        cpu * scale,
        ratio=cpu * scale / mine[0][1],
    )


def sweep(speeds: int = 200, workers: int = 2) -> Row:
    """W: steady state at 200 engine speeds, second call (compiled kernels on disk)."""
    case = load_case(CASE)
    engine_speeds = (np.linspace(0.3, 1.0, speeds) * case.operation.engine_speeds[0]).tolist()
    vt.sweep(case, engine_speeds[:4], spring_sets=("stock",), workers=1, critical_speeds=False)
    begun = time.perf_counter()
    found = vt.sweep(
        case, engine_speeds, spring_sets=("stock",), workers=workers, critical_speeds=False
    )
    wall = time.perf_counter() - begun
    settled = sum(solution.status.completed for solution in found.solutions)
    note = f"target 2 s; {settled} settled"
    return Row(
        "W, sweep to steady state",
        "valvetrain",
        f"{speeds} speeds, {workers} processes",
        wall,
        note=note,
    )
