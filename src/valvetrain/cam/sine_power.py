"""A power of a half sine."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from valvetrain.cam.contract import TURN, Array, LiftSpec, after, check_derivative
from valvetrain.errors import InputError
from valvetrain.parameters.schema_lift import LiftModel
from valvetrain.parameters.schema_types import Angle, PositiveLength, problem


@dataclass(frozen=True, slots=True, kw_only=True)
class SinePower:
    """``maximum_lift * sin(pi (angle - opening_start) / duration) ** power`` between ``opening_start`` and ``closing_end`` (cam rad)."""

    maximum_lift: float
    opening_start: float
    closing_end: float
    power: int = 4

    def __post_init__(self) -> None:
        if not 0 < self.closing_end - self.opening_start <= TURN * (1 + 1e-12) or self.power < 2:
            raise InputError("closing_end must follow opening_start within one cam revolution and power be 2 or more; correct them")

    @property
    def continuity(self) -> int:
        return self.power - 1

    @property
    def joints(self) -> tuple[float, ...]:
        return (self.opening_start, self.closing_end)

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        check_derivative(derivative)
        since, n = after(self.opening_start, cam_angle), self.power
        rate = np.pi / (self.closing_end - self.opening_start)
        inside = since < self.closing_end - self.opening_start
        angle = np.where(inside, rate * since, 0.0)
        sine, cosine = np.sin(angle), np.cos(angle)
        if derivative == 0:
            value = sine**n
        elif derivative == 1:
            value = n * sine ** (n - 1) * cosine
        elif derivative == 2:
            value = n * (n - 1) * sine ** (n - 2) * cosine**2 - n * sine**n
        else:
            steep = n * (n - 1) * (n - 2) * sine ** (n - 3) * cosine**2 if n > 2 else 0.0
            value = cosine * (steep - n * (3 * n - 2) * sine ** (n - 1))
        return np.where(inside, self.maximum_lift * rate**derivative * value, 0.0)


class SinePowerModel(LiftModel):
    """``maximum_lift * sin(pi (angle - opening_start) / duration) ** power``."""

    maximum_lift: PositiveLength
    opening_start: Angle
    closing_end: Angle
    power: int = Field(default=4, description="of the half sine")

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses a power out of range."""
        if not 2 <= self.power <= 40:
            raise problem("power must be a whole number from 2 to 40", ("power",))
        return super().values(folder)


SPEC = LiftSpec(SinePower, SinePowerModel)
