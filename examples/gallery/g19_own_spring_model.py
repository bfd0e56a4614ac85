"""
May I bring a spring model of my own?
=====================================

A spring model is one class that fulfils a contract: forces at both ends, energy, and a compiled
step. Here an air spring as racing engines
have it: gas in a cylinder, pressed together by the lift, F = p A (h / (h - x))^n. It has no coils,
so nothing surges.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

import valvetrain as vt
from valvetrain.integrate.run import run
from valvetrain.springs.contract import EndForces, SpringEnergy, SpringOutputs
from valvetrain.system.prescribed import PrescribedSpring


@njit
def advance(parameters, integers, state, retainer_displacement, retainer_velocity, time_step):
    """Both end forces (N); there is nothing inside that could move. ``parameters``: preload (N),
    height (m), exponent.
    """
    force = (
        parameters[0] * (parameters[1] / (parameters[1] - retainer_displacement)) ** parameters[2]
    )
    return force, force


@dataclass(frozen=True)
class AirSpring:
    """Gas of ``preload`` (N) in a cylinder of ``height`` (m) with the valve closed; ``exponent`` of
    its change of state.
    """

    preload: float
    height: float
    exponent: float = 1.35
    name: str = "air"
    unknowns = 0

    @property
    def kernel(self):
        return advance

    def parameters(self):
        return np.array([self.preload, self.height, self.exponent])

    def integers(self):
        return np.zeros(1, dtype=np.int64)

    def with_time_step(self, time_step):
        return self

    def initial_state(self, retainer_displacement):
        return np.zeros(1)

    def stable_time_step(self):
        return float("inf")

    def force(self, state, retainer_displacement, retainer_velocity=0.0):
        return EndForces(
            *advance(
                self.parameters(),
                self.integers(),
                state,
                retainer_displacement,
                retainer_velocity,
                0.0,
            )
        )

    def tangent(self, state, retainer_displacement):
        return (
            self.exponent
            * self.force(state, retainer_displacement).seat
            / (self.height - retainer_displacement)
        )

    def energy(self, state, retainer_displacement, retainer_velocity=0.0, time_step=0.0):
        share = (self.height / (self.height - retainer_displacement)) ** (self.exponent - 1) - 1
        return SpringEnergy(0.0, self.preload * self.height * share / (self.exponent - 1), 0.0)

    def outputs(self, state, retainer_displacement, retainer_velocity=0.0):
        return SpringOutputs(*self.force(state, retainer_displacement))

    def retainer_mass(self):
        return 0.0


# %%
# It moves with the lift of a case of the library, at 16 000 rpm. To run it by a word in every
# command, add a line in a package of your own
# (see "Add a spring model").

lift = vt.cam.build_lift_law(vt.load_case("job-t").lift_law)
spring = AirSpring(preload=300.0, height=25e-3)
result = run(PrescribedSpring((spring,), lift), cam_speed=8000 * np.pi / 30)
force = result.channel("seat_force")
print(f"{result.status.code}: {force.min():.0f} to {force.max():.0f} N")

figure = result.plot()
