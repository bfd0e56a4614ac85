"""A lift law: one full cosine wave between rest and rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.cam.contract import TURN, Array, LiftSpec, after, check_derivative
from valvetrain.errors import InputError
from valvetrain.parameters.lift_law import LiftModel
from valvetrain.parameters.schema_types import Angle, PositiveLength


@dataclass(frozen=True, slots=True, kw_only=True)
class Versine:
    """``maximum_lift (1 - cos(2 pi s)) / 2`` (m) with s from 0 to 1 between ``opening_start`` and
    ``closing_end`` (cam rad).
    """

    maximum_lift: float
    opening_start: float
    closing_end: float

    def __post_init__(self) -> None:
        if not 0 < self.closing_end - self.opening_start <= TURN:
            raise InputError(
                "closing_end must follow opening_start within one cam revolution; correct them"
            )

    @property
    def continuity(self) -> int:
        return 1

    @property
    def joints(self) -> tuple[float, ...]:
        return (self.opening_start, self.closing_end)

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        check_derivative(derivative)
        since, duration = (
            after(self.opening_start, cam_angle),
            self.closing_end - self.opening_start,
        )
        rate = 2 * np.pi / duration
        wave = -np.cos(rate * since + derivative * np.pi / 2) + (1.0 if derivative == 0 else 0.0)
        return np.where(since < duration, self.maximum_lift / 2 * rate**derivative * wave, 0.0)


class VersineModel(LiftModel):
    """One full cosine wave from ``opening_start`` to ``closing_end``."""

    maximum_lift: PositiveLength
    opening_start: Angle
    closing_end: Angle


SPEC = LiftSpec(Versine, VersineModel)
