"""Job T with mass damping in PyElastica: explicit Cosserat rod with the helix as its stress-free
state.

It has no stiffness-proportional damping and no contact law of given line stiffness between coils,
so the other jobs are left out.
The middle of the first and last element stand at the clamps; the installed state is reached by a
slow, strongly damped
approach that is not counted.
"""

from __future__ import annotations

import elastica as ea
import numpy as np
from common import (
    BEND,
    CAM_SPEED,
    DAMPING,
    DENSITY,
    PER_TURN,
    PRECOMPRESSION,
    SHEAR,
    STRETCH,
    TURNS,
    WIRE,
    YOUNGS,
    answer,
    displacement,
    options,
    start,
    velocity,
    wire,
)


class Spring(ea.BaseSystemCollection, ea.Constraints, ea.Damping):
    """The simulator's parts."""


class Retainer(ea.ConstraintBase):
    """Both ends fixed; the upper one follows ``motion`` = (displacement, velocity) functions of
    time.
    """

    def __init__(self, motion, rest, directors, **kwargs):
        super().__init__(**kwargs)
        self.motion, self.rest, self.directors = motion, rest, directors

    def constrain_values(self, system, time):
        down = np.array([0.0, 0.0, -self.motion[0](time)])
        for node in (0, 1):
            system.position_collection[:, node] = self.rest[:, node]
        for node in (-1, -2):
            system.position_collection[:, node] = self.rest[:, node] + down
        for element in (0, -1):
            system.director_collection[..., element] = self.directors[..., element]

    def constrain_rates(self, system, time):
        system.velocity_collection[:, :2] = 0.0
        system.velocity_collection[:, -2:] = np.array([[0.0], [0.0], [-self.motion[1](time)]])
        system.omega_collection[:, 0] = 0.0
        system.omega_collection[:, -1] = 0.0


def helix(per_coil: int):
    """The rod, stress-free on the helix."""
    count = int(TURNS * per_coil)
    turn = (np.arange(count + 2) - 0.5) / per_coil
    position, _, speed = wire(turn, "T")
    _, frame, _ = wire((turn[1:] + turn[:-1]) / 2, "T")
    # The constructor wants the chord as third director; the true tangent is set afterwards.
    chord = np.diff(position, axis=0)
    chord /= np.linalg.norm(chord, axis=1)[:, None]
    outward = frame[:, :, 0] - np.sum(frame[:, :, 0] * chord, axis=1)[:, None] * chord
    outward /= np.linalg.norm(outward, axis=1)[:, None]
    given = np.stack([outward, np.cross(chord, outward), chord], axis=2)
    rod = ea.CosseratRod.straight_rod(
        count + 1,
        position[0],
        given[0][:, 2],
        given[0][:, 0],
        float(np.sum(speed[1:]) / per_coil),
        WIRE / 2,
        DENSITY,
        youngs_modulus=YOUNGS,
        shear_modulus=SHEAR,
        position=position.T.copy(),
        directors=np.transpose(given, (2, 1, 0)).copy(),
    )
    rod.director_collection[:] = np.transpose(frame, (2, 1, 0))
    for axis in range(3):
        rod.shear_matrix[axis, axis] = STRETCH[axis]
        rod.bend_matrix[axis, axis] = BEND[axis]
    rod.rest_sigma[:], rod.rest_kappa[:] = 0.0, 0.0
    rod.compute_internal_forces_and_torques(0.0)
    rod.rest_sigma[:], rod.rest_kappa[:] = rod.sigma, rod.kappa
    return rod


def simulator(rod, motion, damping: float, step: float, rest, directors):
    """A simulator of ``rod`` under ``motion`` with mass-proportional damping (1/s)."""
    spring = Spring()
    spring.append(rod)
    spring.constrain(rod).using(Retainer, motion=motion, rest=rest, directors=directors)
    spring.dampen(rod).using(
        ea.AnalyticalLinearDamper, uniform_damping_constant=damping, time_step=step
    )
    spring.finalize()
    return spring


def reaction(rod) -> float:
    """Axial force (N, compressive positive) in the first free element."""
    return -float(
        (rod.director_collection[..., 1].T @ rod.internal_stress[:, 1])[2] / rod.dilatation[1]
    )


def run() -> None:
    """One job with the options of the command line."""
    wanted = options()
    if wanted["job"] != "T" or wanted["damping"] != "mass":
        raise SystemExit(
            "PyElastica has no stiffness-proportional damping and no line contact of given stiffness"
        )
    rod = helix(wanted["per_coil"])
    rest, directors = rod.position_collection.copy(), rod.director_collection.copy()
    interval = 2 * np.pi / CAM_SPEED / PER_TURN
    substeps = int(np.ceil(interval / wanted["step"]))
    step, stepper = np.float64(interval / substeps), ea.PositionVerlet()
    approach, rest_time = 6e-3, 14e-3
    slow = (
        lambda t: PRECOMPRESSION * min(t / approach, 1.0),
        lambda t: PRECOMPRESSION / approach if t < approach else 0.0,
    )
    spring, now = simulator(rod, slow, 1500.0, step, rest, directors), np.float64(0.0)
    for _ in range(int(rest_time / step)):
        now = stepper.step(spring, now, step)
    rod.velocity_collection[:], rod.omega_collection[:] = 0.0, 0.0
    held = rod.position_collection.copy(), rod.director_collection.copy()
    rod = helix(wanted["per_coil"])
    rod.position_collection[:], rod.director_collection[:] = held
    spring, now = (
        simulator(rod, (displacement, velocity), DAMPING["mass"][0], step, rest, directors),
        np.float64(0.0),
    )
    rod.compute_internal_forces_and_torques(0.0)
    trace, started = [reaction(rod)], start()
    for _ in range(2 * PER_TURN):
        for _ in range(substeps):
            now = stepper.step(spring, now, step)
        trace.append(reaction(rod))
    answer(started, trace, steps=2 * PER_TURN * substeps)


if __name__ == "__main__":
    run()
