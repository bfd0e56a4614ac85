"""No lift: the valve stays shut."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.cam.contract import HIGHEST_DERIVATIVE, Array, LiftSpec, check_derivative
from valvetrain.parameters.schema_lift import LiftModel


@dataclass(frozen=True, slots=True)
class Zero:
    """Zero lift at every angle."""

    @property
    def continuity(self) -> int:
        return HIGHEST_DERIVATIVE

    @property
    def joints(self) -> tuple[float, ...]:
        return ()

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        check_derivative(derivative)
        return np.zeros_like(np.asarray(cam_angle, dtype=float))


class ZeroModel(LiftModel):
    """No lift at all."""


SPEC = LiftSpec(Zero, ZeroModel)
