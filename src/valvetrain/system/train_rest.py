"""A train at rest: found once, passed on as a value to every run."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from valvetrain.arrays import Array
from valvetrain.system.train_forces import generalised_forces, own_time_step
from valvetrain.system.train_system import TrainSystem

#: Points of the static spring curve over the lift.
CURVE_POINTS = 33
#: Steps of the search for rest without a thousandth of progress after which it ends.
PATIENCE = 25
#: Force (N, N m) that may be left over at rest.
BALANCED = 1e-7
#: Largest way (m, rad) that a body falls through clearances; one that falls further has no rest.
CLEARANCE = 1e-2
#: Largest step (m) of the search: where it holds for LONG_WAY steps in a row the way is long, and
#: it doubles.
MAX_STEP = 2e-4
LONG_WAY = 5


@dataclass(frozen=True, eq=False)
class TrainRest:
    """What every run of a train starts from.

    ``equilibrium`` (N,): positions at rest at cam angle zero. ``reference_force`` (N): level at
    which contact stiffnesses are judged. ``own_time_step`` (s): stable step of the train's own
    masses. ``lifts`` (p,) m and ``spring_forces`` (p,) N: static spring curve from zero to a little
    above the largest lift.
    """

    equilibrium: Array
    reference_force: float
    own_time_step: float
    lifts: Array
    spring_forces: Array

    def static_spring_force(self, valve_lift: Array) -> Array:
        """Static force (N) of all springs at retainer displacements (m), straight between the
        points and beyond them.
        """
        inside = np.interp(valve_lift, self.lifts, self.spring_forces)
        first, last = (
            (self.spring_forces[k + 1] - self.spring_forces[k])
            / (self.lifts[k + 1] - self.lifts[k])
            for k in (0, -2)
        )
        total: Array = (
            inside
            + first * np.minimum(valve_lift - self.lifts[0], 0.0)
            + last * np.maximum(valve_lift - self.lifts[-1], 0.0)
        )
        return total


def rest_of(system: TrainSystem) -> TrainRest:
    """The train at rest; finite-element springs take milliseconds per point of their curve."""
    top = (
        float(system.mechanism.kinematics.maximum_lift)
        if system.mechanism.kinematics is not None
        else 0.0
    )
    lifts = np.linspace(0.0, max(1.05 * top, 1e-5), CURVE_POINTS)
    forces = system.spring_forces(lifts)
    reference = max(4 * system.spring_force(top), 100.0)
    return TrainRest(
        static_equilibrium(system, 0.0), reference, own_time_step(system, reference), lifts, forces
    )


def static_equilibrium(system: TrainSystem, cam_angle: float, start: Array | None = None) -> Array:
    """Rest positions (N,) at a cam angle, by damped Newton with a numeric tangent from ``start``
    (none: valve closed, all at home); free bodies stay where they are.
    """
    spring_force = cache(
        system.spring_force
    )  # an equilibrium of a finite-element spring takes milliseconds
    q = np.zeros(len(system.masses)) if start is None else np.array(start, dtype=float)
    begin = q
    scale = np.maximum(system.masses, 1e-9)
    damping = 1e3
    residual = generalised_forces(system, q, cam_angle, spring_force)
    sizes: list[float] = []
    largest, capped = MAX_STEP, 0
    for _ in range(200):
        size = float(np.sum(residual**2 / scale))
        shifted = (
            generalised_forces(system, q + 1e-9 * row, cam_angle, spring_force)
            for row in np.eye(len(q))
        )
        tangent = np.array([(forces - residual) / 1e-9 for forces in shifted]).T
        # A body that falls through its clearance is on its way, though its force stays as it is.
        free = (np.abs(residual) > BALANCED) & ~np.any(tangent, axis=1)
        falls = np.any(free & (np.abs(q - begin) < CLEARANCE))
        sizes = [] if falls else [*sizes, size]
        if len(sizes) > PATIENCE and size > 0.999 * sizes[-1 - PATIENCE]:
            break  # contacts too hard for the tangent: the motion settles from here as well
        step = np.linalg.solve(-tangent + damping * np.diag(scale), residual)
        share = min(1.0, largest / max(float(np.max(np.abs(step))), 1e-30))
        step *= share
        trial = generalised_forces(system, q + step, cam_angle, spring_force)
        if float(np.sum(trial**2 / scale)) <= size:
            q, residual, damping = q + step, trial, max(damping / 5, 1e-3)
            capped = capped + 1 if share < 1.0 else 0
            largest *= 2.0 if capped > LONG_WAY else 1.0
        else:
            damping, largest, capped = damping * 10, MAX_STEP, 0
        if float(np.max(np.abs(residual))) < BALANCED or damping > 1e18:
            break
    return q
