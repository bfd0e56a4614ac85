"""What the springs of a train do over a revolution by themselves: the linear part of its cycle map, and their
periodic answer to a motion of the retainer.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numba import types

from valvetrain.arrays import Array
from valvetrain.compiled import njit
from valvetrain.integrate.spring_slot import OPTIONS, SPRING_FUNCTION, compiled_once
from valvetrain.integrate.train_record import TrainState
from valvetrain.integrate.train_run import TrainRunner
from valvetrain.springs.contract import SpringModel

#: Disturbance of a scaled state from which a linear step is read.
DISTURBANCE = 1e-6
#: Largest number of positions and velocities of a spring whose powers are taken: beyond, they cost more cycles than
#: they save.
LARGEST = 120
#: Levels of lift at which the step of a spring is read, and change of it from which levels count.
LEVELS, AGREE = 6, 1e-3

_vector, _f8, _i8 = types.Array(types.float64, 1, "C"), types.float64, types.int64
_matrix, _integers = types.Array(types.float64, 2, "C"), types.Array(types.int64, 1, "C")
_STEPS = types.void(SPRING_FUNCTION, _vector, _integers, _matrix, _vector, _f8)
_TURN = types.void(SPRING_FUNCTION, _vector, _integers, _vector, _matrix, _i8, _f8)


@njit(**OPTIONS)
def _step_all(spring, parameters, integers, states, positions, time_step):
    """Advance every row of ``states`` (n, entries) by one step, the retainer at rest at ``positions`` (n,)."""
    for j in range(states.shape[0]):
        spring(parameters, integers, states[j], positions[j], 0.0, time_step)


@njit(**OPTIONS)
def _driven(spring, parameters, integers, state, motion, steps, time_step):
    """Advance a spring's ``state`` over a turn of ``steps``, its retainer on the cubic through ``motion`` (2, S):
    displacement and its velocity.
    """
    samples = motion.shape[1]
    interval = steps * time_step / samples
    for n in range(steps):
        k = n * samples // steps
        s = n * samples / steps - k
        after = (k + 1) % samples
        change = motion[0, after] - motion[0, k]
        first, last = interval * motion[1, k], interval * motion[1, after]
        place = motion[0, k] + s * (
            first + s * (3 * change - 2 * first - last + s * (first + last - 2 * change))
        )
        rate = first + s * (6 * change - 4 * first - 2 * last + 3 * s * (first + last - 2 * change))
        spring(parameters, integers, state, place, rate / interval, time_step)


@dataclass(frozen=True, eq=False)
class _Part:
    """A spring of the train by its number, where its entries are in the packed state, their weights,
    and the inverse of one less its return over a turn, in weighted entries.
    """

    number: int
    entries: slice
    weights: Array
    inverse: Array


@dataclass(frozen=True, eq=False)
class SpringReturn:
    """The springs' own part of the cycle map of a train at one speed; without ``parts`` where no spring has a
    linear return of moderate size that decays.
    """

    runner: TrainRunner
    parts: tuple[_Part, ...]

    def corrected(self, change: Array) -> Array:
        """The ``change`` of a packed state over a cycle as a step to the fixed point: solved with one less the
        springs' return, other entries as they are.
        """
        step = change.copy()
        for part in self.parts:
            step[part.entries] = part.inverse @ (change[part.entries] * part.weights) / part.weights
        return step

    def answer(self, state: TrainState, motion: Array) -> TrainState:
        """The ``state`` with the springs in their periodic answer to the ``motion`` (2, S) of the retainer over
        a turn: displacement (m) and its derivative by the cam angle (m/rad).
        """
        springs = list(state.springs)
        in_time = motion * np.array([[1.0], [self.runner.cam_speed]])
        for part in self.parts:
            model, values = self.runner.springs[part.number], springs[part.number].copy()
            count = len(part.weights)
            begin = values[:count].copy()
            arrays = self.runner.spring_arrays[part.number]
            turn = self.runner.steps, self.runner.time_step
            compiled_once(_driven, _TURN)(model.kernel, *arrays, values, in_time, *turn)
            change = (values[:count] - begin) * part.weights
            springs[part.number] = springs[part.number].copy()
            springs[part.number][:count] = begin + part.inverse @ change / part.weights
        return replace(state, springs=tuple(springs))


def spring_return(runner: TrainRunner, weights: Array) -> SpringReturn:
    """The return of the springs of a train at its speed; ``weights``: one over the scale of every entry of the
    packed state, which ends with those of the springs.
    """
    place, parts = len(weights) - sum(2 * one.unknowns for one in runner.springs), []
    lift = rigid_motion(runner)[0]
    for number, spring in enumerate(runner.springs):
        entries = slice(place, place + 2 * spring.unknowns)
        own, place = weights[entries], entries.stop
        if 0 < len(own) <= LARGEST and np.all(own > 0):
            turn = _over_a_turn(spring, runner.spring_arrays[number], own, runner, lift)
            if np.all(np.isfinite(turn)) and np.max(np.abs(np.linalg.eigvals(turn))) < 1:
                inverse = np.linalg.inv(np.eye(len(own)) - turn).astype(np.float64)
                parts.append(_Part(number, entries, own, inverse))
    return SpringReturn(runner, tuple(parts))


def spring_basis(runner: TrainRunner, weights: Array) -> Array:
    """Columns in which the springs' own return is nearly normal, for the scaled packed state: the eigenvectors of a
    step of each spring with its retainer held, unit vectors elsewhere.
    """
    basis = np.eye(len(weights))
    place = len(weights) - sum(2 * one.unknowns for one in runner.springs)
    for spring, arrays in zip(runner.springs, runner.spring_arrays, strict=True):
        entries = slice(place, place + 2 * spring.unknowns)
        place = entries.stop
        if not 0 < 2 * spring.unknowns <= LARGEST:
            continue
        (step,) = _one_steps(spring, arrays, weights[entries], runner.time_step, np.zeros(1))
        values, vectors = np.linalg.eig(step)
        kept = vectors[:, values.imag >= 0] * np.exp(
            -0.5j * np.angle(np.sum(vectors[:, values.imag >= 0] ** 2, axis=0))
        )
        paired = values[values.imag >= 0].imag > 0
        sizes = np.where(
            paired,
            np.sqrt(np.linalg.norm(kept.real, axis=0) * np.linalg.norm(kept.imag, axis=0)),
            1.0,
        )
        columns = np.hstack([kept.real / sizes, kept.imag[:, paired] / sizes[paired]])
        if columns.shape[1] == len(columns) and np.all(np.isfinite(columns)):
            basis[entries, entries] = columns
    return basis


def rigid_motion(runner: TrainRunner) -> Array:
    """Lift (m) of the rigid valve and its derivative by the cam angle over a turn, (2, S); zeros of a train without
    one.
    """
    kinematics = runner.system.mechanism.kinematics
    return np.zeros((2, 1)) if kinematics is None else kinematics.turn


def _one_steps(
    spring: SpringModel, arrays: Any, weights: Array, step: float, lifts: Array
) -> Array:
    """Derivatives (L, n, n) of a spring's weighted state after one step by that before, at rest with the retainer
    held at each of ``lifts`` (L,) in m.
    """
    count = len(weights)
    rests = [np.asarray(spring.initial_state(lift), dtype=float) for lift in lifts]
    states = np.repeat(np.array(rests), count + 1, axis=0)
    each = states.reshape(len(lifts), count + 1, -1)
    each[:, :count, :count] += np.diag(DISTURBANCE / weights)
    held = np.repeat(np.asarray(lifts, dtype=float), count + 1)
    compiled_once(_step_all, _STEPS)(spring.kernel, *arrays, states, held, step)
    moved = (each[:, :count] - each[:, count:])[:, :, :count]
    return np.asarray(moved.transpose(0, 2, 1) * weights[:, None] / DISTURBANCE)


def _over_a_turn(
    spring: SpringModel, arrays: Any, weights: Array, runner: TrainRunner, lift: Array
) -> Array:
    """Derivative of a spring's weighted state after a turn by that before, the retainer on ``lift`` (S,): a power of
    one step where the steps at no and at full lift agree, else the product of those at :data:`LEVELS` of lift.
    """
    held, unit = np.linspace(0.0, float(np.max(lift)), LEVELS + 1), np.eye(len(weights))
    closed, opened = _one_steps(spring, arrays, weights, runner.time_step, held[[0, -1]])
    if np.max(np.abs(opened - closed)) < AGREE * np.max(np.abs(closed - unit)):
        return np.linalg.matrix_power(closed, runner.steps)
    between = _one_steps(spring, arrays, weights, runner.time_step, held[1:-1])
    steps = (closed, *between, opened)
    levels = np.round(lift / held[-1] * LEVELS).clip(0, LEVELS).astype(int)
    cuts = [0, *(np.flatnonzero(np.diff(levels)) + 1), len(lift)]
    turn = unit
    for begin, end in pairwise(cuts):
        count = end * runner.steps // len(lift) - begin * runner.steps // len(lift)
        turn = np.linalg.matrix_power(steps[levels[begin]], count) @ turn
    return turn
