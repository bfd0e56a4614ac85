"""Rigid motion of an assembled train: pose of every body at a valve lift, and the mass that
lift feels.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from valvetrain.errors import InputError
from valvetrain.system.train_forces import gap_state
from valvetrain.system.train_system import TrainSystem

Array = NDArray[np.float64]
FREE_PLACES = ("cam", "seat", "support")


@dataclass(frozen=True)
class RigidPoses:
    """Poses of a train whose links are rigid and whose gaps (cam and seat apart) are just closed,
    over the valve lift.

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
        """Constant forces (gravity, holding torque) reduced to the valve (N, opening positive)."""
        return np.asarray(self._splines[3](valve_lift))


def rigid_poses(system: TrainSystem, count: int = 41) -> RigidPoses:
    """Rigid poses from a little below zero lift to a little above the largest. Raises
    :class:`InputError` when a body is not tied to the valve.
    """
    kinematics = system.mechanism.kinematics
    top = float(kinematics.maximum_lift + kinematics.lash)
    lifts = np.linspace(-0.02 * top, 1.02 * top, count)
    places = [k for k, name in enumerate(system.interaction_names) if name not in FREE_PLACES]
    total = len(system.masses)
    valve = system.mechanism.index(system.mechanism.valve)
    pins = [valve] + [i for i, name in enumerate(system.coordinate_names) if name == "support"]
    home, _, _ = gap_state(system, np.zeros(total), 0.0)
    positions, modes = np.zeros((count, total)), np.zeros((count, total))
    q = np.zeros(total)
    for row, lift in enumerate(lifts):
        q = _solve_pose(system, q, lift, places, pins, home)
        positions[row] = q
        modes[row] = _mode(system, q, places, pins)
    masses = modes**2 @ system.masses
    return RigidPoses(lifts, positions, modes, masses, modes @ system.arrays.body[:, 1])


def _constraints(
    system: TrainSystem, q: Array, places: list[int], pins: list[int]
) -> tuple[Array, Array]:
    pens, gradients, _ = gap_state(system, q, 0.0)
    matrix = np.vstack([gradients[places], np.eye(len(q))[pins]])
    return pens, matrix


def _solve_pose(
    system: TrainSystem, q: Array, lift: float, places: list[int], pins: list[int], home: Array
) -> Array:
    target = np.zeros(len(pins))
    target[0] = lift
    for _ in range(30):
        pens, matrix = _constraints(system, q, places, pins)
        error = np.concatenate((pens[places] - home[places], q[pins] - target))
        change, *_ = np.linalg.lstsq(matrix, -error, rcond=None)
        q = q + change
        if np.max(np.abs(change)) < 1e-14:
            break
    if np.max(np.abs(error)) > 1e-9:
        raise InputError(
            f"train '{system.name}' finds no rigid pose at {lift * 1e3:.2f} mm of valve lift; check its geometry"
        )
    return q


def _mode(system: TrainSystem, q: Array, places: list[int], pins: list[int]) -> Array:
    _, matrix = _constraints(system, q, places, pins)
    target = np.zeros(len(matrix))
    target[len(places)] = 1.0
    mode, *_ = np.linalg.lstsq(matrix, target, rcond=None)
    return np.asarray(mode)
