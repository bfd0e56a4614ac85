"""Modified sine flanks: a quick sine at both ends and a slow one between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.cam.contract import Array, LiftSpec
from valvetrain.cam.flanks import FlankEvents, FlankModel, flanked


@dataclass(frozen=True, slots=True, kw_only=True)
class ModifiedSine(FlankEvents):
    """Modified sine: peak velocity 1.7596, acceleration 5.5280, jerk 69.47 (per unit rise and flank)."""

    @property
    def joints(self) -> tuple[float, ...]:
        rise, fall = self.opening_end - self.opening_start, self.closing_end - self.closing_start
        flanks = ((self.opening_start, rise), (self.closing_start, fall))
        inner = [start + span * share for start, span in flanks for share in (0.125, 0.875)]
        return tuple(sorted((self.opening_start, self.opening_end, self.closing_start, self.closing_end, *inner)))

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        return flanked(self, _shape, cam_angle, derivative)


def _shape(x: Array, derivative: int) -> Array:
    quick, slow, phase = 4 * np.pi, 4 * np.pi / 3, np.pi / 3
    # sin(a x + b) differentiated n times is a^n sin(a x + b + n pi / 2).
    turn = derivative * np.pi / 2
    ends = quick**derivative * np.sin(quick * x + turn) / 4
    middle = slow**derivative * np.sin(slow * x + phase + turn) * 9 / 4
    line = np.pi * x if derivative == 0 else np.full_like(x, np.pi if derivative == 1 else 0.0)
    steps = (0.0, 2.0, 4.0) if derivative == 0 else (0.0, 0.0, 0.0)
    return np.select([x < 0.125, x < 0.875], [steps[0] + line - ends, steps[1] + line - middle], steps[2] + line - ends) / (4 + np.pi)


SPEC = LiftSpec(ModifiedSine, FlankModel)
