"""The motion that a train settled on, as a start for its run at another speed."""

from __future__ import annotations

from dataclasses import dataclass

from valvetrain.integrate.train_run import TrainRunner, TrainState
from valvetrain.springs.carry import carried_state
from valvetrain.springs.contract import SpringModel


@dataclass(frozen=True, eq=False)
class Orbit:
    """State at the start of a cam turn, with the springs (as the run's step made them) and the cam speed (rad/s) that it belongs to."""

    state: TrainState
    springs: tuple[SpringModel, ...]
    cam_speed: float

    def at(self, ready: TrainRunner) -> TrainState:
        """The state for the same train at the speed of ``ready``: positions as they are, velocities in the ratio of the cam speeds (so
        that the rigid part of the motion fits), springs on the grid of the new step."""
        state, share = self.state.copy(), ready.cam_speed / self.cam_speed
        state.v[:] *= share
        retainer = ready.system.arrays.retainer
        place, rate = float(state.q[retainer]), float(state.v[retainer])
        springs = []
        for values, spring, other in zip(state.springs, self.springs, ready.springs, strict=True):
            values[spring.unknowns : 2 * spring.unknowns] *= share
            springs.append(carried_state(values, spring, other, place, rate))
        return TrainState(state.q, state.v, tuple(springs), state.law_state, state.held, 0.0)
