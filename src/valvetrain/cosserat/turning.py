"""Statics of a rod whose retainer may turn about the axis: it takes the angle at which no
torque holds it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

import numpy as np

from valvetrain.cosserat.rates import end_stiffness, retainer_torque, turning_field
from valvetrain.cosserat.state import RodState, advance
from valvetrain.cosserat.static import Equilibrium, RodStatics

#: Rounds of Newton's method on the angle.
ROUNDS = 12


class TurningStatics(RodStatics):
    """As :class:`RodStatics`, the retainer and the wire fixed to it free to turn about the axis,
    without friction.
    """

    turns: ClassVar[bool] = True

    def solve(self, state: RodState, compression: float) -> Equilibrium:
        """Equilibrium at a retainer displacement (m) and at the angle where the torque is none."""
        found = super().solve(state, compression)
        for _ in range(ROUNDS):
            torque = retainer_torque(self, found.state)
            if not found.converged or abs(torque) <= self.options.tolerance * self._radius:
                return found
            found = super().solve(
                self._turned(found.state, -torque / end_stiffness(self, found.state)[1, 1]),
                compression,
            )
        return replace(found, converged=False)

    def _turned(self, state: RodState, angle: float) -> RodState:
        """The retainer turned by ``angle`` (rad), the wire following by the tangent."""
        _, _, band, contact = self.assemble(state)
        field = turning_field(self, state)
        load = (self.tangent(state) @ field.ravel()).reshape(-1, 6)
        change = angle * self.follow(field, band, contact, load)
        last, x = self.mesh.last, state.position
        cosine, sine = np.cos(angle), np.sin(angle)
        change[last:, 0] = (cosine - 1) * x[last:, 0] - sine * x[last:, 1]
        change[last:, 1] = sine * x[last:, 0] + (cosine - 1) * x[last:, 1]
        return advance(state, change.ravel(), state.compression)


def rotation_of(statics: RodStatics, state: RodState) -> float:
    """Angle (rad) by which the retainer has turned from the free state, within half a turn."""
    last, free = statics.mesh.last, statics.mesh.position
    here = np.arctan2(state.position[last, 1], state.position[last, 0]) - np.arctan2(
        free[last, 1], free[last, 0]
    )
    return float((here + np.pi) % (2 * np.pi) - np.pi)
