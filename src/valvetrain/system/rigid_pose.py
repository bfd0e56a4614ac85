"""Rigid motion of an assembled train: pose of every body at a valve lift, and the mass that
lift feels.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.system.train_forces import gap_state, gap_states, law_force
from valvetrain.system.train_system import TrainSystem


@dataclass(frozen=True)
class RigidPoses:
    """Poses of a train whose links are rigid and whose gaps between bodies are as with the valve
    closed, over the valve lift.

    ``lift`` (p,) in m; ``q`` (p, N) positions; ``reduced_mass`` (p,) in kg: sum of m_i (dq_i /
    dlift)**2, springs' share included.
    """

    valve_lifts: Array
    q: Array
    modes: Array
    reduced_masses: Array
    constant_force: Array

    @cached_property
    def _splines(self) -> tuple[Any, Any, Any, Any]:
        from scipy.interpolate import make_interp_spline

        values = (self.q, self.modes, self.reduced_masses, self.constant_force)
        return tuple(make_interp_spline(self.valve_lifts, value, k=5, axis=0) for value in values)

    def positions(self, valve_lift: ArrayLike) -> Array:
        """Positions (..., N) at a valve lift (m)."""
        return np.asarray(self._splines[0](valve_lift))

    def mode(self, valve_lift: ArrayLike, derivative: int = 0) -> Array:
        """Travel of every coordinate per travel of the valve (..., N), or its derivative by the
        lift (per m).
        """
        return np.asarray(self._splines[1](valve_lift, nu=derivative))

    def mass(self, valve_lift: ArrayLike, derivative: int = 0) -> Array:
        """Reduced mass (kg) at the valve or its derivative by the lift (kg/m)."""
        return np.asarray(
            self._splines[2].derivative(derivative)(valve_lift)
            if derivative
            else self._splines[2](valve_lift)
        )

    def weight(self, valve_lift: ArrayLike) -> Array:
        """Forces of gravity, holding torque and soft parts reduced to the valve (N, opening positive)."""
        return np.asarray(self._splines[3](valve_lift))


def rigid_poses(system: TrainSystem, count: int = 41) -> RigidPoses:
    """Rigid poses from a little below zero lift to a little above the largest. Raises
    :class:`InputError` when a body is not tied to the valve.
    """
    kinematics = system.mechanism.kinematics
    top = float(kinematics.maximum_lift + kinematics.lash)
    lifts = np.linspace(-0.02 * top, 1.02 * top, count)
    total = len(system.masses)
    home, _, _ = gap_state(system, np.zeros(total), 0.0)
    positions, modes = np.zeros((count, total)), np.zeros((count, total))
    q = np.zeros(total)
    for row, lift in enumerate(lifts):
        q = _solve_pose(system, q, lift, home)
        positions[row] = q
        modes[row] = _mode(system, q)
    masses = modes**2 @ system.masses
    loads = system.arrays.body[:, 1] + soft_forces(system, positions)
    return RigidPoses(lifts, positions, modes, masses, np.sum(modes * loads, axis=1))


def soft_forces(system: TrainSystem, positions: Array) -> Array:
    """Generalised forces (p, N) of a train's soft parts in its rigid poses (p, N); the valve is behind
    those by the lash.
    """
    mechanism, total = system.mechanism, np.zeros_like(positions)
    if not mechanism.soft:
        return total
    positions = positions.copy()
    positions[:, mechanism.valve_side] -= mechanism.kinematics.lash
    pens, gradients, _ = gap_states(system, positions, np.zeros(len(positions)))
    for k in mechanism.soft:
        forces = np.array([law_force(system, k, pen) for pen in pens[:, k].tolist()])
        total -= forces[:, None] * gradients[:, k]
    return total


def _constraints(system: TrainSystem, q: Array) -> tuple[Array, Array]:
    pens, gradients, _ = gap_state(system, q, 0.0)
    valve = system.mechanism.index(system.mechanism.valve)
    matrix = np.vstack([gradients[system.mechanism.held], np.eye(len(q))[valve]])
    return pens[system.mechanism.held], matrix


def _solve_pose(system: TrainSystem, q: Array, lift: float, home: Array) -> Array:
    valve, home = system.mechanism.index(system.mechanism.valve), home[system.mechanism.held]
    for _ in range(30):
        pens, matrix = _constraints(system, q)
        error = np.append(pens - home, q[valve] - lift)
        change, *_ = np.linalg.lstsq(matrix, -error, rcond=None)
        q = q + change
        if np.max(np.abs(change)) < 1e-14:
            break
    if np.max(np.abs(error)) > 1e-9:
        raise InputError(
            f"train '{system.name}' finds no rigid pose at {lift * 1e3:.2f} mm of valve lift; check its geometry and the roles of its "
            "interactions"
        )
    return q


def _mode(system: TrainSystem, q: Array) -> Array:
    _, matrix = _constraints(system, q)
    target = np.zeros(len(matrix))
    target[-1] = 1.0
    mode, _, rank, _ = np.linalg.lstsq(matrix, target, rcond=None)
    if rank < len(mode):
        raise InputError(
            f"train '{system.name}' has a body that no link and no contact ties to the valve; check the roles of its interactions"
        )
    return np.asarray(mode)
