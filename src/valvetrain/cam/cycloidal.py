"""Cycloidal flanks: sine-shaped acceleration, zero at both ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.cam.contract import TURN, Array, LiftSpec
from valvetrain.cam.flanks import FlankEvents, FlankModel, flanked


@dataclass(frozen=True, slots=True, kw_only=True)
class Cycloidal(FlankEvents):
    """``s = x - sin(2 pi x) / (2 pi)``: peak velocity 2, acceleration 2 pi, jerk 4 pi^2 (per unit rise and flank)."""

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        return flanked(self, _shape, cam_angle, derivative)


def _shape(x: Array, derivative: int) -> Array:
    if derivative == 0:
        return x - np.sin(TURN * x) / TURN
    if derivative == 1:
        return 1 - np.cos(TURN * x)
    return TURN * np.sin(TURN * x) if derivative == 2 else TURN**2 * np.cos(TURN * x)


SPEC = LiftSpec(Cycloidal, FlankModel)
