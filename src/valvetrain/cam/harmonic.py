"""Simple harmonic flanks: the acceleration jumps where they meet a dwell."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.cam.contract import Array, LiftSpec
from valvetrain.cam.flanks import FlankEvents, FlankModel, flanked


@dataclass(frozen=True, slots=True, kw_only=True)
class Harmonic(FlankEvents):
    """``s = (1 - cos(pi x)) / 2``: peak velocity pi / 2, acceleration pi^2 / 2. Only the velocity is continuous at a dwell."""

    joint_continuity: ClassVar[int] = 1

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        return flanked(self, _shape, cam_angle, derivative)


def _shape(x: Array, derivative: int) -> Array:
    if derivative == 0:
        return (1 - np.cos(np.pi * x)) / 2
    if derivative == 1:
        return np.pi / 2 * np.sin(np.pi * x)
    return np.pi**2 / 2 * np.cos(np.pi * x) if derivative == 2 else -(np.pi**3) / 2 * np.sin(np.pi * x)


SPEC = LiftSpec(Harmonic, FlankModel)
